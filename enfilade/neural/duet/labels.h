/// \file  A teacher's choices on a map of DUET.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::neural::duet {

/// No label: adds nothing to a loss.
inline constexpr std::int64_t kNoLabel = -100;

/// Place + 1 of the neighbour with the least way there and on to the goal, in the whole graph;
/// the first of equals. 0 on the goal, kNoLabel without a neighbour.
std::int64_t neighbour_label(const graph::NavGraph& graph, ViewpointIndex here, ViewpointIndex goal,
                             std::span<const ViewpointIndex> neighbours);

/// The viewpoint after the reference's number `step`; `here` itself at its end.
/// \throws ArgumentError if `here` is not that viewpoint, naming it
ViewpointIndex next_on_reference(const graph::NavGraph& graph, ViewpointIndex here,
                                 std::size_t step, std::span<const ViewpointIndex> reference);

}  // namespace enfilade::neural::duet
