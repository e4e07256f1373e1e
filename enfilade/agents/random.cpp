#include "enfilade/agents/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

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

Decision RandomAgent::decide(const Observation& seen, Plan& plan) {
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

}  // namespace enfilade::agents
