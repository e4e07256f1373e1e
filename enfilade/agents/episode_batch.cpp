#include "enfilade/agents/episode_batch.h"

#include <fmt/format.h>
#include <limits>
#include <utility>

#include "enfilade/agents/panorama.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::agents {

sim::EpisodeStart start_of(const tasks::EpisodeSet& episodes, std::size_t episode) {
  const tasks::ReferencePath& path = episodes.path_of(episodes.episodes[episode]);
  return {{path.scan, path.viewpoints.front()}, path.heading, Radians(0)};
}

EpisodeBatch::EpisodeBatch(const tasks::EpisodeSet& episodes, const sim::SimulatorConfig& config,
                           std::size_t reserved_steps)
    : episodes_(episodes),
      simulator_(episodes.graphs, config),
      graphs_(config.batch_size),
      ended_(config.batch_size, 1),
      reserved_steps_(reserved_steps),
      trajectories_(config.batch_size),
      legs_(config.batch_size, tasks::Leg::kOut) {}

void EpisodeBatch::check_episode(std::size_t episode) const {
  if (episode < episodes_.episodes.size()) return;
  throw ArgumentError(fmt::format("episode {}: split {} has {}", episode, episodes_.split,
                                  episodes_.episodes.size()));
}

void EpisodeBatch::begin(std::span<const std::size_t> episodes) {
  if (episodes.size() != size()) {
    throw ArgumentError(
        fmt::format("{} episodes for a batch of {}: as many are needed", episodes.size(), size()));
  }
  std::vector<sim::EpisodeStart> starts;
  starts.reserve(size());
  for (const std::size_t episode : episodes) {
    check_episode(episode);
    starts.push_back(start_of(episodes_, episode));
  }
  simulator_.new_episodes(starts);
  for (std::size_t i = 0; i < size(); ++i) began(i, episodes[i]);
}

void EpisodeBatch::begin(std::size_t slot, std::size_t episode) {
  check_episode(episode);
  simulator_.new_episode(slot, start_of(episodes_, episode));
  began(slot, episode);
}

void EpisodeBatch::began(std::size_t slot, std::size_t episode) {
  graphs_[slot] = &episodes_.graph_of(episodes_.episodes[episode]);
  tasks::Trajectory& trajectory = trajectories_[slot];
  trajectory.episode = episode;
  trajectory.points.clear();
  trajectory.actions.reset();
  give(slot, {});
  legs_[slot] = tasks::Leg::kOut;
  trajectory.points.reserve(reserved_steps_ + 1);
  running_ += ended_[slot];
  ended_[slot] = 0;
  record(slot);
}

void EpisodeBatch::step(std::span<const sim::Action> actions) {
  simulator_.step(actions);
  for (std::size_t i = 0; i < size(); ++i) {
    if (ended_[i] != 0) continue;
    record(i);
    if (trajectories_[i].actions) ++*trajectories_[i].actions;
  }
}

void EpisodeBatch::walk(std::size_t slot, std::span<const ViewpointIndex> path,
                        std::uint32_t view) {
  const Radians heading = view_heading(view), elevation = view_elevation(view);
  simulator_.new_episode(slot, {{this->path(slot).scan, path.back()}, heading, elevation});
  tasks::Trajectory& trajectory = trajectories_[slot];
  trajectory.actions = trajectory.actions.value_or(trajectory.points.size() - 1) + 1;
  for (const ViewpointIndex viewpoint : path) {
    trajectory.points.push_back({viewpoint, heading, elevation});
  }
}

void EpisodeBatch::end(std::size_t slot) {
  if (ended_[slot] != 0) return;
  ended_[slot] = 1;
  --running_;
}

void EpisodeBatch::give(std::size_t slot, const Answer& answer) {
  tasks::Trajectory& trajectory = trajectories_[slot];
  trajectory.turning_point = answer.turning_point;
  trajectory.object = answer.object;
  trajectory.point = answer.point;
}

double EpisodeBatch::distance_to_goal(std::size_t slot) const {
  return tasks::distance_to_goal(graph(slot), path(slot), state().viewpoint[slot], legs_[slot]);
}

bool EpisodeBatch::reached(std::size_t slot, double radius) const {
  return tasks::goal_reached(graph(slot), path(slot), state().viewpoint[slot], legs_[slot], radius);
}

void EpisodeBatch::take_leg(std::size_t slot, ViewpointIndex passed, double radius) {
  legs_[slot] = tasks::leg_after(graph(slot), path(slot), passed, legs_[slot], radius);
}

std::optional<ViewpointIndex> EpisodeBatch::nearest_goal(std::size_t slot) const {
  return tasks::nearest_goal(graph(slot), path(slot), state().viewpoint[slot], legs_[slot]);
}

std::span<const tasks::ViewedObject> EpisodeBatch::objects_around(std::size_t slot) const {
  if (episodes_.objects == nullptr) return {};
  const graph::NavGraph& here = graph(slot);
  return episodes_.objects->at(here.scan(), here.id(state().viewpoint[slot]));
}

Observation EpisodeBatch::observation(std::size_t slot) const {
  const sim::StateSpans& now = state();
  const std::size_t row = slot * config().max_navigable;
  const std::size_t n = now.navigable_count[slot];
  return {.episode = &episode(slot),
          .graph = graphs_[slot],
          .reference = path(slot).viewpoints,
          .path = &path(slot),
          .task = episodes_.task,
          .objects = objects_around(slot),
          .viewpoint = now.viewpoint[slot],
          .heading = Radians(now.heading[slot]),
          .elevation = Radians(now.elevation[slot]),
          .view_index = now.view_index[slot],
          .step = static_cast<std::uint32_t>(trajectories_[slot].actions.value_or(now.step[slot])),
          .navigable = {now.navigable_viewpoint.subspan(row, n),
                        now.navigable_rel_heading.subspan(row, n),
                        now.navigable_rel_elevation.subspan(row, n),
                        now.navigable_distance.subspan(row, n)},
          .rng = nullptr,
          .ended = ended(slot)};
}

void EpisodeBatch::record(std::size_t slot) {
  const sim::StateSpans& now = state();
  trajectories_[slot].points.push_back(
      {now.viewpoint[slot], Radians(now.heading[slot]), Radians(now.elevation[slot])});
}

std::vector<tasks::Trajectory> EpisodeBatch::take_trajectories() {
  for (std::size_t i = 0; i < size(); ++i) end(i);
  return std::exchange(trajectories_, std::vector<tasks::Trajectory>(size()));
}

}  // namespace enfilade::agents
