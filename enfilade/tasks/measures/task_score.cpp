#include "enfilade/tasks/task_score.h"

#include <fmt/format.h>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/tasks/files.h"

namespace enfilade::tasks {
namespace {

constexpr std::size_t kTrajectoriesAtOnce = 256;  // some microseconds each

// The intervals of some metrics, over the episodes of which `row_counts` holds. All share the
// draws.
void add_intervals(TaskScore& score, const EpisodeSet& episodes,
                   std::span<const std::size_t> metrics,
                   const std::function<bool(std::span<const double>)>& row_counts) {
  std::vector<double> values;
  std::vector<std::size_t> groups;
  for (std::size_t i = 0; i < score.episodes(); ++i) {
    const auto row = score.row(i);
    if (!row_counts(row)) continue;
    for (const std::size_t k : metrics) values.push_back(score.scorer->metrics[k].scale * row[k]);
    groups.push_back(episodes.path_of(episodes.episodes[i]).group);
  }
  if (groups.empty() || metrics.empty()) return;
  const BootstrapOptions options{.samples = score.options.bootstrap_samples,
                                 .seed = score.options.bootstrap_seed,
                                 .threads = score.options.threads};
  const auto intervals = bootstrap_means(values, metrics.size(), groups, options);
  for (std::size_t column = 0; column < metrics.size(); ++column) {
    MeanInterval& mean = score.means[metrics[column]];
    mean.low = intervals[column].low;
    mean.high = intervals[column].high;
  }
}

// Intervals of finite means: a metric that counts some episodes only has draws of its own.
void add_intervals(TaskScore& score, const EpisodeSet& episodes) {
  std::vector<std::size_t> of_all;
  for (std::size_t k = 0; k < score.means.size(); ++k) {
    const MeanRule rule = score.scorer->metrics[k].rule;
    if (rule == MeanRule::kNone || !std::isfinite(score.means[k].mean)) continue;
    if (rule == MeanRule::kWhereDefined) {
      add_intervals(score, episodes, std::array{k},
                    [k](std::span<const double> row) { return !std::isnan(row[k]); });
    } else {
      of_all.push_back(k);
    }
  }
  add_intervals(score, episodes, of_all, [](std::span<const double> /*row*/) { return true; });
}

using Json = nlohmann::ordered_json;

Json means_json(const TaskScore& score) {
  Json means = Json::object();
  for (std::size_t k = 0; k < score.means.size(); ++k) {
    const ScorerMetric& metric = score.scorer->metrics[k];
    if (metric.rule == MeanRule::kNone) continue;
    Json& entry = means[metric.mean_name()];
    entry["mean"] = score.means[k].mean;
    if (score.options.bootstrap_samples == 0) continue;
    entry["low"] = score.means[k].low;
    entry["high"] = score.means[k].high;
  }
  return means;
}

// Means by language, as columns; empty if the episodes name none.
std::string languages_table(const TaskScore& score, const EpisodeSet& episodes) {
  std::map<std::string, std::vector<double>> values;
  for (std::size_t i = 0; i < score.episodes(); ++i) {
    const std::string& language = episodes.episodes[i].details.language;
    if (language.empty()) continue;
    const auto row = score.row(i);
    auto& of = values[language];
    of.insert(of.end(), row.begin(), row.end());
  }
  if (values.empty()) return {};
  std::string text = fmt::format("\n{:<26}", "by language");
  for (const auto& [language, of] : values) text += fmt::format("{:>10}", language);
  text += fmt::format("\n{:<26}", "episodes");
  for (const auto& [language, of] : values) {
    text += fmt::format("{:>10}", of.size() / score.scorer->metrics.size());
  }
  text += '\n';
  for (std::size_t k = 0; k < score.means.size(); ++k) {
    const ScorerMetric& metric = score.scorer->metrics[k];
    if (metric.rule == MeanRule::kNone) continue;
    text += fmt::format("{:<26}", metric.mean_name());
    for (const auto& [language, of] : values) {
      text += fmt::format("{:>10.4f}", summarise(*score.scorer, of)[k]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace

TaskScore compute_task_score(const std::vector<Trajectory>& trajectories,
                             const EpisodeSet& episodes, const PublicScorer& scorer,
                             const TaskScoreOptions& options) {
  if (scorer.task != episodes.task) {
    throw ArgumentError(fmt::format("scorer {:?} is of {}, the episodes are of {}", scorer.name,
                                    title_of(scorer.task), title_of(episodes.task)));
  }
  for (const Trajectory& trajectory : trajectories) check_trajectory(trajectory, episodes);
  trajectory_by_episode(trajectories, episodes);  // each has one
  const std::size_t width = scorer.metrics.size();
  TaskScore score{episodes.split, &scorer, options, {}, {}};
  score.values.resize(trajectories.size() * width);
  parallel_for(trajectories.size(), kTrajectoriesAtOnce, options.threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = begin; i < end; ++i) {
                   const Trajectory& trajectory = trajectories[i];
                   const Episode& episode = episodes.episodes[trajectory.episode];
                   scorer.score(episodes.graph_of(episode), episodes.path_of(episode), trajectory,
                                std::span(score.values).subspan(trajectory.episode * width, width));
                 }
               });
  for (const double mean : summarise(scorer, score.values)) {
    score.means.push_back({mean, mean, mean});
  }
  add_intervals(score, episodes);
  return score;
}

std::string to_table(const TaskScore& score, const EpisodeSet& episodes) {
  std::string text =
      fmt::format("{} {}: {} episodes, scored as {} ({})\n", title_of(episodes.task), score.split,
                  score.episodes(), score.scorer->name, score.scorer->source);
  const bool intervals = score.options.bootstrap_samples > 0;
  text += fmt::format("{:<26}{:>10}{}\n", "", "mean", intervals ? "   95 % interval" : "");
  for (std::size_t k = 0; k < score.means.size(); ++k) {
    const ScorerMetric& metric = score.scorer->metrics[k];
    if (metric.rule == MeanRule::kNone) continue;
    const MeanInterval& mean = score.means[k];
    text += fmt::format("{:<26}{:>10.4f}", metric.mean_name(), mean.mean);
    if (intervals) text += fmt::format("   [{:.4f}, {:.4f}]", mean.low, mean.high);
    text += '\n';
  }
  return text + languages_table(score, episodes);
}

std::string to_json(const TaskScore& score, const EpisodeSet& episodes, bool per_episode) {
  Json all{{"task", name_of(episodes.task)}, {"split", score.split},
           {"scorer", score.scorer->name},   {"source", score.scorer->source},
           {"episodes", score.episodes()},   {"means", means_json(score)}};
  if (per_episode) {
    Json& entries = all["per_episode"] = Json::object();
    for (std::size_t i = 0; i < score.episodes(); ++i) {
      Json& entry = entries[episodes.episodes[i].instruction_id];
      const auto row = score.row(i);
      for (std::size_t k = 0; k < row.size(); ++k) entry[score.scorer->metrics[k].name] = row[k];
    }
  }
  return all.dump(1) + "\n";
}

}  // namespace enfilade::tasks
