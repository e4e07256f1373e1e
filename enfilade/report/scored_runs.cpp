#include "enfilade/report/scored_runs.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>
#include <variant>

#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/goal_distance.h"

namespace enfilade::report {
namespace {

using tasks::EpisodeMetrics;
using tasks::Task;
using tasks::Trajectory;

constexpr double kRadius = tasks::MetricOptions{}.success_distance;

// On which leg an agent of R2R-Back is at the end: back, if the turning point that it names is one.
tasks::Leg last_leg(const graph::NavGraph& graph, const tasks::ReferencePath& path,
                    const Trajectory& trajectory) {
  if (!trajectory.turning_point) return tasks::Leg::kOut;
  return leg_after(graph, path, *trajectory.turning_point, tasks::Leg::kOut, kRadius);
}

// Puts the goal that there is in the place of the path's end.
void judge_by_goal(EpisodeMetrics& m, const graph::NavGraph& graph,
                   const tasks::ReferencePath& path, const Trajectory& trajectory) {
  const tasks::Leg leg = last_leg(graph, path, trajectory);
  const ViewpointIndex end = trajectory.points.back().viewpoint;
  m.nav_error = distance_to_goal(graph, path, end, leg);
  m.success = goal_reached(graph, path, end, leg, kRadius) ? 1 : 0;
  m.oracle_error = m.nav_error;
  m.oracle_success = m.success;
  tasks::Leg at = tasks::Leg::kOut;
  for (const tasks::TrajectoryPoint& point : trajectory.points) {
    // On the way out, R2R-Back's start is no end that was reached.
    at = leg_after(graph, path, point.viewpoint, at, kRadius);
    if (leg == tasks::Leg::kBack && at == tasks::Leg::kOut) continue;
    m.oracle_error = std::min(m.oracle_error, distance_to_goal(graph, path, point.viewpoint, leg));
    if (goal_reached(graph, path, point.viewpoint, leg, kRadius)) m.oracle_success = 1;
  }
  m.shortest = shortest_to_goal(graph, path, end);
  // Also where the end is out of reach, and `shortest` infinite.
  m.spl = m.success * (m.trajectory_length > m.shortest ? m.shortest / m.trajectory_length : 1);
}

Scores score(const std::vector<Trajectory>& trajectories, const tasks::EpisodeSet& episodes) {
  Scores scores{compute_score(trajectories, episodes), {}};
  if (episodes.task == Task::kR2r) return scores;
  const tasks::Benchmark& benchmark = tasks::benchmark(episodes.task);
  scores.by_task =
      compute_task_score(trajectories, episodes, benchmark.scorer(benchmark.table_scorer));
  for (const Trajectory& one : trajectories) {
    const tasks::Episode& episode = episodes.episodes[one.episode];
    const tasks::ReferencePath& path = episodes.path_of(episode);
    if (std::holds_alternative<tasks::NearEnd>(path.goal)) continue;
    judge_by_goal(scores.ours.episodes[one.episode], episodes.graph_of(episode), path, one);
  }
  return scores;
}

std::map<std::string, Scores> score_languages(const std::vector<Trajectory>& trajectories,
                                              const tasks::EpisodeSet& episodes) {
  std::map<std::string, std::vector<Trajectory>> by_language;
  for (const Trajectory& one : trajectories) {
    const std::string& language = episodes.episodes[one.episode].details.language;
    if (!language.empty()) by_language[language].push_back(one);
  }
  std::map<std::string, Scores> scores;
  for (auto& [language, part] : by_language) {
    const tasks::EpisodeSet there = part_of(episodes, part);
    scores.emplace(language, score(part, there));
  }
  return scores;
}

tasks::EpisodeSet episodes_of(const dataset::Dataset& data, Task task, const std::string& split) {
  return task == Task::kR2r ? data.episodes(split) : data.episodes(task, split);
}

}  // namespace

ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress) {
  ScoredRuns scored;
  scored.task = found.task;
  scored.graphs = data.graphs();
  std::size_t done = 0;
  for (const ResultsFile& file : found.results) {
    if (!scored.splits.contains(file.split)) {
      scored.splits.emplace(file.split, episodes_of(data, found.task, file.split));
    }
    const tasks::EpisodeSet& episodes = scored.splits.at(file.split);
    if (goals_hidden(episodes)) {
      scored.left_out.push_back(
          fmt::format("{} on {}: the goals of this split are hidden", file.agent, file.split));
    } else {
      std::vector<Trajectory> trajectories = load_results(file.file, episodes).trajectories;
      Scores scores = score(trajectories, episodes);
      auto languages = score_languages(trajectories, episodes);
      scored.runs.push_back({file.agent, file.split, std::move(trajectories), std::move(scores),
                             std::move(languages)});
    }
    if (progress) progress(++done, found.results.size());
  }
  return scored;
}

}  // namespace enfilade::report
