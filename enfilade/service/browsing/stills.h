/// \file  A picture of each building, as lists of buildings show it.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/service/site.h"

namespace enfilade::service::browsing {

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
