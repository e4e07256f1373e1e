#include "enfilade/agents/continuous_environment.h"

#include <fmt/format.h>

#include <limits>
#include <numeric>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::agents {

using continuous::Action;
using continuous::EpisodeState;

namespace {

ContinuousWorld checked(ContinuousWorld world, const continuous::SimulatorConfig& config) {
  if (!world.episodes) throw ArgumentError("episodes: null");
  if (!world.buildings) throw ArgumentError("buildings: null");
  if (world.episodes->episodes.empty()) {
    throw ArgumentError(fmt::format("episodes: {} has none", world.episodes->file));
  }
  if (!world.experts) world.experts = std::make_shared<const tasks::ExpertWalks>();
  check_starts(*world.episodes, *world.buildings, config.start_reach);
  std::vector<std::size_t> all(world.episodes->episodes.size());
  std::iota(all.begin(), all.end(), 0);
  check_goals(*world.episodes, *world.buildings, all);
  return world;
}

std::vector<Vec3d> points_of(const tasks::ContinuousEpisode& episode, ContinuousExpert rule) {
  if (rule == ContinuousExpert::kReference && episode.reference_path) {
    return *episode.reference_path;
  }
  return {episode.goals->front().position};
}

}  // namespace

ContinuousEnvironment::ContinuousEnvironment(ContinuousWorld world,
                                             const continuous::SimulatorConfig& config)
    : world_(checked(std::move(world), config)),
      simulator_(world_.buildings, config),
      slots_(config.batch_size),
      episode_(config.batch_size),
      distance_(config.batch_size, std::numeric_limits<double>::quiet_NaN()) {}

void ContinuousEnvironment::begin(std::span<const std::int64_t> chosen) {
  if (chosen.size() != slots_.size()) {
    throw ArgumentError(
        fmt::format("chosen: {} elements for a batch of {}", chosen.size(), slots_.size()));
  }
  const auto count = static_cast<std::int64_t>(world_.episodes->episodes.size());
  for (std::size_t a = 0; a < chosen.size(); ++a) {
    if (chosen[a] >= count) {
      throw ArgumentError(
          fmt::format("agent {}: episode {}, but 0 to {} are allowed", a, chosen[a], count - 1));
    }
    if (chosen[a] < 0 && !slots_[a].begun) {
      throw ArgumentError(fmt::format("agent {} has no episode yet, so it cannot be left out", a));
    }
  }
  for (std::size_t a = 0; a < chosen.size(); ++a) {
    if (chosen[a] >= 0) begin_one(a, static_cast<std::size_t>(chosen[a]));
  }
}

void ContinuousEnvironment::begin_one(std::size_t agent, std::size_t index) {
  const tasks::ContinuousEpisode& episode = world_.episodes->episodes[index];
  const std::size_t building = world_.buildings->at(episode.scan());
  std::optional<continuous::DistanceField> field;
  if (!episode.goal_hidden()) field = goal_field(episode, world_.buildings->floor(building));
  simulator_.new_episode(agent, start_of(episode, building));
  Slot& slot = slots_[agent];
  slot = {};
  slot.begun = true;
  slot.building = building;
  slot.field = std::move(field);
  slot.walk.episode = index;
  episode_[agent] = static_cast<std::uint32_t>(index);
  record(agent);
}

void ContinuousEnvironment::record(std::size_t agent) {
  Slot& slot = slots_[agent];
  slot.walk.positions.push_back(simulator_.state().position[agent]);
  slot.walk.headings.emplace_back(simulator_.state().heading[agent]);
  distance_[agent] = slot.field ? slot.field->distance(simulator_.floor_point(agent))
                                : std::numeric_limits<double>::quiet_NaN();
}

void ContinuousEnvironment::step(std::span<const Action> actions) {
  std::vector<std::size_t> walking;
  for (std::size_t a = 0; a < slots_.size(); ++a) {
    if (simulator_.state().episode[a] == EpisodeState::kWalking) walking.push_back(a);
  }
  simulator_.step(actions);
  for (const std::size_t a : walking) {
    slots_[a].walk.actions.push_back(static_cast<std::uint8_t>(actions[a]));
    slots_[a].walk.collided.push_back(simulator_.state().collided[a]);
    record(a);
  }
}

const ContinuousEnvironment::Slot& ContinuousEnvironment::slot(std::size_t agent) const {
  if (agent >= slots_.size()) {
    throw ArgumentError(fmt::format("agent {}: 0 to {} are allowed", agent, slots_.size() - 1));
  }
  if (!slots_[agent].begun) throw ArgumentError(fmt::format("agent {} has no episode yet", agent));
  return slots_[agent];
}

const tasks::ContinuousEpisode& ContinuousEnvironment::episode_of(const Slot& slot) const {
  return world_.episodes->episodes[slot.walk.episode];
}

const tasks::ContinuousResult& ContinuousEnvironment::walk(std::size_t agent) const {
  return slot(agent).walk;
}

void ContinuousEnvironment::make_teacher(Slot& slot, ContinuousExpert rule) const {
  const continuous::Floor& floor = world_.buildings->floor(slot.building);
  std::vector<continuous::FloorPoint> points;
  for (const Vec3d point : points_of(episode_of(slot), rule)) {
    if (const auto found = floor.nearest(to_float(point), {1, 1})) points.push_back(*found);
  }
  if (points.empty()) throw ArgumentError("expert: no floor within 1 m of the reference path");
  const bool shortest = rule == ContinuousExpert::kShortest;
  // The buildings outlive the teacher.
  slot.teacher.emplace(
      std::shared_ptr<const continuous::Floor>(std::shared_ptr<const void>(), &floor),
      std::move(points), simulator_.config(),
      continuous::FollowerConfig{.reached = 0.5, .last_reached = shortest ? 0.25 : 0.5});
  slot.rule = rule;
  slot.followed = 0;
}

std::optional<Action> ContinuousEnvironment::expert(std::size_t agent, ContinuousExpert rule) {
  if (!slot(agent).field) return std::nullopt;
  if (simulator_.state().episode[agent] != EpisodeState::kWalking) return Action::kStop;
  Slot& own = slots_[agent];
  if (!own.teacher || own.rule != rule) make_teacher(own, rule);
  const continuous::Floor& floor = world_.buildings->floor(own.building);
  for (; own.followed < own.walk.positions.size(); ++own.followed) {
    const bool now = own.followed + 1 == own.walk.positions.size();
    const auto at = now ? std::optional(simulator_.floor_point(agent))
                        : floor.nearest(own.walk.positions[own.followed], {1, 1});
    if (at) own.advice = own.teacher->next(*at, own.walk.headings[own.followed]);
  }
  return own.advice;
}

tasks::ContinuousScore ContinuousEnvironment::score(std::size_t agent) const {
  const Slot& own = slot(agent);
  if (!own.field) {
    throw ArgumentError(fmt::format("episode {} hides its goal, so there is no score",
                                    tasks::text_of(episode_of(own).id)));
  }
  return score_continuous_walk(own.walk, episode_of(own), *world_.buildings, *world_.experts);
}

}  // namespace enfilade::agents
