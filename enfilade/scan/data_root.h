/// \file  Where the files of a data set are, in the folder layouts found in the wild.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "enfilade/scan/panorama_set.h"

namespace enfilade::scan {

/// Paths of the files in a folder that holds graphs, annotations and panoramas. Layouts: Enfilade's
/// (`connectivity/`, `r2r/`, `regions/`), a checkout of Matterport3DSimulator (`connectivity/`,
/// `tasks/R2R/data/`), or all files side by side. JSON may be packed (`.json.gz`). dataset::Dataset
/// opens these files. A plain value: any thread.
class DataRoot {
 public:
  /// Searches at each request for a file. \throws FileError if `folder` is not a folder.
  explicit DataRoot(std::filesystem::path folder);

  /// The folder named by the environment variable ENFILADE_DATA; nothing if it is unset or empty.
  /// \throws FileError if it names no folder.
  static std::optional<DataRoot> from_environment();

  const std::filesystem::path& folder() const noexcept { return folder_; }

  // Each throws FileError naming every place that was tried.
  std::filesystem::path connectivity() const;  ///< folder with scans.txt
  std::filesystem::path annotations(
      std::string_view split) const;      ///< R2R_<split>.json, not packed
  std::filesystem::path regions() const;  ///< region_to_panorama.json
  /// The first of several files or folders, relative to folder(), that is there.
  /// \param what  for messages: "boxes of objects"
  /// \throws FileError naming every one that was tried
  std::filesystem::path first_of(std::string_view what,
                                 std::span<const std::filesystem::path> places) const;
  /// Where panoramas may be: `store`, `scans`, `v1/scans`, `data/v1/scans` and the folder itself,
  /// in this order, as far as they are folders. With connectivity(), or no folder if there is no
  /// list of scans.
  PanoramaPlaces panoramas() const;

 private:
  std::filesystem::path folder_;
};

}  // namespace enfilade::scan
