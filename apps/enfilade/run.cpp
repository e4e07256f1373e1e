// enfilade run: an agent over a split.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <filesystem>
#include <memory>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/continuous/walks.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_agent.h"
#include "enfilade/agents/run.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/soon_submission.h"

namespace enfilade::apps {
namespace run_verb {
namespace {

struct Options {
  std::string data, features, meshes, output;
  std::string agent = "random", split = "val_unseen", task, form;
  bool walk_graph = false;
  agents::RunOptions run;
};

std::string results_text(const Options& options, const std::vector<tasks::Trajectory>& trajectories,
                         const tasks::EpisodeSet& episodes) {
  return options.form.empty() ? to_json(trajectories, episodes)
                              : to_released_soon(trajectories, episodes);
}

void check_form(const std::string& form, tasks::Task task) {
  if (form.empty()) return;
  if (form != "released") throw UsageError(fmt::format("--to {}: only released is known", form));
  if (task != tasks::Task::kSoon) {
    throw UsageError(fmt::format("--to released: a form of SOON's results; those of {} have one",
                                 tasks::benchmark(task).title));
  }
}

void run(const Options& options) {
  const tasks::Benchmark* named = tasks::find_benchmark(options.task);
  if (named != nullptr && named->continuous()) {
    if (!options.form.empty())
      throw UsageError(fmt::format("--task {}: takes no --to", options.task));
    if (!options.features.empty() && !options.walk_graph) {
      throw UsageError(
          fmt::format("--task {}: takes --features with --walk-graph only", options.task));
    }
    run_free_walk({.data = options.data,
                   .task = options.task,
                   .agent = options.agent,
                   .split = options.split,
                   .features = options.features,
                   .output = options.output,
                   .meshes = options.meshes,
                   .walk_graph = options.walk_graph,
                   .seed = options.run.seed,
                   .batch_size = options.run.batch_size});
    return;
  }
  if (options.walk_graph) throw UsageError("--walk-graph: with --task r2r-ce or rxr-ce only");
  if (!options.meshes.empty()) throw UsageError("--meshes: with --task r2r-ce only");
  const bool trained = std::filesystem::is_directory(options.agent);
  std::unique_ptr<agents::Agent> agent;
  if (!trained) agent = agents::make_agent(options.agent);
  const dataset::Dataset data = open_data(options.data);
  const tasks::EpisodeSet episodes = episodes_of(data, task_of(options.task, data), options.split);
  check_form(options.form, episodes.task);
  if (trained) agent = load_trained_agent(options.agent, options.features, episodes);
  const auto trajectories = agents::run_agent(*agent, episodes, options.run,
                                              progress_bar(options.agent + ", " + options.split));
  const bool to_stdout = options.output == "-";
  if (!options.output.empty()) {
    write_output(options.output, results_text(options, trajectories, episodes));
  }
  if (to_stdout) return;
  fmt::print("{} on {}: {} episodes{}\n", options.agent, options.split, trajectories.size(),
             options.output.empty() ? "" : " -> " + options.output);
  if (goals_hidden(episodes)) {
    fmt::print("The goals of this split are hidden, so there is nothing to score it with.\n");
  } else {
    print_score(trajectories, episodes);
  }
  if (trained && tasks::benchmark(episodes.task).answer != tasks::AnswerKind::kNone) {
    fmt::print("A trained agent gives no answer beside its path, so none is right.\n");
  }
}

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("run", "Run an agent over a split and write its results");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_setting(verb, "--agent", options->agent, "NAME",
              fmt::format("One of {}, or a model directory; r2r-ce and rxr-ce: {}, or one",
                          fmt::join(agents::agent_names(), ", "),
                          fmt::join(agents::continuous_agent_names(), ", ")));
  add_task_option(verb, options->task, "r2r, or what the data set has", FreeTasks::kToo);
  add_setting(verb, "--split", options->split, "NAME", "train, val_seen, val_unseen, test, ...");
  add_value(verb, "--features", options->features, "FILE",
            "Image features, for a model with vision");
  add_value(verb, "--meshes", options->meshes, "DIR",
            "r2r-ce: folder of meshes SCAN.glb, .obj or .ply, instead of the data set's");
  add_value(verb, "-o,--output", options->output, "FILE",
            "Results file in the benchmark's form; - for standard output");
  add_value(verb, "--to", options->form, "FORM",
            "released: SOON's results as its own code writes them (default: as DUET does)");
  verb.add_flag("--walk-graph", options->walk_graph,
                "r2r-ce, rxr-ce: a controller follows the trajectories of a graph agent");
  add_whole_number(verb, "--seed", options->run.seed, "Seed of the agent's random numbers", 0);
  add_whole_number(verb, "--batch", options->run.batch_size, "Episodes at once; changes no result");
  set_examples(verb, {"enfilade run --agent random --split val_unseen -o results.json",
                      "enfilade run --agent shortest --split val_seen",
                      "enfilade run --agent reference --task reverie --split val_unseen",
                      "enfilade run --agent shortest --task r2r-ce --split val_unseen",
                      "enfilade run --agent random --task r2r-ce --walk-graph",
                      "enfilade run --agent MODELDIR --task r2r-ce --split val_seen",
                      "enfilade run --agent MODELDIR --features FILE --split test -o test.json"});
  verb.callback([options] { run(*options); });
}

}  // namespace
}  // namespace run_verb

void add_run(CLI::App& app, int& status) { run_verb::add_verb(app, status); }

}  // namespace enfilade::apps
