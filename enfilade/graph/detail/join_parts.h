/// \file  Viewpoints added where the edge rule leaves gaps: doors, bends, stairs. Internal.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "enfilade/graph/detail/passage.h"

namespace enfilade::graph::detail {

/// Adds cells until all viewpoints of each part of the floor are connected by edges, or until no
/// cell helps.
void join_parts(const mesh::WalkableFloor& floor, const Passage& passage,
                const std::function<PlacedViewpoint(std::uint32_t)>& placed,
                std::vector<std::uint32_t>& cells);

}  // namespace enfilade::graph::detail
