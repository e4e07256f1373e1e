/// \file  PanoramaSet: the panoramas of several scans, opened when first used, shared by all
/// threads.
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan {

/// Folders of panoramas.
struct PanoramaPlaces {
  /// Folders that may hold `<scan>.enfilade` (a store) or Matterport3D's files in any layout of
  /// matterport_images.h. The first that has the scan is used, a store before loose files.
  std::vector<std::filesystem::path> images;
  /// Folder of `<scan>_connectivity.json`, for loose files; stores bring their own graph.
  std::filesystem::path connectivity;
};

/// Sources by ScanIndex, in the order of the list that the set was opened with. Use a GraphSet's
/// scans(), so that a ScanIndex is valid for both. Opening the set reads nothing; each scan is
/// opened once, at its first use. All functions may be called from any thread. Sources live as long
/// as the set.
class PanoramaSet {
 public:
  /// Panoramas of these scans, searched in these places.
  static std::shared_ptr<const PanoramaSet> open(PanoramaPlaces places,
                                                 std::vector<std::string> scans);
  /// \throws ArgumentError if one is null or two have one scan id
  static std::shared_ptr<const PanoramaSet> of(
      std::vector<std::shared_ptr<const PanoramaSource>> sources);
  ~PanoramaSet();
  PanoramaSet(const PanoramaSet&) = delete;
  PanoramaSet& operator=(const PanoramaSet&) = delete;

  std::size_t size() const noexcept { return scans_.size(); }
  const std::vector<std::string>& scans() const noexcept { return scans_; }
  /// Place of a scan in scans(); no value if it is not there.
  std::optional<ScanIndex> find(std::string_view scan) const;
  ScanIndex at(std::string_view scan) const;  ///< \throws LookupError

  /// The scan's source, opened at the first call. \pre scan < size()
  /// \throws LookupError naming the scan and every place that was tried; FileError, InvalidInput
  const PanoramaSource& source(ScanIndex scan) const;
  /// As source(), but null where no place has the scan. \throws FileError, InvalidInput
  const PanoramaSource* find_source(ScanIndex scan) const;

 private:
  struct Slot;
  PanoramaSet(PanoramaPlaces places, std::vector<std::string> scans);
  const PanoramaSource* open(ScanIndex scan, std::string& tried) const;
  PanoramaPlaces places_;
  std::vector<std::string> scans_;
  std::unique_ptr<Slot[]> slots_;
};

/// One scan, opened from those places. \throws as PanoramaSet::source()
std::shared_ptr<const PanoramaSource> open_panoramas(const PanoramaPlaces& places,
                                                     const std::string& scan);

}  // namespace enfilade::scan
