/// \file  Plain instructions for a path through rooms with names. Internal.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::homes::speaking {

/// Name of the room that a viewpoint is in.
using RoomOf = std::function<const std::string&(ViewpointIndex)>;

/// Three ways to say it: in one sentence, step by step, and with the goal first. The room called
/// "stairs" is climbed. \pre the path has two viewpoints or more, adjacent each
std::vector<std::string> describe_path(const graph::NavGraph& graph,
                                       const std::vector<ViewpointIndex>& path, Radians heading,
                                       const RoomOf& room_of);

}  // namespace enfilade::homes::speaking
