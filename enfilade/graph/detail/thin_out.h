/// \file  Viewpoints that stand nearly in the same place become one. Internal.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "enfilade/graph/detail/floor_walk.h"
#include "enfilade/graph/detail/passage.h"

namespace enfilade::graph::detail {

/// Puts one cell of `candidates` (best first), or one of the two, in the place of two viewpoints
/// that see each other from less than `least` metres, where nothing is lost: their neighbours hang
/// together by it as they did by the two, no pocket is left without a viewpoint, and those there
/// for their surroundings, the `first` ones, move by half of `least` at most, on foot; no two of
/// them become one.
void thin_out(const mesh::WalkableFloor& floor, const Passage& passage, const Pockets& pockets,
              const std::vector<std::uint32_t>& candidates, double least, std::size_t first,
              const std::function<PlacedViewpoint(std::uint32_t)>& placed,
              std::vector<std::uint32_t>& cells);

}  // namespace enfilade::graph::detail
