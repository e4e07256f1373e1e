#include "enfilade/tasks/task_score.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/tasks/files.h"

namespace enfilade::tasks {
namespace {

constexpr std::size_t kTrajectoriesAtOnce = 256;  // some microseconds each

void check_trajectory(const Trajectory& trajectory, const EpisodeSet& episodes) {
  const Episode& episode = episodes.episodes[trajectory.episode];
  if (trajectory.points.empty()) {
    throw ArgumentError(fmt::format("the trajectory of {} is empty", episode.instruction_id));
  }
  if (std::holds_alternative<HiddenGoal>(episodes.path_of(episode).goal)) {
    throw ArgumentError(fmt::format("the goal of {} in split {} is hidden; it cannot be scored",
                                    episode.instruction_id, episodes.split));
  }
  const std::size_t size = episodes.graph_of(episode).size();
  for (const TrajectoryPoint& point : trajectory.points) {
    if (point.viewpoint.at() < size) continue;
    throw ArgumentError(fmt::format("the trajectory of {} goes to viewpoint {} of {}",
                                    episode.instruction_id, point.viewpoint.value, size));
  }
}

// \throws ArgumentError unless each episode has one trajectory
void check_all(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes) {
  const std::size_t n = episodes.episodes.size();
  if (trajectories.size() != n) {
    throw ArgumentError(fmt::format("{} trajectories for the {} episodes of split {}",
                                    trajectories.size(), n, episodes.split));
  }
  std::vector<bool> seen(n);
  for (const Trajectory& trajectory : trajectories) {
    if (trajectory.episode >= n) {
      throw ArgumentError(fmt::format("a trajectory of episode {}; split {} has {}",
                                      trajectory.episode, episodes.split, n));
    }
    if (seen[trajectory.episode]) {
      throw ArgumentError(fmt::format("two trajectories of {}",
                                      episodes.episodes[trajectory.episode].instruction_id));
    }
    seen[trajectory.episode] = true;
    check_trajectory(trajectory, episodes);
  }
}

// The interval of one metric's mean, over the episodes that its rule counts.
MeanInterval interval(const TaskScore& score, const EpisodeSet& episodes, std::size_t metric,
                      double mean) {
  const ScorerMetric& of = score.scorer->metrics[metric];
  std::vector<double> values;
  std::vector<std::size_t> groups;
  for (std::size_t i = 0; i < score.episodes(); ++i) {
    const double value = score.row(i)[metric];
    if (of.rule == MeanRule::kWhereDefined && std::isnan(value)) continue;
    values.push_back(of.scale * value);
    groups.push_back(episodes.path_of(episodes.episodes[i]).group);
  }
  if (values.empty() || of.rule == MeanRule::kNone || !std::isfinite(mean)) {
    return {mean, mean, mean};
  }
  const BootstrapOptions options{.samples = score.options.bootstrap_samples,
                                 .seed = score.options.bootstrap_seed,
                                 .threads = score.options.threads};
  MeanInterval found = bootstrap_means(values, 1, groups, options).front();
  found.mean = mean;
  return found;
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
  check_all(trajectories, episodes);
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
  const std::vector<double> means = summarise(scorer, score.values);
  for (std::size_t k = 0; k < width; ++k) {
    score.means.push_back(interval(score, episodes, k, means[k]));
  }
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
