/// \file  The interface of agents: a batch of observations in, a decision for each out.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/core/ids.h"
#include "enfilade/core/rng.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/results.h"

namespace enfilade::agents {

/// The viewpoints that an agent can move to; entry 0 is the one where it stands.
struct NavigableView {
  std::span<const ViewpointIndex> viewpoint;
  std::span<const double> rel_heading;    ///< radians, right positive
  std::span<const double> rel_elevation;  ///< radians, up positive
  std::span<const double> distance;       ///< metres
  std::size_t size() const noexcept { return viewpoint.size(); }
};

/// Input of an agent in one episode. Valid during the call that it is passed to.
struct Observation {
  const tasks::Episode* episode = nullptr;    ///< the instruction
  const graph::NavGraph* graph = nullptr;     ///< of the building; for oracles only
  std::span<const ViewpointIndex> reference;  ///< start to goal; for oracles only
  /// The same path with its `goal`; for oracles only.
  const tasks::ReferencePath* path = nullptr;
  tasks::Task task = tasks::Task::kR2r;  ///< the benchmark, which decides the expected answer
  /// The objects around the viewpoint, visible in its pictures or not (ViewedObject::visible).
  /// Empty if the episodes have no objects.
  std::span<const tasks::ViewedObject> objects;
  ViewpointIndex viewpoint;
  Radians heading, elevation;
  std::uint32_t view_index = 0;
  std::uint32_t step = 0;  ///< actions so far
  NavigableView navigable;
  Rng* rng = nullptr;  ///< this episode's own random numbers
  bool ended = false;  ///< the episode is over; the decision is ignored
};

/// Answer that some benchmarks require beside the path. At most one field counts. The path is
/// scored without an answer, too.
struct Answer {
  std::optional<ViewpointIndex> turning_point = {};  ///< R2R-Back: where it turned
  std::string object = {};                           ///< REVERIE: the object's id; empty: none
  std::optional<tasks::SpherePoint> point = {};      ///< SOON: where the object is
  friend bool operator==(const Answer&, const Answer&) = default;
};

/// An action: stop for good, or go to an entry of the navigable list (0: stay) and turn.
struct Decision {
  bool stop = true;
  std::uint32_t index = 0;
  Radians heading_change;    ///< right positive; one view of 30 degrees, only its sign counts
  Radians elevation_change;  ///< up positive; likewise
  /// Given with any decision; the last one of an episode counts.
  std::optional<Answer> answer = {};

  /// Stops for good.
  static Decision stop_here() { return {}; }
  /// The same, with an answer.
  static Decision stop_with(Answer answer) { return {true, 0, {}, {}, std::move(answer)}; }
  /// Goes to an entry of the navigable list.
  static Decision go(std::uint32_t index) { return {false, index, {}, {}, {}}; }
  /// Turns by so much, radians; right and up are positive.
  static Decision turn(double right, double up = 0) {
    return {false, 0, Radians(right), Radians(up), {}};
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
