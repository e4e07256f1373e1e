/// \file  Input of panoramic agents: the 36 views of a viewpoint, and its candidates. Their ways,
/// in small steps of the simulator.
#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/sim/candidates.h"
#include "enfilade/sim/simulator.h"

namespace enfilade::agents {

/// A viewpoint's views and candidates. They do not depend on an agent's direction.
struct Panorama {
  /// The neighbours, in the order in which turning through the views meets them.
  std::vector<sim::Candidate> candidates;
  /// The view of each of DUET's picture tokens. First those of the candidates, in their order
  /// (several may share one), then all views that no candidate has, ascending. More than 36 if some
  /// are shared.
  std::vector<std::uint32_t> token_views;
};

/// Computes panoramas, each once. One thread at a time.
class PanoramaCache {
 public:
  /// \throws ArgumentError as CandidateFinder
  explicit PanoramaCache(std::shared_ptr<const graph::GraphSet> graphs,
                         const sim::SimulatorConfig& config = sim::SimulatorConfig::room_to_room());

  /// Valid as long as *this. \throws as CandidateFinder::find()
  const Panorama& at(graph::Location location);

 private:
  sim::CandidateFinder finder_;
  std::map<std::pair<ScanIndex, ViewpointIndex>, Panorama> known_;
};

/// [sin h, cos h, sin e, cos e], computed in double precision.
using AngleFeature = std::array<float, 4>;
AngleFeature angle_feature(Radians heading, Radians elevation);

/// Heading and elevation of the middle of a discretized view: 12 headings from 0 in steps of 30
/// degrees, at elevations -30, 0 and 30. \pre view < 36
Radians view_heading(std::uint32_t view);
Radians view_elevation(std::uint32_t view);  ///< likewise
/// The level view of the nearest heading: direction at an episode's start.
std::uint32_t level_view(Radians heading);
/// The view of an agent that had `view`, after an action of the discretized simulator. It turns by
/// one view or none, to the right or left, up or down.
/// \pre view < 36
std::uint32_t view_after(const sim::Action& action, std::uint32_t view);

/// The view with which an agent arrives at a neighbour. It is the one in which this panorama has
/// it, so that the agent faces along its way. No value if the viewpoint is not a candidate.
std::optional<std::uint32_t> arrival_view(const Panorama& panorama, ViewpointIndex neighbour);

/// The next of the low-level actions with which EnvDrop's agent goes to a candidate (Tan, Yu,
/// Bansal 2019). It goes up or down to the row of its view, right until its column, then forward.
/// Each is an entry of the trajectory; the last keeps the view.
/// \param view of the agent now
/// \pre both views are below 36
sim::Action step_towards(const sim::Candidate& candidate, std::uint32_t view);

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
