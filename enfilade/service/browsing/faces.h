/// \file  The faces of panoramas as image files, with a cache.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>

#include "enfilade/geometry/cube_map.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/service/detail/kept.h"

namespace enfilade::service::browsing {

/// Six pictures by index(CubeFace): JPEG for colour; depth and classes as PNG in the colours of
/// draw/colour_maps.h.
using FaceFiles = std::array<std::shared_ptr<const std::string>, kCubeFaces>;

/// A cache: browsers request all six faces of a viewpoint at once, and workers follow the same
/// paths. All functions may be called from any thread.
class Faces {
 public:
  /// \param most_bytes of the cache; the least recently used panorama is dropped first
  explicit Faces(const scan::PanoramaSet& panoramas, std::size_t most_bytes = 32U << 20U);

  /// Colour as the source's own JPEGs where it has them; else encoded.
  /// \throws as scan::PanoramaSource: LookupError if there is no such picture
  FaceFiles get(ScanIndex scan, ViewpointIndex viewpoint, scan::Layer layer);
  /// distance_grid() and legends_json() of layers.h, cached as pictures are. \throws as they do
  std::shared_ptr<const std::string> distances(ScanIndex scan, ViewpointIndex viewpoint);
  std::shared_ptr<const std::string> legends(ScanIndex scan, ViewpointIndex viewpoint);
  /// Changes whenever the scan's pictures do; empty if the source does not report it. The source is
  /// asked once.
  /// \throws FileError, InvalidInput
  std::string version(ScanIndex scan);

 private:
  enum class Kind : std::uint8_t { kColour, kDepth, kClass, kDistances, kLegends };
  using Key = std::tuple<ScanIndex, ViewpointIndex, Kind>;
  FaceFiles find_or_make(const Key& key);
  FaceFiles make(const Key& key) const;

  const scan::PanoramaSet& panoramas_;
  detail::Kept<Key, FaceFiles> kept_;  // a layer with one file has it first
  std::mutex mutex_;
  std::map<ScanIndex, std::string> versions_;
};

}  // namespace enfilade::service::browsing
