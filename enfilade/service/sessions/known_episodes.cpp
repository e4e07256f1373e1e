#include "enfilade/service/sessions/known_episodes.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/goal_distance.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/results.h"

namespace enfilade::service::sessions {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostKnownBytes = 64U << 20U;
constexpr std::size_t kMostInstructionBytes = 4000;

std::size_t bytes_of(const std::shared_ptr<const KnownEpisode>& known) {
  const TranscriptSummary& summary = known->summary;
  constexpr std::size_t kAround = 256;  // the key, and the cache's own
  return sizeof(KnownEpisode) + kAround + summary.instruction.size() + summary.reason.size() +
         (known->outcome ? known->outcome->values.size() * sizeof(double) : 0);
}

/// Changes with the file.
std::string key_of(const Run& run, const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  const auto time = fs::last_write_time(file, error).time_since_epoch().count();
  return fmt::format("{}\n{}\n{}\n{}\n{}", file.string(), error ? 0 : size, error ? 0 : time,
                     run.task.value_or(""), run.split.value_or(""));
}

/// Where a walk ended, and its score if the site has the goal.
Outcome outcome_of(const EpisodePlace& place, const ReadWalk& walk) {
  const tasks::EpisodeSet& set = walk.episodes;
  const tasks::Episode& episode = set.episodes[walk.trajectory.episode];
  const graph::NavGraph& graph = set.graph_of(episode);
  const tasks::ReferencePath& reference = set.path_of(episode);
  Outcome outcome{.end = graph.id(walk.trajectory.points.back().viewpoint)};
  if (place.split->goals_hidden || tasks::goal_hidden(reference)) return outcome;
  const tasks::Scorer& scorer = scorer_of(*place.split);
  outcome.values.resize(scorer.metrics.size());
  scorer.on_graph({graph, reference, walk.trajectory}, outcome.values);
  const double radius = tasks::MetricOptions().success_distance;
  outcome.goal_distance = tasks::judge(graph, reference, walk.trajectory, radius).error;
  return outcome;
}

/// The measure with a column of that title ("SR"); null if there is none.
const tasks::Measure* find_column(const tasks::Scorer& scorer, std::string_view column) {
  const auto found = std::ranges::find(scorer.columns, column, &tasks::Measure::column);
  return found == scorer.columns.end() ? nullptr : &*found;
}

}  // namespace

const tasks::Scorer& scorer_of(const PublicSplit& split) {
  return tasks::benchmark(split.annotations.task).scorers.front();
}

std::optional<double> value_of(const KnownEpisode& known, const tasks::Scorer& scorer,
                               const tasks::Measure& measure) {
  if (!known.outcome || known.outcome->values.empty()) return std::nullopt;
  const std::size_t place = scorer.place_of(measure.name);
  const double value = known.outcome->values[place] * scorer.metrics[place].scale / measure.whole;
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

ShortScore score_of(const Run& run, const KnownEpisode& known) {
  ShortScore score;
  if (!run.has_outcomes() || !known.outcome || known.outcome->values.empty()) return score;
  const tasks::Scorer& scorer = scorer_of(*run.served);
  const auto column = [&](const char* name) -> std::optional<double> {
    const tasks::Measure* measure = find_column(scorer, name);
    return measure == nullptr ? std::nullopt : value_of(known, scorer, *measure);
  };
  constexpr double kHalf = 0.5;
  if (const auto success = column("SR")) score.success = *success > kHalf;
  score.spl = column("SPL");
  score.nav_error = column("NE");
  const double distance = known.outcome->goal_distance;
  if (!score.nav_error && std::isfinite(distance)) score.nav_error = distance;
  return score;
}

std::optional<ReadWalk> read_walk(const std::shared_ptr<const Site>& site,
                                  const EpisodePlace& place, const std::string& result) {
  const tasks::Annotations& all = place.split->annotations;
  try {
    const tasks::ObjectBoxes* objects =
        all.task == tasks::Task::kReverie ? site->objects() : nullptr;
    // Its results need no other path of the split.
    tasks::EpisodeSet set =
        tasks::make_episodes({all.split, all.file, {*place.path}, all.task}, site->shared_graphs(),
                             tasks::Instructions::kAll, objects);
    std::vector<tasks::Trajectory> walked =
        tasks::parse_results("[" + result + "]", "result", set, tasks::Coverage::kPart)
            .trajectories;
    if (walked.size() != 1 || walked.front().episode != place.number) return std::nullopt;
    return ReadWalk{std::move(set), std::move(walked.front())};
  } catch (const Error&) {  // what it says may name files of this machine
    return std::nullopt;
  }
}

KnownEpisodes::KnownEpisodes(std::shared_ptr<const Site> site)
    : site_(std::move(site)), known_(kMostKnownBytes, bytes_of) {}

std::shared_ptr<const KnownEpisode> KnownEpisodes::of(const Run& run, const NamedPath& transcript) {
  return known_.get(key_of(run, transcript.path), [&] { return read(run, transcript); });
}

std::shared_ptr<const KnownEpisode> KnownEpisodes::read(const Run& run,
                                                        const NamedPath& transcript) const {
  auto known = std::make_shared<KnownEpisode>();
  TranscriptSummary& summary = known->summary;
  summary = summarise_transcript(transcript.path);
  const std::string result = std::exchange(summary.result, {});
  const EpisodePlace* place = run.find(transcript.name);
  if (place != nullptr && !result.empty() && place->text() == summary.instruction) {
    if (const auto walk = read_walk(site_, *place, result)) {
      known->outcome = outcome_of(*place, *walk);
    }
  }
  if (!run.shows_text(transcript.name, summary.instruction)) summary.instruction.clear();
  summary.instruction = beginning(std::move(summary.instruction), kMostInstructionBytes);
  return known;
}

}  // namespace enfilade::service::sessions
