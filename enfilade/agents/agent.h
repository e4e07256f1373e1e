/// \file  The interface of agents: a batch of observations in, a decision for each out.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

#include "enfilade/core/ids.h"
#include "enfilade/core/rng.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::agents {

/// The viewpoints that an agent can move to; entry 0 is the one where it stands.
struct NavigableView {
  std::span<const ViewpointIndex> viewpoint;
  std::span<const double> rel_heading;    ///< radians, right positive
  std::span<const double> rel_elevation;  ///< radians, up positive
  std::span<const double> distance;       ///< metres
  std::size_t size() const noexcept { return viewpoint.size(); }
};

/// What an agent sees in one episode. Valid during the call that it is passed to.
struct Observation {
  const tasks::Episode* episode = nullptr;    ///< the instruction
  const graph::NavGraph* graph = nullptr;     ///< of the building; only oracles may look at it
  std::span<const ViewpointIndex> reference;  ///< start to goal; only oracles may look at it
  ViewpointIndex viewpoint;
  Radians heading, elevation;
  std::uint32_t view_index = 0;
  std::uint32_t step = 0;  ///< actions so far
  NavigableView navigable;
  Rng* rng = nullptr;  ///< this episode's own random numbers
  bool ended = false;  ///< the episode is over; the decision is ignored
};

/// What to do: stop for good, or go to an entry of the navigable list (0: stay) and turn.
struct Decision {
  bool stop = true;
  std::uint32_t index = 0;
  Radians heading_change;    ///< right positive; one view of 30 degrees, only its sign counts
  Radians elevation_change;  ///< up positive; likewise

  /// Stops for good.
  static Decision stop_here() { return {}; }
  /// Goes to an entry of the navigable list.
  static Decision go(std::uint32_t index) { return {false, index, {}, {}}; }
  /// Turns by so much, radians; right and up are positive.
  static Decision turn(double right, double up = 0) {
    return {false, 0, Radians(right), Radians(up)};
  }
};

/// Implement this to run an agent with run_agent(), `enfilade run` and the tables. Keep the state
/// of each episode in arrays by slot; start() begins a new episode in every slot.
class Agent {
 public:
  virtual ~Agent() = default;
  virtual std::string_view name() const = 0;
  /// True for oracles, which cannot run where the goal is hidden.
  virtual bool needs_goal() const { return false; }
  /// New episodes begin, one a slot; at most the number of slots of the last call may follow.
  virtual void start(std::span<const Observation> batch) = 0;
  /// Decides for each slot that has not ended. \pre decisions.size() == batch.size()
  virtual void act(std::span<const Observation> batch, std::span<Decision> decisions) = 0;
};

}  // namespace enfilade::agents
