/// \file  Viewpoints that stand nearly in the same place become one. Internal.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "enfilade/graph/detail/floor_walk.h"
#include "enfilade/graph/detail/passage.h"

namespace enfilade::graph::detail {

/// Arguments of thin_out().
struct ThinningInput {
  const mesh::WalkableFloor& floor;
  const Passage& passage;
  const Pockets& pockets;
  const std::vector<std::uint32_t>& candidates;
  double least;  ///< metres
  std::size_t first;
  std::function<PlacedViewpoint(std::uint32_t)> placed;  ///< the viewpoint at a cell
};
/// Replaces two viewpoints less than `least` metres apart, in view of each other, by one. That is
/// at a cell of `candidates` (best first) or at one of the two. Does so only if nothing is lost:
/// their neighbours stay connected, and no pocket is left without a viewpoint. The first `first`
/// viewpoints were chosen for their surroundings. They move by half of `least` at most, along the
/// floor; two of them are never replaced by one.
void thin_out(const ThinningInput& input, std::vector<std::uint32_t>& cells);

}  // namespace enfilade::graph::detail
