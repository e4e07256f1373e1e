#include "enfilade/tasks/score_table.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/threads.h"

namespace enfilade::tasks {
namespace {

constexpr std::size_t kTrajectoriesAtOnce = 256;  // some microseconds each

void check_success_distance(const MetricOptions& options) {
  if (options.success_distance > 0) return;
  throw ArgumentError(
      fmt::format("success distance {} m; more than 0 is expected", options.success_distance));
}

// The intervals of some metrics, over the episodes of which `row_counts` holds. All share the
// draws.
void add_intervals(ScoreTable& table, std::span<const std::size_t> groups,
                   std::span<const std::size_t> metrics,
                   const std::function<bool(std::span<const double>)>& row_counts) {
  std::vector<double> values;
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < table.episodes; ++i) {
    const auto row = table.row(i);
    if (!row_counts(row)) continue;
    for (const std::size_t k : metrics) values.push_back(table.scorer->metrics[k].scale * row[k]);
    drawn.push_back(groups[i]);
  }
  if (drawn.empty() || metrics.empty()) return;
  const BootstrapOptions options{.samples = table.options.bootstrap_samples,
                                 .seed = table.options.bootstrap_seed,
                                 .threads = table.options.threads};
  const auto intervals = bootstrap_means(values, metrics.size(), drawn, options);
  for (std::size_t column = 0; column < metrics.size(); ++column) {
    MeanInterval& mean = table.means[metrics[column]];
    mean.low = intervals[column].low;
    mean.high = intervals[column].high;
  }
}

// A metric that counts some episodes only has draws of its own. Public scorers' infinite means have
// no interval.
void add_means(ScoreTable& table, std::span<const std::size_t> groups) {
  for (const double mean : summarise(*table.scorer, table.values)) {
    table.means.push_back({mean, mean, mean});
  }
  table.groups = std::set(groups.begin(), groups.end()).size();
  const bool finite = table.scorer->on_graph != nullptr && table.scorer != &own_scorer();
  std::vector<std::size_t> of_all;
  for (std::size_t k = 0; k < table.means.size(); ++k) {
    const MeanRule rule = table.scorer->metrics[k].rule;
    const double mean = table.means[k].mean;
    if (rule == MeanRule::kNone || std::isnan(mean) || (finite && std::isinf(mean))) continue;
    if (rule == MeanRule::kWhereDefined) {
      add_intervals(table, groups, std::array{k},
                    [k](std::span<const double> row) { return !std::isnan(row[k]); });
    } else {
      of_all.push_back(k);
    }
  }
  add_intervals(table, groups, of_all, [](std::span<const double> /*row*/) { return true; });
}

}  // namespace

EpisodeMetrics metrics_of(const ScoreTable& table, std::size_t episode) {
  EN_CHECK(table.scorer == &own_scorer());
  EpisodeMetrics metrics;
  const auto row = table.row(episode);
  std::size_t k = 0;
  for (const MetricField& field : kMetricFields) metrics.*field.field = row[k++];
  return metrics;
}

std::vector<EpisodeMetrics> score_trajectories(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes,
                                               const MetricOptions& options, int threads) {
  check_success_distance(options);
  std::vector<EpisodeMetrics> metrics(trajectories.size());
  const auto score = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      check_trajectory(trajectories[i], episodes);
      const Episode& episode = episodes.episodes[trajectories[i].episode];
      metrics[i] = compute_metrics(episodes.graph_of(episode), episodes.path_of(episode),
                                   trajectories[i], options);
    }
  };
  parallel_for(trajectories.size(), kTrajectoriesAtOnce, threads, score);
  return metrics;
}

ScoreTable compute_score(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes,
                         const Scorer& scorer, const ScoreOptions& options) {
  if (scorer.on_graph == nullptr || scorer.task.value_or(episodes.task) != episodes.task) {
    throw ArgumentError(fmt::format(
        "scorer {} is of {}, the episodes are of {}", quote(scorer.name),
        scorer.task ? benchmark(*scorer.task).title : std::string_view("continuous space"),
        benchmark(episodes.task).title));
  }
  check_success_distance(options.metrics);
  for (const Trajectory& trajectory : trajectories) check_trajectory(trajectory, episodes);
  trajectory_by_episode(trajectories, episodes);  // each has one
  const std::size_t width = scorer.metrics.size();
  ScoreTable table{.benchmark = &benchmark(episodes.task),
                   .scorer = &scorer,
                   .split = episodes.split,
                   .options = options,
                   .episodes = trajectories.size(),
                   .values = std::vector<double>(trajectories.size() * width),
                   .ids = {},
                   .means = {}};
  const auto score = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Trajectory& trajectory = trajectories[i];
      const Episode& episode = episodes.episodes[trajectory.episode];
      scorer.on_graph(
          {episodes.graph_of(episode), episodes.path_of(episode), trajectory, options.metrics},
          std::span(table.values).subspan(trajectory.episode * width, width));
    }
  };
  parallel_for(trajectories.size(), kTrajectoriesAtOnce, options.threads, score);
  std::vector<std::size_t> groups;
  for (const Episode& episode : episodes.episodes) {
    table.ids.push_back(episode.instruction_id);
    groups.push_back(episodes.path_of(episode).group);
    if (table.benchmark->languages) table.languages.push_back(episode.details.language);
  }
  add_means(table, groups);
  return table;
}

ScoreTable compute_score(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes,
                         const ScoreOptions& options) {
  return compute_score(trajectories, episodes, benchmark(episodes.task).scorers.front(), options);
}

ScoreTable make_score_table(const Benchmark& benchmark, const Scorer& scorer,
                            std::span<const ContinuousResult> walks,
                            const ContinuousEpisodes& episodes, std::vector<double> values,
                            const ScoreOptions& options) {
  if (walks.empty() || values.size() != walks.size() * scorer.metrics.size()) {
    throw ArgumentError(fmt::format("{} values of {} walks; {} per walk, and one walk at least",
                                    values.size(), walks.size(), scorer.metrics.size()));
  }
  ScoreTable table{.benchmark = &benchmark,
                   .scorer = &scorer,
                   .split = episodes.split,
                   .options = options,
                   .episodes = walks.size(),
                   .values = std::move(values),
                   .ids = {},
                   .means = {}};
  std::vector<std::size_t> groups;
  std::map<std::string, std::size_t> trajectories;
  for (const ContinuousResult& walk : walks) {
    const ContinuousEpisode& episode = episodes.episodes.at(walk.episode);
    table.ids.push_back(text_of(episode.id));
    const std::string id = text_of(episode.trajectory_id);
    groups.push_back(trajectories.try_emplace(id, trajectories.size()).first->second);
  }
  add_means(table, groups);
  return table;
}

bool goals_hidden(const EpisodeSet& episodes) noexcept {
  return std::ranges::any_of(episodes.paths, goal_hidden);
}

}  // namespace enfilade::tasks
