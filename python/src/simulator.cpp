// Simulator: the batched state machine, writing into arrays.
#include "enfilade/sim/simulator.h"

#include <fmt/format.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <vector>

#include "enfilade/sim/candidates.h"
#include "python/src/bindings.h"
#include "python/src/errors.h"

namespace enfilade::python {
namespace {

using graph::GraphSet;
using namespace nb::literals;

/// A simulator and the arrays of its state.
class BatchSimulator {
 public:
  BatchSimulator(const std::shared_ptr<const GraphSet>& graphs, const sim::SimulatorConfig& config)
      : graphs_(graphs),
        native_(graphs, config),
        starts_(config.batch_size),
        actions_(config.batch_size) {}

  void new_episodes(const Row<std::uint32_t>& scans, const Row<std::uint32_t>& viewpoints,
                    const Row<double>& headings, const Row<double>& elevations) {
    const Busy busy(busy_);
    check("scans", scans.size());
    check("viewpoints", viewpoints.size());
    check("headings", headings.size());
    check("elevations", elevations.size());
    const nb::gil_scoped_release unlocked;
    for (std::size_t i = 0; i < starts_.size(); ++i) {
      starts_[i] = {{ScanIndex(scans.data()[i]), ViewpointIndex(viewpoints.data()[i])},
                    Radians(headings.data()[i]),
                    Radians(elevations.data()[i])};
    }
    native_.new_episodes(starts_);
  }
  void new_episode(std::size_t agent, std::uint32_t scan, std::uint32_t viewpoint, double heading,
                   double elevation) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    native_.new_episode(
        agent,
        {{ScanIndex(scan), ViewpointIndex(viewpoint)}, Radians(heading), Radians(elevation)});
  }
  void new_random_episodes(const Row<std::uint32_t>& scans) {
    const Busy busy(busy_);
    check("scans", scans.size());
    const nb::gil_scoped_release unlocked;
    std::vector<ScanIndex> indices;
    for (const std::uint32_t scan : span_of(scans)) indices.emplace_back(scan);
    native_.new_random_episodes(indices);
  }
  void step(const Row<std::uint32_t>& indices, const Row<double>& headings,
            const Row<double>& elevations) {
    const Busy busy(busy_);
    check("indices", indices.size());
    check("heading_changes", headings.size());
    check("elevation_changes", elevations.size());
    const nb::gil_scoped_release unlocked;
    for (std::size_t i = 0; i < actions_.size(); ++i) {
      actions_[i] = {indices.data()[i], Radians(headings.data()[i]), Radians(elevations.data()[i])};
    }
    native_.step(actions_);
  }
  std::vector<sim::Candidate> candidates(std::uint32_t scan, std::uint32_t viewpoint) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    if (!finder_) finder_.emplace(graphs_, native_.config());
    return finder_->find({ScanIndex(scan), ViewpointIndex(viewpoint)});
  }

  const sim::Simulator& native() const { return native_; }
  const std::shared_ptr<const GraphSet>& graphs() const { return graphs_; }
  const sim::StateSpans& state() const { return native_.state(); }

 private:
  void check(const char* name, std::size_t found) const {
    check_batch(name, found, native_.batch_size());
  }

