#include "enfilade/sim/simulator.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/sim/detail/navigable_views.h"

namespace enfilade::sim {
namespace {

using detail::FloorDirection;
using detail::NavigableViews;
using graph::NavGraph;

constexpr int kHeadings = 12;  // of discretized viewing
constexpr double kHeadingStep = 2 * kPi / kHeadings;
constexpr double kElevationStep = kPi / 6;
constexpr std::size_t kMaxNavigable = 1024;              // lists are sorted in O(n^2)
constexpr std::size_t kMaxRows = std::size_t{1} << 31U;  // of the navigable lists of a batch
// Agents worked on together: enough to fill vector registers, few enough for the first cache.
constexpr std::size_t kChunk = 16;
// Agents a task if there are threads: 70 us of work, several times the cost of starting a task.
constexpr std::size_t kGrain = 1024;

int sign(Radians change) { return int{change.value > 0} - int{change.value < 0}; }

bool is_finite(Radians angle) { return std::isfinite(angle.value); }

double half_field_of_view(const SimulatorConfig& config) {
  const Camera& camera = config.camera;
  if (config.field_of_view == FieldOfView::kPerspective) {
    return horizontal_field_of_view(camera).value / 2;
  }
  return camera.vertical_field_of_view.value * camera.width / camera.height / 2;
}

// The simulator's own state: callers get copies.
struct Agents {
  explicit Agents(const SimulatorConfig& config)
      : target(config.batch_size * config.max_navigable) {
    const auto resize = [&](auto&... arrays) { (arrays.resize(config.batch_size), ...); };
    resize(graph, scan, viewpoint, heading, elevation, heading_step, elevation_step, step,
           navigable_count, random_episodes);
  }

  std::vector<const NavGraph*> graph;
  std::vector<ScanIndex> scan;
  std::vector<ViewpointIndex> viewpoint;
  std::vector<double> heading, elevation;
  std::vector<int> heading_step, elevation_step;  // 0..11, -1..1; discretized viewing only
  std::vector<std::uint32_t> step;
  std::vector<std::uint32_t> navigable_count;  // 0: no episode was started
  std::vector<std::uint32_t> target;           // rows of max_navigable: the navigable viewpoints
  std::vector<std::uint64_t> random_episodes;  // drawn so far
};

// Agents of a batch may be anywhere in 2 MB of edges; four cache lines hold the edges of a
// viewpoint.
void prefetch([[maybe_unused]] std::span<const graph::Edge> edges) {
#if defined(__GNUC__)
  if (edges.empty()) return;
  const char* first = reinterpret_cast<const char*>(edges.data());
  for (std::size_t line = 0; line < 4; ++line) __builtin_prefetch(first + 64 * line);
#endif
}

struct CheckedStart {
  const NavGraph* graph;
  EpisodeStart start;
};

// Throws an ActionError: "agent 3: " and what the format says.
template <class... Args>
[[noreturn]] void fail(std::size_t agent, fmt::format_string<Args...> format, Args&&... args) {
  throw ActionError(
      agent, fmt::format("agent {}: {}", agent, fmt::format(format, std::forward<Args>(args)...)));
}

void check_angle(std::size_t agent, const char* name, Radians angle) {
  if (!is_finite(angle)) fail(agent, "{} {}: any finite angle is allowed", name, angle.value);
}

void check_shape(const char* name, std::size_t found, std::size_t wanted) {
  if (found == wanted) [[likely]]
    return;
  throw ArgumentError(fmt::format("{}: {} elements, not {}", name, found, wanted));
}

}  // namespace

struct Simulator::Impl {
  Impl(std::shared_ptr<const graph::GraphSet> set, const SimulatorConfig& given);

  void check_agent(std::size_t agent) const;
  void check_output(const StateSpans& out) const;
  void check_actions(std::span<const Action> actions) const;
  void explain(std::size_t agent, const Action& action) const;
  const NavGraph& checked_graph(std::size_t agent, ScanIndex scan) const;
  CheckedStart checked(std::size_t agent, const EpisodeStart& start) const;

