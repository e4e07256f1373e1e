/// \file  The pictures of scans as their files are now: stores may be replaced while a server runs.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "enfilade/core/ids.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::service::browsing {

/// A scan's pictures, and how often they were replaced since the first call for the scan.
struct NewestSource {
  std::shared_ptr<const scan::PanoramaSource> source;
  std::uint32_t replaced = 0;
};

/// A set of panoramas whose stores may be replaced by others of the same viewpoints, by a rename,
/// as scan::pack() does it. For example, homes::enlarge_pictures() makes larger faces while the
/// small ones are shown. Sources that were replaced stay open. All functions may be called from any
/// thread.
class NewestSources {
 public:
  /// \param panoramas must outlive this
  explicit NewestSources(const scan::PanoramaSet& panoramas) : panoramas_(panoramas) {}

  /// The scan's store as it is now, found out by the file's time and size. The set's own source
  /// where that is no store, where its file is gone or broken, or has other viewpoints.
  /// \throws as scan::PanoramaSet::source()
  NewestSource get(ScanIndex scan);

 private:
  using Stamp = std::pair<std::filesystem::file_time_type, std::uintmax_t>;
  struct Watched {
    NewestSource newest;
    std::optional<Stamp> stamp;  // of the file when it was opened last
  };
  static std::optional<Stamp> stamp_of(const std::filesystem::path& file);
  static void update(Watched& watched);

  const scan::PanoramaSet& panoramas_;
  std::mutex mutex_;
  std::map<ScanIndex, Watched> watched_;
};

}  // namespace enfilade::service::browsing
