/// \file  Running an agent over the episodes of a split of either world, and scoring it.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/agents/continuous_agent.h"
#include "enfilade/core/progress.h"
#include "enfilade/sim/simulator.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/split.h"

namespace enfilade::agents {

/// How agents are run. The batch size does not change trajectories.
struct RunOptions {
  std::size_t batch_size = 100;
  /// Actions after which an episode is ended. Far more than the agents here need: the longest
  /// teacher path of R2R takes 35; DUET's goes back and forth, and turns at each viewpoint.
  std::size_t max_actions = 1000;
  std::uint64_t seed = 1;  ///< an episode's stream is named by its instruction id
  /// Batch size and seed in it are replaced by those above.
  sim::SimulatorConfig simulator = sim::SimulatorConfig::room_to_room();
};

/// One trajectory per episode, in order: the start pose (heading snapped by the simulator,
/// elevation 0), then one entry per action. The same at any batch size.
/// \throws ActionError for an invalid action of the agent
/// \throws ArgumentError for a batch size of 0, or if it needs hidden goals, or REVERIE's objects
/// and the episodes were made without boxes; errors of graph files
std::vector<tasks::Trajectory> run_agent(Agent& agent, const tasks::EpisodeSet& episodes,
                                         const RunOptions& options = {},
                                         const Progress& progress = {});

/// An agent of the split's world.
using AnyAgent = std::variant<std::unique_ptr<Agent>, std::unique_ptr<ContinuousAgent>>;
/// By its name, of a benchmark's world. \throws LookupError listing the names
AnyAgent make_agent(const tasks::Benchmark& benchmark, std::string_view name);
/// run_agent(), or run_continuous() with the benchmark's simulator. \param buildings  continuous:
/// open_buildings(); null on graphs \pre the agent is of the split's world
/// \throws as those
tasks::Trajectories run(const AnyAgent& agent, const tasks::Split& split,
                        const std::shared_ptr<const continuous::Buildings>& buildings,
                        const RunOptions& options = {}, const Progress& progress = {});
/// Scores results by one of the benchmark's scorers. \param buildings  as above
/// \throws as tasks::compute_score(), score_continuous_walks()
tasks::ScoreTable compute_score(const tasks::Trajectories& trajectories, const tasks::Split& split,
                                const continuous::Buildings* buildings, const tasks::Scorer& scorer,
                                const Progress& progress = {});

/// An agent on graphs by its name: "random", "reference" or "shortest". \throws LookupError listing
/// the names
std::unique_ptr<Agent> make_agent(std::string_view name);
std::vector<std::string> agent_names();

}  // namespace enfilade::agents
