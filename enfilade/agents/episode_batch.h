/// \file  A batch of episodes in one simulator.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/sim/simulator.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/goal_distance.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/results.h"

namespace enfilade::agents {

/// Where an episode starts: its path's first viewpoint and heading, elevation 0.
sim::EpisodeStart start_of(const tasks::EpisodeSet& episodes, std::size_t episode);

/// Episodes in slots 0 .. size() - 1. Each slot has its episode, its agent's pose, its trajectory
/// so far, and whether it has ended. Agents, environments and training are built on it. An *action
/// space* gives their actions a meaning (six actions, a neighbour of the list, ...). It is a
/// function from a number and a slot's state to a sim::Action. A new action space needs no change
/// here.
///
/// All slots step together, since the simulator steps its whole batch. Give ended ones the action
/// {}: they do not move. step() allocates nothing until a trajectory is longer than
/// `reserved_steps`. One thread at a time.
class EpisodeBatch {
 public:
  /// `episodes` has to outlive *this. `config.batch_size` is size(). Every slot has ended until
  /// begin(). \param reserved_steps that trajectories have memory for from the start
  /// \throws ArgumentError as sim::Simulator
  EpisodeBatch(const tasks::EpisodeSet& episodes, const sim::SimulatorConfig& config,
               std::size_t reserved_steps = 0);

  std::size_t size() const noexcept { return simulator_.batch_size(); }
  const tasks::EpisodeSet& episodes() const noexcept { return episodes_; }
  const sim::SimulatorConfig& config() const noexcept { return simulator_.config(); }
  const sim::StateSpans& state() const noexcept { return simulator_.state(); }

  /// Begins an episode in every slot. \param episodes indices into EpisodeSet::episodes
  /// \throws ArgumentError for another number than size(), or an index out of range; errors of
  /// graph files. Then nothing has happened.
  void begin(std::span<const std::size_t> episodes);
  /// Begins one in a slot. \pre slot < size() (here and below) \throws as begin() of all
  void begin(std::size_t slot, std::size_t episode);

  /// One action per slot; slots that have not ended add a point to their trajectories.
  /// \throws as sim::Simulator::step(); then nothing has changed
  void step(std::span<const sim::Action> actions);
  /// Moves the agent of a slot along edges, as one action. Each viewpoint becomes a point of its
  /// trajectory, with the pose of the arrival, which is that of view `view` (0..35). Others stay.
  /// \pre `path` is not empty, its viewpoints are included; the slot has not ended
  void walk(std::size_t slot, std::span<const ViewpointIndex> path, std::uint32_t view);
  /// Ends the slot's episode: its trajectory does not change until the next begin().
  void end(std::size_t slot);

  /// The answer of the agent in a slot; it replaces earlier answers of this episode.
  void give(std::size_t slot, const Answer& answer);

  bool ended(std::size_t slot) const { return ended_[slot] != 0; }
  std::span<const std::uint8_t> ended() const noexcept { return ended_; }  ///< (size()) 1: ended
  std::size_t running() const noexcept { return running_; }  ///< slots that have not ended

  /// The slot's episode: its index, the episode, its reference path, its graph.
  /// \pre begin() was called for the slot
  std::size_t index(std::size_t slot) const { return trajectories_[slot].episode; }
  const tasks::Episode& episode(std::size_t slot) const { return episodes_.episodes[index(slot)]; }
  const tasks::ReferencePath& path(std::size_t slot) const {
    return episodes_.path_of(episode(slot));
  }
  const graph::NavGraph& graph(std::size_t slot) const { return *graphs_[slot]; }
  /// Distance along the graph to the goal, metres (tasks/goal_distance.h). R2R-Back: through the
  /// turning point, until take_leg() has found it there. NaN if the goal is hidden.
  double distance_to_goal(std::size_t slot) const;
  /// Whether stopping here would be a success: tasks::goal_reached().
  bool reached(std::size_t slot, double radius) const;
  /// R2R-Back: an agent within `radius` metres of the turning point is on the way back from now on.
  void take_leg(std::size_t slot, double radius) {
    take_leg(slot, state().viewpoint[slot], radius);
  }
  /// The same for a viewpoint that it has passed on the way.
  void take_leg(std::size_t slot, ViewpointIndex passed, double radius);
  /// The viewpoint to go to from here: tasks::nearest_goal(). No value if the goal is hidden or out
  /// of reach.
  std::optional<ViewpointIndex> nearest_goal(std::size_t slot) const;
  /// The slot's observation, without `rng`. Valid until the next step() or begin().
  Observation observation(std::size_t slot) const;

  /// The start, then one entry per action until end(), as in results files.
  const tasks::Trajectory& trajectory(std::size_t slot) const { return trajectories_[slot]; }
  std::span<const tasks::Trajectory> trajectories() const noexcept { return trajectories_; }
  /// All of them, moved out; every slot has ended then.
  std::vector<tasks::Trajectory> take_trajectories();

 private:
  void check_episode(std::size_t episode) const;
  void began(std::size_t slot, std::size_t episode);
  void record(std::size_t slot);
  std::span<const tasks::ViewedObject> objects_around(std::size_t slot) const;

  const tasks::EpisodeSet& episodes_;
  sim::Simulator simulator_;
  std::vector<const graph::NavGraph*> graphs_;
  std::vector<std::uint8_t> ended_;
  std::size_t running_ = 0;
  std::size_t reserved_steps_;
  std::vector<tasks::Trajectory> trajectories_;
  std::vector<tasks::Leg> legs_;  // by slot
};

}  // namespace enfilade::agents
