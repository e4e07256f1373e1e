#include "enfilade/service/evaluation/scoring.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/core/check.h"
#include "enfilade/service/evaluation/near_copies.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_measures.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score.h"
#include "enfilade/tasks/scorer.h"
#include "enfilade/tasks/task_score.h"

namespace enfilade::service::evaluation {
namespace {

// The name of a results file in messages.
constexpr const char* kFileName = "submission";
constexpr std::size_t kMostFaults = 20;  // of one kind: a file that has one has thousands
// Metres: more than the rounding of files, less than what would help.
constexpr double kStepTolerance = 0.01;

Judgement score_as_own(const Phase& phase, const tasks::Results& results,
                       const tasks::EpisodeSet& episodes) {
  const tasks::Score score = tasks::compute_score(results.trajectories, episodes);
  return {tasks::to_json(score), score.mean(phase.primary).mean, {}};
}

Judgement score_as_public(const Phase& phase, const tasks::Results& results,
                          const tasks::EpisodeSet& episodes) {
  const tasks::Scorer& scorer = *phase.scorer;
  const auto score = tasks::compute_task_score(results.trajectories, episodes, scorer);
  const tasks::Measure& primary = phase.primary_measure();
  const auto metric = std::ranges::find(scorer.metrics, std::string_view(primary.name),
                                        &tasks::ScorerMetric::mean_name);
  EN_CHECK(metric != scorer.metrics.end());
  const auto k = static_cast<std::size_t>(metric - scorer.metrics.begin());
  return {tasks::to_json(score, episodes, false), score.means[k].mean / primary.whole, {}};
}

/// What a body of the benchmark could not have done.
void check_steps(const agents::ContinuousSetup& setup,
                 const std::vector<tasks::ContinuousResult>& walks,
                 const tasks::ContinuousEpisodes& episodes) {
  const continuous::SimulatorConfig& rules = setup.simulator;
  std::vector<Diagnostic> faults;
  const auto add = [&](const tasks::ContinuousResult& walk, std::size_t pose, const char* code,
                       std::string text) {
    const std::string id = tasks::text_of(episodes.episodes[walk.episode].id);
    faults.push_back({Severity::kError, kFileName, fmt::format("episode {}, pose {}", id, pose),
                      code, std::move(text)});
  };
  for (const tasks::ContinuousResult& walk : walks) {
    if (faults.size() >= kMostFaults) break;
    if (walk.actions.size() > rules.most_steps) {
      add(walk, rules.most_steps + 1, "too-many-steps",
          fmt::format("{} actions; {} allows {}", walk.actions.size(), setup.benchmark->title,
                      rules.most_steps));
    }
    for (std::size_t k = 1; k < walk.positions.size(); ++k) {
      const Vec3d step = to_double(walk.positions[k]) - to_double(walk.positions[k - 1]);
      const double length = std::hypot(step.x, step.y);  // heights follow the floor
      if (length <= rules.forward + kStepTolerance) continue;
      add(walk, k, "step-too-long",
          fmt::format("{:.3f} m from the pose before; a step of {} is {} m long", length,
                      setup.benchmark->title, rules.forward));
      break;
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

std::vector<tasks::ContinuousResult> read_walks(const Phase& phase, const ContinuousGoals& goals,
                                                const std::string& results) {
  auto walks = tasks::parse_continuous_results(results, kFileName, goals.episodes);
  check_steps(agents::continuous_setup(*phase.benchmark), walks, goals.episodes);
  return walks;
}

Judgement score_walks(const Phase& phase, const ContinuousGoals& goals,
                      const std::string& results) {
  const auto walks = read_walks(phase, goals, results);
  const auto scores =
      agents::score_continuous_walks(walks, goals.episodes, *goals.buildings, goals.experts);
  const tasks::ContinuousMeasures measures = tasks::measure(scores, walks, goals.episodes);
  auto stored =
      nlohmann::ordered_json{{"task", phase.benchmark->name}, {"scorer", phase.scorer->name}};
  stored.update(nlohmann::ordered_json::parse(
      tasks::to_json(measures, scores, walks, goals.episodes, false)));
  const auto all = tasks::continuous_measures();
  const auto primary = std::ranges::find(all, phase.primary, &tasks::ContinuousMeasure::name);
  EN_CHECK(primary != all.end());
  return {stored.dump(), measures.means[static_cast<std::size_t>(primary - all.begin())].mean,
          trajectory_ends(walks)};
}

}  // namespace

std::vector<Diagnostic> check_results(const Phase& phase, const SecretEpisodes& episodes,
                                      const std::string& results) {
  if (const auto* goals = std::get_if<ContinuousGoals>(&episodes)) {
    read_walks(phase, *goals, results);
    return {};
  }
  return tasks::parse_results(results, kFileName, std::get<tasks::EpisodeSet>(episodes)).warnings;
}

Judgement score_results(const Phase& phase, const SecretEpisodes& episodes,
                        const std::string& results) {
  if (const auto* goals = std::get_if<ContinuousGoals>(&episodes)) {
    return score_walks(phase, *goals, results);
  }
  const auto& graph = std::get<tasks::EpisodeSet>(episodes);
  const tasks::Results checked = tasks::parse_results(results, kFileName, graph);
  const auto score = phase.scorer == &tasks::own_scorer() ? score_as_own : score_as_public;
  Judgement judged = score(phase, checked, graph);
  judged.ends = trajectory_ends(checked.trajectories);
  return judged;
}

}  // namespace enfilade::service::evaluation
