#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/core/errors.h"

namespace enfilade::agents {

using continuous::Action;

namespace {

class RandomWalk final : public ContinuousAgent {
 public:
  std::string_view name() const override { return "random"; }
  void start(std::size_t, const ContinuousObservation&,
             const continuous::SimulatorConfig&) override {}
  void act(std::span<const ContinuousObservation> batch, std::span<Action> actions) override {
    for (std::size_t a = 0; a < batch.size(); ++a) {
      if (!batch[a].ended) actions[a] = draw(batch[a].rng->uniform());
    }
  }

 private:
  static Action draw(double uniform) {
    if (uniform < 0.68) return Action::kForward;
    if (uniform < 0.83) return Action::kLeft;
    return uniform < 0.98 ? Action::kRight : Action::kStop;
  }
};

class ForwardOnly final : public ContinuousAgent {
 public:
  static constexpr std::uint32_t kSteps = 37;

  std::string_view name() const override { return "forward"; }
  void start(std::size_t slot, const ContinuousObservation& seen,
             const continuous::SimulatorConfig& config) override {
    if (turns_.size() <= slot) turns_.resize(slot + 1);
    const auto full = static_cast<std::uint64_t>(2 * kPi / config.turn.value + 0.5);
    turns_[slot] = static_cast<std::uint32_t>(seen.rng->below(std::max<std::uint64_t>(full, 1)));
  }
  void act(std::span<const ContinuousObservation> batch, std::span<Action> actions) override {
    for (std::size_t a = 0; a < batch.size(); ++a) {
      if (batch[a].ended) continue;
      const std::uint32_t step = batch[a].step, turns = turns_[a];
      actions[a] = step < turns            ? Action::kRight
                   : step < turns + kSteps ? Action::kForward
                                           : Action::kStop;
    }
  }

 private:
  std::vector<std::uint32_t> turns_;  // by slot
};

// The floor of a building; the agent's runner keeps it alive.
std::shared_ptr<const continuous::Floor> floor_of(const ContinuousObservation& seen) {
  return {std::shared_ptr<const void>(), &seen.buildings->floor(seen.building)};
}

// Where a point of an episode is on the floor; the agent's own place if it is off every floor.
continuous::FloorPoint on_floor(const ContinuousObservation& seen, Vec3d point) {
  const auto found = seen.buildings->floor(seen.building).nearest(to_float(point), {1, 1});
  return found.value_or(seen.floor);
}

// Where an episode's walk leads, point by point.
using PointsOf = std::function<std::vector<Vec3d>(const tasks::ContinuousEpisode& episode)>;

class Follower final : public ContinuousAgent {
 public:
  Follower(std::string name, PointsOf points_of, const continuous::FollowerConfig& distances,
           bool needs_goal = true)
      : name_(std::move(name)),
        points_of_(std::move(points_of)),
        distances_(distances),
        needs_goal_(needs_goal) {}

  std::string_view name() const override { return name_; }
  bool needs_goal() const override { return needs_goal_; }
  void start(std::size_t slot, const ContinuousObservation& seen,
             const continuous::SimulatorConfig& config) override {
    if (followers_.size() <= slot) followers_.resize(slot + 1);
    std::vector<continuous::FloorPoint> points;
    for (const Vec3d point : points_of_(*seen.episode)) points.push_back(on_floor(seen, point));
    followers_[slot].emplace(floor_of(seen), std::move(points), config, distances_);
  }
  void act(std::span<const ContinuousObservation> batch, std::span<Action> actions) override {
    for (std::size_t a = 0; a < batch.size(); ++a) {
      if (!batch[a].ended) {
        actions[a] = followers_[a]->next(batch[a].floor, batch[a].pose.heading);
      }
    }
  }

 private:
  std::string name_;
  PointsOf points_of_;
  continuous::FollowerConfig distances_;
  bool needs_goal_;
  std::vector<std::optional<continuous::ReferenceFollower>> followers_;  // by slot
};

constexpr continuous::FollowerConfig kToTheEnd{.reached = 0.5, .last_reached = 0.25};

std::vector<Vec3d> goal_of(const tasks::ContinuousEpisode& episode) {
  return {episode.goals->front().position};
}

std::vector<Vec3d> path_of(const tasks::ContinuousEpisode& episode) {
  return episode.reference_path ? *episode.reference_path : goal_of(episode);
}

using Maker = std::unique_ptr<ContinuousAgent> (*)();

const std::map<std::string_view, Maker>& makers() {
  using Made = std::unique_ptr<ContinuousAgent>;
  static const std::map<std::string_view, Maker> kMakers{
      {"random", []() -> Made { return std::make_unique<RandomWalk>(); }},
      {"forward", []() -> Made { return std::make_unique<ForwardOnly>(); }},
      {"reference",
       []() -> Made {
         return std::make_unique<Follower>("reference", path_of, continuous::FollowerConfig{});
       }},
      {"shortest",
       []() -> Made { return std::make_unique<Follower>("shortest", goal_of, kToTheEnd); }}};
  return kMakers;
}

}  // namespace

std::unique_ptr<ContinuousAgent> make_continuous_agent(std::string_view name) {
  const auto found = makers().find(name);
  if (found == makers().end()) {
    throw LookupError(fmt::format("no continuous agent \"{}\"; there are {}", name,
                                  fmt::join(continuous_agent_names(), ", ")));
  }
  return found->second();
}

std::unique_ptr<ContinuousAgent> make_patient_reference() {
  return std::make_unique<Follower>("reference", path_of,
                                    continuous::FollowerConfig{.patient = true});
}

std::unique_ptr<ContinuousAgent> make_route_agent(
    std::string name, std::map<std::string, std::vector<Vec3d>, std::less<>> routes) {
  auto points_of = [routes = std::move(routes)](const tasks::ContinuousEpisode& episode) {
    const auto route = routes.find(tasks::text_of(episode.id));
    const bool none = route == routes.end() || route->second.empty();
    return none ? std::vector<Vec3d>{episode.start} : route->second;
  };
  return std::make_unique<Follower>(std::move(name), std::move(points_of), kToTheEnd, false);
}

std::vector<std::string> continuous_agent_names() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : makers()) names.emplace_back(name);
  return names;
}

}  // namespace enfilade::agents
