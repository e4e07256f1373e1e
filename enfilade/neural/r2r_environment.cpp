#include "enfilade/neural/r2r_environment.h"

#include <fmt/format.h>
#include <algorithm>

#include "enfilade/agents/shortest.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/r2r/score.h"

namespace enfilade::neural {
namespace {

constexpr auto number(ModelAction action) { return static_cast<std::int32_t>(action); }

// Only their signs count: one view of 30 degrees.
constexpr Radians kRight(1), kLeft(-1), kUp(1), kDown(-1);

sim::SimulatorConfig simulator_config(const R2rEnvironmentConfig& config) {
  sim::SimulatorConfig simulator = sim::SimulatorConfig::room_to_room();
  simulator.batch_size = config.batch_size;  // which the simulator checks
  return simulator;
}

}  // namespace

R2rEnvironment::R2rEnvironment(const r2r::EpisodeSet& episodes, const ViewFeatures* features,
                               const R2rEnvironmentConfig& config)
    : episodes_(episodes),
      features_(features),
      config_(config),
      has_teacher_(!goals_hidden(episodes)),
      simulator_(episodes.graphs, simulator_config(config)),
      buffer_(config.batch_size, simulator_.config().max_navigable),
      state_(buffer_.spans()),
      paths_(config.batch_size),
      graphs_(config.batch_size),
      ended_(config.batch_size),
      actions_(config.batch_size),
      trajectories_(config.batch_size) {
  if (config.forward == models::ForwardTo::kIntended && !has_teacher_) {
    throw ArgumentError(fmt::format(
        "forward to the intended neighbour: the goals of split {} are hidden", episodes.split));
  }
  for (r2r::Trajectory& one : trajectories_) one.points.reserve(config.max_steps + 1);
}

std::size_t R2rEnvironment::dimensions() const {
  return features_ == nullptr ? 0 : features_->dimensions();
}

void R2rEnvironment::start(std::span<const std::size_t> episodes) {
  if (episodes.size() != size()) {
    throw ArgumentError(
        fmt::format("{} episodes for a batch of {}: as many are needed", episodes.size(), size()));
  }
  std::vector<sim::EpisodeStart> starts;
  starts.reserve(size());
  for (std::size_t i = 0; i < size(); ++i) {
    if (episodes[i] >= episodes_.episodes.size()) {
      throw ArgumentError(fmt::format("episode {}: split {} has {}", episodes[i], episodes_.split,
                                      episodes_.episodes.size()));
    }
    const r2r::Episode& episode = episodes_.episodes[episodes[i]];
    const r2r::ReferencePath& path = episodes_.path_of(episode);
    paths_[i] = &path;
    graphs_[i] = &episodes_.graph_of(episode);
    trajectories_[i].episode = episodes[i];
    trajectories_[i].points.clear();
    starts.push_back({{path.scan, path.viewpoints.front()}, path.heading, Radians(0)});
    // Shortest paths are made at their first use, which is not to fall into a step.
    if (has_teacher_) graphs_[i]->distance(path.viewpoints.front(), path.viewpoints.back());
  }
  simulator_.new_episodes(starts, state_);
  std::ranges::fill(ended_, std::uint8_t{0});
  for (std::size_t i = 0; i < size(); ++i) record(i);
}

void R2rEnvironment::observe(const EnvironmentView& out) {
  const std::size_t n = dimensions();
  for (std::size_t i = 0; i < size(); ++i) {
    if (n > 0) {
      features_->copy(state_.scan[i], state_.viewpoint[i], state_.view_index[i],
                      out.features.subspan(i * n, n));
    }
    out.forward_open[i] = state_.navigable_count[i] > 1 ? 1 : 0;
    if (!out.labels.empty()) out.labels[i] = label(i);
  }
}

bool R2rEnvironment::step(std::span<const std::int32_t> actions) {
  EN_CHECK_EQ(actions.size(), size());
  for (std::size_t i = 0; i < size(); ++i) {
    if (ended_[i] != 0 && config_.after_end == models::AfterEnd::kStays) {
      actions_[i] = {};
      continue;
    }
    actions_[i] = action_of(i, actions[i]);
    if (actions[i] == number(ModelAction::kEnd)) ended_[i] = 1;
  }
  simulator_.step(actions_, state_);
  for (std::size_t i = 0; i < size(); ++i) {
    if (ended_[i] == 0) record(i);
  }
  return std::ranges::find(ended_, std::uint8_t{0}) != ended_.end();
}

agents::Decision R2rEnvironment::teacher(std::size_t agent) const {
  const std::size_t row = agent * buffer_.max_navigable();
  const std::size_t n = state_.navigable_count[agent];
  agents::Observation seen;
  seen.graph = graphs_[agent];
  seen.viewpoint = state_.viewpoint[agent];
  seen.heading = Radians(state_.heading[agent]);
  seen.elevation = Radians(state_.elevation[agent]);
  seen.view_index = state_.view_index[agent];
  seen.navigable = {
      state_.navigable_viewpoint.subspan(row, n), state_.navigable_rel_heading.subspan(row, n),
      state_.navigable_rel_elevation.subspan(row, n), state_.navigable_distance.subspan(row, n)};
  return agents::teacher_decision(seen, paths_[agent]->viewpoints.back());
}

std::int32_t R2rEnvironment::label(std::size_t agent) const {
  const bool ended = ended_[agent] != 0;
  if (ended && config_.after_end == models::AfterEnd::kStays) return kIgnoreLabel;
  const agents::Decision decision = teacher(agent);
  if (decision.heading_change.value > 0) return number(ModelAction::kRight);
  if (decision.heading_change.value < 0) return number(ModelAction::kLeft);
  if (decision.elevation_change.value > 0) return number(ModelAction::kUp);
  if (decision.elevation_change.value < 0) return number(ModelAction::kDown);
  if (decision.index > 0) return number(ModelAction::kForward);
  return ended ? kIgnoreLabel : number(ModelAction::kEnd);
}

sim::Action R2rEnvironment::action_of(std::size_t agent, std::int32_t action) const {
  if (action == number(ModelAction::kLeft)) return {0, kLeft, {}};
  if (action == number(ModelAction::kRight)) return {0, kRight, {}};
  if (action == number(ModelAction::kUp)) return {0, {}, kUp};
  if (action == number(ModelAction::kDown)) return {0, {}, kDown};
  if (action != number(ModelAction::kForward) || state_.navigable_count[agent] < 2) return {};
  if (config_.forward == models::ForwardTo::kIntended) {
    const agents::Decision decision = teacher(agent);
    if (decision.index > 0) return {decision.index, {}, {}};
  }
  return {1, {}, {}};
}

void R2rEnvironment::record(std::size_t agent) {
  trajectories_[agent].points.push_back(
      {state_.viewpoint[agent], Radians(state_.heading[agent]), Radians(state_.elevation[agent])});
}

}  // namespace enfilade::neural