  EpisodeStart draw_start(std::size_t agent, ScanIndex scan, MatterSimRandom& viewpoints,
                          MatterSimRandom& headings) const;
  void begin(std::size_t agent, const CheckedStart& start);
  void look(std::size_t agent, Radians heading, Radians elevation);
  void look_at_view(std::size_t agent, int heading_step, int elevation_step) {
    agents.heading_step[agent] = heading_step;
    agents.elevation_step[agent] = elevation_step;
    agents.heading[agent] = heading_step * kHeadingStep;
    agents.elevation[agent] = elevation_step * kElevationStep;
  }
  void advance(std::size_t agent, const Action& action);
  void look_around(std::size_t begin, std::size_t end, NavigableViews& scratch) const;
  void observe(std::size_t begin, std::size_t end, NavigableViews& scratch, const StateSpans& out);
  void observe_all(const StateSpans& out);

  std::shared_ptr<const graph::GraphSet> graphs;
  SimulatorConfig config;
  detail::ViewLimit limit;
  std::array<FloorDirection, kHeadings> directions;  // of discretized viewing
  Agents agents;
  StateBuffer buffer;
  StateSpans state;  // of buffer
  NavigableViews views;
  MatterSimRandom random;
};

Simulator::Impl::Impl(std::shared_ptr<const graph::GraphSet> set, const SimulatorConfig& given)
    : graphs(std::move(set)),
      config((validate(given), given)),
      limit{given.navigation == Navigation::kUnrestricted, std::cos(half_field_of_view(given))},
      directions{},
      agents(given),
      buffer(given.batch_size, given.max_navigable),
      state(buffer.spans()),
      views(std::min(given.batch_size, kChunk), given.max_navigable),
      random(given.seed) {
  for (int i = 0; i < kHeadings; ++i) {
    directions[static_cast<std::size_t>(i)] = detail::direction_of(Radians(i * kHeadingStep));
  }
}

void Simulator::Impl::check_agent(std::size_t agent) const {
  if (agent < config.batch_size) return;
  throw ArgumentError(fmt::format("agent {}: 0 to {} are allowed", agent, config.batch_size - 1));
}

void Simulator::Impl::check_output(const StateSpans& out) const {
  const std::size_t n = config.batch_size;
  check_shape("scan", out.scan.size(), n);
  check_shape("viewpoint", out.viewpoint.size(), n);
  check_shape("heading", out.heading.size(), n);
  check_shape("elevation", out.elevation.size(), n);
  check_shape("view_index", out.view_index.size(), n);
  check_shape("step", out.step.size(), n);
  check_shape("navigable_count", out.navigable_count.size(), n);
  const std::size_t rows = n * config.max_navigable;
  check_shape("navigable_viewpoint", out.navigable_viewpoint.size(), rows);
  check_shape("navigable_rel_heading", out.navigable_rel_heading.size(), rows);
  check_shape("navigable_rel_elevation", out.navigable_rel_elevation.size(), rows);
  check_shape("navigable_distance", out.navigable_distance.size(), rows);
}

void Simulator::Impl::check_actions(std::span<const Action> actions) const {
  check_shape("actions", actions.size(), config.batch_size);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const Action& action = actions[i];
    // An agent without an episode has a list of length 0.
    const bool good = action.index < agents.navigable_count[i] &&
                      is_finite(action.heading_change) && is_finite(action.elevation_change);
    if (!good) [[unlikely]]
      explain(i, action);
  }
}

// Throws what is wrong with an action that cannot be carried out.
void Simulator::Impl::explain(std::size_t agent, const Action& action) const {
  const std::uint32_t count = agents.navigable_count[agent];
  if (count == 0) throw ArgumentError(fmt::format("agent {}: no episode was started", agent));
  if (action.index >= count) {
    const NavGraph& graph = *agents.graph[agent];
    fail(agent, "index {} of its navigable list: 0 to {} are allowed at viewpoint {} of scan {}",
         action.index, count - 1, graph.id(agents.viewpoint[agent]), graph.scan());
  }
  check_angle(agent, "heading change", action.heading_change);
  check_angle(agent, "elevation change", action.elevation_change);
}

const NavGraph& Simulator::Impl::checked_graph(std::size_t agent, ScanIndex scan) const {
  if (scan.at() >= graphs->size()) {
    fail(agent, "scan {}: 0 to {} are allowed", scan.value, graphs->size() - 1);
  }
  const NavGraph& graph = graphs->graph(scan);
  if (graph.max_degree() + 1 > config.max_navigable) {
    fail(agent, "scan {} has a viewpoint with {} neighbours; max_navigable {} allows {}",
         graph.scan(), graph.max_degree(), config.max_navigable, config.max_navigable - 1);
  }
  return graph;
}

