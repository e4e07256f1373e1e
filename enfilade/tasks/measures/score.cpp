#include "enfilade/tasks/score.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"

namespace enfilade::tasks {
namespace {

// A trajectory takes about 2 microseconds: the cost of starting a task must not matter.
constexpr std::size_t kGrain = 256;

std::vector<MeanInterval> means_of(const std::vector<EpisodeMetrics>& metrics,
                                   const EpisodeSet& episodes, const ScoreOptions& options) {
  const auto fields = metric_fields();
  if (metrics.empty()) return std::vector<MeanInterval>(fields.size());
  std::vector<double> values;
  std::vector<std::size_t> paths;
  values.reserve(metrics.size() * fields.size());
  paths.reserve(metrics.size());
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    for (const MetricField& field : fields) values.push_back(metrics[i].*field.field);
    paths.push_back(episodes.episodes[i].path);
  }
  const BootstrapOptions bootstrap{.samples = options.bootstrap_samples,
                                   .seed = options.bootstrap_seed,
                                   .threads = options.threads};
  return bootstrap_means(values, fields.size(), paths, bootstrap);
}

using Json = nlohmann::ordered_json;

Json means_json(const Score& score) {
  Json means = Json::object();
  const auto fields = metric_fields();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const MeanInterval& mean = score.means[i];
    Json& entry = means[fields[i].name];
    entry["mean"] = mean.mean;  // what is not finite becomes null
    if (score.options.bootstrap_samples == 0) continue;
    entry["low"] = mean.low;
    entry["high"] = mean.high;
  }
  return means;
}

Json summary_json(const Score& score) {
  return {{"split", score.split},
          {"episodes", score.episodes.size()},
          {"options",
           {{"success_distance", score.options.metrics.success_distance},
            {"bootstrap_samples", score.options.bootstrap_samples},
            {"bootstrap_seed", score.options.bootstrap_seed},
            {"confidence", BootstrapOptions{}.confidence}}},
          {"means", means_json(score)}};
}

struct Line {
  const char* label;
  const char* metric;
  double scale;
  int digits;
};

std::string line_text(const Score& score, const Line& line) {
  const MeanInterval& mean = score.mean(line.metric);
  const auto show = [&line](double value) {
    return fmt::format("{:.{}f}", line.scale * value, line.digits);
  };
  std::string text = fmt::format("{:<10}{:>8}", line.label, show(mean.mean));
  if (score.options.bootstrap_samples > 0) {
    text += fmt::format("   [{}, {}]", show(mean.low), show(mean.high));
  }
  return text + "\n";
}

}  // namespace

std::vector<EpisodeMetrics> score_trajectories(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes,
                                               const MetricOptions& options, int threads) {
  if (!(options.success_distance > 0)) {
    throw ArgumentError(
        fmt::format("success distance {} m; more than 0 is expected", options.success_distance));
  }
  std::vector<EpisodeMetrics> metrics(trajectories.size());
  parallel_for(trajectories.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<ViewpointIndex> viewpoints;
    for (std::size_t i = begin; i < end; ++i) {
      const Trajectory& trajectory = trajectories[i];
      check_trajectory(trajectory, episodes);
      const Episode& episode = episodes.episodes[trajectory.episode];
      viewpoints.clear();
      for (const TrajectoryPoint& point : trajectory.points) viewpoints.push_back(point.viewpoint);
      metrics[i] = compute_metrics(episodes.graph_of(episode), viewpoints,
                                   episodes.path_of(episode).viewpoints, options);
    }
  });
  return metrics;
}

Score compute_score(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes,
                    const ScoreOptions& options) {
  Score score{episodes.split, options, {}, {}};
  const auto metrics = score_trajectories(trajectories, episodes, options.metrics, options.threads);
  for (const std::size_t i : trajectory_by_episode(trajectories, episodes)) {
    score.episodes.push_back(metrics[i]);
  }
  score.means = means_of(score.episodes, episodes, options);
  return score;
}

bool goals_hidden(const EpisodeSet& episodes) noexcept {
  return std::ranges::any_of(episodes.paths, goal_hidden);
}

const MeanInterval& Score::mean(std::string_view metric) const {
  const auto fields = metric_fields();
  const auto found =
      std::ranges::find_if(fields, [metric](const MetricField& f) { return f.name == metric; });
  if (found == fields.end()) {
    std::vector<std::string_view> names;
    for (const MetricField& field : fields) names.emplace_back(field.name);
    throw LookupError(fmt::format("no metric {:?}; there are {}", metric, fmt::join(names, ", ")));
  }
  return means[static_cast<std::size_t>(found - fields.begin())];
}

std::string to_json(const Score& score) { return summary_json(score).dump(1) + "\n"; }

std::string to_json(const Score& score, const EpisodeSet& episodes) {
  Json all = summary_json(score);
  Json& per_episode = all["per_episode"] = Json::object();
  for (std::size_t i = 0; i < score.episodes.size(); ++i) {
    Json& entry = per_episode[episodes.episodes[i].instruction_id];
    for (const MetricField& field : metric_fields()) {
      entry[field.name] = score.episodes[i].*field.field;
    }
  }
  return all.dump(1) + "\n";
}

std::string to_table(const Score& score, SplLength spl) {
  const bool reference = spl == SplLength::kReference;
  const std::array<Line, 9> lines{
      {{"TL (m)", "trajectory_length", 1, 2},
       {"NE (m)", "nav_error", 1, 2},
       {"SR (%)", "success", 100, 1},
       {"OSR (%)", "oracle_success", 100, 1},
       {reference ? "SPL* (%)" : "SPL (%)", reference ? "spl_refpath" : "spl", 100, 1},
       {"nDTW (%)", "ndtw_collapsed", 100, 1},
       {"sDTW (%)", "sdtw_collapsed", 100, 1},
       {"CLS (%)", "cls", 100, 1},
       {"steps", "steps", 1, 2}}};
  std::string text = fmt::format("{}: {} episodes\n", score.split, score.episodes.size());
  text += fmt::format("{:<10}{:>8}", "", "mean");
  text += score.options.bootstrap_samples > 0 ? "   95 % interval\n" : "\n";
  for (const Line& line : lines) text += line_text(score, line);
  text += "nDTW, sDTW: turns on the spot taken once (in JSON ndtw_collapsed; ndtw counts them)\n";
  if (reference) text += "* against the length of the reference path\n";
  return text;
}

}  // namespace enfilade::tasks
