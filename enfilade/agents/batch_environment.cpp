#include "enfilade/agents/batch_environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/agents/simple_agents.h"
#include "enfilade/agents/six_actions.h"
#include "enfilade/core/errors.h"

namespace enfilade::agents {
namespace {

constexpr double kStopReward = 2;

sim::SimulatorConfig simulator_config(const EnvironmentConfig& config) {
  auto simulator = sim::SimulatorConfig::room_to_room();
  simulator.batch_size = config.batch_size;
  simulator.camera = config.camera;
  simulator.max_navigable = config.max_navigable;
  if (config.actions == ActionSpace::kViewpoint) {
    simulator.viewing = sim::Viewing::kContinuous;
    simulator.navigation = sim::Navigation::kUnrestricted;
  }
  return simulator;
}

void validate(const tasks::EpisodeSet& episodes, const EnvironmentConfig& config) {
  if (episodes.episodes.empty()) {
    throw ArgumentError(fmt::format("split {} has no episodes", episodes.split));
  }
  if (config.max_steps == 0) throw ArgumentError("max_steps 0: at least 1 is needed");
  if (!(config.success_distance > 0)) {
    throw ArgumentError(
        fmt::format("success_distance {}: more than 0 m is needed", config.success_distance));
  }
  for (const tasks::ReferencePath& path : episodes.paths) {
    const graph::NavGraph& graph = episodes.graphs->graph(path.scan);
    if (graph.max_degree() < config.max_navigable) continue;
    throw ArgumentError(fmt::format("max_navigable {}: scan {} has a viewpoint with {} neighbours",
                                    config.max_navigable, graph.scan(), graph.max_degree()));
  }
  if (config.reward == Reward::kNone) return;
  for (const tasks::ReferencePath& path : episodes.paths) {
    if (!goal_hidden(path)) continue;
    throw ArgumentError(fmt::format("split {} hides its goals (path {}), so there is no reward",
                                    episodes.split, path.path_id));
  }
}

// 0 if the goal is out of reach, as an object that no viewpoint sees is.
double nearer(double before, double now) {
  return std::isfinite(before) && std::isfinite(now) ? before - now : 0;
}

std::int64_t count_actions(const tasks::EpisodeSet& episodes, const EnvironmentConfig& config) {
  if (config.actions == ActionSpace::kSixActions) return kSixActionCount;
  if (config.actions != ActionSpace::kMap) return static_cast<std::int64_t>(config.max_navigable);
  std::size_t most = 0;
  for (const tasks::ReferencePath& path : episodes.paths) {
    most = std::max(most, episodes.graphs->graph(path.scan).included_count());
  }
  return static_cast<std::int64_t>(most) + 1;
}

double length(const graph::NavGraph& graph, ViewpointIndex from, ViewpointIndex to) {
  const graph::Edge* edge = graph.edge(from, to);
  if (edge == nullptr) edge = graph.edge(to, from);  // maps have one-way edges in both directions
  return edge->length;
}

void check_length(const char* name, std::size_t found, std::size_t wanted) {
  if (found == wanted) return;
  throw ArgumentError(fmt::format("{}: {} elements for {} agents", name, found, wanted));
}

}  // namespace

BatchEnvironment::BatchEnvironment(std::shared_ptr<const tasks::EpisodeSet> episodes,
                                   const EnvironmentConfig& config)
    : episodes_(std::move(episodes)),
      config_((validate(*episodes_, config), config)),
      batch_(*episodes_, simulator_config(config)),
      actions_(config.batch_size) {
  const std::size_t n = config.batch_size;
  outcome_.reward.resize(n);
  for (auto* flags : {&outcome_.terminated, &outcome_.truncated, &outcome_.began}) flags->resize(n);
  for (auto* reals : {&outcome_.distance, &outcome_.success, &outcome_.spl, &walked_}) {
    reals->resize(n);
  }
  outcome_.episode.resize(n);
  outcome_.actions.resize(n);
  passed_.resize(n);
  action_count_ = count_actions(*episodes_, config_);
  if (has_panoramas()) {
    auto published = sim::SimulatorConfig::room_to_room();
    published.max_navigable = config.max_navigable;
    panoramas_ = std::make_unique<PanoramaCache>(episodes_->graphs, published);
    seen_.resize(n);
  }
  if (config.actions == ActionSpace::kMap) maps_.resize(n);
  for (std::size_t i = 0; i < n; ++i) rngs_.emplace_back(config.seed + i);
}

void BatchEnvironment::seed(std::size_t agent, std::uint64_t seed) { rngs_[agent] = Rng(seed); }

void BatchEnvironment::begin(std::size_t agent, std::size_t episode) {
  batch_.begin(agent, episode);
  outcome_.episode[agent] = static_cast<std::uint32_t>(episode);
  outcome_.began[agent] = 1;
  outcome_.reward[agent] = 0;
  outcome_.terminated[agent] = outcome_.truncated[agent] = 0;
  batch_.take_leg(agent, config_.success_distance);
  outcome_.distance[agent] = batch_.distance_to_goal(agent);
  walked_[agent] = 0;
  passed_[agent] = 1;
  outcome_.actions[agent] = 0;
  if (!maps_.empty()) maps_[agent].clear();
  look(agent);
}

// Panorama and map of where an agent has come to.
void BatchEnvironment::look(std::size_t agent) {
  if (!has_panoramas()) return;
  const graph::Location here{state().scan[agent], state().viewpoint[agent]};
  seen_[agent] = &panoramas_->at(here);
  if (maps_.empty()) return;
  maps_[agent].arrive(batch_.graph(agent), here.viewpoint, seen_[agent]->candidates,
                      outcome_.actions[agent]);
}

void BatchEnvironment::reset(std::span<const std::uint8_t> mask,
                             std::span<const std::int64_t> chosen) {
  const std::size_t n = config_.batch_size;
  if (!mask.empty()) check_length("mask", mask.size(), n);
  if (!chosen.empty()) check_length("episodes", chosen.size(), n);
  const auto count = static_cast<std::int64_t>(episodes_->episodes.size());
  for (std::size_t i = 0; i < n; ++i) {
    const bool wanted = mask.empty() || mask[i] != 0;
    if (!wanted && !started_) {
      throw ArgumentError("mask: the first reset() has to be of all agents");
    }
    if (!wanted || chosen.empty() || chosen[i] < count) continue;
    throw ArgumentError(fmt::format("episodes: {} for agent {}: the split {} has 0 to {}",
                                    chosen[i], i, episodes_->split, count - 1));
  }
  for (std::size_t i = 0; i < n; ++i) {
    outcome_.began[i] = 0;
    if (!mask.empty() && mask[i] == 0) continue;
    const bool draw = chosen.empty() || chosen[i] < 0;
    begin(i, draw ? rngs_[i].below(static_cast<std::uint64_t>(count))
                  : static_cast<std::size_t>(chosen[i]));
  }
  started_ = true;
}

void BatchEnvironment::check_actions(std::span<const std::int64_t> actions) const {
  check_length("actions", actions.size(), config_.batch_size);
  if (!started_) throw ArgumentError("step(): reset() has to come first");
  for (std::size_t i = 0; i < actions.size(); ++i) {
    if (batch_.ended(i) && !config_.reset_at_next_step) {
      throw ArgumentError(
          fmt::format("agent {}: its episode has ended; reset() begins another", i));
    }
    if (actions[i] >= 0 && actions[i] < action_count()) continue;
    throw ArgumentError(
        fmt::format("agent {}: action {}: 0 to {} are allowed", i, actions[i], action_count() - 1));
  }
}

sim::Action BatchEnvironment::action_of(std::size_t agent, std::int64_t number) const {
  const sim::StateSpans& now = state();
  const std::uint32_t count = now.navigable_count[agent];
  if (config_.actions == ActionSpace::kSixActions) {
    return to_action(static_cast<SixAction>(number), count);
  }
  if (number == 0 || number >= count) return {};
  const auto index = static_cast<std::uint32_t>(number);
  const std::size_t row = agent * config_.max_navigable + index;
  return {index, Radians(now.navigable_rel_heading[row]), Radians(-now.elevation[agent])};
}

// Where an action leads, into way_; returns the view at its end.
std::uint32_t BatchEnvironment::plan(std::size_t agent, std::int64_t number) {
  const ViewpointIndex here = state().viewpoint[agent];
  const std::uint32_t view = state().view_index[agent];
  way_.assign(1, here);
  if (number == 0) return view;
  const auto k = static_cast<std::size_t>(number - 1);
  if (maps_.empty()) {
    const std::vector<sim::Candidate>& candidates = seen_[agent]->candidates;
    if (k >= candidates.size()) return view;
    way_[0] = candidates[k].viewpoint;
    return candidates[k].view;
  }
  const TopologicalMap& map = maps_[agent];
  const auto node = static_cast<TopologicalMap::Node>(k);
  if (k >= map.size() || map.visited(node)) return view;
  map.path(map.find(here).value(), node, way_);
  const ViewpointIndex last = way_.size() > 1 ? way_[way_.size() - 2] : here;
  return arrival_view(panoramas_->at({state().scan[agent], last}), way_.back()).value_or(view);
}

void BatchEnvironment::step(std::span<const std::int64_t> actions) {
  check_actions(actions);
  if (has_panoramas()) {
    for (std::size_t i = 0; i < actions.size(); ++i) {
      if (batch_.ended(i)) continue;
      const std::uint32_t view = plan(i, actions[i]);
      batch_.walk(i, way_, view);
    }
  } else {
    for (std::size_t i = 0; i < actions.size(); ++i) {
      actions_[i] = batch_.ended(i) ? sim::Action{} : action_of(i, actions[i]);
    }
    batch_.step(actions_);
  }
  const bool six = config_.actions == ActionSpace::kSixActions;
  const std::int64_t stop = six ? static_cast<std::int64_t>(SixAction::kStop) : 0;
  for (std::size_t i = 0; i < actions.size(); ++i) {
    outcome_.began[i] = 0;
    if (batch_.ended(i)) {
      begin(i, rngs_[i].below(episodes_->episodes.size()));
    } else {
      ++outcome_.actions[i];
      judge(i, actions[i] == stop);
    }
  }
}

// Counts what an agent has walked since the last call, viewpoint by viewpoint.
void BatchEnvironment::pass(std::size_t agent) {
  const std::vector<tasks::TrajectoryPoint>& points = batch_.trajectory(agent).points;
  for (std::size_t& i = passed_[agent]; i < points.size(); ++i) {
    const ViewpointIndex from = points[i - 1].viewpoint, to = points[i].viewpoint;
    if (from == to) continue;
    walked_[agent] += length(batch_.graph(agent), from, to);
    batch_.take_leg(agent, to, config_.success_distance);
  }
}

void BatchEnvironment::judge(std::size_t agent, bool stopped) {
  const std::vector<tasks::TrajectoryPoint>& points = batch_.trajectory(agent).points;
  const bool moved = points[passed_[agent] - 1].viewpoint != points.back().viewpoint;
  const double before = outcome_.distance[agent];
  pass(agent);
  if (moved) look(agent);
  const double now = moved ? batch_.distance_to_goal(agent) : before;
  const bool success = stopped && batch_.reached(agent, config_.success_distance);
  double reward = 0;
  if (config_.reward == Reward::kSuccess) reward = success ? 1 : 0;
  if (config_.reward == Reward::kProgress) {
    reward =
        (moved ? nearer(before, now) : 0) + (stopped ? (success ? kStopReward : -kStopReward) : 0);
  }
  outcome_.distance[agent] = now;
  outcome_.reward[agent] = reward;
  outcome_.terminated[agent] = stopped ? 1 : 0;
  outcome_.truncated[agent] = !stopped && outcome_.actions[agent] >= config_.max_steps ? 1 : 0;
  if ((outcome_.terminated[agent] | outcome_.truncated[agent]) != 0) finish(agent);
}

// An agent that is cut off is scored as if it had stopped where it is.
void BatchEnvironment::finish(std::size_t agent) {
  batch_.end(agent);
  const double distance = outcome_.distance[agent];
  const double success = batch_.reached(agent, config_.success_distance) ? 1 : 0;
  const double shortest =
      tasks::shortest_to_goal(batch_.graph(agent), batch_.path(agent), state().viewpoint[agent]);
  // Also where the end is out of reach, and `shortest` infinite.
  const double share = walked_[agent] > shortest ? shortest / walked_[agent] : 1;
  const bool hidden = std::isnan(distance);
  outcome_.success[agent] = hidden ? distance : success;
  outcome_.spl[agent] = hidden ? distance : success * share;
}

void BatchEnvironment::check_agent(std::size_t agent) const {
  if (agent < config_.batch_size && started_) return;
  throw ArgumentError(
      fmt::format("agent {} of {}: no episode was begun", agent, config_.batch_size));
}

const Panorama& BatchEnvironment::panorama(std::size_t agent) const {
  check_agent(agent);
  if (has_panoramas()) return *seen_[agent];
  throw ArgumentError("panorama(): only the panoramic and the map action space have them");
}

const TopologicalMap& BatchEnvironment::map(std::size_t agent) const {
  check_agent(agent);
  if (!maps_.empty()) return maps_[agent];
  throw ArgumentError("map(): only the map action space has them");
}

std::optional<std::int64_t> BatchEnvironment::map_action(std::size_t agent, ExpertRule rule) const {
  if (goal_hidden(batch_.path(agent))) return std::nullopt;
  std::vector<ViewpointIndex> walked;
  for (const tasks::TrajectoryPoint& point : batch_.trajectory(agent).points) {
    if (walked.empty() || walked.back() != point.viewpoint) walked.push_back(point.viewpoint);
  }
  const std::vector<ViewpointIndex>& reference = batch_.path(agent).viewpoints;
  const TopologicalMap& map = maps_[agent];
  const auto to = map_expert({batch_.graph(agent), map, walked, reference}, rule);
  if (!to) return std::nullopt;
  return *to == walked.back() ? 0 : std::int64_t{map.find(*to).value()} + 1;
}

// The action that leads to a neighbour.
std::int64_t BatchEnvironment::action_to(std::size_t agent, ViewpointIndex neighbour) const {
  if (config_.actions == ActionSpace::kPanoramic) {
    const std::vector<sim::Candidate>& candidates = seen_[agent]->candidates;
    const auto found = std::ranges::find(candidates, neighbour, &sim::Candidate::viewpoint);
    return found - candidates.begin() + 1;
  }
  const auto list = state().navigable_viewpoint.subspan(agent * config_.max_navigable,
                                                        state().navigable_count[agent]);
  return std::ranges::find(list, neighbour) - list.begin();
}

std::optional<std::int64_t> BatchEnvironment::expert(std::size_t agent, ExpertRule rule) const {
  check_agent(agent);
  if (config_.actions == ActionSpace::kMap) return map_action(agent, rule);
  const auto goal = batch_.nearest_goal(agent);
  if (!goal) return std::nullopt;
  if (config_.actions == ActionSpace::kSixActions) {
    return static_cast<std::int64_t>(
        six_action_of(teacher_decision(batch_.observation(agent), *goal)));
  }
  const ViewpointIndex here = state().viewpoint[agent];
  const auto next = next_on_shortest(batch_.graph(agent), here, *goal);
  if (!next) return std::nullopt;
  return *next == here ? 0 : action_to(agent, *next);
}

tasks::EpisodeMetrics BatchEnvironment::compute_metrics(std::size_t agent) const {
  check_agent(agent);
  const tasks::ReferencePath& path = batch_.path(agent);
  if (goal_hidden(path)) {
    throw ArgumentError(fmt::format("path {} hides its goal", path.path_id));
  }
  std::vector<ViewpointIndex> walked;
  for (const auto& point : batch_.trajectory(agent).points) walked.push_back(point.viewpoint);
  return tasks::compute_metrics(batch_.graph(agent), walked, path.viewpoints,
                                {config_.success_distance});
}

}  // namespace enfilade::agents
