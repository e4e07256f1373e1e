/// \file  Episodes of any benchmark as a reinforcement-learning environment: a batch of agents, one
/// action each.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/agents/episode_batch.h"
#include "enfilade/agents/experts.h"
#include "enfilade/agents/panorama.h"
#include "enfilade/agents/topological_map.h"
#include "enfilade/core/rng.h"
#include "enfilade/sim/simulator.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/metrics.h"

namespace enfilade::agents {

/// The meaning of the action numbers (the paper, section 3 and its baseline). An action that is not
/// possible leaves the agent where it is.
enum class ActionSpace {
  /// 0: stop; k: go to entry k of the navigable list, which has all neighbours, and face the
  /// direction of the move, elevation 0.
  kViewpoint,
  kSixActions,  ///< SixAction: 0 left, 1 right, 2 up, 3 down, 4 forward, 5 stop.
  /// 0: stop; k: go to candidate k - 1 of panorama(), and face its view (Fried et al. 2018; EnvDrop
  /// without its turns).
  kPanoramic,
  /// 0: stop; k: go to node k - 1 of map() if it is open, through visited ones (DUET, Chen et al.
  /// 2022). The agent then faces the view in which the last of them has it. Edges count in both
  /// directions.
  kMap,
};
constexpr std::array<std::string_view, 4> names_of(ActionSpace) {
  return {"viewpoint", "six", "panoramic", "map"};
}

/// The reward of a step.
enum class Reward {
  kNone,      ///< always 0
  kSuccess,   ///< 1 for stopping where the goal is reached (tasks::goal_reached()), else 0
  kProgress,  ///< decrease of the distance to the goal along the graph, metres, and 2 for a
              ///< successful stop, -2 for another, as in EnvDrop (Tan et al. 2019)
};

/// How many episodes run at once, with which actions and which reward.
struct EnvironmentConfig {
  std::size_t batch_size = 1;
  ActionSpace actions = ActionSpace::kViewpoint;
  Reward reward = Reward::kProgress;
  std::uint32_t max_steps = 40;  ///< actions after which an episode is cut off, >= 1
  /// Metres, for goals that use it. R2R-Back: an agent this near to the turning point has turned
  /// there, as actions have no answer.
  double success_distance = tasks::MetricOptions{}.success_distance;
  /// An agent whose episode has ended begins a new one at its next step, with any action
  /// (Gymnasium's NEXT_STEP). Otherwise reset() is required.
  bool reset_at_next_step = false;
  std::uint64_t seed = 1;  ///< of the drawn episodes: agent k has the stream of seed + k
  Camera camera;
  std::size_t max_navigable = 16;  ///< rows of a list, the present viewpoint included
};

/// The results of the last step or reset: one value per agent.
struct Outcome {
  std::vector<double> reward;
  std::vector<std::uint8_t> terminated;  ///< 1: the agent has stopped
  std::vector<std::uint8_t> truncated;   ///< 1: out of steps
  /// To the goal along the graph, metres; NaN if hidden; of R2R-Back through the turning point
  /// until the agent has been there.
  std::vector<double> distance;
  std::vector<std::uint32_t> episode;  ///< index into EpisodeSet::episodes
  std::vector<std::uint32_t> actions;  ///< taken in the present episode
  std::vector<std::uint8_t> began;     ///< 1: an episode began
  std::vector<double> success;         ///< of the ended episode: 1 or 0; NaN if hidden
  /// Likewise. R2R: as tasks::EpisodeMetrics. Other goals: tasks::goal_reached() and
  /// tasks::shortest_to_goal(). Answers do not count: for REVERIE and SOON it is navigation only.
  std::vector<double> spl;
};

/// step() allocates nothing but memory of growing trajectories, and of panoramas that are seen for
/// the first time. One thread at a time.
class BatchEnvironment {
 public:
  /// \throws ArgumentError naming the field for values out of range; for no episodes, or a reward
  /// with hidden goals
  /// \throws ArgumentError if a graph has more neighbours than max_navigable
  BatchEnvironment(std::shared_ptr<const tasks::EpisodeSet> episodes,
                   const EnvironmentConfig& config);

