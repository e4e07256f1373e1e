#include "enfilade/agents/simple_agents.h"
#include "enfilade/tasks/objects.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <variant>

namespace enfilade::agents {
namespace {

constexpr std::uint64_t kHeadings = 12;

// The id of one of the objects that the pictures of this viewpoint show; empty if there is none.
std::string any_object(const Observation& seen) {
  const auto shown = std::ranges::count_if(seen.objects, &tasks::ViewedObject::visible);
  if (shown == 0) return {};
  std::uint64_t left = seen.rng->below(static_cast<std::uint64_t>(shown));
  for (const tasks::ViewedObject& object : seen.objects) {
    if (object.visible() && left-- == 0) return std::to_string(object.id);
  }
  return {};
}

Answer any_answer(const Observation& seen, std::span<const ViewpointIndex> walked) {
  switch (seen.task) {
    case tasks::Task::kR2rBack:
      return {.turning_point = walked[seen.rng->below(walked.size())]};
    case tasks::Task::kReverie:
      return {.object = any_object(seen)};
    case tasks::Task::kSoon: {
      // Evenly over the sphere: the sine of the elevation is uniform.
      const double heading = 2 * std::numbers::pi * seen.rng->uniform();
      const double elevation = std::asin(2 * seen.rng->uniform() - 1);
      return {.point = tasks::sphere_point({Radians(heading), Radians(elevation)})};
    }
    default:
      return {};
  }
}

}  // namespace

void RandomAgent::start(std::span<const Observation> batch) {
  plans_.clear();
  for (const Observation& seen : batch) plans_.push_back({seen.rng->below(kHeadings), kMoves});
}

Decision RandomAgent::decide(const Observation& seen, Draw& plan) {
  const auto made = static_cast<std::size_t>(kMoves - plan.moves);
  plan.walked[made] = seen.viewpoint;
  if (plan.turns > 0) {
    --plan.turns;
    return Decision::turn(1);
  }
  if (plan.moves == 0) {
    return Decision::stop_with(any_answer(seen, std::span(plan.walked).first(made + 1)));
  }
  if (seen.navigable.size() < 2) return Decision::turn(1);
  --plan.moves;
  return Decision::go(1);
}

void RandomAgent::act(std::span<const Observation> batch, std::span<Decision> decisions) {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    if (!batch[i].ended) decisions[i] = decide(batch[i], plans_[i]);
  }
}

void ReferenceAgent::start(std::span<const Observation> batch) { next_.assign(batch.size(), 0); }

void ReferenceAgent::act(std::span<const Observation> batch, std::span<Decision> decisions) {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const Observation& seen = batch[i];
    if (seen.ended) continue;
    std::size_t& next = next_[i];
    const std::size_t last = seen.reference.size() - 1;
    while (next < last && seen.viewpoint == seen.reference[next]) ++next;
    decisions[i] = teacher_decision(seen, seen.reference[next]);
    if (decisions[i].stop) decisions[i].answer = true_answer(seen);
  }
}

namespace {

constexpr Radians kView = degrees(30);  // one step of the discretized camera

// The row of the 36 views that the camera is in: 0 down, 1 level, 2 up.
std::uint32_t row(const Observation& seen) { return seen.view_index / 12; }

std::optional<ViewpointIndex> next_on_path(const Observation& seen, ViewpointIndex goal) {
  // Follows the predecessors from the goal back to the agent.
  ViewpointIndex node = goal;
  for (;;) {
    const auto before = seen.graph->before(seen.viewpoint, node);
    if (!before) return std::nullopt;
    if (*before == seen.viewpoint) return node;
    node = *before;
  }
}

Decision towards_navigable(const Observation& seen, std::size_t index) {
  const double right = seen.navigable.rel_heading[index];
  const double up = seen.navigable.rel_elevation[index];
  if (right > kView.value) return Decision::turn(1);
  if (right < -kView.value) return Decision::turn(-1);
  if (up > kView.value && row(seen) < 2) return Decision::turn(0, 1);
  if (up < -kView.value && row(seen) > 0) return Decision::turn(0, -1);
  return Decision::go(static_cast<std::uint32_t>(index));
}

// Levels the camera first, then turns the shorter way, to the right if both are equal.
Decision towards_hidden(const Observation& seen, ViewpointIndex next) {
  if (row(seen) == 0) return Decision::turn(0, 1);
  if (row(seen) == 2) return Decision::turn(0, -1);
  const graph::Edge& edge = *seen.graph->edge(seen.viewpoint, next);
  const double turn = wrap_difference(edge.heading - seen.heading).value;
  return Decision::turn(turn < 0 ? -1 : 1);
}

}  // namespace

Decision teacher_decision(const Observation& seen, ViewpointIndex goal) {
  if (seen.viewpoint == goal) return Decision::stop_here();
  const auto next = next_on_path(seen, goal);
  if (!next) return Decision::stop_here();
  const auto found = std::ranges::find(seen.navigable.viewpoint, *next);
  if (found == seen.navigable.viewpoint.end()) return towards_hidden(seen, *next);
  return towards_navigable(seen,
                           static_cast<std::size_t>(found - seen.navigable.viewpoint.begin()));
}

Answer true_answer(const Observation& seen) {
  const tasks::Goal& goal = seen.path->goal;
  if (const auto* turn = std::get_if<tasks::TurningPoint>(&goal)) {
    return {.turning_point = turn->viewpoint};
  }
  if (const auto* object = std::get_if<tasks::SeenObject>(&goal)) {
    return {.object = std::to_string(object->id)};
  }
  const auto* boxes = std::get_if<tasks::Boxes>(&goal);
  if (boxes == nullptr) return {};
  const auto box =
      std::find_if(boxes->boxes.rbegin(), boxes->boxes.rend(),
                   [&seen](const tasks::Box& one) { return one.viewpoint == seen.viewpoint; });
  if (box == boxes->boxes.rend()) return {};
  return {.point = tasks::sphere_point(box->centre)};
}

void ShortestAgent::start(std::span<const Observation> batch) {
  plans_.clear();
  for (const Observation& seen : batch) {
    plans_.push_back({tasks::Leg::kOut, nearest_goal(*seen.graph, *seen.path, seen.viewpoint)});
  }
}

Decision ShortestAgent::decide(const Observation& seen, Target& plan) {
  if (!plan.target) return Decision::stop_with(true_answer(seen));
  if (plan.leg == tasks::Leg::kOut && seen.viewpoint == *plan.target) {
    plan.leg = tasks::Leg::kBack;  // of R2R-Back; other goals have no second leg
    if (std::holds_alternative<tasks::TurningPoint>(seen.path->goal)) {
      plan.target = nearest_goal(*seen.graph, *seen.path, seen.viewpoint, plan.leg);
      return decide(seen, plan);
    }
  }
  Decision decision = teacher_decision(seen, *plan.target);
  if (decision.stop) decision.answer = true_answer(seen);
  return decision;
}

void ShortestAgent::act(std::span<const Observation> batch, std::span<Decision> decisions) {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    if (!batch[i].ended) decisions[i] = decide(batch[i], plans_[i]);
  }
}

}  // namespace enfilade::agents
