// EpisodeSet: the episodes of a split of any benchmark, and their scores. Words of instructions.

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/tokenizer.h"
#include "python/src/bindings.h"

namespace enfilade::python {
namespace {

using namespace nb::literals;
using tasks::Vocabulary;
using Set = std::shared_ptr<const tasks::EpisodeSet>;

tasks::EpisodeSet load(const dataset::Dataset& dataset, tasks::Task task, const std::string& split,
                       const std::optional<std::filesystem::path>& file,
                       tasks::Instructions wanted) {
  if (!file) return dataset.episodes(task, split, wanted);
  const tasks::Annotations read = tasks::load_annotations(*file, split, task);
  return tasks::make_episodes(read, dataset.graphs(), wanted,
                              tasks::needs_boxes(read) ? &dataset.objects() : nullptr);
}

/// The episodes, and their places by id once somebody has asked for one.
class Episodes {
 public:
  explicit Episodes(Set set) : set_(std::move(set)) {}

  const Set& set() const noexcept { return set_; }
  const tasks::Episode& at(std::size_t i) const {
    if (i >= set_->episodes.size()) throw nb::index_error("episode");
    return set_->episodes[i];
  }
  // Under the GIL.
  std::optional<std::size_t> find(const std::string& id) {
    if (by_id_.empty()) {
      for (std::size_t i = 0; i < set_->episodes.size(); ++i) {
        by_id_.emplace(set_->episodes[i].instruction_id, i);
      }
    }
    const auto found = by_id_.find(id);
    return found == by_id_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  Set set_;
  std::unordered_map<std::string, std::size_t> by_id_;
};

std::unique_ptr<Episodes> load_episodes(const dataset::Dataset& dataset, const std::string& task,
                                        const std::string& split, bool all_instructions,
                                        const std::optional<std::filesystem::path>& file) {
  const nb::gil_scoped_release unlocked;
  const auto wanted = all_instructions ? tasks::Instructions::kAll : tasks::Instructions::kScored;
  return std::make_unique<Episodes>(std::make_shared<tasks::EpisodeSet>(
      load(dataset, tasks::benchmark(task, tasks::WorldKind::kGraph).task, split, file, wanted)));
}

nb::object optional_number(const std::optional<double>& number) {
  return number ? nb::cast(*number) : nb::none();
}

// (language, words, turns, parts, tokens, fields), as Episode's fields.
nb::tuple details_tuple(const tasks::InstructionDetails& details) {
  nb::list words, turns, parts, fields;
  for (const tasks::TimedWord& w : details.words) {
    words.append(nb::make_tuple(w.word, optional_number(w.start), optional_number(w.end)));
  }
  for (const tasks::DialogueTurn& t : details.turns) {
    turns.append(nb::make_tuple(t.role, t.message, t.nav_step));
  }
  for (const tasks::SubInstruction& p : details.parts) {
    nb::list pieces;
    for (const std::string& word : p.words) pieces.append(word);
    nb::object places = nb::none();
    if (p.places) places = nb::make_tuple(p.places->first, p.places->second);
    parts.append(nb::make_tuple(nb::tuple(pieces), places));
  }
  for (const auto& [name, text] : details.fields) fields.append(nb::make_tuple(name, text));
  nb::list tokens;
  for (const std::int32_t token : details.tokens) tokens.append(token);
  return nb::make_tuple(details.language, words, turns, parts, nb::tuple(tokens), fields);
}

// (instruction_id, path_id, scan, path, heading, text, goal, group, details)
nb::tuple episode(const Episodes& self, std::size_t i) {
  const tasks::EpisodeSet& set = *self.set();
  const tasks::Episode& e = self.at(i);
  const tasks::ReferencePath& path = set.path_of(e);
  const graph::NavGraph& graph = set.graph_of(e);
  nb::list viewpoints;
  for (const ViewpointIndex v : path.viewpoints) viewpoints.append(graph.id(v));
  const tasks::Goal goal = tasks::goal_hidden(path) ? tasks::Goal(tasks::HiddenGoal{}) : path.goal;
  return nb::make_tuple(e.instruction_id, path.path_id, graph.scan(), nb::tuple(viewpoints),
                        path.heading.value, e.text, goal_tuple(goal, graph, path.viewpoints.back()),
                        path.group, details_tuple(e.details));
}

// For enfilade._learn, which is built with this module and has the same classes, but not its types
// of Python objects.
nb::capsule shared(const Episodes& self) {
  return nb::capsule(new Set(self.set()), "enfilade.EpisodeSet",
                     [](void* set) noexcept { delete static_cast<Set*>(set); });
}

// (instruction_id, path_id, group, scan, language): what a table of scores begins with.
nb::tuple about(const Episodes& self, std::size_t i) {
  const tasks::EpisodeSet& set = *self.set();
  const tasks::Episode& e = self.at(i);
  const tasks::ReferencePath& path = set.path_of(e);
  return nb::make_tuple(e.instruction_id, path.path_id, path.group, set.graph_of(e).scan(),
                        e.details.language);
}

nb::tuple scored_tuple(tasks::ScoreTable score, const std::vector<std::size_t>& places,
                       const std::vector<Diagnostic>& warnings) {
  nb::dict means;
  nb::list names, told;
  const auto metrics = score.scorer->metrics;
  for (std::size_t k = 0; k < metrics.size(); ++k) {
    names.append(metrics[k].name);
    if (metrics[k].rule == tasks::MeanRule::kNone) continue;
    const auto& mean = score.means[k];
    means[metrics[k].mean_name()] = nb::make_tuple(mean.mean, mean.low, mean.high);
  }
  for (const Diagnostic& warning : warnings) told.append(to_string(warning));
  return nb::make_tuple(std::string(score.scorer->name), nb::tuple(names), means,
                        owned_array(std::move(score.values), score.episodes, metrics.size()),
                        places, told);
}

// (scorer, names, {metric: (mean, low, high)}, values, places of the episodes, warnings)
nb::tuple score(const Episodes& self, const std::optional<std::filesystem::path>& file,
                const std::string& text, const std::string& wanted, double success_distance,
                int samples, bool part) {
  const tasks::EpisodeSet& all = *self.set();
  const tasks::Scorer& scorer = tasks::benchmark(all.task).scorer(wanted);
  if (scorer.name != "enfilade" && success_distance != tasks::MetricOptions{}.success_distance) {
    throw ArgumentError(
        fmt::format("success_distance {}: scorer '{}' has its own", success_distance, scorer.name));
  }
  const tasks::MetricOptions options = metric_options(success_distance);
  tasks::Results results;
  tasks::ScoreTable scored;
  std::vector<std::size_t> places;
  {
    const nb::gil_scoped_release unlocked;
    const auto coverage = part ? tasks::Coverage::kPart : tasks::Coverage::kAll;
    results = file ? tasks::load_results(*file, all, coverage)
                   : tasks::parse_results(text, "<results>", all, coverage);
    for (const tasks::Trajectory& trajectory : results.trajectories) {
      places.push_back(trajectory.episode);
    }
    std::optional<tasks::EpisodeSet> smaller;
    if (part) smaller = tasks::part_of(all, results.trajectories);
    const tasks::EpisodeSet& episodes = smaller ? *smaller : all;
    scored = compute_score(results.trajectories, episodes, scorer,
                           {.metrics = options, .bootstrap_samples = samples});
  }
  return scored_tuple(std::move(scored), places, results.warnings);
}

// Words and their ids, as in Room-to-Room's released code.
void bind_tokens(nb::module_& m) {
  m.def("tokenize", &tasks::tokenize, "text"_a,
        "Splits a text into words, as R2R's released code does.");
  nb::class_<Vocabulary>(m, "Vocabulary", "Words and their ids: 0 <PAD>, 1 <UNK>, 2 <EOS>.")
      .def_static(
          "load", &Vocabulary::load, "file"_a,
          "Reads one word per line, as in R2R's train_vocab.txt. Raises FileError, InvalidInput.")
      .def_static(
          "build",
          [](const std::vector<std::string>& texts, std::size_t least_count) {
            return Vocabulary::build(texts, least_count);
          },
          "texts"_a, "least_count"_a = 5,
          "The words with at least least_count occurrences, most frequent first; ties by alphabet.")
      .def("save", &Vocabulary::save, "file"_a, "Writes a file for load(). Raises FileError.")
      .def("__len__", &Vocabulary::size)
      .def_prop_ro("words", &Vocabulary::words, "Words by id.")
      .def("encode", &Vocabulary::encode, "text"_a, "length"_a = 80,
           "Token ids: words reversed, <EOS>, then <PAD> up to `length`.")
      .def(
          "decode",
          [](const Vocabulary& v, const std::vector<std::uint32_t>& ids) { return v.decode(ids); },
          "ids"_a, "Words in reading order, without <PAD> and <EOS>; unknown ids become <UNK>.")
      .def("__getstate__", &Vocabulary::words)
      .def("__setstate__", [](Vocabulary& v, const std::vector<std::string>& words) {
        new (&v) Vocabulary(Vocabulary::of(words));
      });
}

}  // namespace

Set episode_set(nb::handle episodes) { return nb::cast<const Episodes&>(episodes).set(); }

void bind_episodes(nb::module_& m) {
  bind_tokens(m);
  nb::class_<Episodes>(m, "EpisodeSet", "The core of enfilade.Episodes.")
      .def(nb::new_(&load_episodes), "dataset"_a, "task"_a, "split"_a, "all_instructions"_a,
           "file"_a.none())
      .def("__len__", [](const Episodes& s) { return s.set()->episodes.size(); })
      .def("episode", episode, "index"_a,
           nb::sig("def episode(self, index: int) -> tuple[typing.Any, ...]"))
      .def("about", about, "index"_a,
           nb::sig("def about(self, index: int) -> tuple[str, int, int, str, str]"))
      .def("find", &Episodes::find, "instruction_id"_a)
      .def("shared", shared, "The C++ object, for another extension module of this package.",
           nb::sig("def shared(self) -> typing.Any"))
      .def_prop_ro(
          "texts",
          [](const Episodes& s) {
            nb::list texts;
            for (const tasks::Episode& e : s.set()->episodes) texts.append(e.text);
            return texts;
          },
          nb::sig("def texts(self) -> list[str]"))
      .def_prop_ro(
          "task",
          [](const Episodes& s) { return std::string(tasks::benchmark(s.set()->task).name); })
      .def_prop_ro("graphs", [](const Episodes& s) { return s.set()->graphs; })
      .def("score", score, "file"_a.none(), "text"_a, "scorer"_a, "success_distance"_a,
           "bootstrap_samples"_a, "part"_a,
           nb::sig("def score(self, file: str | os.PathLike | None, text: str, scorer: str, "
                   "success_distance: float, bootstrap_samples: int, part: bool) -> "
                   "tuple[str, tuple[str, ...], dict[str, tuple[float, float, float]], "
                   "numpy.typing.NDArray[numpy.float64], list[int], list[str]]"));
}

}  // namespace enfilade::python
