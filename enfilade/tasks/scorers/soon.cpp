// SOON's scorers: to end at a viewpoint that shows the object, and to point at it.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>

#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {
namespace {

// As results have points. Nothing is wrapped: a box across heading 0 spans the wrong way round.
SpherePoint normalised(const Direction& direction) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return {direction.heading.value / kTurn, (direction.elevation.value + std::numbers::pi) / kTurn};
}

// Twice the area of a, b, p, with its sign.
double side(const SpherePoint& a, const SpherePoint& b, const SpherePoint& p) {
  return (b.heading - a.heading) * (p.elevation - a.elevation) -
         (b.elevation - a.elevation) * (p.heading - a.heading);
}

bool between(double low, double high, double x) {
  return std::min(low, high) <= x && x <= std::max(low, high);
}

// Strictly inside by the even-odd rule: edges and corners are outside.
bool contains(const Box& box, const SpherePoint& p) {
  std::array<SpherePoint, 4> corners;
  std::ranges::transform(box.corners, corners.begin(), normalised);
  bool inside = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const SpherePoint& a = corners[i];
    const SpherePoint& b = corners[(i + 1) % corners.size()];
    const double turn = side(a, b, p);
    if (turn == 0 && between(a.heading, b.heading, p.heading) &&
        between(a.elevation, b.elevation, p.elevation)) {
      return false;
    }
    if ((a.elevation > p.elevation) != (b.elevation > p.elevation)) {
      inside ^= (turn > 0) == (b.elevation > a.elevation);
    }
  }
  return inside;
}

struct Walk {
  std::vector<ViewpointIndex> path;
  double walked = 0, error = 0, oracle_error = 0, shortest = 0;
  const Box* box = nullptr;  // of the last viewpoint
  bool success() const { return error < kSuccessDistance; }
  bool oracle() const { return oracle_error < kSuccessDistance; }
  double spl() const { return scorers::spl(success(), shortest, walked, kGuard); }
};

// `box`: of the last viewpoint. If there is one, the goal is there and no longer the path's end.
Walk walk(const Scored& scored, std::span<const ViewpointIndex> reference, const Box* box) {
  Walk w{viewpoints_of(scored.trajectory), 0, 0, 0, 0, box};
  const graph::NavGraph& graph = scored.graph;
  const auto distance_to = [&graph](ViewpointIndex to) {
    return [&graph, to](ViewpointIndex from) { return graph.distance(from, to); };
  };
  const ViewpointIndex best = *std::ranges::min_element(w.path, {}, distance_to(reference.back()));
  const ViewpointIndex goal = box != nullptr ? w.path.back() : reference.back();
  w.walked = walked(graph, w.path);
  w.error = graph.distance(w.path.back(), goal);
  w.oracle_error = graph.distance(best, goal);
  w.shortest = graph.distance(reference.front(), goal);
  return w;
}

bool detected(const Walk& w, const Trajectory& trajectory) {
  return w.box != nullptr && trajectory.point && contains(*w.box, *trajectory.point);
}

// The first or the last box of a viewpoint; null if it has none.
const Box* first_box(const std::vector<Box>& boxes, ViewpointIndex viewpoint) {
  const auto found = std::ranges::find(boxes, viewpoint, &Box::viewpoint);
  return found == boxes.end() ? nullptr : &*found;
}
const Box* last_box(const std::vector<Box>& boxes, ViewpointIndex viewpoint) {
  const auto found = std::find_if(boxes.rbegin(), boxes.rend(),
                                  [viewpoint](const Box& b) { return b.viewpoint == viewpoint; });
  return found == boxes.rend() ? nullptr : &*found;
}

}  // namespace

void soon_duet(const Scored& scored, Out out) {
  const auto& goal = std::get<Boxes>(scored.reference.goal);
  const ViewpointIndex end = scored.trajectory.points.back().viewpoint;
  const Walk w = walk(scored, scored.reference.viewpoints, last_box(goal.boxes, end));
  const bool found = detected(w, scored.trajectory);
  out[0] = found ? 1 : 0;
  out[1] = action_steps(scored.trajectory);
  out[2] = static_cast<double>(w.path.size() - 1);
  out[3] = w.walked;
  out[4] = w.error;
  out[5] = w.oracle_error;
  out[6] = w.success() ? 1 : 0;
  out[7] = w.oracle() ? 1 : 0;
  out[8] = w.shortest - w.error;
  out[9] = w.spl();
  out[10] = spl(found, w.shortest, w.walked, kGuard);
}

void soon_official(const Scored& scored, Out out) {
  const auto& goal = std::get<Boxes>(scored.reference.goal);
  const std::span<const ViewpointIndex> reference =
      goal.first_alternative.empty() ? scored.reference.viewpoints : goal.first_alternative;
  const ViewpointIndex end = scored.trajectory.points.back().viewpoint;
  const Walk w = walk(scored, reference, first_box(goal.boxes, end));
  const bool found = detected(w, scored.trajectory);
  double heading = kNone, elevation = kNone;
  if (w.box != nullptr && scored.trajectory.point) {
    const SpherePoint centre = normalised(w.box->centre);
    heading = std::abs(scored.trajectory.point->heading - centre.heading);
    elevation = std::abs(scored.trajectory.point->elevation - centre.elevation);
  }
  out[0] = w.error;
  out[1] = w.oracle_error;
  out[2] = static_cast<double>(w.path.size() - 1);
  out[3] = w.walked;
  out[4] = heading;
  out[5] = elevation;
  out[6] = found ? std::hypot(heading, elevation) : kNone;
  out[7] = w.shortest - w.error;
  out[8] = found ? 1 : 0;
  out[9] = w.success() ? 1 : 0;
  out[10] = w.oracle() ? 1 : 0;
  out[11] = w.spl();
  out[12] = found ? w.spl() : 0;
}

}  // namespace enfilade::tasks::scorers
