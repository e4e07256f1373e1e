/// \file  Goals of episodes, passed between C++ and enfilade.goals as tuples.
#pragma once
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/goal.h"
#include "python/src/bindings.h"

namespace enfilade::python {

/// The name of a class of enfilade.goals, then its fields: ("Object", 66, ("<viewpoint>", ...)).
/// \param end  the path's last viewpoint, for NearEnd
nb::tuple goal_tuple(const tasks::Goal& goal, const graph::NavGraph& graph, ViewpointIndex end);
/// The goal of such a tuple. \throws LookupError for an unknown viewpoint; nb::python_error for
/// values of wrong types
tasks::Goal read_goal(const nb::tuple& goal, const graph::NavGraph& graph);
/// Whether a task's scorers accept such a goal.
bool fits(const tasks::Goal& goal, tasks::Task task) noexcept;

/// The viewpoints of a path: ids, or indices as integers. Negative indices are padding and are
/// skipped. \param what  its name in messages
/// \throws LookupError; ArgumentError for an empty path and indices out of range
std::vector<ViewpointIndex> read_viewpoints(nb::handle path, const graph::NavGraph& graph,
                                            const char* what);

}  // namespace enfilade::python