  /// Begins episodes for all agents, or those with mask[i] != 0. If it throws, nothing has changed.
  /// \param mask empty: all
  /// \param chosen indices of episodes, < 0: draw one; empty: draw all
  /// \throws ArgumentError for spans of another length, an index out of range, or if agents that
  /// have never begun are left out
  void reset(std::span<const std::uint8_t> mask = {}, std::span<const std::int64_t> chosen = {});
  /// Restarts an agent's stream of random episodes. \pre agent < batch_size
  void seed(std::size_t agent, std::uint64_t seed);
  /// \throws ArgumentError for another length, a number outside the action space, before reset(),
  /// or if an agent's episode has ended and reset_at_next_step is off. Then nothing has happened.
  void step(std::span<const std::int64_t> actions);

  const EnvironmentConfig& config() const noexcept { return config_; }
  const tasks::EpisodeSet& episodes() const noexcept { return *episodes_; }
  /// How many actions there are; of kMap 1 + the viewpoints of the largest building.
  std::int64_t action_count() const noexcept { return action_count_; }
  const sim::StateSpans& state() const noexcept { return batch_.state(); }
  const Outcome& outcome() const noexcept { return outcome_; }
  /// The views and candidates at an agent's viewpoint. Candidates are those of 640 x 480 pixels and
  /// 60 degrees, as published, for any camera. Valid as long as *this.
  /// \throws ArgumentError for other action spaces than kPanoramic and kMap, an agent beyond the
  /// batch, or before reset()
  const Panorama& panorama(std::size_t agent) const;
  /// An agent's map of the building in its present episode. Valid until the next step() or reset().
  /// \throws ArgumentError for other action spaces than kMap, an agent beyond the batch, or before
  /// reset()
  const TopologicalMap& map(std::size_t agent) const;
  /// The action of a teacher, an oracle. No value if the goal is hidden or out of reach, or no node
  /// is open.
  /// - kSixActions: the released R2R code's. Its "forward" leads to entry 1 of the list even if the
  ///   teacher means another one, so it may go in circles.
  /// - kMap: map_expert() by `rule`, towards the end of the annotated path.
  /// - Others: a step on the shortest path to the nearest viewpoint that satisfies the goal, and
  ///   stop on it.
  ///
  /// \throws ArgumentError for an agent beyond the batch, or before reset()
  std::optional<std::int64_t> expert(std::size_t agent, ExpertRule rule = ExpertRule::kSpl) const;
  /// All metrics of the agent's trajectory so far. O(steps * reference length).
  /// \throws ArgumentError for an agent beyond the batch, before reset(), or if the goal is hidden
  tasks::EpisodeMetrics compute_metrics(std::size_t agent) const;
  /// The agent's trajectory so far: for scorers of other benchmarks.
  /// \pre agent < batch_size, reset() was called. Valid until the next reset() or step().
  const tasks::Trajectory& trajectory(std::size_t agent) const { return batch_.trajectory(agent); }

 private:
  bool has_panoramas() const noexcept {
    return config_.actions == ActionSpace::kPanoramic || config_.actions == ActionSpace::kMap;
  }
  void check_agent(std::size_t agent) const;
  void check_actions(std::span<const std::int64_t> actions) const;
  void begin(std::size_t agent, std::size_t episode);
  sim::Action action_of(std::size_t agent, std::int64_t number) const;
  std::uint32_t plan(std::size_t agent, std::int64_t number);
  void look(std::size_t agent);
  std::optional<std::int64_t> map_action(std::size_t agent, ExpertRule rule) const;
  std::int64_t action_to(std::size_t agent, ViewpointIndex neighbour) const;
  void pass(std::size_t agent);
  void judge(std::size_t agent, bool stopped);
  void finish(std::size_t agent);

  std::shared_ptr<const tasks::EpisodeSet> episodes_;
  EnvironmentConfig config_;
  EpisodeBatch batch_;
  Outcome outcome_;
  std::vector<Rng> rngs_;
  std::vector<sim::Action> actions_;
  std::vector<double> walked_;       // metres, of the present episode
  std::vector<std::size_t> passed_;  // points of the trajectory that walked_ includes
  std::int64_t action_count_ = 0;
  std::unique_ptr<PanoramaCache> panoramas_;
  std::vector<const Panorama*> seen_;  // by agent
  std::vector<TopologicalMap> maps_;   // likewise
  std::vector<ViewpointIndex> way_;    // of plan()
  bool started_ = false;
};

}  // namespace enfilade::agents
