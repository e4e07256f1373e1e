/// \file  Running agents over continuous episodes, recording experts, and scoring walks.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/core/progress.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/continuous_score.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::agents {

/// How agents are run. Batch size and threads do not change walks.
struct ContinuousRunOptions {
  std::size_t batch_size = 64;
  std::uint64_t seed = 1;  ///< an episode's stream is named by its id
  /// Batch size in it is replaced by that above.
  continuous::SimulatorConfig simulator = continuous::SimulatorConfig::room_to_room();
};

/// Checks all starts.
/// \throws LookupError for a scan without a navigation mesh
/// \throws InvalidInput naming each episode whose start is off the floor (`start-off-floor`)
/// \throws errors of files
void check_starts(const tasks::ContinuousEpisodes& episodes, const continuous::Buildings& buildings,
                  const continuous::Reach& reach);
/// Checks the goals of some episodes.
/// \param which  their indices
/// \throws LookupError for a scan without a navigation mesh
/// \throws InvalidInput naming each episode without a goal within 1 m of the floor
/// (`goal-off-floor`)
/// \throws errors of files
void check_goals(const tasks::ContinuousEpisodes& episodes, const continuous::Buildings& buildings,
                 std::span<const std::size_t> which);
/// Where an episode puts a body. \param building  that of the episode's scan
continuous::EpisodeStart start_of(const tasks::ContinuousEpisode& episode, std::size_t building);

/// One walk an episode, in order. Slots take the next episode when theirs has ended.
/// \throws ArgumentError if the agent needs goals that the file hides; for a batch size of 0
/// \throws LookupError for a scan without a navigation mesh
/// \throws InvalidInput naming each episode whose start is off the floor (`start-off-floor`)
/// \throws errors of files
std::vector<tasks::ContinuousResult> run_continuous(
    ContinuousAgent& agent, const tasks::ContinuousEpisodes& episodes,
    std::shared_ptr<const continuous::Buildings> buildings,
    const ContinuousRunOptions& options = {}, const Progress& progress = {});

/// The reference agent's walks as VLN-CE's `_gt` files have them. \throws as run_continuous()
tasks::ExpertWalks record_experts(const tasks::ContinuousEpisodes& episodes,
                                  std::shared_ptr<const continuous::Buildings> buildings,
                                  const ContinuousRunOptions& options = {},
                                  const Progress& progress = {});

/// How far it is to the nearest goal of an episode. \param floor  of the episode's building
/// \pre the goals are not hidden \throws ArgumentError if no floor is within 1 m of any goal
continuous::DistanceField goal_field(const tasks::ContinuousEpisode& episode,
                                     const continuous::Floor& floor);
/// Geodesic distances of all poses of a walk to the nearest goal. \pre the goals are not hidden
std::vector<double> goal_distances(const tasks::ContinuousResult& walk,
                                   const tasks::ContinuousEpisode& episode,
                                   const continuous::Buildings& buildings);

/// Scores walks by one of the benchmark's scorers, in their order. \param experts  as below
/// \throws as score_continuous_walks()
tasks::ScoreTable compute_score(std::span<const tasks::ContinuousResult> walks,
                                const tasks::ContinuousEpisodes& episodes,
                                const continuous::Buildings& buildings,
                                const tasks::ExpertWalks& experts,
                                const tasks::Benchmark& benchmark, const tasks::Scorer& scorer,
                                const Progress& progress = {});

/// VLN-CE's measures of each walk, in order. \param experts  their locations are what nDTW compares
/// with; the reference path, for an episode that has none
/// \throws ArgumentError for hidden goals; as run_continuous() and check_goals()
std::vector<tasks::ContinuousScore> score_continuous_walks(
    std::span<const tasks::ContinuousResult> walks, const tasks::ContinuousEpisodes& episodes,
    const continuous::Buildings& buildings, const tasks::ExpertWalks& experts = {},
    const Progress& progress = {});

/// The same of one walk through an episode. \pre its goals are not hidden
tasks::ContinuousScore score_continuous_walk(const tasks::ContinuousResult& walk,
                                             const tasks::ContinuousEpisode& episode,
                                             const continuous::Buildings& buildings,
                                             const tasks::ExpertWalks& experts = {});

}  // namespace enfilade::agents
