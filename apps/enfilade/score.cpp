// enfilade score: checks a results file completely, then scores it.
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/continuous/walks.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/gzip.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::apps {
namespace score_verb {
namespace {

namespace fs = std::filesystem;

using tasks::Task;

struct Options {
  std::string results;
  std::string split;
  std::string data;
  std::string annotations;
  std::string connectivity;
  std::string objects;
  std::string task;
  std::string scorer;
  std::string json;
  bool per_episode = false;
  bool part = false;
  bool all_instructions = false;
  std::string spl = "shortest";
};

// What --task says, or what the files look like: annotations first, as they tell more.
Task find_task(const Options& options, const std::string& annotations, const std::string& results) {
  if (!options.task.empty()) return tasks::benchmark(options.task, tasks::World::kGraph).task;
  std::optional<Task> found;
  if (!options.annotations.empty()) found = tasks::find_task(annotations);
  if (!found || *found == Task::kR2r) {
    if (const auto by_results = tasks::find_task_of_results(results)) found = by_results;
  }
  return found.value_or(Task::kR2r);
}

std::shared_ptr<const tasks::ObjectBoxes> load_objects(const Options& options,
                                                       const tasks::Annotations& annotations) {
  if (annotations.task != Task::kReverie) return nullptr;
  if (!options.objects.empty()) {
    return std::make_shared<tasks::ObjectBoxes>(tasks::ObjectBoxes::load(options.objects));
  }
  if (!tasks::needs_boxes(annotations)) return nullptr;
  const auto data = std::make_shared<dataset::Dataset>(open_data(options.data));
  return {data, &data->objects()};
}

std::string annotations_file(const Options& options, Task task) {
  if (!options.annotations.empty()) return options.annotations;
  const auto data = open_data(options.data);
  const fs::path file = task == Task::kR2r ? data.annotations_file(options.split)
                                           : data.annotations_file(task, options.split);
  return file.string();
}

// `text`: of --annotations, if that was given.
tasks::EpisodeSet load_episodes(const Options& options, Task task, const std::string& text) {
  const auto which =
      options.all_instructions ? tasks::Instructions::kAll : tasks::Instructions::kScored;
  const bool usual = options.annotations.empty() && options.connectivity.empty();
  if (usual && task == Task::kR2r) return open_data(options.data).episodes(options.split, which);
  const std::string file = annotations_file(options, task);
  const std::string split = options.split.empty() ? fs::path(file).stem().string() : options.split;
  const tasks::Annotations annotations = options.annotations.empty()
                                             ? tasks::load_annotations(file, split, task)
                                             : tasks::parse_annotations(text, file, split, task);
  const auto graphs = options.connectivity.empty() ? open_data(options.data).graphs()
                                                   : graph::GraphSet::open(options.connectivity);
  const auto objects = load_objects(options, annotations);
  return tasks::make_episodes(annotations, graphs, which, objects.get());
}

void print_score(const Options& options, const tasks::ScoreTable& score) {
  if (!options.json.empty()) write_output(options.json, to_json(score, options.per_episode));
  if (options.json == "-") return;
  const bool reference = options.spl == "reference";
  fmt::print("{}", to_table(score, reference ? tasks::SplLength::kReference
                                             : tasks::SplLength::kShortest));
}

void refuse_hidden(const Options& options, const tasks::EpisodeSet& episodes) {
  if (!goals_hidden(episodes)) return;
  throw UsageError(fmt::format(
      "{}: the file is good (each of the {} instructions has a trajectory that can be walked), "
      "but the goals of split {} are hidden, so it cannot be scored here.{}",
      options.results, episodes.episodes.size(), episodes.split,
      episodes.task == Task::kR2r
          ? " Those of R2R's test are known to its leaderboard only: hand the file "
            "in at eval.ai, challenge 97"
          : ""));
}

// Options that say nothing about walks in continuous space are not read over.
ExitCode score_free(const Options& options) {
  if (options.split.empty()) throw UsageError("score: which split? Give --split NAME");
  for (const auto& [name, given] : {std::pair{"--annotations", !options.annotations.empty()},
                                    {"--connectivity", !options.connectivity.empty()},
                                    {"--objects", !options.objects.empty()},
                                    {"--all-instructions", options.all_instructions},
                                    {"--spl reference", options.spl == "reference"}}) {
    if (given) throw UsageError(fmt::format("--task {}: takes no {}", options.task, name));
  }
  return score_free_walk({.data = options.data,
                          .task = options.task,
                          .split = options.split,
                          .results = options.results,
                          .json = options.json,
                          .scorer = options.scorer,
                          .per_episode = options.per_episode,
                          .part = options.part});
}

ExitCode score(const Options& options) {
  const tasks::Benchmark* named = tasks::find_benchmark(options.task);
  if (named != nullptr && named->continuous()) return score_free(options);
  if (options.split.empty() && options.annotations.empty()) {
    throw UsageError("score: which split? Give --split NAME, or --annotations FILE");
  }
  const std::string text = read_text_file(options.results);
  const std::string annotations =
      options.annotations.empty() ? std::string() : read_text_file(options.annotations);
  tasks::EpisodeSet episodes =
      load_episodes(options, find_task(options, annotations, text), annotations);
  if (episodes.episodes.empty()) {  // means over none would be nothing that a table can show
    throw UsageError(fmt::format(
        "split {}: the annotations have no episode, so there is nothing to score; the export of a "
        "collection has the paths whose every instruction was walked",
        episodes.split));
  }
  tasks::Results results;
  try {
    results = tasks::parse_results(text, options.results, episodes,
                                   options.part ? tasks::Coverage::kPart : tasks::Coverage::kAll);
  } catch (const InvalidInput& refused) {  // what was to be checked has faults
    print_diagnostics(refused.diagnostics());
    return kFaultsFound;
  }
  if (!results.warnings.empty()) print_diagnostics(results.warnings);
  if (options.part) {
    const std::size_t whole = episodes.episodes.size();
    episodes = part_of(episodes, results.trajectories);
    fmt::print(stderr, "note: a part of split {}: {} of its {} instructions\n", episodes.split,
               episodes.episodes.size(), whole);
  }
  refuse_hidden(options, episodes);
  const tasks::Scorer& scorer = tasks::benchmark(episodes.task).scorer(options.scorer);
  print_score(options, compute_score(results.trajectories, episodes, scorer));
  return kSuccess;
}

void add_options(CLI::App& verb, Options& options) {
  add_value(verb, "results", options.results, "RESULTS.json",
            "Results file, in any of the usual forms")
      ->required();
  add_value(verb, "--split", options.split, "NAME", "train, val_seen, val_unseen, ...");
  add_data_option(verb, options.data);
  add_value(
      verb, "--task", options.task, "NAME",
      "r2r, r2r-last, r2r-back, r4r, rxr, reverie, cvdn, soon, r2r-ce or rxr-ce (default: what "
      "the files are of; where results say nothing, r2r)");
  add_value(verb, "--scorer", options.scorer, "NAME",
            "Scorer: official, duet, hamt, valan, r4r_public, vlnce, etpnav, ... (docs/tasks.md) "
            "(default: ours for r2r; else the scorer of the published table)");
  add_value(verb, "--annotations", options.annotations, "FILE",
            "Annotations to score against, instead of the data set's; may be packed");
  add_value(verb, "--objects", options.objects, "FILE",
            "REVERIE's boxes, file or folder, instead of the data set's");
  add_value(verb, "--connectivity", options.connectivity, "DIR",
            "Navigation graphs, instead of the data set's");
  add_setting(verb, "--spl", options.spl, "PATH",
              "Path in the table's SPL: shortest, or reference, as DUET",
              CLI::IsMember({"shortest", "reference"}));
  CLI::Option* json = add_value(verb, "--json", options.json, "FILE",
                                "Write all measures; - for standard output, without the table");
  verb.add_flag("--part", options.part,
                "Score the file's instructions only; otherwise a missing one is a fault");
  verb.add_flag("--all-instructions", options.all_instructions,
                "R2R: score fourth instructions too, such as 757_3, which papers leave out");
  verb.add_flag("--per-episode", options.per_episode, "Measures of each episode in the JSON too")
      ->needs(json);
}

void add_verb(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand("score", "Check a results file completely, then score it");
  const auto options = std::make_shared<Options>();
  add_options(verb, *options);
  set_examples(verb, {"enfilade score results.json --split val_unseen",
                      "enfilade score results.json --split val_seen --json - --per-episode",
                      "enfilade score results.json --task reverie --split val_unseen --scorer duet",
                      "enfilade score results.json --task r2r-ce --split val_unseen",
                      "enfilade score results.json --task rxr --annotations "
                      "rxr_val_unseen_guide.jsonl.gz"});
  verb.callback([options, &status] { status = score(*options); });
}

}  // namespace
}  // namespace score_verb

void add_score(CLI::App& app, int& status) { score_verb::add_verb(app, status); }

}  // namespace enfilade::apps