  std::shared_ptr<const GraphSet> graphs_;
  sim::Simulator native_;
  std::vector<sim::EpisodeStart> starts_;
  std::vector<sim::Action> actions_;
  std::optional<sim::CandidateFinder> finder_;
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

std::unique_ptr<BatchSimulator> make_simulator(const std::shared_ptr<const GraphSet>& graphs,
                                               std::size_t batch_size, std::uint32_t width,
                                               std::uint32_t height, double vfov, bool discretized,
                                               bool restricted, bool linear_view,
                                               std::pair<double, double> elevation_limits,
                                               bool mattersim_starts, std::uint64_t seed,
                                               std::size_t max_navigable, int threads) {
  sim::SimulatorConfig config;
  config.batch_size = batch_size;
  config.camera = {width, height, Radians(vfov)};
  if (discretized) config.viewing = sim::Viewing::kDiscretized;
  if (!restricted) config.navigation = sim::Navigation::kUnrestricted;
  if (linear_view) config.field_of_view = sim::FieldOfView::kLinear;
  config.elevation_limits = {Radians(elevation_limits.first), Radians(elevation_limits.second)};
  if (mattersim_starts) config.random_starts = sim::RandomStarts::kMatterSim;
  config.seed = seed;
  config.max_navigable = max_navigable;
  config.threads = threads;
  return std::make_unique<BatchSimulator>(graphs, config);
}

// The state's arrays by their names; all share the simulator's memory.
nb::dict state_arrays(nb::handle self) {
  const auto& simulator = nb::cast<const BatchSimulator&>(self);
  const sim::StateSpans& s = simulator.state();
  const std::size_t n = simulator.native().batch_size();
  const std::size_t m = simulator.native().config().max_navigable;
  nb::dict d;
  d["scan"] = view_of(s.scan, self, n);
  d["viewpoint"] = view_of(s.viewpoint, self, n);
  d["heading"] = view_of(s.heading, self, n);
  d["elevation"] = view_of(s.elevation, self, n);
  d["view_index"] = view_of(s.view_index, self, n);
  d["step"] = view_of(s.step, self, n);
  d["navigable_count"] = view_of(s.navigable_count, self, n);
  d["navigable_viewpoint"] = view_of(s.navigable_viewpoint, self, n, m);
  d["navigable_rel_heading"] = view_of(s.navigable_rel_heading, self, n, m);
  d["navigable_rel_elevation"] = view_of(s.navigable_rel_elevation, self, n, m);
  d["navigable_distance"] = view_of(s.navigable_distance, self, n, m);
  return d;
}

nb::list candidate_list(BatchSimulator& self, std::uint32_t scan, std::uint32_t viewpoint) {
  const std::vector<sim::Candidate> found = self.candidates(scan, viewpoint);
  nb::list list;
  for (const sim::Candidate& c : found) {
    list.append(nb::make_tuple(c.viewpoint.value, c.view, c.index, c.heading.value,
                               c.elevation.value, c.rel_heading.value, c.rel_elevation.value,
                               c.angle, c.distance));
  }
  return list;
}

/// Columns of a table of candidates.
struct CandidateColumns {
  std::vector<std::uint32_t> integers;  // scan, viewpoint, neighbour, view, index
  std::vector<double> reals;  // heading, elevation, rel_heading, rel_elevation, angle, distance
};

// Every candidate of every included viewpoint of these scans, one per row.
CandidateColumns all_candidates(const std::shared_ptr<const GraphSet>& graphs,
                                const sim::SimulatorConfig& config,
                                std::span<const std::uint32_t> scans) {
  CandidateColumns columns;
  sim::CandidateFinder finder(graphs, config);
  for (const std::uint32_t scan : scans) {
    if (scan >= graphs->size()) {
      throw ArgumentError(fmt::format("scan {}: 0 to {} are allowed", scan, graphs->size() - 1));
    }
    const graph::NavGraph& graph = graphs->graph(ScanIndex(scan));
    for (std::uint32_t v = 0; v < graph.size(); ++v) {
      if (!graph.included(ViewpointIndex(v))) continue;
      for (const sim::Candidate& c : finder.find({ScanIndex(scan), ViewpointIndex(v)})) {
        columns.integers.insert(columns.integers.end(),
                                {scan, v, c.viewpoint.value, c.view, c.index});
        columns.reals.insert(columns.reals.end(),
                             {c.heading.value, c.elevation.value, c.rel_heading.value,
                              c.rel_elevation.value, c.angle, c.distance});
      }
    }
  }
  return columns;
}

nb::tuple candidate_arrays(BatchSimulator& self, const Row<std::uint32_t>& scans) {
  CandidateColumns columns;
  {
    const nb::gil_scoped_release unlocked;
    columns = all_candidates(self.graphs(), self.native().config(), span_of(scans));
  }
  const std::size_t rows = columns.integers.size() / 5;
  return nb::make_tuple(owned_array(std::move(columns.integers), rows, 5),
                        owned_array(std::move(columns.reals), rows, 6));
}

}  // namespace

void check_batch(const char* name, std::size_t found, std::size_t batch) {
  if (found == batch) return;
  throw ArgumentError(fmt::format("{}: {} elements for a batch of {}", name, found, batch));
}

void bind_simulator(nb::module_& m) {
  nb::class_<BatchSimulator>(m, "BatchSimulator",
                             "The core of enfilade.Simulator: indices and arrays only.")
      .def(nb::new_(&make_simulator), "graphs"_a, nb::kw_only(), "batch_size"_a, "width"_a,
           "height"_a, "vfov"_a, "discretized"_a, "restricted"_a, "linear_view"_a,
           "elevation_limits"_a, "mattersim_starts"_a, "seed"_a, "max_navigable"_a, "threads"_a)
      .def("new_episodes", &BatchSimulator::new_episodes, "scans"_a, "viewpoints"_a, "headings"_a,
           "elevations"_a)
      .def("new_episode", &BatchSimulator::new_episode, "agent"_a, "scan"_a, "viewpoint"_a,
           "heading"_a, "elevation"_a)
      .def("new_random_episodes", &BatchSimulator::new_random_episodes, "scans"_a)
      .def("step", &BatchSimulator::step, "indices"_a, "heading_changes"_a, "elevation_changes"_a)
      .def("state_arrays", state_arrays,
           nb::sig("def state_arrays(self) -> dict[str, numpy.typing.NDArray[typing.Any]]"))
      .def("candidates", candidate_list, "scan"_a, "viewpoint"_a,
           nb::sig("def candidates(self, scan: int, viewpoint: int) -> list[tuple[int, int, int, "
                   "float, float, float, float, float, float]]"))
      .def("candidate_arrays", candidate_arrays, "scans"_a,
           nb::sig("def candidate_arrays(self, scans: numpy.typing.NDArray[numpy.uint32]) -> "
                   "tuple[numpy.typing.NDArray[numpy.uint32], "
                   "numpy.typing.NDArray[numpy.float64]]"));
}

}  // namespace enfilade::python
