/// \file  Agents for continuous environments: an observation in, an action out.
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/continuous/follower.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/core/rng.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::agents {

/// Input of an agent in one episode. Valid during the call that it is passed to.
struct ContinuousObservation {
  const tasks::ContinuousEpisode* episode = nullptr;  ///< goals and path are for oracles only
  const continuous::Buildings* buildings = nullptr;   ///< for oracles only
  std::size_t building = 0;
  continuous::Pose pose;
  continuous::FloorPoint floor;  ///< where it stands
  bool collided = false;         ///< whether a wall stopped its last action
  std::uint32_t step = 0;        ///< actions so far
  Rng* rng = nullptr;            ///< this episode's own random numbers
  bool ended = false;            ///< the episode is over; the action is ignored
};

/// Implement this to run an agent with run_continuous(). Keep the state of each episode in arrays
/// by slot.
class ContinuousAgent {
 public:
  virtual ~ContinuousAgent() = default;
  virtual std::string_view name() const = 0;
  /// True for oracles, which cannot run where the goal is hidden.
  virtual bool needs_goal() const { return false; }
  /// A new episode begins in a slot, in a simulator of this config.
  virtual void start(std::size_t slot, const ContinuousObservation& seen,
                     const continuous::SimulatorConfig& config) = 0;
  /// Decides for each slot that has not ended. \pre actions.size() == batch.size()
  virtual void act(std::span<const ContinuousObservation> batch,
                   std::span<continuous::Action> actions) = 0;
};

/// Agents by name:
/// - "random": forward, left, right and stop with their shares in VLN-CE's training data, 0.68,
///   0.15, 0.15 and 0.02 (Krantz et al. 2020, section 4)
/// - "forward": turns to a random heading, goes 37 steps, the mean of that data, and stops (the
///   same)
/// - "shortest": the shortest path to the goal
/// - "reference": along the reference path, as VLN-CE's experts
///
/// \throws LookupError listing the names
std::unique_ptr<ContinuousAgent> make_continuous_agent(std::string_view name);
/// The agent "reference" as a teacher of an agent that may leave the path. It gives up no point,
/// and leads back an agent that passes the last one. If every point can be reached, an agent that
/// follows all its advice has the trajectory of "reference".
std::unique_ptr<ContinuousAgent> make_patient_reference();
/// An agent that follows given routes, by the ids of episodes as text. A route is points of the
/// floor. It visits them in order, to within 0.5 m, and stops at the last, to within 0.25 m. An
/// episode without a route stops at once. For decisions that were made elsewhere, such as in a
/// graph.
std::unique_ptr<ContinuousAgent> make_route_agent(
    std::string name, std::map<std::string, std::vector<Vec3d>, std::less<>> routes);
std::vector<std::string> continuous_agent_names();

}  // namespace enfilade::agents
