#include "python/src/bindings.h"

#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::python {
namespace {

using tasks::Direction;

nb::tuple names_of(std::span<const ViewpointIndex> viewpoints, const graph::NavGraph& graph) {
  nb::list names;
  for (const ViewpointIndex v : viewpoints) names.append(graph.id(v));
  return nb::tuple(names);
}

nb::tuple pair_of(const Direction& direction) {
  return nb::make_tuple(direction.heading.value, direction.elevation.value);
}

Direction direction_of(nb::handle pair) {
  return {Radians(nb::cast<double>(pair[0])), Radians(nb::cast<double>(pair[1]))};
}

nb::tuple box_tuple(const tasks::Box& box, const graph::NavGraph& graph) {
  nb::list corners;
  for (const Direction& corner : box.corners) corners.append(pair_of(corner));
  return nb::make_tuple(graph.id(box.viewpoint), pair_of(box.centre), nb::tuple(corners));
}

tasks::Box read_box(nb::handle box, const graph::NavGraph& graph) {
  tasks::Box read{find_viewpoint(graph, nb::cast<std::string>(box[0])), direction_of(box[1]), {}};
  const nb::tuple corners = nb::tuple(nb::object(box[2]));
  if (corners.size() != read.corners.size()) {
    throw ArgumentError(fmt::format("a box of {} corners: 4 are wanted", corners.size()));
  }
  for (std::size_t i = 0; i < corners.size(); ++i) read.corners[i] = direction_of(corners[i]);
  return read;
}

// For paths that may be empty.
std::vector<ViewpointIndex> list_of(nb::handle path, const graph::NavGraph& graph) {
  if (nb::len(path) == 0) return {};
  return read_viewpoints(path, graph, "goal");
}

}  // namespace

nb::tuple goal_tuple(const tasks::Goal& goal, const graph::NavGraph& graph, ViewpointIndex end) {
  struct Visitor {
    const graph::NavGraph& graph;
    ViewpointIndex end;
    nb::tuple operator()(const tasks::NearEnd& /*goal*/) const {
      return nb::make_tuple("NearEnd", graph.id(end));
    }
    nb::tuple operator()(const tasks::HiddenGoal& /*goal*/) const {
      return nb::make_tuple("Hidden");
    }
    nb::tuple operator()(const tasks::TurningPoint& goal) const {
      return nb::make_tuple("TurningPoint", graph.id(goal.viewpoint));
    }
    nb::tuple operator()(const tasks::SeenObject& goal) const {
      return nb::make_tuple("Object", goal.id, names_of(goal.seen_from, graph));
    }
    nb::tuple operator()(const tasks::Region& goal) const {
      return nb::make_tuple("Region", names_of(goal.viewpoints, graph),
                            names_of(goal.player, graph), names_of(goal.planner, graph));
    }
    nb::tuple operator()(const tasks::Boxes& goal) const {
      nb::list boxes;
      for (const tasks::Box& box : goal.boxes) boxes.append(box_tuple(box, graph));
      return nb::make_tuple("Boxes", nb::tuple(boxes), names_of(goal.first_alternative, graph));
    }
  };
  return std::visit(Visitor{graph, end}, goal);
}

tasks::Goal read_goal(const nb::tuple& goal, const graph::NavGraph& graph) {
  const auto kind = nb::cast<std::string>(goal[0]);
  if (kind == "NearEnd") return tasks::NearEnd{};
  if (kind == "TurningPoint") {
    return tasks::TurningPoint{find_viewpoint(graph, nb::cast<std::string>(goal[1]))};
  }
  if (kind == "Object") {
    tasks::SeenObject object{nb::cast<std::int64_t>(goal[1]), list_of(goal[2], graph)};
    std::ranges::sort(object.seen_from);
    return object;
  }
  if (kind == "Region") {
    return tasks::Region{read_viewpoints(goal[1], graph, "goal"), list_of(goal[2], graph),
                         list_of(goal[3], graph)};
  }
  if (kind == "Boxes") {
    tasks::Boxes boxes{{}, list_of(goal[2], graph)};
    for (const nb::handle box : nb::tuple(goal[1])) boxes.boxes.push_back(read_box(box, graph));
    return boxes;
  }
  return tasks::HiddenGoal{};
}

bool fits(const tasks::Goal& goal, tasks::GoalKind kind) noexcept {
  switch (kind) {
    case tasks::GoalKind::kTurningPoint:
      return std::holds_alternative<tasks::TurningPoint>(goal);
    case tasks::GoalKind::kObject:
      return std::holds_alternative<tasks::SeenObject>(goal);
    case tasks::GoalKind::kRegion:
      return std::holds_alternative<tasks::Region>(goal);
    case tasks::GoalKind::kBoxes:
      return std::holds_alternative<tasks::Boxes>(goal);
    default:
      return std::holds_alternative<tasks::NearEnd>(goal);
  }
}

std::vector<ViewpointIndex> read_viewpoints(nb::handle path, const graph::NavGraph& graph,
                                            const char* what) {
  std::vector<ViewpointIndex> read;
  for (const nb::handle item : path) {
    if (PyUnicode_Check(item.ptr())) {
      read.push_back(find_viewpoint(graph, nb::cast<std::string>(item)));
      continue;
    }
    const Py_ssize_t index = PyNumber_AsSsize_t(item.ptr(), PyExc_OverflowError);
    if (index == -1 && PyErr_Occurred() != nullptr) throw nb::python_error();
    if (index < 0) continue;
    if (static_cast<std::size_t>(index) >= graph.size()) {
      throw ArgumentError(fmt::format("{}: viewpoint {} of scan {}: 0 to {} are allowed", what,
                                      index, graph.scan(), graph.size() - 1));
    }
    read.emplace_back(static_cast<std::size_t>(index));
  }
  if (read.empty()) throw ArgumentError(fmt::format("{}: a path without viewpoints", what));
  return read;
}

}  // namespace enfilade::python
