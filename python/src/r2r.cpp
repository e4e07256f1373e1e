// Room-to-Room: episodes, metrics, scores, tokens.
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score.h"
#include "enfilade/tasks/tokenizer.h"
#include "python/src/bindings.h"

namespace enfilade::python {
namespace {

using tasks::EpisodeSet;
using namespace nb::literals;

std::shared_ptr<const EpisodeSet> load_episodes(const std::filesystem::path& folder,
                                                const std::string& split, bool all_instructions) {
  const nb::gil_scoped_release unlocked;
  return std::make_shared<EpisodeSet>(dataset::Dataset(folder).episodes(
      split, all_instructions ? tasks::Instructions::kAll : tasks::Instructions::kScored));
}

// (instruction_id, path_id, scan, viewpoints, heading, text)
nb::tuple episode(const EpisodeSet& set, std::size_t i) {
  if (i >= set.episodes.size()) throw nb::index_error("episode");
  const tasks::Episode& e = set.episodes[i];
  const tasks::ReferencePath& path = set.path_of(e);
  const graph::NavGraph& graph = set.graph_of(e);
  nb::list viewpoints;
  for (const ViewpointIndex v : path.viewpoints) viewpoints.append(graph.id(v));
  return nb::make_tuple(e.instruction_id, path.path_id, graph.scan(), nb::tuple(viewpoints),
                        path.heading.value, e.text);
}

std::vector<ViewpointIndex> indices(const graph::NavGraph& graph,
                                    const std::vector<std::string>& names) {
  if (names.empty()) throw ArgumentError("a path without viewpoints");
  std::vector<ViewpointIndex> found;
  for (const std::string& name : names) found.push_back(find_viewpoint(graph, name));
  return found;
}

tasks::MetricOptions metric_options(double success_distance) {
  if (!(success_distance > 0)) {
    throw ArgumentError(
        fmt::format("success_distance {}: more than 0 m is needed", success_distance));
  }
  return {success_distance};
}

nb::dict metrics(const graph::GraphSet& graphs, const std::string& scan,
                 const std::vector<std::string>& trajectory,
                 const std::vector<std::string>& reference, double success_distance) {
  const graph::NavGraph& graph = graphs.graph(scan);
  return metrics_dict(tasks::compute_metrics(graph, indices(graph, trajectory),
                                             indices(graph, reference),
                                             metric_options(success_distance)));
}

// ({metric: (mean, low, high)}, {instruction_id: {metric: value}}, warnings)
nb::tuple score_file(const EpisodeSet& episodes, const std::filesystem::path& file,
                     double success_distance, int bootstrap_samples) {
  tasks::Results results;
  tasks::Score score;
  {
    const nb::gil_scoped_release unlocked;
    tasks::ScoreOptions options;
    options.metrics = metric_options(success_distance);
    results = tasks::load_results(file, episodes);
    options.bootstrap_samples = bootstrap_samples;
    score = tasks::compute_score(results.trajectories, episodes, options);
  }
  nb::dict means, each;
  for (std::size_t i = 0; i < score.means.size(); ++i) {
    const auto& mean = score.means[i];
    means[tasks::metric_fields()[i].name] = nb::make_tuple(mean.mean, mean.low, mean.high);
  }
  for (std::size_t i = 0; i < score.episodes.size(); ++i) {
    each[episodes.episodes[i].instruction_id.c_str()] = metrics_dict(score.episodes[i]);
  }
  nb::list warnings;
  for (const Diagnostic& warning : results.warnings) warnings.append(to_string(warning));
  return nb::make_tuple(means, each, warnings);
}

void bind_tokens(nb::module_& m) {
  using tasks::Vocabulary;
  m.def("tokenize", &tasks::tokenize, "text"_a, "Words as R2R's released code splits them.");
  nb::class_<Vocabulary>(m, "Vocabulary", "Words and their ids: 0 <PAD>, 1 <UNK>, 2 <EOS>.")
      .def_static("load", &Vocabulary::load, "file"_a,
                  "One word a line, as R2R's train_vocab.txt. Raises FileError, InvalidInput.")
      .def_static(
          "build",
          [](const std::vector<std::string>& texts, std::size_t least_count) {
            return Vocabulary::build(texts, least_count);
          },
          "texts"_a, "least_count"_a = 5,
          "The words that come at least so often, most frequent first; ties by alphabet.")
      .def("save", &Vocabulary::save, "file"_a, "For load(). Raises FileError.")
      .def("__len__", &Vocabulary::size)
      .def_prop_ro("words", &Vocabulary::words, "By id.")
      .def("encode", &Vocabulary::encode, "text"_a, "length"_a = 80,
           "Ids: words reversed, <EOS>, <PAD> up to `length`.")
      .def(
          "decode",
          [](const Vocabulary& v, const std::vector<std::uint32_t>& ids) { return v.decode(ids); },
          "ids"_a,
          "Back to words in reading order, without specials but <UNK>, which ids of no word are "
          "too.");
}

}  // namespace

nb::dict metrics_dict(const tasks::EpisodeMetrics& metrics) {
  nb::dict d;
  for (const tasks::MetricField& field : tasks::metric_fields())
    d[field.name] = metrics.*field.field;
  return d;
}

void bind_r2r(nb::module_& m) {
  nb::class_<EpisodeSet>(m, "EpisodeSet", "What enfilade.Episodes is made of.")
      .def(nb::new_(&load_episodes), "folder"_a, "split"_a, "all_instructions"_a)
      .def("__len__", [](const EpisodeSet& s) { return s.episodes.size(); })
      .def("episode", episode, "index"_a,
           nb::sig("def episode(self, index: int) -> tuple[str, int, str, tuple[str, ...], float, "
                   "str]"))
      .def_prop_ro("graphs", [](const EpisodeSet& s) { return s.graphs; })
      .def("score", score_file, "file"_a, "success_distance"_a, "bootstrap_samples"_a,
           nb::sig("def score(self, file: str | os.PathLike, success_distance: float, "
                   "bootstrap_samples: int) -> "
                   "tuple[dict[str, tuple[float, float, float]], dict[str, dict[str, float]], "
                   "list[str]]"));
  m.def("metrics", metrics, "graphs"_a, "scan"_a, "trajectory"_a, "reference"_a,
        "success_distance"_a = 3.0,
        nb::sig("def metrics(graphs: Graphs, scan: str, trajectory: typing.Sequence[str], "
                "reference: typing.Sequence[str], success_distance: float = 3.0) -> dict[str, "
                "float]"),
        "All metrics of one trajectory against one reference path, both lists of viewpoint ids: "
        "nav_error, success, spl, ndtw, cls, ... (docs/tasks.md has the equations). Raises "
        "UnknownNameError, and ArgumentError for a path without viewpoints.");
  bind_tokens(m);
}

}  // namespace enfilade::python