CheckedStart Simulator::Impl::checked(std::size_t agent, const EpisodeStart& start) const {
  const NavGraph& graph = checked_graph(agent, start.location.scan);
  const ViewpointIndex viewpoint = start.location.viewpoint;
  if (viewpoint.at() >= graph.size()) {
    fail(agent, "viewpoint {} of scan {}: 0 to {} are allowed", viewpoint.value, graph.scan(),
         static_cast<std::ptrdiff_t>(graph.size()) - 1);
  }
  if (!graph.included(viewpoint)) {
    fail(agent, "viewpoint {} ({}) of scan {} is excluded from its graph", viewpoint.value,
         graph.id(viewpoint), graph.scan());
  }
  check_angle(agent, "heading", start.heading);
  check_angle(agent, "elevation", start.elevation);
  return {&graph, start};
}

EpisodeStart Simulator::Impl::draw_start(std::size_t agent, ScanIndex scan,
                                         MatterSimRandom& viewpoints,
                                         MatterSimRandom& headings) const {
  const NavGraph& graph = checked_graph(agent, scan);
  if (graph.included_count() == 0) {
    fail(agent, "no viewpoint of scan {} is included, so none can be drawn", graph.scan());
  }
  if (config.random_starts == RandomStarts::kMatterSim) {
    std::size_t v = viewpoints.below(static_cast<std::uint32_t>(graph.size()));
    while (!graph.included(ViewpointIndex(v))) v = (v + 1) % graph.size();
    return {{scan, ViewpointIndex(v)}, headings.heading(), Radians(0)};
  }
  Rng rng(config.seed, agent, agents.random_episodes[agent]);
  std::uint64_t skip = rng.below(graph.included_count());
  std::size_t v = 0;
  while (!graph.included(ViewpointIndex(v)) || skip-- > 0) ++v;
  return {{scan, ViewpointIndex(v)}, Radians(rng.uniform() * (2 * kPi)), Radians(0)};
}

void Simulator::Impl::begin(std::size_t agent, const CheckedStart& start) {
  agents.graph[agent] = start.graph;
  agents.scan[agent] = start.start.location.scan;
  agents.viewpoint[agent] = start.start.location.viewpoint;
  agents.step[agent] = 0;
  look(agent, start.start.heading, start.start.elevation);
}

void Simulator::Impl::look(std::size_t agent, Radians heading, Radians elevation) {
  const double h = wrap_heading(heading).value;
  if (config.viewing == Viewing::kContinuous) {
    agents.heading[agent] = h;
    agents.elevation[agent] = std::max(std::min(elevation.value, config.elevation_limits.max.value),
                                       config.elevation_limits.min.value);
    return;
  }
  const int step = static_cast<int>(std::lround(h / kHeadingStep)) % kHeadings;
  const int row =
      int{elevation.value > kElevationStep / 2} - int{elevation.value < -kElevationStep / 2};
  look_at_view(agent, step, row);
}

void Simulator::Impl::advance(std::size_t agent, const Action& action) {
  agents.viewpoint[agent].value = agents.target[agent * config.max_navigable + action.index];
  ++agents.step[agent];
  if (config.viewing == Viewing::kContinuous) {
    look(agent, Radians(agents.heading[agent]) + action.heading_change,
         Radians(agents.elevation[agent]) + action.elevation_change);
    return;
  }
  int step = agents.heading_step[agent] + sign(action.heading_change);
  step = step < 0 ? kHeadings - 1 : step == kHeadings ? 0 : step;
  const int row = std::clamp(agents.elevation_step[agent] + sign(action.elevation_change), -1, 1);
  look_at_view(agent, step, row);
}

