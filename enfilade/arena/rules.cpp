#include "enfilade/arena/rules.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/random.h"
#include "enfilade/arena/detail/moves.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/tasks/goal_distance.h"

namespace enfilade::arena {
namespace {

constexpr std::uint64_t kHeadings = 12;

Call go_to(const Place& place) { return {std::string(name_of(Tool::kGoTo)), place.name}; }
Call stop() { return {std::string(name_of(Tool::kStop)), {}}; }

class StopAtOnce : public Follower {
 public:
  Call next() override { return stop(); }
};

class GoToFirst : public Follower {
 public:
  explicit GoToFirst(const Session& session) : session_(session) {}
  Call next() override {
    const auto& places = session_.observation().places;
    return places.empty() ? Call{std::string(name_of(Tool::kLook)), "left"} : go_to(places[0]);
  }

 private:
  const Session& session_;
};

class ForwardForEver : public Follower {
 public:
  Call next() override { return {std::string(name_of(Tool::kMove)), "forward"}; }
};

/// In calls of as many actions as one may have.
class RecordedActions : public Follower {
 public:
  explicit RecordedActions(std::vector<std::uint8_t> actions) : actions_(std::move(actions)) {}

  Call next() override {
    std::vector<std::string_view> names;
    for (; names.size() < kMostMoves && at_ < actions_.size(); ++at_) {
      const auto move = std::ranges::find(
          detail::kMoves, static_cast<continuous::Action>(actions_[at_]), &detail::Move::action);
      if (move == detail::kMoves.end()) break;  // it stops
      names.push_back(move->name);
    }
    if (names.empty()) return stop();
    return {std::string(name_of(Tool::kMove)), fmt::format("{}", fmt::join(names, ","))};
  }

 private:
  std::vector<std::uint8_t> actions_;
  std::size_t at_ = 0;
};

/// Keeps the heading that the agent "random" has, which is not where a session looks.
class RandomRule : public Follower {
 public:
  RandomRule(const GraphSession& session, std::uint64_t seed) : session_(session) {
    const std::string id = session.episode_id();
    Rng rng(seed, stream_of(id.data(), id.size()));
    heading_ = session.pose().heading + degrees(30.0 * static_cast<double>(rng.below(kHeadings)));
  }

  Call next() override {
    if (moves_ == 0) return stop();
    for (std::uint64_t turns = 0; turns < kHeadings; ++turns) {
      if (const Place* ahead = nearest_ahead()) {
        --moves_;
        return go_to(*ahead);
      }
      heading_ = heading_ + degrees(30);
    }
    return stop();  // nothing leads away from here
  }

 private:
  const Place* nearest_ahead() const {
    static const double half_width = horizontal_field_of_view(Camera{}).value / 2;
    const Observation& seen = session_.observation();
    const Place* nearest = nullptr;
    double least = 0;
    for (const Place& place : seen.places) {
      const double aside = wrap_difference(seen.heading + place.turn - heading_).value;
      if (std::abs(aside) > half_width) continue;
      const double away = std::hypot(aside, place.elevation.value);
      if (nearest != nullptr && away >= least) continue;
      nearest = &place;
      least = away;
    }
    return nearest;
  }

  const GraphSession& session_;
  Radians heading_;
  int moves_ = agents::RandomAgent::kMoves;
};

class Oracle : public Follower {
 public:
  Oracle(const GraphWorld& world, const GraphSession& session)
      : session_(session),
        path_(world.episodes().path_of(world.episodes().episodes[session.episode()])),
        graph_(world.episodes().graphs->graph(path_.scan)) {
    if (tasks::goal_hidden(path_)) {
      throw ArgumentError(
          fmt::format("the goal of {} is hidden; an oracle needs it", session.episode_id()));
    }
  }

  Call next() override {
    const ViewpointIndex here = session_.pose().location.viewpoint;
    auto goal = tasks::nearest_goal(graph_, path_, here, leg_);
    const bool goes_back = std::holds_alternative<tasks::TurningPoint>(path_.goal);
    if (goes_back && leg_ == tasks::Leg::kOut && goal == here) {
      leg_ = tasks::Leg::kBack;
      return {std::string(name_of(Tool::kTurnBack)), {}};
    }
    if (!goal || *goal == here) return finish();
    const Observation& seen = session_.observation();
    const auto way = [&](const Place& place) {
      const ViewpointIndex there = session_.viewpoint_of(place.name);
      return graph_.distance(there, *goal) + graph_.distance(here, there);
    };
    const auto best = std::ranges::min_element(seen.places, {}, way);
    return best == seen.places.end() ? stop() : go_to(*best);
  }

 private:
  Call finish() const {
    const auto* object = std::get_if<tasks::SeenObject>(&path_.goal);
    if (object == nullptr) return stop();
    for (const Thing& thing : session_.observation().things) {
      if (session_.object_of(thing.name) == object->id) {
        return {std::string(name_of(Tool::kAnswer)), thing.name};
      }
    }
    return stop();
  }

  const GraphSession& session_;
  const tasks::ReferencePath& path_;
  tasks::Leg leg_ = tasks::Leg::kOut;
  const graph::NavGraph& graph_;
};

}  // namespace

Rule rule_named(std::string_view name) {
  if (const auto rule = find_enum<Rule>(name)) return *rule;
  throw LookupError(
      fmt::format("no rule {:?}; there are {}", name, fmt::join(names_of(Rule()), ", ")));
}

std::unique_ptr<Follower> GraphWorld::follow(Rule rule, const Session& session,
                                             std::uint64_t seed) const {
  const auto& walked = dynamic_cast<const GraphSession&>(session);
  switch (rule) {
    case Rule::kRandom:
      return std::make_unique<RandomRule>(walked, seed);
    case Rule::kOracle:
      return std::make_unique<Oracle>(*this, walked);
    case Rule::kStop:
      return std::make_unique<StopAtOnce>();
    case Rule::kFirst:
      break;
  }
  return std::make_unique<GoToFirst>(session);
}

std::unique_ptr<Follower> FreeWorld::follow(Rule rule, const Session& session,
                                            std::uint64_t seed) const {
  if (rule == Rule::kStop) return std::make_unique<StopAtOnce>();
  if (rule == Rule::kFirst) return std::make_unique<ForwardForEver>();
  // The agent's walk through this episode alone: what it does depends on nothing else.
  auto alone = std::make_shared<tasks::ContinuousEpisodes>();
  alone->split = split();
  alone->episodes.push_back(world_.episodes->episodes[session.episode()]);
  const auto agent = agents::make_continuous_agent(rule == Rule::kOracle ? "shortest" : "random");
  auto walks =
      agents::run_continuous(*agent, *alone, world_.buildings,
                             {.batch_size = 1, .seed = seed, .simulator = setup_->simulator});
  return std::make_unique<RecordedActions>(std::move(walks[0].actions));
}

}  // namespace enfilade::arena
