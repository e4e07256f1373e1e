/// \file  Pictures for the viewer, with caches: the faces of panoramas, and a still of each
/// building.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/site.h"

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
  /// Distances in each direction: six faces by index(CubeFace), each of n x n numbers in rows.
  /// Numbers are 16 bits little-endian, quarter millimetres along the ray, 0: unknown. n is the
  /// size of the depth faces, at most 96. They are single readings: means would make surfaces that
  /// do not exist. Rounded to 2 mm, which compresses in half.
  /// \throws LookupError if the viewpoint has no depth; as scan::PanoramaSource
  std::shared_ptr<const std::string> distances(ScanIndex scan, ViewpointIndex viewpoint);
  /// The legends of a panorama's depth and classes in the colours of draw/colour_maps.h: {"depth":
  /// {"farthest", "colours"}, "classes": [{"id", "name", "colour", "share"}]}, the largest area
  /// first. A layer without pictures is null.
  /// \throws as scan::PanoramaSource
  std::shared_ptr<const std::string> legends(ScanIndex scan, ViewpointIndex viewpoint);
  /// Changes whenever the scan's pictures do; empty if the source does not report it. The source is
  /// asked once.
  /// \throws FileError, InvalidInput
  std::string version(ScanIndex scan);

 private:
  using Key = std::tuple<ScanIndex, ViewpointIndex, std::string_view>;  // and what is made
  using Make = std::function<FaceFiles(const scan::PanoramaSource&)>;
  FaceFiles find_or_make(const Key& key, const Make& make);

  const scan::PanoramaSet& panoramas_;
  detail::OnceCache<Key, FaceFiles> kept_;  // a layer with one file has it first
  std::mutex mutex_;
  std::map<ScanIndex, std::string> versions_;
};

/// A viewpoint and direction that show much of a building.
struct Outlook {
  ViewpointIndex viewpoint;  ///< of the scan's graph
  Radians heading, elevation;
};

/// Widths that a still may have, in pixels; its height is 5/8 of that. Few, as each is kept.
inline constexpr std::array<std::int64_t, 2> kStillWidths{640, 1280};

/// Opening of stills from top to bottom.
inline constexpr Radians kStillFieldOfView = degrees(60);

/// Chooses outlooks and draws them with the CPU renderer, one at a time; each is drawn once. All
/// functions may be called from any thread.
class Stills {
 public:
  explicit Stills(std::shared_ptr<const Site> site) : site_(std::move(site)) {}

  /// The most open direction, from one of the viewpoints with the most edges. With depth, it is
  /// chosen by the distance to surfaces, else towards the farthest neighbour. No value if no
  /// viewpoint of the graph has pictures.
  /// \throws as scan::PanoramaSource for broken files
  std::optional<Outlook> outlook(ScanIndex scan);
  /// That view as a JPEG file; null if there is no outlook. About 100 kB at 640 pixels.
  /// \param width one of kStillWidths  \throws as outlook()
  std::shared_ptr<const std::string> get(ScanIndex scan, std::int64_t width);

 private:
  const std::optional<Outlook>& find_outlook(ScanIndex scan);

  std::shared_ptr<const Site> site_;
  std::mutex mutex_;
  std::map<ScanIndex, std::optional<Outlook>> outlooks_;
  std::map<std::pair<ScanIndex, std::int64_t>, std::shared_ptr<const std::string>> files_;
};

}  // namespace enfilade::service::browsing