void Simulator::Impl::look_around(std::size_t begin, std::size_t end,
                                  NavigableViews& scratch) const {
  const std::size_t n = end - begin;
  std::array<std::span<const graph::Edge>, kChunk> edges;
  for (std::size_t i = 0; i < n; ++i) {
    edges[i] = agents.graph[begin + i]->edges(agents.viewpoint[begin + i]);
    prefetch(edges[i]);
  }
  std::array<FloorDirection, kChunk> camera;
  if (config.viewing == Viewing::kDiscretized) {
    for (std::size_t i = 0; i < n; ++i) {
      camera[i] = directions[static_cast<std::size_t>(agents.heading_step[begin + i])];
    }
  } else {
    detail::compute_directions(std::span(agents.heading).subspan(begin, n),
                               std::span(camera).first(n));
  }
  scratch.clear();
  for (std::size_t i = 0; i < n; ++i) {
    scratch.add(edges[i], camera[i], agents.elevation[begin + i], limit);
  }
  scratch.compute();
}

void Simulator::Impl::observe(std::size_t begin, std::size_t end, NavigableViews& scratch,
                              const StateSpans& out) {
  look_around(begin, end, scratch);
  const bool discretized = config.viewing == Viewing::kDiscretized;
  for (std::size_t i = begin; i < end; ++i) {
    const int view = agents.heading_step[i] + kHeadings * (agents.elevation_step[i] + 1);
    out.scan[i] = agents.scan[i];
    out.viewpoint[i] = agents.viewpoint[i];
    out.heading[i] = agents.heading[i];
    out.elevation[i] = agents.elevation[i];
    out.view_index[i] = discretized ? static_cast<std::uint32_t>(view) : 0;
    out.step[i] = agents.step[i];
    const std::size_t row = i * config.max_navigable;
    agents.navigable_count[i] = scratch.write(
        agents.viewpoint[i],
        {&agents.target[row], &out.navigable_viewpoint[row], &out.navigable_rel_heading[row],
         &out.navigable_rel_elevation[row], &out.navigable_distance[row]});
    out.navigable_count[i] = agents.navigable_count[i];
  }
}

void Simulator::Impl::observe_all(const StateSpans& out) {
  for (std::size_t i = 0; i < config.batch_size; i += kChunk) {
    observe(i, std::min(i + kChunk, config.batch_size), views, out);
  }
}

SimulatorConfig SimulatorConfig::room_to_room() {
  SimulatorConfig config;
  config.viewing = Viewing::kDiscretized;
  config.field_of_view = FieldOfView::kLinear;
  return config;
}

SimulatorConfig SimulatorConfig::mattersim() {
  SimulatorConfig config;
  config.camera = {320, 240, Radians(0.8)};
  config.field_of_view = FieldOfView::kLinear;
  config.random_starts = RandomStarts::kMatterSim;
  return config;
}

void validate(const SimulatorConfig& config) {
  enfilade::validate(config.camera);
  if (config.batch_size == 0) throw ArgumentError("batch_size 0: at least 1 is needed");
  if (config.max_navigable == 0 || config.max_navigable > kMaxNavigable) {
    throw ArgumentError(
        fmt::format("max_navigable {}: 1 to {} are allowed", config.max_navigable, kMaxNavigable));
  }
  if (config.batch_size > kMaxRows / config.max_navigable) {
    throw ArgumentError(fmt::format("batch_size {}: at most {} are allowed with max_navigable {}",
                                    config.batch_size, kMaxRows / config.max_navigable,
                                    config.max_navigable));
  }
  const double min = config.elevation_limits.min.value;
  const double max = config.elevation_limits.max.value;
  if (!(-kPi / 2 < min && min < 0 && 0 < max && max < kPi / 2)) {
    throw ArgumentError(fmt::format(
        "elevation_limits {} to {} rad: -pi/2 < min < 0 < max < pi/2 is needed", min, max));
  }
  if (config.threads < 0) {
    throw ArgumentError(fmt::format("threads {}: 0 (all cores) or more", config.threads));
  }
}

Simulator::Simulator(std::shared_ptr<const graph::GraphSet> graphs, const SimulatorConfig& config) {
  if (!graphs) throw ArgumentError("graphs: null; a GraphSet is needed");
  impl_ = std::make_unique<Impl>(std::move(graphs), config);
}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

const SimulatorConfig& Simulator::config() const noexcept { return impl_->config; }
const StateSpans& Simulator::state() const noexcept { return impl_->state; }

