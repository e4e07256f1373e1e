/// \file  The batched simulator: agents that move between viewpoints and turn (Anderson et al.,
/// CVPR 2018, section 3).
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/sim/state.h"

namespace enfilade::sim {

/// Possible directions of agents.
enum class Viewing {
  kContinuous,   ///< any heading; elevation within the limits
  kDiscretized,  ///< 12 headings x 3 elevations of 30 degrees: 36 views
};

/// The neighbours that are navigable.
enum class Navigation {
  kRestricted,    ///< only neighbours in the horizontal field of view are navigable
  kUnrestricted,  ///< all neighbours are
};

/// Which angle Navigation::kRestricted tests against.
enum class FieldOfView {
  kPerspective,  ///< the picture's: 2 atan(tan(vfov/2) width/height)
  kLinear,       ///< MatterSim's, on which R2R results rest: vfov width/height (80 degrees where
                 ///< the picture shows 75.2). Its cosine turns round past a half-angle of pi.
};

/// How new_random_episodes() draws.
enum class RandomStarts {
  kUniform,    ///< uniform included viewpoint and heading, a stream per agent and episode
  kMatterSim,  ///< MatterSim's numbers: one minstd_rand0 for the viewpoints of the batch, skewed
               ///< towards those after excluded ones, and the same fixed headings at every call
};

/// Limits of the elevation, down and up; the defaults are MatterSim's.
struct ElevationLimits {
  Radians min = Radians(-0.94);
  Radians max = Radians(0.94);
};

/// Everything that a Simulator is made from; nothing can be changed later.
struct SimulatorConfig {
  std::size_t batch_size = 1;  ///< agents, >= 1
  Camera camera;
  Viewing viewing = Viewing::kContinuous;
  Navigation navigation = Navigation::kRestricted;
  FieldOfView field_of_view = FieldOfView::kPerspective;
  /// For continuous viewing; -pi/2 < min < 0 < max < pi/2. Discretized viewing ignores them.
  ElevationLimits elevation_limits;
  RandomStarts random_starts = RandomStarts::kUniform;
  std::uint64_t seed = 1;  ///< of new_random_episodes()
  /// Rows of StateSpans::navigable: the present viewpoint and as many neighbours as a graph has.
  /// Matterport3D's graphs need 14. 1 .. 1024
  std::size_t max_navigable = 32;
  int threads = 1;  ///< that step() may use, 0: all cores. Never changes a result.

  /// The configuration of R2R's results: 640 x 480, 60 degrees, discretized, restricted, linear.
  static SimulatorConfig room_to_room();
  /// MatterSim v0.2 after `Simulator()`: 320 x 240, 0.8 rad, continuous, restricted, its quirks on.
  static SimulatorConfig mattersim();
};

/// \throws ArgumentError naming the field, its value and the allowed range.
void validate(const SimulatorConfig& config);

/// Where an agent starts.
struct EpisodeStart {
  graph::Location location;
  Radians heading;
  Radians elevation;
};

/// One agent's action: first the move, then the turn.
struct Action {
  std::uint32_t index = 0;   ///< of its navigable list; 0: stay
  Radians heading_change;    ///< right positive; when discretized, only the sign counts: one view
  Radians elevation_change;  ///< up positive; likewise
};

/// An invalid action or start of one agent; the whole batch is as it was before the call. what()
/// names agent, value and allowed range.
class ActionError : public ArgumentError {
 public:
  /// \param agent its place in the batch
  ActionError(std::size_t agent, const std::string& what) : ArgumentError(what), agent_(agent) {}
  std::size_t agent() const noexcept { return agent_; }

 private:
  std::size_t agent_;
};

/// Steps a batch of agents through the buildings of a GraphSet. Needs no picture, display or GPU.
/// Each call that moves agents writes the whole state of each agent that it concerns. It writes
/// into state(), the simulator's own memory, or only into the caller's memory (`out`). The
/// simulator keeps its own copy: changes to that memory have no effect on it. step() allocates
/// nothing with one thread. Same start, actions and seed give the same bytes at any batch size and
/// thread count. One thread at a time per simulator; any number of simulators share a GraphSet.
/// Making one costs microseconds.
///
///     sim::Simulator simulator(graphs, sim::SimulatorConfig::room_to_room());
///     simulator.new_random_episodes(std::vector{ScanIndex(0)});
///     simulator.step(std::vector{sim::Action{0, degrees(30), {}}});
///     simulator.state().heading[0];
class Simulator {
 public:
  /// \throws ArgumentError as validate(), or if `graphs` is null
  Simulator(std::shared_ptr<const graph::GraphSet> graphs, const SimulatorConfig& config);
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  const SimulatorConfig& config() const noexcept;
  const graph::GraphSet& graphs() const noexcept;
  std::size_t batch_size() const noexcept { return config().batch_size; }
  /// The state written by the last calls without `out`; agents without such a call are 0. Valid as
  /// long as the simulator, which may be moved.
  const StateSpans& state() const noexcept;

  /// Starts an episode for every agent. Reads graphs at their first use. If it throws, nothing has
  /// changed.
  /// \pre out has the shapes of batch_size() and max_navigable
  /// \throws ArgumentError if starts.size() != batch_size() or `out` has other shapes
  /// \throws ActionError for an unknown scan, an unknown or excluded viewpoint, an angle that is
  /// not finite, or a graph with more neighbours than max_navigable - 1
  /// \throws FileError, InvalidInput for a graph's file
  void new_episodes(std::span<const EpisodeStart> starts, const StateSpans& out);
  void new_episodes(std::span<const EpisodeStart> starts) { new_episodes(starts, state()); }
  /// The same for one agent, as in a vector environment whose episodes end at different times.
  void new_episode(std::size_t agent, const EpisodeStart& start, const StateSpans& out);
  void new_episode(std::size_t agent, const EpisodeStart& start) {
    new_episode(agent, start, state());
  }
  /// A random viewpoint and heading for every agent, elevation 0.
  /// \throws as new_episodes(); ActionError for a graph in which no viewpoint is included
  void new_random_episodes(std::span<const ScanIndex> scans, const StateSpans& out);
  void new_random_episodes(std::span<const ScanIndex> scans) {
    new_random_episodes(scans, state());
  }
  /// The same for one agent: with kUniform what new_random_episodes() would give it next.
  void new_random_episode(std::size_t agent, ScanIndex scan, const StateSpans& out);
  void new_random_episode(std::size_t agent, ScanIndex scan) {
    new_random_episode(agent, scan, state());
  }

  /// Performs one action per agent. If it throws, nothing has changed.
  /// \throws ArgumentError if actions.size() != batch_size(), `out` has other shapes or no episode
  /// was started
  /// \throws ActionError for an index outside an agent's navigable list, or a change that is not
  /// finite
  void step(std::span<const Action> actions, const StateSpans& out);
  void step(std::span<const Action> actions) { step(actions, state()); }

  /// Writes the state again, e.g. into other memory. \throws as step()
  void write_state(const StateSpans& out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::sim
