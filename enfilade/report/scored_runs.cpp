#include "enfilade/report/scored_runs.h"

#include <fmt/format.h>
#include <utility>

namespace enfilade::report {
ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress) {
  ScoredRuns scored;
  scored.graphs = data.graphs();
  std::size_t done = 0;
  for (const ResultsFile& file : found.results) {
    if (!scored.splits.contains(file.split)) {
      scored.splits.emplace(file.split, data.episodes(file.split));
    }
    const tasks::EpisodeSet& episodes = scored.splits.at(file.split);
    if (goals_hidden(episodes)) {
      scored.left_out.push_back(
          fmt::format("{} on {}: the goals of this split are hidden", file.agent, file.split));
    } else {
      tasks::Results results = tasks::load_results(file.file, episodes);
      tasks::Score score = compute_score(results.trajectories, episodes);
      scored.runs.push_back(
          {file.agent, file.split, std::move(results.trajectories), std::move(score)});
    }
    if (progress) progress(++done, found.results.size());
  }
  return scored;
}

}  // namespace enfilade::report
