#include "enfilade/service/evaluation/submissions.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/agents/run.h"
#include "enfilade/service/store/database.h"
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
    // A step that slides along a wall ends where the floor is nearest to its aim, at most as far
    // from there as it began. So single steps may be longer, and all of them together may not.
    const double longest = 2 * rules.forward;
    double all = longest;
    for (std::size_t k = 1; k < walk.positions.size(); ++k) {
      const Vec3d step = to_double(walk.positions[k]) - to_double(walk.positions[k - 1]);
      const double length = std::hypot(step.x, step.y);  // heights follow the floor
      all += rules.forward + kStepTolerance - length;
      if (length <= longest + kStepTolerance && all >= 0) continue;
      add(walk, k, "step-too-long",
          fmt::format("{:.3f} m from the pose before; a step of {} is {} m long, and one that "
                      "slides at most {}",
                      length, setup.benchmark->title, rules.forward, longest));
      break;
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

tasks::Trajectories read_results(const tasks::Split& split, const std::string& results,
                                 std::vector<Diagnostic>* warnings = nullptr) {
  auto read = tasks::parse_trajectories(results, kFileName, split, tasks::Coverage::kAll, warnings);
  if (const auto* walks = std::get_if<std::vector<tasks::ContinuousResult>>(&read)) {
    check_steps(agents::continuous_setup(split.benchmark()), *walks, *split.continuous());
  }
  return read;
}

constexpr std::size_t kBytes = 4;  // of an episode
// Rows read at a time: 16 of R2R's largest split are 270 kB.
constexpr int kRowsAtOnce = 16;

/// FNV-1a, of 32 bits: two answers that differ are taken for one in 2^-32 of cases.
std::uint32_t hash_of(std::string_view bytes) {
  std::uint32_t value = 0x811C9DC5U;
  for (const char byte : bytes) value = (value ^ static_cast<unsigned char>(byte)) * 0x01000193U;
  return value;
}

/// Of what is said of the goal; 0 where nothing is.
std::uint32_t answer_of(const tasks::Trajectory& trajectory) {
  std::string said = trajectory.object;
  if (trajectory.turning_point) said += fmt::format("@{}", trajectory.turning_point->value);
  if (trajectory.point) {
    said += fmt::format("({},{})", trajectory.point->heading, trajectory.point->elevation);
  }
  return said.empty() ? 0 : hash_of(said);
}

std::uint32_t end_of(const tasks::Trajectory& trajectory) {
  return trajectory.points.back().viewpoint.value ^ answer_of(trajectory);
}

std::uint32_t end_of(const tasks::ContinuousResult& walk) {
  constexpr double kCell = 0.25;  // metres
  const Vec3f place = walk.positions.back();
  const auto cell = [](float x) { return std::floor(double{x} / kCell); };
  return hash_of(
      fmt::format("{} {} {} {}", cell(place.x), cell(place.y), cell(place.z), walk.stopped()));
}

}  // namespace

std::vector<Diagnostic> check_results(const SecretEpisodes& episodes, const std::string& results) {
  std::vector<Diagnostic> warnings;
  read_results(episodes.split, results, &warnings);
  return warnings;
}

bool is_unknown_episode(const Diagnostic& fault) {
  return fault.code == "unknown-instr-id" || fault.code == "unknown-episode";
}

bool names_episodes_of(const tasks::Split& split, const std::string& results) {
  try {
    tasks::parse_trajectories(results, kFileName, split, tasks::Coverage::kPart);
    return true;
  } catch (const InvalidInput& faults) {
    return std::ranges::none_of(faults.diagnostics(), is_unknown_episode);
  }
}

ScoredSubmission score_results(const Phase& phase, const SecretEpisodes& episodes,
                               const std::string& results) {
  const tasks::Trajectories read = read_results(episodes.split, results);
  const tasks::ScoreTable score =
      agents::compute_score(read, episodes.split, episodes.buildings.get(), *phase.scorer);
  const double primary = score.mean(phase.primary).mean / phase.primary_measure().whole;
  return {tasks::to_record(score), primary, trajectory_ends(read)};
}

std::string trajectory_ends(const tasks::Trajectories& trajectories) {
  std::string bytes;
  bytes.reserve(kBytes * tasks::size(trajectories));
  const auto add_ends = [&bytes](const auto& all) {
    for (const auto& one : all) {
      std::uint32_t end = end_of(one);
      for (std::size_t k = 0; k < kBytes; ++k, end >>= 8U) {
        bytes.push_back(static_cast<char>(end & 0xFFU));
      }
    }
  };
  std::visit(add_ends, trajectories);
  return bytes;
}

std::optional<std::size_t> count_differing(std::string_view ends, std::string_view other) {
  if (ends.size() != other.size()) return std::nullopt;
  std::size_t count = 0;
  for (std::size_t at = 0; at < ends.size(); at += kBytes) {
    if (ends.substr(at, kBytes) != other.substr(at, kBytes)) ++count;
  }
  return count;
}

std::optional<NearCopy> find_near_copy(store::Database& db, const std::vector<std::string>& phases,
                                       std::int64_t id, std::string_view ends) {
  const std::size_t episodes = ends.size() / kBytes;
  const std::size_t most = std::min(std::max<std::size_t>(5, episodes / 50), episodes / 4);
  std::optional<NearCopy> nearest;
  for (const std::string& phase : phases) {
    for (std::int64_t after = 0;;) {
      const auto rows = db.select<std::tuple<std::int64_t, std::string>>(
          "SELECT id, ends FROM submission WHERE phase = ? AND id > ? AND id < ? AND ends IS NOT "
          "NULL ORDER BY id LIMIT ?",
          phase, after, id, kRowsAtOnce);
      for (const auto& [other, its_ends] : rows) {
        after = other;
        const auto differing = count_differing(ends, its_ends);
        if (!differing || *differing > most) continue;
        const NearCopy copy{other, static_cast<std::int64_t>(*differing)};
        if (!nearest ||
            std::tie(copy.differing, copy.of) < std::tie(nearest->differing, nearest->of)) {
          nearest = copy;
        }
      }
      if (rows.size() < static_cast<std::size_t>(kRowsAtOnce)) break;
    }
  }
  return nearest;
}

}  // namespace enfilade::service::evaluation
