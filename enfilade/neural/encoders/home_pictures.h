/// \file  Rendered pictures with labels, for training.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::neural::encoders {

/// mpcat40 counts from 0 (void) to 41 (unlabeled).
inline constexpr std::int64_t kObjectClasses = 42;

/// A viewpoint to render at, and its room.
struct LabelledPlace {
  ScanIndex scan;
  ViewpointIndex viewpoint;
  char room = '-';
};

/// Letter of the room of a viewpoint; '-': unknown.
using RoomOf = std::function<char(const std::string& scan, const std::string& viewpoint)>;

/// The included viewpoints of scans that have pictures, in their order. An empty function: rooms
/// are unknown.
std::vector<LabelledPlace> places_of(const scan::PanoramaSet& panoramas,
                                     std::span<const std::string> scans, const RoomOf& room);
/// Keeps at most `most` of them, evenly from all.
void thin_out(std::vector<LabelledPlace>& places, std::size_t most);

/// n pictures of kHomeWidth x kHomeHeight, with labels per cell (home_network.h).
struct LabelledPictures {
  at::Tensor colours;    ///< (n, height, width, 3) uint8
  at::Tensor classes;    ///< (n, kObjectClasses, rows, columns) uint8: pixels of the 64 of a cell
  at::Tensor distances;  ///< (n, 1, rows, columns) float, ln of metres; NaN: unknown
  at::Tensor rooms;      ///< (n) int64: letters
};

/// Renders `views` pictures at each place: evenly spaced headings from a random one, and the
/// elevations of agents, both with a little noise. The same seed gives the same bytes.
LabelledPictures draw_labelled(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                               std::span<const LabelledPlace> places, std::size_t views,
                               std::uint64_t seed, int threads);

/// The labels of the 36 discretized views of each place (render::discrete_views), one place after
/// the other; `colours` is empty.
/// \param vfov of the views, whose shape is that of kHomeWidth x kHomeHeight
LabelledPictures label_views(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                             std::span<const LabelledPlace> places, Radians vfov, int threads);

}  // namespace enfilade::neural::encoders
