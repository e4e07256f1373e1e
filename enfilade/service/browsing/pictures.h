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
#include "enfilade/service/browsing/newest_sources.h"
#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/site.h"

namespace enfilade::service::browsing {

/// Six pictures by index(CubeFace): JPEG for colour; depth and classes as PNG in the colours of
/// draw/colour_maps.h.
using FaceFiles = std::array<std::shared_ptr<const std::string>, kCubeFaces>;

/// A cache: browsers request all six faces of a viewpoint at once, and workers follow the same
/// paths. Pictures of stores that were replaced are made anew (NewestSources). All functions may be
/// called from any thread.
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
  /// The legends of a panorama's depth and classes in the colours of draw/colour_maps.h. Classes
  /// are sorted by their area, the largest first. Colours of depth span draw::depth_range() of the
  /// panorama. A layer without pictures is null.
  /// \returns {"depth": {"nearest", "farthest", "colours"},
  ///           "classes": [{"id", "name", "colour", "share"}]}
  /// \throws as scan::PanoramaSource
  std::shared_ptr<const std::string> legends(ScanIndex scan, ViewpointIndex viewpoint);
  /// Changes whenever the scan's pictures do; empty if the source does not report it. To be asked
  /// before the pictures, so that none gets the version of one that replaced it meanwhile.
  /// \throws FileError, InvalidInput
  std::string version(ScanIndex scan);

 private:
  /// And what is made, of which of the scan's sources: NewestSource::replaced.
  using Key = std::tuple<ScanIndex, ViewpointIndex, std::string_view, std::uint32_t>;
  using Make = std::function<FaceFiles(const scan::PanoramaSource&)>;
  FaceFiles find_or_make(ScanIndex scan, ViewpointIndex viewpoint, std::string_view what,
                         const Make& make);

  NewestSources newest_;
  detail::OnceCache<Key, FaceFiles> kept_;  // a layer with one file has it first
  std::mutex mutex_;
  std::map<std::pair<ScanIndex, std::uint32_t>, std::string>
      versions_;  // and NewestSource::replaced
};

/// A viewpoint and direction that show much of a building.
struct Outlook {
  ViewpointIndex viewpoint;  ///< of the scan's graph
  Radians heading, elevation;
};

/// Widths that a still may have, in pixels; its height is 5/8 of that. Few, as each is kept.
inline constexpr std::array<std::int64_t, 2> kStillWidths{640, 1280};

/// Width of a viewpoint's still, in pixels; its height is 5/8 of that.
inline constexpr std::int64_t kThumbnailWidth = 320;

/// Opening of stills from top to bottom.
inline constexpr Radians kStillFieldOfView = degrees(60);

/// Chooses outlooks and draws them with the CPU renderer, one at a time, each once. Thumbnails are
/// drawn beside them. All functions may be called from any thread.
class Stills {
 public:
  explicit Stills(std::shared_ptr<const Site> site);

  /// The most open direction, from one of the viewpoints with the most edges. With depth, it is
  /// chosen by the distance to surfaces, else towards the farthest neighbour. No value if no
  /// viewpoint of the graph has pictures.
  /// \throws as scan::PanoramaSource for broken files
  std::optional<Outlook> outlook(ScanIndex scan);
  /// That view as a JPEG file; null if there is no outlook. About 100 kB at 640 pixels.
  /// \param width one of kStillWidths  \throws as outlook()
  std::shared_ptr<const std::string> get(ScanIndex scan, std::int64_t width);
  /// A viewpoint's most open direction as a JPEG file, kThumbnailWidth wide: about 15 kB. The
  /// latest ones are kept.
  /// \param viewpoint of the scan's panoramas, and of its graph
  /// \throws LookupError if it has no colour; as scan::PanoramaSource
  std::shared_ptr<const std::string> thumbnail(ScanIndex scan, ViewpointIndex viewpoint);

 private:
  const std::optional<Outlook>& find_outlook(ScanIndex scan);

  std::shared_ptr<const Site> site_;
  std::mutex mutex_;
  std::map<ScanIndex, std::optional<Outlook>> outlooks_;
  NewestSources newest_;
  std::map<std::tuple<ScanIndex, std::int64_t, std::uint32_t>, std::shared_ptr<const std::string>>
      files_;           // by scan, width and NewestSource::replaced
  std::mutex drawing_;  // a thumbnail: they come by the dozen, and nothing else waits for them
  detail::OnceCache<std::tuple<ScanIndex, ViewpointIndex, std::uint32_t>,
                    std::shared_ptr<const std::string>>
      thumbnails_;  // the number: NewestSource::replaced
};

}  // namespace enfilade::service::browsing
