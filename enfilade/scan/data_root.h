/// \file  Paths of the files of a data set.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/scan/panorama_set.h"

namespace enfilade::scan {

/// A folder with connectivity graphs and R2R annotations, in one of the usual layouts: Enfilade's
/// (`connectivity/`, `r2r/`, `regions/`), a checkout of Matterport3DSimulator
/// (`connectivity/`, `tasks/R2R/data/`), or all files side by side. A plain value: any thread.
class DataRoot {
 public:
  /// Files are searched for when they are asked for. \throws FileError if `folder` is not a folder.
  explicit DataRoot(std::filesystem::path folder);

  /// The folder named by the environment variable ENFILADE_DATA; nothing if it is unset or empty.
  /// \throws FileError if it names no folder.
  static std::optional<DataRoot> from_environment();

  const std::filesystem::path& folder() const noexcept { return folder_; }

  // Each throws FileError naming every place that was tried.
  std::filesystem::path connectivity() const;                       ///< folder with scans.txt
  std::filesystem::path annotations(std::string_view split) const;  ///< R2R_<split>.json
  std::filesystem::path regions() const;                            ///< region_to_panorama.json
  /// Where panoramas may be: those of `store`, `scans`, `v1/scans`, `data/v1/scans` and the folder
  /// itself that are folders, in this order, and connectivity().
  PanoramaPlaces panoramas() const;

 private:
  std::filesystem::path folder_;
};

}  // namespace enfilade::scan
