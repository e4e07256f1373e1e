// enfilade score: checks a results file completely, then scores it.
#include <fmt/format.h>
#include <filesystem>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string results;
  std::string split;
  std::string data;
  std::string annotations;
  std::string connectivity;
  std::string json;
  bool per_episode = false;
  std::string spl = "shortest";
};

tasks::EpisodeSet load_episodes(const Options& options) {
  if (options.split.empty() && options.annotations.empty()) {
    throw UsageError("score: which split? Give --split NAME, or --annotations FILE");
  }
  if (options.annotations.empty() && options.connectivity.empty()) {
    return open_data(options.data).episodes(options.split);
  }
  const fs::path annotations = options.annotations.empty()
                                   ? open_data(options.data).annotations_file(options.split)
                                   : fs::path(options.annotations);
  const fs::path connectivity = options.connectivity.empty()
                                    ? open_data(options.data).connectivity_folder()
                                    : fs::path(options.connectivity);
  const std::string split = options.split.empty() ? annotations.stem().string() : options.split;
  return tasks::make_episodes(tasks::load_annotations(annotations, split),
                              graph::GraphSet::open(connectivity));
}

void print_score(const Options& options, const tasks::Score& score,
                 const tasks::EpisodeSet& episodes) {
  if (!options.json.empty()) {
    write_output(options.json, options.per_episode ? to_json(score, episodes) : to_json(score));
  }
  if (options.json == "-") return;
  const bool reference = options.spl == "reference";
  fmt::print("{}", to_table(score, reference ? tasks::SplLength::kReference
                                             : tasks::SplLength::kShortest));
}

ExitCode score(const Options& options) {
  const tasks::EpisodeSet episodes = load_episodes(options);
  if (episodes.episodes.empty()) {  // means over none would be nothing that a table can show
    throw UsageError(fmt::format(
        "split {}: the annotations have no episode, so there is nothing to score; the export of a "
        "collection has the paths whose every instruction was walked",
        episodes.split));
  }
  tasks::Results results;
  try {
    results = tasks::load_results(options.results, episodes);
  } catch (const InvalidInput& refused) {  // what was to be checked has faults
    print_diagnostics(refused.diagnostics());
    return kFaultsFound;
  }
  if (!results.warnings.empty()) print_diagnostics(results.warnings);
  if (goals_hidden(episodes)) {
    throw UsageError(fmt::format(
        "{}: the file is good (each of the {} instructions has a trajectory that can be walked), "
        "but the goals of split {} are hidden, so it cannot be scored here. Those of R2R's test "
        "are known to its leaderboard only: hand the file in at eval.ai, challenge 97",
        options.results, episodes.episodes.size(), episodes.split));
  }
  print_score(options, compute_score(results.trajectories, episodes), episodes);
  return kSuccess;
}

void add_options(CLI::App& verb, Options& options) {
  add_value(verb, "results", options.results, "RESULTS.json",
            "Results file, in any of the usual forms")
      ->required();
  add_value(verb, "--split", options.split, "NAME", "train, val_seen, val_unseen, ...");
  add_data_option(verb, options.data);
  add_value(verb, "--annotations", options.annotations, "FILE",
            "Annotations to score against, instead of the data set's R2R_<split>.json");
  add_value(verb, "--connectivity", options.connectivity, "DIR",
            "Navigation graphs, instead of the data set's");
  add_setting(verb, "--spl", options.spl, "PATH",
              "What SPL in the table compares with: the shortest path, or the reference path, "
              "as DUET does. The JSON has both",
              CLI::IsMember({"shortest", "reference"}));
  CLI::Option* json = add_value(verb, "--json", options.json, "FILE",
                                "Write all metrics; - for standard output, without the table");
  verb.add_flag("--per-episode", options.per_episode, "Metrics of each episode in the JSON too")
      ->needs(json);
}

}  // namespace

void add_score(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "score", "Check a results file completely, every problem in one list, then score it");
  const auto options = std::make_shared<Options>();
  add_options(verb, *options);
  set_examples(verb, {"enfilade score results.json --split val_unseen",
                      "enfilade score results.json --split val_seen --json - --per-episode"});
  verb.callback([options, &status] { status = score(*options); });
}

}  // namespace enfilade::apps
