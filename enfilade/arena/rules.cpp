#include "enfilade/arena/world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/simple_agents.h"
#include "enfilade/arena/detail/texts.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/tasks/goal_distance.h"

namespace enfilade::arena {
namespace {

constexpr std::uint64_t kHeadings = 12;

Call go_to(const Neighbour& place) { return {std::string(name_of(Tool::kGoTo)), place.name}; }
Call stop() { return {std::string(name_of(Tool::kStop)), {}}; }

/// As many of the actions from `at` on as one call may have; stops behind the last.
Call next_moves(const std::vector<std::uint8_t>& actions, std::size_t& at) {
  std::vector<std::string_view> names;
  for (; names.size() < kMostMoves && at < actions.size(); ++at) {
    if (actions[at] == static_cast<std::uint8_t>(continuous::Action::kStop)) break;
    names.push_back(detail::kMoves.at(actions[at]));
  }
  if (names.empty()) return stop();
  return {std::string(name_of(Tool::kMove)), fmt::format("{}", fmt::join(names, ","))};
}

/// Keeps the heading that the agent "random" has, which is not where a session looks.
class RandomRule {
 public:
  RandomRule(const GraphSession& session, std::uint64_t seed) : session_(session) {
    const std::string id = session.episode_id();
    Rng rng(seed, stream_of(id.data(), id.size()));
    heading_ = session.pose().heading + degrees(30.0 * static_cast<double>(rng.below(kHeadings)));
  }

  Call operator()() {
    if (moves_ == 0) return stop();
    for (std::uint64_t turns = 0; turns < kHeadings; ++turns) {
      if (const Neighbour* ahead = nearest_ahead()) {
        --moves_;
        return go_to(*ahead);
      }
      heading_ = heading_ + degrees(30);
    }
    return stop();  // nothing leads away from here
  }

 private:
  const Neighbour* nearest_ahead() const {
    static const double kHalfWidth = horizontal_field_of_view(Camera{}).value / 2;
    const SessionObservation& seen = session_.observation();
    const Neighbour* nearest = nullptr;
    double least = 0;
    for (const Neighbour& place : seen.places) {
      const double aside = wrap_difference(seen.heading + place.turn - heading_).value;
      if (std::abs(aside) > kHalfWidth) continue;
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

class Oracle {
 public:
  Oracle(const GraphWorld& world, const GraphSession& session)
      : session_(session),
        path_(episodes_of(world).path_of(episodes_of(world).episodes[session.episode()])),
        graph_(episodes_of(world).graphs->graph(path_.scan)) {
    if (tasks::goal_hidden(path_)) {
      throw ArgumentError(
          fmt::format("the goal of {} is hidden; an oracle needs it", session.episode_id()));
    }
  }

  Call operator()() {
    const ViewpointIndex here = session_.pose().location.viewpoint;
    auto goal = tasks::nearest_goal(graph_, path_, here, leg_);
    const bool goes_back = std::holds_alternative<tasks::TurningPoint>(path_.goal);
    if (goes_back && leg_ == tasks::Leg::kOut && goal == here) {
      leg_ = tasks::Leg::kBack;
      return {std::string(name_of(Tool::kTurnBack)), {}};
    }
    if (!goal || *goal == here) return finish();
    const SessionObservation& seen = session_.observation();
    const auto way = [&](const Neighbour& place) {
      const ViewpointIndex there = session_.viewpoint_of(place.name);
      return graph_.distance(there, *goal) + graph_.distance(here, there);
    };
    const auto best = std::ranges::min_element(seen.places, {}, way);
    return best == seen.places.end() ? stop() : go_to(*best);
  }

 private:
  static const tasks::EpisodeSet& episodes_of(const World& world) {
    return *world.episodes().on_graph();
  }
  Call finish() const {
    const auto* object = std::get_if<tasks::SeenObject>(&path_.goal);
    if (object == nullptr) return stop();
    for (const VisibleObject& thing : session_.observation().things) {
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

Follower GraphWorld::follow(Rule rule, const Session& session, std::uint64_t seed) const {
  const auto& walked = dynamic_cast<const GraphSession&>(session);
  switch (rule) {
    case Rule::kRandom:
      return RandomRule(walked, seed);
    case Rule::kOracle:
      return Oracle(*this, walked);
    case Rule::kStop:
      return stop;
    case Rule::kFirst:
      break;
  }
  return [&places = session.observation().places]() -> Call {
    return places.empty() ? Call{std::string(name_of(Tool::kLook)), "left"} : go_to(places[0]);
  };
}

Follower FloorWorld::follow(Rule rule, const Session& session, std::uint64_t seed) const {
  if (rule == Rule::kStop) return stop;
  if (rule == Rule::kFirst) {
    return [] { return Call{std::string(name_of(Tool::kMove)), "forward"}; };
  }
  // The agent's walk through this episode alone: what it does depends on nothing else.
  auto alone = std::make_shared<tasks::ContinuousEpisodes>();
  alone->split = split();
  alone->episodes.push_back(episodes().continuous()->episodes[session.episode()]);
  const auto agent = agents::make_continuous_agent(rule == Rule::kOracle ? "shortest" : "random");
  auto walks = agents::run_continuous(
      *agent, *alone, buildings_,
      {.batch_size = 1,
       .seed = seed,
       .simulator = agents::continuous_setup(episodes().benchmark()).simulator});
  return [actions = std::move(walks[0].actions), at = std::size_t{0}]() mutable {
    return next_moves(actions, at);
  };
}

}  // namespace enfilade::arena
