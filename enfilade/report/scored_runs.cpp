#include "enfilade/report/scored_runs.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/tasks/benchmark.h"

namespace enfilade::report {
namespace {

using tasks::Task;
using tasks::Trajectory;

Scores score(const std::vector<Trajectory>& trajectories, const tasks::EpisodeSet& episodes) {
  const tasks::Benchmark& benchmark = tasks::benchmark(episodes.task);
  return {compute_score(trajectories, episodes, tasks::own_scorer()),
          compute_score(trajectories, episodes, benchmark.scorer(benchmark.table_scorer))};
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
