// enfilade run: an agent over a split.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_agent.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/agents/mesh_floor.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/split.h"

namespace enfilade::apps {
namespace run_verb {
namespace {

void check_options(const AgentRun& options, const tasks::Benchmark& benchmark) {
  const auto refuse = [&](bool given, std::string_view what) {
    if (given) throw UsageError(fmt::format("--task {}: takes {}", benchmark.name, what));
  };
  if (benchmark.continuous()) {
    refuse(!options.form.empty(), "no --to");
    refuse(!options.features.empty() && !options.walk_graph, "--features with --walk-graph only");
    return;
  }
  if (options.walk_graph) throw UsageError("--walk-graph: with --task r2r-ce or rxr-ce only");
  if (!options.meshes.empty()) throw UsageError("--meshes: with --task r2r-ce only");
  if (options.form.empty()) return;
  if (options.form != "released") {
    throw UsageError(fmt::format("--to {}: only released is known", options.form));
  }
  if (benchmark.task != tasks::Task::kSoon) {
    throw UsageError(fmt::format("--to released: a form of SOON's results; those of {} have one",
                                 benchmark.title));
  }
}

std::string results_text(const AgentRun& options, const tasks::Trajectories& trajectories,
                         const tasks::Split& split) {
  if (options.form.empty()) return to_json(trajectories, split);
  return to_released_soon(std::get<std::vector<tasks::Trajectory>>(trajectories),
                          *split.on_graph());
}

// Runs a graph agent through the graph's episodes, prints how it did there, and makes the agent
// that follows its trajectories.
std::unique_ptr<agents::ContinuousAgent> decide_in_graph(
    const AgentRun& options, const dataset::Dataset& data, const tasks::Split& split,
    const std::shared_ptr<const continuous::Buildings>& buildings) {
  const tasks::Split on_graph = data.split(tasks::benchmark(split.benchmark().task), options.split,
                                           {.instructions = tasks::Instructions::kAll});
  const tasks::EpisodeSet& set = *on_graph.on_graph();
  const agents::AnyAgent agent =
      std::filesystem::is_directory(options.agent)
          ? agents::AnyAgent(load_trained_agent(options.agent, options.features, set))
          : agents::make_agent(on_graph.benchmark(), options.agent);
  const tasks::Trajectories trajectories =
      agents::run(agent, on_graph, nullptr, options.run, progress_bar(options.agent + ", graph"));
  if (options.output != "-" && !on_graph.goals_hidden()) {
    say("In the graph:\n");
    print_score(trajectories, on_graph, nullptr);
    say("\n");
  }
  return agents::make_graph_walker(options.agent,
                                   std::get<std::vector<tasks::Trajectory>>(trajectories), set,
                                   *split.continuous(), agents::MeshFloor(buildings));
}

agents::AnyAgent load_agent(const AgentRun& options, const dataset::Dataset& data,
                            const tasks::Split& split,
                            const std::shared_ptr<const continuous::Buildings>& buildings) {
  if (options.walk_graph) return decide_in_graph(options, data, split, buildings);
  if (const auto& episodes = split.continuous()) {
    return load_continuous_agent(options.agent, data, {.folder = options.meshes}, *episodes,
                                 options.threads);
  }
  return load_trained_agent(options.agent, options.features, *split.on_graph());
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("run", "Run an agent over a split and write its results");
  const auto options = std::make_shared<AgentRun>();
  add_data_option(verb, options->data);
  add_setting(verb, "--agent", options->agent, "NAME",
              fmt::format("One of {}, or a model directory; r2r-ce and rxr-ce: {}, or one",
                          fmt::join(agents::agent_names(), ", "),
                          fmt::join(agents::continuous_agent_names(), ", ")));
  add_task_option(verb, options->task, "r2r, or what the data set has", Worlds::kBoth);
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
  verb.callback([options] { run_agent_over_split(*options); });
}

}  // namespace run_verb

void run_agent_over_split(const AgentRun& options) {
  using namespace run_verb;
  const tasks::Benchmark* named = tasks::find_benchmark(options.task);
  if (named != nullptr) check_options(options, *named);
  const bool trained = std::filesystem::is_directory(options.agent);
  const bool by_name = !trained && !options.walk_graph;
  const tasks::Benchmark& world = named != nullptr ? *named : tasks::benchmark(tasks::Task::kR2r);
  // Before the data: a name that is none is refused at once.
  agents::AnyAgent agent;
  if (by_name) agent = agents::make_agent(world, options.agent);
  const dataset::Dataset data = open_data(options.data);
  const tasks::Benchmark& benchmark = benchmark_of(options.task, data);
  if (named == nullptr) check_options(options, benchmark);
  const tasks::Split split = data.split(benchmark, options.split);
  const auto buildings = agents::open_buildings(benchmark, data.folder());
  if (!by_name) agent = load_agent(options, data, split, buildings);
  const tasks::Trajectories trajectories =
      agents::run(agent, split, buildings, options.run,
                  progress_bar(fmt::format("{}, {}", options.agent, options.split)));
  if (!options.output.empty()) {
    write_output(options.output, results_text(options, trajectories, split));
  }
  if (options.output == "-") return;
  say("{} on {}{}: {} episodes{}\n", options.agent, options.split,
      benchmark.continuous() ? fmt::format(" of {}", benchmark.title) : "", size(trajectories),
      options.output.empty() ? "" : " -> " + options.output);
  if (split.goals_hidden()) {
    say("The goals of this split are hidden, so there is nothing to score it with.\n");
  } else {
    print_score(trajectories, split, buildings.get());
  }
  if (trained && benchmark.answer != tasks::AnswerKind::kNone) {
    say("A trained agent gives no answer beside its path, so none is right.\n");
  }
}

}  // namespace enfilade::apps
