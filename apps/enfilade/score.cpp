// enfilade score: checks a results file completely, then scores it.
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/agents/run.h"
#include "enfilade/core/gzip.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/split.h"

namespace enfilade::apps::score_verb {
namespace {

namespace fs = std::filesystem;

using tasks::Task;

struct Options {
  std::string results, split, data, annotations, connectivity, objects, task, scorer, json;
  bool per_episode = false, part = false, all_instructions = false;
  std::string spl = "shortest";
};

// What --task says, or what the files look like: annotations first, as they tell more.
Task find_task(const Options& options, const std::string& annotations, const std::string& results) {
  if (!options.task.empty()) return tasks::benchmark(options.task, tasks::WorldKind::kGraph).task;
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

// `text`: of --annotations, if that was given.
tasks::Split load_episodes(const Options& options, Task task, const std::string& text) {
  const auto which =
      options.all_instructions ? tasks::Instructions::kAll : tasks::Instructions::kScored;
  if (options.annotations.empty() && options.connectivity.empty() && options.objects.empty()) {
    return open_data(options.data)
        .split(tasks::benchmark(task), options.split, {.instructions = which});
  }
  const std::string file =
      !options.annotations.empty()
          ? options.annotations
          : open_data(options.data).episodes_file(tasks::benchmark(task), options.split).string();
  const std::string split = options.split.empty() ? fs::path(file).stem().string() : options.split;
  const tasks::Annotations annotations = options.annotations.empty()
                                             ? tasks::load_annotations(file, split, task)
                                             : tasks::parse_annotations(text, file, split, task);
  const auto graphs = options.connectivity.empty() ? open_data(options.data).graphs()
                                                   : graph::GraphSet::open(options.connectivity);
  const auto objects = load_objects(options, annotations);
  tasks::Split read(tasks::make_episodes(annotations, graphs, which, objects.get()));
  tasks::require_episodes(read, file);
  return read;
}

void print_score(const Options& options, const tasks::ScoreTable& score) {
  if (!options.json.empty()) write_output(options.json, to_json(score, options.per_episode));
  if (options.json == "-") return;
  const bool reference = options.spl == "reference";
  say("{}",
      to_table(score, reference ? tasks::SplLength::kReference : tasks::SplLength::kShortest));
}

void refuse_hidden(const Options& options, const tasks::Split& split) {
  if (!split.goals_hidden()) return;
  const std::string_view board = split.benchmark().leaderboard;
  throw UsageError(fmt::format(
      "{}: the file is good (each of the {} instructions has a trajectory), but the goals of split "
      "{} are hidden, so it cannot be scored here.{}{}",
      options.results, split.size(), split.name(), board.empty() ? "" : " ", board));
}

// Options that say nothing about continuous episodes are not read over.
tasks::Split load_continuous(const Options& options, const tasks::Benchmark& benchmark) {
  if (options.split.empty()) throw UsageError("score: which split? Give --split NAME");
  for (const auto& [name, given] : {std::pair{"--annotations", !options.annotations.empty()},
                                    {"--connectivity", !options.connectivity.empty()},
                                    {"--objects", !options.objects.empty()},
                                    {"--all-instructions", options.all_instructions},
                                    {"--spl reference", options.spl == "reference"}}) {
    if (given) throw UsageError(fmt::format("--task {}: takes no {}", options.task, name));
  }
  return open_data(options.data).split(benchmark, options.split);
}

tasks::Split load_on_graph(const Options& options, const std::string& results) {
  const std::string annotations =
      options.annotations.empty() ? std::string() : read_text_file(options.annotations);
  return load_episodes(options, find_task(options, annotations, results), annotations);
}

ExitCode score(const Options& options) {
  const tasks::Benchmark* named = tasks::find_benchmark(options.task);
  const bool continuous = named != nullptr && named->continuous();
  if (!continuous && options.split.empty() && options.annotations.empty()) {
    throw UsageError("score: which split? Give --split NAME, or --annotations FILE");
  }
  const std::string text = read_text_file(options.results);
  tasks::Split split = continuous ? load_continuous(options, *named) : load_on_graph(options, text);
  tasks::Trajectories trajectories;
  std::vector<Diagnostic> warnings;
  try {
    trajectories = parse_trajectories(text, options.results, split,
                                      options.part ? tasks::Coverage::kPart : tasks::Coverage::kAll,
                                      &warnings);
  } catch (const InvalidInput& refused) {  // what was to be checked has faults
    print_diagnostics(refused.diagnostics());
    return kFaultsFound;
  }
  if (!warnings.empty()) print_diagnostics(warnings);
  if (options.part) {
    say(stderr, "note: a part of split {}: {} of its {} instructions\n", split.name(),
        size(trajectories), split.size());
    split = part_of(split, trajectories);
  }
  refuse_hidden(options, split);
  std::shared_ptr<const continuous::Buildings> buildings;  // graphs may lie in no data set
  if (continuous) buildings = agents::open_buildings(*named, open_data(options.data).folder());
  print_score(options, agents::compute_score(trajectories, split, buildings.get(),
                                             split.benchmark().scorer(options.scorer),
                                             progress_bar("scoring")));
  return kSuccess;
}

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand("score", "Check a results file completely, then score it");
  const auto options = std::make_shared<Options>();
  add_value(verb, "results", options->results, "RESULTS.json",
            "Results file, in any of the usual forms")
      ->required();
  add_value(verb, "--split", options->split, "NAME", "train, val_seen, val_unseen, ...");
  add_data_option(verb, options->data);
  add_value(
      verb, "--task", options->task, "NAME",
      "r2r, r2r-last, r2r-back, r4r, rxr, reverie, cvdn, soon, r2r-ce or rxr-ce (default: what "
      "the files are of; where results say nothing, r2r)");
  add_value(verb, "--scorer", options->scorer, "NAME",
            "Scorer: official, duet, hamt, valan, r4r_public, vlnce, etpnav, ... (docs/tasks.md) "
            "(default: ours for r2r; else the scorer of the published table)");
  add_value(verb, "--annotations", options->annotations, "FILE",
            "Annotations to score against, instead of the data set's; may be packed");
  add_value(verb, "--objects", options->objects, "FILE",
            "REVERIE's boxes, file or folder, instead of the data set's");
  add_value(verb, "--connectivity", options->connectivity, "DIR",
            "Navigation graphs, instead of the data set's");
  add_setting(verb, "--spl", options->spl, "PATH",
              "Path in the table's SPL: shortest, or reference, as DUET",
              CLI::IsMember({"shortest", "reference"}));
  CLI::Option* json = add_value(verb, "--json", options->json, "FILE",
                                "Write all measures; - for standard output, without the table");
  verb.add_flag("--part", options->part,
                "Score the file's instructions only; otherwise a missing one is a fault");
  verb.add_flag("--all-instructions", options->all_instructions,
                "R2R: score fourth instructions too, such as 757_3, which papers leave out");
  verb.add_flag("--per-episode", options->per_episode, "Measures of each episode in the JSON too")
      ->needs(json);
  set_examples(verb, {"enfilade score results.json --split val_unseen",
                      "enfilade score results.json --split val_seen --json - --per-episode",
                      "enfilade score results.json --task reverie --split val_unseen --scorer duet",
                      "enfilade score results.json --task r2r-ce --split val_unseen",
                      "enfilade score results.json --task rxr --annotations "
                      "rxr_val_unseen_guide.jsonl.gz"});
  verb.callback([options, &status] { status = score(*options); });
}

}  // namespace enfilade::apps::score_verb
