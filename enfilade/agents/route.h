/// \file  From a choice of viewpoints to the simulator's small steps.
#pragma once
#include <deque>
#include <optional>
#include <span>

#include "enfilade/agents/agent.h"
#include "enfilade/agents/panorama.h"

namespace enfilade::agents {

/// In which way an agent turns to the view that has its next viewpoint.
enum class Turning {
  kRight,    ///< always to the right, as in EnvDrop: its trajectories have one entry per turn
  kShorter,  ///< the shorter way
};

/// The viewpoints ahead of an agent, one after another. It turns to the view that has the next one,
/// view by view, and goes there.
class Route {
 public:
  /// A way that is done, until set().
  explicit Route(Turning turning) : turning_(turning) {}

  /// Begins anew. \param way neighbours, one after another, without the present viewpoint
  void set(std::span<const ViewpointIndex> way) { way_.assign(way.begin(), way.end()); }
  /// The next turn or move; no value at the end of the route. To be called before each action.
  /// \throws ArgumentError for a viewpoint that is not reachable from the agent's
  std::optional<Decision> next(const Observation& seen, const Panorama& panorama);

 private:
  Turning turning_;
  std::deque<ViewpointIndex> way_;
};

}  // namespace enfilade::agents
