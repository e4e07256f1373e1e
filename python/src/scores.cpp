// Metrics as functions of paths: R2R's, and those of every benchmark's public scorers.
#include <fmt/format.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/threads.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/scorer.h"
#include "python/src/bindings.h"

namespace enfilade::python {
namespace {

using namespace nb::literals;

constexpr std::size_t kPathsAtOnce = 256;

nb::dict metrics(const graph::GraphSet& graphs, const std::string& scan, nb::handle trajectory,
                 nb::handle reference, double success_distance) {
  const graph::NavGraph& graph = graphs.graph(scan);
  return metrics_dict(tasks::compute_metrics(
      graph, read_viewpoints(trajectory, graph, "trajectory"),
      read_viewpoints(reference, graph, "reference"), metric_options(success_distance)));
}

/// A trajectory with everything that a scorer needs.
struct Item {
  const graph::NavGraph* graph = nullptr;
  tasks::ReferencePath reference;
  tasks::Trajectory trajectory;
};

// An agent's answer: an object's id, a point, the turning point; None: no answer.
void read_answer(nb::handle answer, const tasks::Benchmark& benchmark, const graph::NavGraph& graph,
                 tasks::Trajectory& trajectory) {
  if (answer.is_none()) return;
  switch (benchmark.answer) {
    case tasks::AnswerKind::kObject:
      trajectory.object = nb::cast<std::string>(nb::str(answer));
      return;
    case tasks::AnswerKind::kTurningPoint:
      trajectory.turning_point = find_viewpoint(graph, nb::cast<std::string>(answer));
      return;
    case tasks::AnswerKind::kPoint:
      trajectory.point =
          tasks::SpherePoint{nb::cast<double>(answer[0]), nb::cast<double>(answer[1])};
      return;
    case tasks::AnswerKind::kNone:
      throw ArgumentError(fmt::format("answers: {} asks for a path alone", benchmark.title));
  }
}

void read_item(Item& item, const tasks::Benchmark& benchmark, std::size_t i, nb::handle trajectory,
               nb::handle reference, nb::handle goal, nb::handle answer) {
  for (const ViewpointIndex v : read_viewpoints(trajectory, *item.graph, "trajectories")) {
    item.trajectory.points.push_back({v, {}, {}});
  }
  item.reference.viewpoints = read_viewpoints(reference, *item.graph, "references");
  if (!goal.is_none()) item.reference.goal = read_goal(nb::tuple(nb::borrow(goal)), *item.graph);
  if (!fits(item.reference.goal, benchmark.goal)) {
    throw ArgumentError(
        fmt::format("goals: element {} is of a kind that {} does not have", i, benchmark.title));
  }
  read_answer(answer, benchmark, *item.graph, item.trajectory);
}

nb::object score_paths(const graph::GraphSet& graphs, const std::string& task_name,
                       const std::string& scorer_name, const nb::list& scans,
                       const nb::list& trajectories, const nb::list& references,
                       const nb::list& goals, const nb::list& answers) {
  const auto& benchmark = tasks::benchmark(task_name, tasks::WorldKind::kGraph);
  const tasks::Scorer& scorer = benchmark.scorer(scorer_name);
  if (scorer.name == tasks::kOwnScorer) {
    throw LookupError(fmt::format("scorer \"{}\": enfilade.metrics() has it", scorer_name));
  }
  std::vector<Item> items(scans.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].graph = &graphs.graph(nb::cast<std::string>(scans[i]));
    read_item(items[i], benchmark, i, trajectories[i], references[i], goals[i], answers[i]);
  }
  const std::size_t width = scorer.metrics.size();
  std::vector<double> values(items.size() * width);
  {
    const nb::gil_scoped_release unlocked;
    parallel_for(items.size(), kPathsAtOnce, 0, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        scorer.on_graph({*items[i].graph, items[i].reference, items[i].trajectory},
                        std::span(values).subspan(i * width, width));
      }
    });
  }
  return owned_array(std::move(values), items.size(), width);
}

// [(name, source, metric names, names of their means), ...]
nb::list scorers(const std::string& task) {
  nb::list rows;
  for (const tasks::Scorer& scorer : tasks::benchmark(task, tasks::WorldKind::kGraph).scorers) {
    if (scorer.name == tasks::kOwnScorer) continue;  // metrics() is it
    nb::list metrics, means;
    for (const tasks::ScorerMetric& metric : scorer.metrics) {
      metrics.append(metric.name);
      if (metric.rule != tasks::MeanRule::kNone) means.append(metric.mean_name());
    }
    rows.append(nb::make_tuple(std::string(scorer.name), std::string(scorer.source),
                               nb::tuple(metrics), nb::tuple(means)));
  }
  return rows;
}

}  // namespace

tasks::MetricOptions metric_options(double success_distance) {
  if (!(success_distance > 0)) {
    throw ArgumentError(
        fmt::format("success_distance {}: more than 0 m is needed", success_distance));
  }
  return {success_distance};
}

nb::dict metrics_dict(const tasks::EpisodeMetrics& metrics) {
  nb::dict d;
  for (const tasks::MetricField& field : tasks::kMetricFields) d[field.name] = metrics.*field.field;
  return d;
}

void bind_scores(nb::module_& m) {
  m.def("metrics", metrics, "graphs"_a, "scan"_a, "trajectory"_a, "reference"_a,
        "success_distance"_a = 3.0,
        nb::sig("def metrics(graphs: Graphs, scan: str, trajectory: typing.Iterable[str | int], "
                "reference: typing.Iterable[str | int], success_distance: float = 3.0) -> "
                "dict[str, float]"),
        "All metrics of one trajectory against one reference path, both viewpoint ids or indices: "
        "nav_error, success, spl, ndtw, cls, ... (docs/tasks.md has the equations). Raises "
        "UnknownNameError, and ArgumentError for a path without viewpoints.");
  m.def("score_paths", score_paths, "graphs"_a, "task"_a, "scorer"_a, "scans"_a, "trajectories"_a,
        "references"_a, "goals"_a, "answers"_a,
        nb::sig("def score_paths(graphs: Graphs, task: str, scorer: str, scans: list[str], "
                "trajectories: list[typing.Any], references: list[typing.Any], goals: "
                "list[typing.Any], answers: list[typing.Any]) -> "
                "numpy.typing.NDArray[numpy.float64]"));
  m.def("scorers", scorers, "task"_a,
        nb::sig("def scorers(task: str) -> list[tuple[str, str, tuple[str, ...], tuple[str, "
                "...]]]"));
}

}  // namespace enfilade::python
