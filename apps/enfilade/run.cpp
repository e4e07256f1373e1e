// enfilade run: an agent over a split.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <filesystem>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/learn.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/run.h"
#include "enfilade/r2r/results.h"
#include "enfilade/r2r/score.h"

namespace enfilade::apps {
namespace {

struct Options {
  std::string data;
  std::string agent = "random";
  std::string split = "val_unseen";
  std::string features;
  std::string output;
  agents::RunOptions run;
};

void run(const Options& options) {
  const bool trained = std::filesystem::is_directory(options.agent);
  std::unique_ptr<agents::Agent> agent;
  if (!trained) agent = agents::make_agent(options.agent);
  const r2r::EpisodeSet episodes = open_data(options.data).episodes(options.split);
  if (trained) agent = load_trained_agent(options.agent, options.features, episodes);
  const auto trajectories = agents::run_agent(*agent, episodes, options.run,
                                              progress_bar(options.agent + ", " + options.split));
  const bool to_stdout = options.output == "-";
  if (!options.output.empty()) write_output(options.output, to_json(trajectories, episodes));
  if (to_stdout) return;
  fmt::print("{} on {}: {} episodes{}\n", options.agent, options.split, trajectories.size(),
             options.output.empty() ? "" : " -> " + options.output);
  if (goals_hidden(episodes)) {
    fmt::print("The goals of this split are hidden, so there is nothing to score it with.\n");
  } else {
    fmt::print("{}", to_table(compute_score(trajectories, episodes)));
  }
}

}  // namespace

void add_run(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand("run", "Run an agent over a split and write its results");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  verb.add_option("--agent", options->agent,
                  fmt::format("One of {}, or the directory of a trained model",
                              fmt::join(agents::agent_names(), ", ")))
      ->capture_default_str()
      ->type_name("NAME");
  verb.add_option("--split", options->split, "train, val_seen, val_unseen, test, ...")
      ->capture_default_str()
      ->type_name("NAME");
  verb.add_option("--features", options->features, "Image features, for a model with vision")
      ->type_name("FILE");
  verb.add_option("-o,--output", options->output,
                  "Results file, in the format of R2R's leaderboard; - for standard output")
      ->type_name("FILE");
  verb.add_option("--seed", options->run.seed, "Seed of the agent's random numbers")
      ->check(whole_number())
      ->capture_default_str();
  verb.add_option("--batch", options->run.batch_size, "Episodes at once; changes no result")
      ->check(whole_number(1))
      ->capture_default_str();
  set_examples(verb, {"enfilade run --agent random --split val_unseen -o results.json",
                      "enfilade run --agent shortest --split val_seen",
                      "enfilade run --agent MODELDIR --features FILE --split test -o test.json"});
  verb.callback([options, &status] {
    run(*options);
    status = kSuccess;
  });
}

}  // namespace enfilade::apps
