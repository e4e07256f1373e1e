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

namespace enfilade::sim {

/// The state of n = batch agents. One array per quantity, shape (batch); for navigable viewpoints,
/// shape (batch, max_navigable), row-major. Row k of `navigable_*` is filled up to
/// navigable_count[k]; the rest is not changed. Entry 0 is the present viewpoint with zeros. The
/// others follow by rising sqrt(rel_heading^2 + rel_elevation^2), ties by viewpoint.
struct StateSpans {
  std::span<ScanIndex> scan;
  std::span<ViewpointIndex> viewpoint;
  std::span<double> heading;            ///< radians, [0, 2 pi]
  std::span<double> elevation;          ///< radians
  std::span<std::uint32_t> view_index;  ///< 0..35 = 12 * row (down, level, up) + heading step;
                                        ///< 0 if viewing is continuous
  std::span<std::uint32_t> step;        ///< actions since the start
  std::span<std::uint32_t> navigable_count;
  std::span<ViewpointIndex> navigable_viewpoint;
  std::span<double> navigable_rel_heading;    ///< radians from the view's middle, right positive
  std::span<double> navigable_rel_elevation;  ///< radians from the view's middle, up positive
  std::span<double> navigable_distance;       ///< metres, straight line

  std::size_t batch_size() const noexcept { return scan.size(); }
  /// Columns of navigable_*. \pre batch_size() > 0
  std::size_t max_navigable() const noexcept { return navigable_viewpoint.size() / scan.size(); }
};

/// Memory for a StateSpans, for callers who keep more than one state of a simulator. A plain value.
class StateBuffer {
 public:
  /// For `batch_size` agents with `max_navigable` entries in each navigable list.
  StateBuffer(std::size_t batch_size, std::size_t max_navigable);
  StateSpans spans() noexcept;  ///< valid as long as *this, until it is moved or assigned to

 private:
  std::vector<ScanIndex> scan_;
  std::vector<ViewpointIndex> viewpoint_;
  std::vector<double> heading_, elevation_;
  std::vector<std::uint32_t> view_index_, step_, navigable_count_;
  std::vector<ViewpointIndex> navigable_viewpoint_;
  std::vector<double> navigable_rel_heading_, navigable_rel_elevation_, navigable_distance_;
};

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

using enfilade::ActionError;

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

  /// Performs one action per agent. If it throws, nothing has changed.
  /// \throws ArgumentError if actions.size() != batch_size(), `out` has other shapes or no episode
  /// was started
  /// \throws ActionError for an index outside an agent's navigable list, or a change that is not
  /// finite
  void step(std::span<const Action> actions, const StateSpans& out);
  void step(std::span<const Action> actions) { step(actions, state()); }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// std::minstd_rand0 with libstdc++'s distributions on top, which the C++ standard leaves to each
/// library: x <- 16807 x mod 2^31 - 1. Poor numbers by today's measure; kept because recorded runs
/// start from them. A plain value: any thread.
class MatterSimRandom {
 public:
  /// A seed that is a multiple of 2^31 - 1 counts as 1. Negative ones were converted to 64 bits
  /// without sign.
  explicit MatterSimRandom(std::uint64_t seed = 1) noexcept;

  /// 1 .. 2^31 - 2.
  std::uint32_t next() noexcept;
  /// Uniform over 0 .. n-1: libstdc++'s uniform_int_distribution. \pre 0 < n <= 2^31 - 3
  std::uint32_t below(std::uint32_t n) noexcept;
  /// Uniform over [0, 1), from two draws: libstdc++'s generate_canonical<double, 53>.
  double uniform() noexcept;
  /// Uniform over [0, 2 pi).
  Radians heading() noexcept { return Radians(uniform() * (2 * kPi)); }

 private:
  std::uint32_t state_;
};

}  // namespace enfilade::sim