void Simulator::new_episodes(std::span<const EpisodeStart> starts, const StateSpans& out) {
  impl_->check_output(out);
  check_shape("starts", starts.size(), batch_size());
  std::vector<CheckedStart> checked;
  checked.reserve(starts.size());
  for (std::size_t i = 0; i < starts.size(); ++i) checked.push_back(impl_->checked(i, starts[i]));
  for (std::size_t i = 0; i < starts.size(); ++i) impl_->begin(i, checked[i]);
  impl_->observe_all(out);
}

void Simulator::new_episode(std::size_t agent, const EpisodeStart& start, const StateSpans& out) {
  impl_->check_agent(agent);
  impl_->check_output(out);
  impl_->begin(agent, impl_->checked(agent, start));
  impl_->observe(agent, agent + 1, impl_->views, out);
}

void Simulator::new_random_episodes(std::span<const ScanIndex> scans, const StateSpans& out) {
  check_shape("scans", scans.size(), batch_size());
  MatterSimRandom viewpoints = impl_->random;
  MatterSimRandom headings;  // seeded alike at every call: MatterSim's headings are
  std::vector<EpisodeStart> starts;
  starts.reserve(scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    starts.push_back(impl_->draw_start(i, scans[i], viewpoints, headings));
  }
  new_episodes(starts, out);
  impl_->random = viewpoints;
  for (std::uint64_t& drawn : impl_->agents.random_episodes) ++drawn;
}

void Simulator::step(std::span<const Action> actions, const StateSpans& out) {
  impl_->check_output(out);
  impl_->check_actions(actions);
  const auto run = [&](std::size_t begin, std::size_t end, NavigableViews& views) {
    for (std::size_t i = begin; i < end; i += kChunk) {
      const std::size_t last = std::min(i + kChunk, end);
      for (std::size_t k = i; k < last; ++k) impl_->advance(k, actions[k]);
      impl_->observe(i, last, views, out);
    }
  };
  if (config().threads == 1 || batch_size() <= kGrain) {
    run(0, batch_size(), impl_->views);
    return;
  }
  parallel_for(batch_size(), kGrain, config().threads, [&](std::size_t begin, std::size_t end) {
    NavigableViews views(kChunk, config().max_navigable);
    run(begin, end, views);
  });
}

StateBuffer::StateBuffer(std::size_t batch_size, std::size_t max_navigable) {
  const auto resize = [](std::size_t size, auto&... arrays) { (arrays.resize(size), ...); };
  resize(batch_size, scan_, viewpoint_, heading_, elevation_, view_index_, step_, navigable_count_);
  resize(batch_size * max_navigable, navigable_viewpoint_, navigable_rel_heading_,
         navigable_rel_elevation_, navigable_distance_);
}

StateSpans StateBuffer::spans() noexcept {
  return {scan_,
          viewpoint_,
          heading_,
          elevation_,
          view_index_,
          step_,
          navigable_count_,
          navigable_viewpoint_,
          navigable_rel_heading_,
          navigable_rel_elevation_,
          navigable_distance_};
}

namespace {

constexpr std::uint64_t kMultiplier = 16807;
constexpr std::uint64_t kModulus = 2147483647;  // 2^31 - 1, prime
constexpr std::uint32_t kMin = 1;
constexpr std::uint32_t kMax = kModulus - 1;

}  // namespace

MatterSimRandom::MatterSimRandom(std::uint64_t seed) noexcept
    : state_(static_cast<std::uint32_t>(seed % kModulus == 0 ? 1 : seed % kModulus)) {}

std::uint32_t MatterSimRandom::next() noexcept {
  state_ = static_cast<std::uint32_t>(state_ * kMultiplier % kModulus);
  return state_;
}

std::uint32_t MatterSimRandom::below(std::uint32_t n) noexcept {
  const std::uint32_t scaling = (kMax - kMin) / n;
  const std::uint32_t past = n * scaling;
  std::uint32_t drawn = next() - kMin;
  while (drawn >= past) drawn = next() - kMin;
  return drawn / scaling;
}

double MatterSimRandom::uniform() noexcept {
  constexpr double kRange = static_cast<double>(kMax - kMin) + 1;
  const double low = next() - kMin;
  const double high = next() - kMin;
  const double value = (low + high * kRange) / (kRange * kRange);
  return value < 1 ? value : std::nextafter(1.0, 0.0);
}

}  // namespace enfilade::sim
