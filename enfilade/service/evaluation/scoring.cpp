#include "enfilade/service/evaluation/scoring.h"

#include <fmt/format.h>
#include <cmath>
#include <utility>
#include <variant>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/service/evaluation/near_copies.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::service::evaluation {
namespace {

// The name of a results file in messages.
constexpr const char* kFileName = "submission";
constexpr std::size_t kMostFaults = 20;  // of one kind: a file that has one has thousands
// Metres: more than the rounding of files, less than what would help.
constexpr double kStepTolerance = 0.01;

/// A score as the database keeps it, and its primary mean as a share or in metres.
Judgement judgement_of(const Phase& phase, const tasks::ScoreTable& score, std::string ends) {
  const double primary = score.mean(phase.primary).mean / phase.primary_measure().whole;
  return {tasks::to_record(score), primary, std::move(ends)};
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
    const auto walks = read_walks(phase, *goals, results);
    return judgement_of(phase,
                        agents::compute_score(walks, goals->episodes, *goals->buildings,
                                              goals->experts, *phase.benchmark, *phase.scorer),
                        trajectory_ends(walks));
  }
  const auto& graph = std::get<tasks::EpisodeSet>(episodes);
  const auto checked = tasks::parse_results(results, kFileName, graph).trajectories;
  return judgement_of(phase, tasks::compute_score(checked, graph, *phase.scorer),
                      trajectory_ends(checked));
}

}  // namespace enfilade::service::evaluation
