/// \file  Pictures with labels, as the renderer draws them, for training.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <memory>
#include <span>

#include "enfilade/core/ids.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::neural::encoders {

/// mpcat40 counts from 0 (void) to 41 (unlabeled).
inline constexpr std::int64_t kObjectClasses = 42;

struct LabelledPlace {
  ScanIndex scan;
  ViewpointIndex viewpoint;
  char room = '-';
};

/// n pictures of kHomeWidth x kHomeHeight, labels by cells (home_network.h).
struct LabelledPictures {
  at::Tensor colours;    ///< (n, height, width, 3) uint8
  at::Tensor classes;    ///< (n, kObjectClasses, rows, columns) uint8: pixels of the cell's 64
  at::Tensor distances;  ///< (n, 1, rows, columns) float, ln of metres; NaN: unknown
  at::Tensor rooms;      ///< (n) int64: letters
};

/// `views` of each place, headings spread evenly from a random one, elevations those of agents,
/// shaken a little. The same seed gives the same bytes.
LabelledPictures draw_labelled(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                               std::span<const LabelledPlace> places, std::size_t views,
                               std::uint64_t seed, int threads);

}  // namespace enfilade::neural::encoders
