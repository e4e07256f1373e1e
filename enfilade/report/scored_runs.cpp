#include "enfilade/report/scored_runs.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/tasks/benchmark.h"

namespace enfilade::report {
namespace {

using tasks::Task;
using tasks::Trajectory;

Scores score(const std::vector<Trajectory>& trajectories, const tasks::EpisodeSet& episodes) {
  Scores scores{compute_score(trajectories, episodes, tasks::own_scorer())};
  const tasks::Benchmark& benchmark = tasks::benchmark(episodes.task);
  if (benchmark.table_scorer.empty()) return scores;
  scores.by_task = compute_score(trajectories, episodes, benchmark.scorer(benchmark.table_scorer));
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

// Reads and scores the files of a run, each split once.
class Scoring {
 public:
  Scoring(const tasks::Benchmark& benchmark, const dataset::Dataset& data)
      : benchmark_(benchmark), data_(data) {
    scored_.benchmark = &benchmark;
    if (benchmark.continuous()) {
      scored_.buildings = std::make_shared<const continuous::Buildings>(
          data.folder() / agents::continuous_setup(benchmark).navigation_folder());
    } else {
      scored_.graphs = data.graphs();
    }
  }

  void add(const ResultsFile& file) {
    if (benchmark_.continuous() ? add_walks(file) : add_trajectories(file)) return;
    scored_.left_out.push_back(
        fmt::format("{} on {}: the goals of this split are hidden", file.agent, file.split));
  }
  ScoredRuns take() { return std::move(scored_); }

 private:
  // False if the goals are hidden.
  bool add_trajectories(const ResultsFile& file) {
    if (!scored_.splits.contains(file.split)) {
      scored_.splits.emplace(file.split, episodes_of(data_, benchmark_.task, file.split));
    }
    const tasks::EpisodeSet& episodes = scored_.splits.at(file.split);
    if (goals_hidden(episodes)) return false;
    ScoredRun& run = scored_.runs.emplace_back(ScoredRun{file.agent, file.split});
    run.trajectories = load_results(file.file, episodes).trajectories;
    run.scores = score(run.trajectories, episodes);
    if (benchmark_.languages) run.languages = score_languages(run.trajectories, episodes);
    return true;
  }

  bool add_walks(const ResultsFile& file) {
    if (!scored_.continuous_splits.contains(file.split)) {
      scored_.continuous_splits.emplace(
          file.split, agents::load_continuous_split(benchmark_, data_.folder(), file.split));
      experts_.emplace(file.split, agents::load_experts_of(benchmark_, data_.folder(), file.split));
    }
    const tasks::ContinuousEpisodes& episodes = scored_.continuous_splits.at(file.split);
    if (goals_hidden(episodes)) return false;
    ScoredRun& run = scored_.runs.emplace_back(ScoredRun{file.agent, file.split});
    run.walks = tasks::load_continuous_results(file.file, episodes);
    run.scores.ours =
        agents::compute_score(run.walks, episodes, *scored_.buildings, experts_.at(file.split),
                              benchmark_, benchmark_.scorers.front());
    return true;
  }

  const tasks::Benchmark& benchmark_;
  const dataset::Dataset& data_;
  std::map<std::string, tasks::ExpertWalks> experts_;
  ScoredRuns scored_;
};

}  // namespace

ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress) {
  Scoring scoring(*found.benchmark, data);
  std::size_t done = 0;
  for (const ResultsFile& file : found.results) {
    scoring.add(file);
    if (progress) progress(++done, found.results.size());
  }
  return scoring.take();
}

}  // namespace enfilade::report
