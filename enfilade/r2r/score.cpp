#include "enfilade/r2r/score.h"

#include <fmt/format.h>
#include <algorithm>
#include <numeric>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"

namespace enfilade::r2r {
namespace {

// A trajectory takes about 2 microseconds; handing over a range of them should not show.
constexpr std::size_t kGrain = 256;

void validate(const Trajectory& trajectory, const EpisodeSet& episodes) {
  if (trajectory.episode >= episodes.episodes.size()) {
    throw ArgumentError(fmt::format("a trajectory of episode {}; split {} has {}",
                                    trajectory.episode, episodes.split, episodes.episodes.size()));
  }
  const Episode& episode = episodes.episodes[trajectory.episode];
  if (trajectory.points.empty()) {
    throw ArgumentError(fmt::format("the trajectory of {} is empty", episode.instruction_id));
  }
  if (episodes.path_of(episode).viewpoints.size() < 2) {
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

// Trajectory of each episode: exactly one is expected.
std::vector<std::size_t> trajectory_by_episode(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes) {
  if (trajectories.size() != episodes.episodes.size()) {
    throw ArgumentError(fmt::format("{} trajectories for the {} episodes of split {}",
                                    trajectories.size(), episodes.episodes.size(), episodes.split));
  }
  constexpr auto kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> places(trajectories.size(), kNone);
  for (std::size_t i = 0; i < trajectories.size(); ++i) {
    std::size_t& place = places[trajectories[i].episode];
    if (place != kNone) {
      throw ArgumentError(fmt::format("two trajectories of {}",
                                      episodes.episodes[trajectories[i].episode].instruction_id));
    }
    place = i;
  }
  return places;
}

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
  BootstrapOptions bootstrap;
  bootstrap.samples = options.bootstrap_samples;
  bootstrap.seed = options.bootstrap_seed;
  bootstrap.threads = options.threads;
  return bootstrap_means(values, fields.size(), paths, bootstrap);
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
      validate(trajectory, episodes);
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
  return std::ranges::any_of(episodes.paths,
                             [](const ReferencePath& path) { return path.viewpoints.size() < 2; });
}

}  // namespace enfilade::r2r
