#include "enfilade/report/continuous_runs.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"

namespace enfilade::report {

ContinuousRuns score_continuous_runs(const RunDirectory& found, const tasks::Benchmark& benchmark,
                                     const dataset::Dataset& data, const Progress& progress) {
  ContinuousRuns scored;
  scored.benchmark = &benchmark;
  scored.buildings = std::make_shared<const continuous::Buildings>(
      data.folder() / agents::continuous_setup(benchmark).navigation_folder());
  std::map<std::string, tasks::ExpertWalks> experts;
  std::size_t done = 0;
  for (const ResultsFile& file : found.results) {
    if (!scored.splits.contains(file.split)) {
      scored.splits.emplace(file.split,
                            agents::load_continuous_split(benchmark, data.folder(), file.split));
      experts.emplace(file.split, agents::load_experts_of(benchmark, data.folder(), file.split));
    }
    const tasks::ContinuousEpisodes& episodes = scored.splits.at(file.split);
    if (goals_hidden(episodes)) {
      scored.left_out.push_back(
          fmt::format("{} on {}: the goals of this split are hidden", file.agent, file.split));
    } else {
      auto walks = tasks::load_continuous_results(file.file, episodes);
      auto scores = agents::compute_score(walks, episodes, *scored.buildings,
                                          experts.at(file.split), benchmark, benchmark.scorer({}));
      scored.runs.push_back({file.agent, file.split, std::move(walks), std::move(scores)});
    }
    if (progress) progress(++done, found.results.size());
  }
  return scored;
}

}  // namespace enfilade::report
