#include "enfilade/report/parts/result_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/report/parts/dataset_parts.h"

namespace enfilade::report::parts {
namespace {

using tasks::GoalKind;

constexpr double kMetresABin = 2;     // of path lengths
constexpr std::size_t kPoints = 400;  // of a curve, at most: charts have few more pixels
// Bins with fewer paths are left out.
constexpr std::size_t kFewestPaths = 5;

// All agents but "shortest", in their order: [{"agent", "splits": {split: one(runs)}}].
template <class Run, class One>
Json by_agent(const std::vector<Run>& all_runs, const One& one) {
  std::vector<std::string> agents;
  std::map<std::string, std::map<std::string, std::vector<const Run*>>> groups;
  for (const Run& run : all_runs) {
    const std::string agent(without_seed(run.agent));
    if (is_oracle(agent)) continue;
    if (!groups.contains(agent)) agents.push_back(agent);
    groups[agent][run.split].push_back(&run);
  }
  if (agents.empty()) {
    return missing("No agent but Shortest and Reference has results that can be scored.");
  }
  Json all = Json::array();
  for (const std::string& agent : agents) {
    Json splits = Json::object();
    for (const auto& [split, runs] : groups[agent]) splits[split] = one(runs);
    all.push_back({{"agent", agent}, {"splits", std::move(splits)}});
  }
  return {{"agents", std::move(all)}};
}

struct LengthBin {
  std::size_t episodes = 0;
  double successes = 0;
  std::set<std::size_t> paths;
};

Json success_by_length(const std::vector<const ScoredRun*>& runs, const ScoredRuns& scored) {
  std::map<std::size_t, LengthBin> bins;
  for (const ScoredRun* run : runs) {
    const tasks::EpisodeSet& episodes = scored.splits.at(run->split);
    for (std::size_t i = 0; i < run->scores.ours.episodes; ++i) {
      const tasks::EpisodeMetrics m = metrics_of(run->scores.ours, i);
      if (!std::isfinite(m.shortest)) continue;
      LengthBin& bin = bins[static_cast<std::size_t>(m.shortest / kMetresABin)];
      ++bin.episodes;
      bin.successes += m.success;
      bin.paths.insert(episodes.episodes[i].path);
    }
  }
  Json all = Json::array();
  for (const auto& [k, bin] : bins) {
    if (bin.paths.size() < kFewestPaths) continue;
    const double share = bin.successes / static_cast<double>(bin.episodes);
    const auto interval = wilson_interval(share, static_cast<double>(bin.paths.size()));
    all.push_back({{"from", kMetresABin * static_cast<double>(k)},
                   {"to", kMetresABin * static_cast<double>(k + 1)},
                   {"paths", bin.paths.size()},
                   {"success", share},
                   {"low", interval.low},
                   {"high", interval.high}});
  }
  return all;
}

Json run_json(const std::string& name, const models::TrainingHistory& log) {
  Json training = Json::array();
  for (const CurvePoint& point : training_curve(log.training, kPoints)) {
    training.push_back({{"iteration", point.iteration}, {"loss", point.loss}});
  }
  Json splits = Json::object();
  for (const models::EvaluationRecord& record : log.evaluations) {
    splits[record.split].push_back({{"iteration", static_cast<double>(record.iteration)},
                                    {"loss", record.loss},  // null if it is not finite
                                    {"error", record.nav_error},
                                    {"success", record.success_rate}});
  }
  return {{"run", name}, {"train", std::move(training)}, {"evaluations", std::move(splits)}};
}

// Whether success is to stop near a place, however many steps are left.
bool ends_near(GoalKind goal) {
  return goal == GoalKind::kNearEnd || goal == GoalKind::kTurningPoint || goal == GoalKind::kPoint;
}

const char* rule_of(GoalKind goal) {
  switch (goal) {
    case GoalKind::kObject:
      return "The goal is the nearest viewpoint that sees the object; an episode succeeds where it "
             "is seen.";
    case GoalKind::kRegion:
      return "The goal is the nearest viewpoint of the region; an episode succeeds in it.";
    case GoalKind::kBoxes:
      return "The goal is the nearest viewpoint with a box of the object; an episode succeeds "
             "there, or less than 3 m from the end of the path.";
    case GoalKind::kTurningPoint:
      return "Where the agent named no viewpoint within 3 m of the turning point, the distance "
             "goes "
             "through that point. An episode succeeds if the named viewpoint and the end are at "
             "most 3 m off.";
    case GoalKind::kPoint:
      return "An episode succeeds if the agent says stop and it is less than 3 m.";
    case GoalKind::kNearEnd:
      break;
  }
  return "An episode succeeds if it is less than 3 m.";
}

}  // namespace

ShareInterval wilson_interval(double share, double n) noexcept {
  constexpr double kZ = 1.959964;  // quantile 0.975 of the normal distribution
  const double centre = (share + kZ * kZ / (2 * n)) / (1 + kZ * kZ / n);
  const double half =
      kZ / (1 + kZ * kZ / n) * std::sqrt(share * (1 - share) / n + kZ * kZ / (4 * n * n));
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

std::vector<CurvePoint> training_curve(std::span<const models::TrainRecord> records,
                                       std::size_t most) {
  if (most == 0) throw ArgumentError("most: 0, not at least 1");
  const std::size_t each = std::max<std::size_t>(1, (records.size() + most - 1) / most);
  std::vector<CurvePoint> curve;
  for (std::size_t begin = 0; begin < records.size(); begin += each) {
    const auto part = records.subspan(begin, std::min(each, records.size() - begin));
    const auto n = static_cast<double>(part.size());
    CurvePoint mean;
    for (const models::TrainRecord& record : part) {
      mean.iteration += static_cast<double>(record.iteration) / n;
      mean.loss += record.loss / n;
    }
    curve.push_back(mean);
  }
  return curve;
}

Json errors_part(const ScoredRuns& scored) {
  const tasks::Benchmark& benchmark = *scored.benchmark;
  const char* error = benchmark.continuous() ? "distance_to_goal" : "nav_error";
  Json part = by_agent(scored.runs, [error](const std::vector<const ScoredRun*>& runs) {
    Histogram histogram{1, {}, 0};
    for (const ScoredRun* run : runs) {
      for (std::size_t i = 0; i < run->scores.ours.episodes; ++i) {
        const double metres = run->scores.ours.value(i, error);
        if (std::isfinite(metres)) histogram.add(metres);
      }
    }
    return to_json(histogram);
  });
  const bool near = ends_near(benchmark.goal);
  part["measured"] = benchmark.continuous() ? "along the floor" : "along the graph";
  part["rule"] = rule_of(benchmark.goal);
  part["radius"] = near ? Json(tasks::MetricOptions{}.success_distance) : Json(nullptr);
  return part;
}

Json by_length_part(const ScoredRuns& scored) {
  return by_agent(scored.runs, [&scored](const std::vector<const ScoredRun*>& runs) {
    return success_by_length(runs, scored);
  });
}

Json curves_part(const RunDirectory& found) {
  if (found.models.empty()) return missing("No model was trained here.");
  Json all = Json::array();
  for (const ModelDirectory& model : found.models) {
    const std::filesystem::path file = models::ModelFiles{model.folder}.log();
    std::error_code code;
    if (!std::filesystem::exists(file, code)) continue;
    const std::string agent(without_seed(model.agent));
    if (all.empty() || all.back()["agent"] != agent) {
      all.push_back({{"agent", agent}, {"runs", Json::array()}});
    }
    all.back()["runs"].push_back(run_json(model.agent, models::load_training_log(file)));
  }
  if (all.empty()) return missing("The model directories have no log.jsonl.");
  return {{"agents", std::move(all)}};
}

}  // namespace enfilade::report::parts
