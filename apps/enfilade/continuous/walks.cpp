#include "apps/enfilade/continuous/walks.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/task_option.h"
#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/agents/graph_walk.h"
#include "enfilade/agents/run.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::apps {
namespace {

using agents::ContinuousSetup;

std::shared_ptr<const continuous::Buildings> open_buildings(const ContinuousSetup& setup,
                                                            const dataset::Dataset& data) {
  return std::make_shared<const continuous::Buildings>(data.folder() / setup.navigation_folder());
}

tasks::ScoreTable score(const std::vector<tasks::ContinuousResult>& walks,
                        const tasks::ContinuousEpisodes& episodes,
                        const continuous::Buildings& buildings, const tasks::Benchmark& benchmark,
                        const tasks::Scorer& scorer, const dataset::Dataset& data) {
  return agents::compute_score(walks, episodes, buildings,
                               agents::load_experts_of(benchmark, data.folder(), episodes.split),
                               benchmark, scorer, progress_bar("scoring"));
}

// Runs the agent through the graph's episodes, and prints how it did there.
std::unique_ptr<agents::ContinuousAgent> decide_in_graph(
    const FreeWalk& walk, const ContinuousSetup& setup, const dataset::Dataset& data,
    const tasks::ContinuousEpisodes& episodes,
    const std::shared_ptr<const continuous::Buildings>& buildings) {
  const tasks::Task task =
      setup.benchmark->form == tasks::ContinuousForm::kRxr ? tasks::Task::kRxr : tasks::Task::kR2r;
  const tasks::EpisodeSet set = episodes_of(data, task, walk.split, tasks::Instructions::kAll);
  const std::unique_ptr<agents::Agent> agent =
      std::filesystem::is_directory(walk.agent) ? load_trained_agent(walk.agent, walk.features, set)
                                                : agents::make_agent(walk.agent);
  const auto trajectories =
      agents::run_agent(*agent, set, {.batch_size = walk.batch_size, .seed = walk.seed},
                        progress_bar(walk.agent + ", graph"));
  if (walk.output != "-" && !tasks::goals_hidden(set)) {
    fmt::print("In the graph:\n");
    print_score(trajectories, set);
    fmt::print("\n");
  }
  return agents::make_graph_walker(walk.agent, trajectories, set, episodes,
                                   agents::MeshFloor(buildings));
}

}  // namespace

void run_free_walk(const FreeWalk& walk) {
  const ContinuousSetup& setup = agents::continuous_setup(walk.task);
  std::unique_ptr<agents::ContinuousAgent> agent;
  const bool trained = std::filesystem::is_directory(walk.agent);
  if (!walk.walk_graph && !trained) agent = agents::make_continuous_agent(walk.agent);
  const dataset::Dataset data = open_data(walk.data);
  const tasks::ContinuousEpisodes episodes =
      agents::load_continuous_split(*setup.benchmark, data.folder(), walk.split);
  const auto buildings = open_buildings(setup, data);
  if (walk.walk_graph) agent = decide_in_graph(walk, setup, data, episodes, buildings);
  if (!agent) {
    agent = load_continuous_agent(walk.agent, data, {.folder = walk.meshes, .up = "format"},
                                  episodes, walk.threads);
  }
  const agents::ContinuousRunOptions options{
      .batch_size = walk.batch_size, .seed = walk.seed, .simulator = setup.simulator};
  const auto walks =
      agents::run_continuous(*agent, episodes, buildings, options,
                             progress_bar(fmt::format("{}, {}", walk.agent, walk.split)));
  if (!walk.output.empty()) {
    write_output(walk.output, to_json(walks, episodes, setup.benchmark->results_form));
  }
  if (walk.output == "-") return;
  fmt::print("{} on {} of {}: {} episodes{}\n", walk.agent, walk.split, setup.benchmark->title,
             walks.size(), walk.output.empty() ? "" : " -> " + walk.output);
  if (goals_hidden(episodes)) {
    fmt::print("The goals of this split are hidden, so there is nothing to score it with.\n");
    return;
  }
  const tasks::Benchmark& benchmark = *setup.benchmark;
  fmt::print("{}",
             to_table(score(walks, episodes, *buildings, benchmark, benchmark.scorer({}), data)));
}

ExitCode score_free_walk(const FreeScore& asked) {
  const ContinuousSetup& setup = agents::continuous_setup(asked.task);
  const tasks::Scorer& scorer = setup.benchmark->scorer(asked.scorer);
  const dataset::Dataset data = open_data(asked.data);
  const tasks::ContinuousEpisodes episodes =
      agents::load_continuous_split(*setup.benchmark, data.folder(), asked.split);
  std::vector<tasks::ContinuousResult> walks;
  try {
    walks = tasks::load_continuous_results(
        asked.results, episodes, asked.part ? tasks::Coverage::kPart : tasks::Coverage::kAll);
  } catch (const InvalidInput& refused) {
    print_diagnostics(refused.diagnostics());
    return kFaultsFound;
  }
  if (goals_hidden(episodes)) {
    throw UsageError(
        fmt::format("{}: the file is good, but the goals of split {} are hidden, so "
                    "it cannot be scored here",
                    asked.results, asked.split));
  }
  const auto buildings = open_buildings(setup, data);
  const tasks::ScoreTable made = score(walks, episodes, *buildings, *setup.benchmark, scorer, data);
  if (!asked.json.empty()) write_output(asked.json, to_json(made, asked.per_episode));
  if (asked.json != "-") fmt::print("{}", to_table(made));
  return kSuccess;
}

}  // namespace enfilade::apps
