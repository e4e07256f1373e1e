#include "enfilade/agents/run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <numeric>
#include <utility>
#include <variant>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/agents/episode_batch.h"
#include "enfilade/agents/simple_agents.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"

namespace enfilade::agents {
namespace {

using tasks::EpisodeSet;
using tasks::Trajectory;

// Runs the episodes [first, first + count) in one simulator, to the end of the last.
std::vector<Trajectory> run_batch(Agent& agent, const EpisodeSet& episodes,
                                  const RunOptions& options, std::size_t first, std::size_t count) {
  sim::SimulatorConfig config = options.simulator;
  config.batch_size = count;
  config.seed = options.seed;
  EpisodeBatch batch(episodes, config);
  std::vector<std::size_t> chosen(count);
  std::iota(chosen.begin(), chosen.end(), first);
  batch.begin(chosen);

  std::vector<Rng> rngs;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& id = batch.episode(i).instruction_id;
    rngs.emplace_back(options.seed, stream_of(id.data(), id.size()));
  }
  std::vector<Observation> observations(count);
  const auto observe = [&] {
    for (std::size_t i = 0; i < count; ++i) {
      observations[i] = batch.observation(i);
      observations[i].rng = &rngs[i];
    }
  };
  observe();
  agent.start(observations);

  std::vector<Decision> decisions(count);
  std::vector<sim::Action> actions(count);
  for (std::size_t taken = 0; taken < options.max_actions && batch.running() > 0; ++taken) {
    if (taken > 0) observe();
    agent.act(observations, decisions);
    for (std::size_t i = 0; i < count; ++i) {
      const Decision& d = decisions[i];
      if (d.answer && !batch.ended(i)) batch.give(i, *d.answer);
      if (d.stop) batch.end(i);
      actions[i] = batch.ended(i) ? sim::Action{}
                                  : sim::Action{d.index, d.heading_change, d.elevation_change};
    }
    if (batch.running() > 0) batch.step(actions);
  }
  return batch.take_trajectories();
}

void require_goals(const Agent& agent, const EpisodeSet& episodes) {
  for (const tasks::ReferencePath& path : episodes.paths) {
    if (goal_hidden(path)) {
      throw ArgumentError(fmt::format("agent {} needs the goal, which split {} hides (path {})",
                                      agent.name(), episodes.split, path.path_id));
    }
    const auto* object = std::get_if<tasks::SeenObject>(&path.goal);
    if (object == nullptr || !object->seen_from.empty()) continue;
    throw ArgumentError(
        fmt::format("agent {} needs to know where object {} of path {} is seen: split {} was made "
                    "without boxes",
                    agent.name(), object->id, path.path_id, episodes.split));
  }
}

}  // namespace

std::vector<Trajectory> run_agent(Agent& agent, const EpisodeSet& episodes,
                                  const RunOptions& options, const Progress& progress) {
  if (options.batch_size == 0) throw ArgumentError("batch size 0: at least 1 is needed");
  if (agent.needs_goal()) require_goals(agent, episodes);
  const std::size_t total = episodes.episodes.size();
  std::vector<Trajectory> all;
  all.reserve(total);
  for (std::size_t first = 0; first < total; first += options.batch_size) {
    const std::size_t count = std::min(options.batch_size, total - first);
    for (Trajectory& one : run_batch(agent, episodes, options, first, count)) {
      all.push_back(std::move(one));
    }
    if (progress) progress(all.size(), total);
  }
  return all;
}

std::unique_ptr<Agent> make_agent(std::string_view name) {
  if (name == "random") return std::make_unique<RandomAgent>();
  if (name == "reference") return std::make_unique<ReferenceAgent>();
  if (name == "shortest") return std::make_unique<ShortestAgent>();
  throw LookupError(fmt::format("agent {}: there is none of that name; there are: {}", quote(name),
                                fmt::join(agent_names(), ", ")));
}

AnyAgent make_agent(const tasks::Benchmark& benchmark, std::string_view name) {
  if (benchmark.continuous()) return make_continuous_agent(name);
  return make_agent(name);
}

tasks::Trajectories run(const AnyAgent& agent, const tasks::Split& split,
                        const std::shared_ptr<const continuous::Buildings>& buildings,
                        const RunOptions& options, const Progress& progress) {
  if (const auto* on_graph = std::get_if<std::unique_ptr<Agent>>(&agent)) {
    return run_agent(**on_graph, *split.on_graph(), options, progress);
  }
  return run_continuous(*std::get<std::unique_ptr<ContinuousAgent>>(agent), *split.continuous(),
                        buildings,
                        {.batch_size = options.batch_size,
                         .seed = options.seed,
                         .simulator = continuous_setup(split.benchmark()).simulator},
                        progress);
}

tasks::ScoreTable compute_score(const tasks::Trajectories& trajectories, const tasks::Split& split,
                                const continuous::Buildings* buildings, const tasks::Scorer& scorer,
                                const Progress& progress) {
  if (const auto* on_graph = std::get_if<std::vector<Trajectory>>(&trajectories)) {
    return tasks::compute_score(*on_graph, *split.on_graph(), scorer);
  }
  return compute_score(std::get<std::vector<tasks::ContinuousResult>>(trajectories),
                       *split.continuous(), *buildings, *split.experts(), split.benchmark(), scorer,
                       progress);
}

std::vector<std::string> agent_names() { return {"random", "reference", "shortest"}; }

}  // namespace enfilade::agents
