#include "enfilade/report/scored_runs.h"

#include <fmt/format.h>
#include <utility>

namespace enfilade::report {
namespace {

const r2r::EpisodeSet& episodes_of(const std::string& split, const dataset::Dataset& data,
                                   ScoredRuns& scored) {
  const auto known = scored.splits.find(split);
  if (known != scored.splits.end()) return known->second;
  return scored.splits.emplace(split, data.episodes(split)).first->second;
}

}  // namespace

ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress) {
  ScoredRuns scored;
  scored.graphs = data.graphs();
  std::size_t done = 0;
  for (const ResultsFile& file : found.results) {
    const r2r::EpisodeSet& episodes = episodes_of(file.split, data, scored);
    if (goals_hidden(episodes)) {
      scored.left_out.push_back(
          fmt::format("{} on {}: the goals of this split are hidden", file.agent, file.split));
    } else {
      r2r::Results results = r2r::load_results(file.file, episodes);
      r2r::Score score = compute_score(results.trajectories, episodes);
      scored.runs.push_back(
          {file.agent, file.split, std::move(results.trajectories), std::move(score)});
    }
    if (progress) progress(++done, found.results.size());
  }
  return scored;
}

}  // namespace enfilade::report
