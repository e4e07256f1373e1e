// An adversary who wants to know where secret goals are, at the limits that a phase allows, over
// real sockets: what gives something away must not tell more bits than the server says.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "enfilade/core/rng.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/metrics.h"
#include "tests/support/secret_phase.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using namespace testing;  // NOLINT(google-build-using-namespace)

// An adversary who draws conclusions as well as can be: it keeps the probability of every
// combination of goals of four paths at a time, and of many files sends the one whose answer it
// can foretell least. It knows the split, the metrics and the rules of showing; where it knows
// goals already, walks that surely succeed bring a mean to where rounding and steps tell the most.

constexpr std::size_t kGroup = 4;  // paths whose goals are asked for by one file
constexpr std::size_t kGroups = kPaths / kGroup;
constexpr std::size_t kMostDetours = 4;
constexpr std::size_t kHypotheses = kCandidates * kCandidates * kCandidates * kCandidates;
// Metrics that are 0 for a walk that stays at its start, whatever its goal is: so only the group
// and the walks of known goals count.
constexpr std::array<const char*, 4> kMetrics{"success", "oracle_success", "spl", "sdtw_collapsed"};
using Sums = std::array<double, kMetrics.size()>;

std::size_t goal_of(std::size_t hypothesis, std::size_t path) {
  for (; path > 0; --path) hypothesis /= kCandidates;
  return hypothesis % kCandidates;
}

/// What a walk adds to the sums, by its goal.
class WalkTable {
 public:
  WalkTable() : graph_(scan::testing::row_of_viewpoints("hall", kLength)) {
    for (std::size_t goal = 0; goal < kCandidates; ++goal) {
      for (std::size_t end = 0; end < kEnds; ++end) {
        for (std::size_t detours = 0; detours <= kMostDetours; ++detours) {
          table_[place(goal, {end, detours})] = compute(goal, {end, detours});
        }
      }
    }
  }
  const Sums& operator()(std::size_t goal, const Walk& walk) const {
    return table_[place(goal, walk)];
  }

 private:
  static constexpr std::size_t kEnds = kNearest + kCandidates;

  static std::size_t place(std::size_t goal, const Walk& walk) {
    return (goal * kEnds + walk.end) * (kMostDetours + 1) + walk.detours;
  }
  Sums compute(std::size_t goal, const Walk& walk) const {
    std::vector<ViewpointIndex> trajectory;
    std::vector<ViewpointIndex> reference;
    for (const std::size_t step : walk.steps()) trajectory.emplace_back(step);
    for (std::size_t v = 0; v <= kNearest + goal; ++v) reference.emplace_back(v);
    const tasks::EpisodeMetrics metrics = tasks::compute_metrics(graph_, trajectory, reference);
    return {metrics.success, metrics.oracle_success, metrics.spl, metrics.sdtw_collapsed};
  }

  graph::NavGraph graph_;
  std::array<Sums, kCandidates * kEnds*(kMostDetours + 1)> table_{};
};

double entropy_of(const std::map<std::int64_t, double>& weights) {
  double total = 0;
  double bits = 0;
  for (const auto& [answer, weight] : weights) total += weight;
  for (const auto& [answer, weight] : weights) bits -= weight / total * std::log2(weight / total);
  return bits;
}

/// What is still possible of the goals of a group; all that is possible is equally likely.
struct Belief {
  std::vector<std::size_t> possible;

  Belief() {
    for (std::size_t h = 0; h < kHypotheses; ++h) possible.push_back(h);
  }
  double learned_bits() const {
    return std::log2(static_cast<double>(kHypotheses) / static_cast<double>(possible.size()));
  }
  std::optional<std::size_t> known_goal(std::size_t path) const {
    const std::size_t first = goal_of(possible.front(), path);
    const bool same =
        std::ranges::all_of(possible, [&](std::size_t h) { return goal_of(h, path) == first; });
    return same ? std::optional(first) : std::nullopt;
  }
};

/// One file: which group is asked, how its paths are walked, and which known paths succeed.
struct Question {
  std::size_t group = 0;
  std::array<Walk, kGroup> walks;
  std::size_t known = 0;    // of the paths with known goals, so many go to them
  std::size_t detours = 0;  // of the last of these, so that it adds less than a whole
};

class Adversary {
 public:
  /// \param phase_step Phase::step
  Adversary(Target& target, double phase_step) : target_(target), step_(phase_step) {}

  const std::vector<Belief>& beliefs() const { return beliefs_; }
  double learned_bits() const {
    double bits = 0;
    for (const Belief& belief : beliefs_) bits += belief.learned_bits();
    return bits;
  }
  std::size_t known_goals() const { return known_paths().size(); }

  /// Submits at the ladder's limits, as one team after another.
  void climb(std::size_t teams, std::size_t submissions, std::string_view names = "climber") {
    for (std::size_t t = 0; t < teams; ++t) {
      const auto team = target_.served().team(fmt::format("{} {}", names, t));
      std::optional<double> best;
      for (std::size_t k = 0; k < submissions; ++k) {
        const Question question = best_question(best);
        const json answer = target_.submit(team, file_of(question), fmt::format("m{}", k));
        best = conclude_from_ladder(question, best, answer);
      }
    }
  }

  /// Hands files in without being told anything, each about a group of its own, and then reads
  /// whatever it can see.
  void wait_for_the_end(std::size_t teams, std::size_t submissions) {
    struct Sent {
      std::int64_t id = 0;
      httplib::Headers team;
      Question question;
    };
    std::vector<Sent> all;
    for (std::size_t t = 0; t < teams; ++t) {
      const auto team = target_.served().team(fmt::format("waiter {}", t));
      for (std::size_t k = 0; k < submissions; ++k) {
        const Question question = finest_question(all.size() % kGroups);
        const json answer = target_.submit(team, file_of(question), fmt::format("m{}", k));
        all.push_back({answer.at("id").get<std::int64_t>(), team, question});
      }
    }
    target_.end();
    for (const Sent& sent : all) {
      const json seen =
          target_.served().json("/api/v1/submissions/" + std::to_string(sent.id), sent.team);
      if (seen.contains("means")) conclude_from_means(sent.question, seen.at("means"));
    }
    // A team's other files are no better than the one that stands for it.
    const json board = target_.served().json("/api/v1/leaderboards/test");
    for (const json& row : board.at("rows")) {
      const double spl = row.at("means").at("spl").at("mean").get<double>();
      for (const Sent& sent : all) conclude_no_better(sent.question, spl, row, sent.team);
    }
  }

 private:
  std::vector<std::size_t> known_paths() const {
    std::vector<std::size_t> paths;
    for (std::size_t path = 0; path < kPaths; ++path) {
      if (beliefs_[path / kGroup].known_goal(path % kGroup)) paths.push_back(path);
    }
    return paths;
  }

  /// Known paths that are not of the group that is asked.
  std::vector<std::size_t> ballast_of(std::size_t group) const {
    std::vector<std::size_t> paths = known_paths();
    std::erase_if(paths, [group](std::size_t path) { return path / kGroup == group; });
    return paths;
  }

  Walk ballast_walk(const Question& question, std::size_t path, bool is_last) const {
    const std::size_t goal = *beliefs_[path / kGroup].known_goal(path % kGroup);
    return {kNearest + goal, is_last ? question.detours : 0};
  }

  Walks file_of(const Question& question) const {
    Walks walks{};
    for (std::size_t k = 0; k < kGroup; ++k) walks[question.group * kGroup + k] = question.walks[k];
    const auto ballast = ballast_of(question.group);
    for (std::size_t k = 0; k < question.known; ++k) {
      walks[ballast[k]] = ballast_walk(question, ballast[k], k + 1 == question.known);
    }
    return walks;
  }

  Sums ballast_sums(const Question& question) const {
    Sums sums{};
    const auto ballast = ballast_of(question.group);
    for (std::size_t k = 0; k < question.known; ++k) {
      const std::size_t goal = *beliefs_[ballast[k] / kGroup].known_goal(ballast[k] % kGroup);
      add(sums, table_(goal, ballast_walk(question, ballast[k], k + 1 == question.known)));
    }
    return sums;
  }

  static void add(Sums& sums, const Sums& more) {
    for (std::size_t m = 0; m < sums.size(); ++m) sums[m] += more[m];
  }

  Sums means_of(const Question& question, const Sums& ballast, std::size_t hypothesis) const {
    Sums sums = ballast;
    for (std::size_t k = 0; k < kGroup; ++k) {
      add(sums, table_(goal_of(hypothesis, k), question.walks[k]));
    }
    for (double& sum : sums) sum /= static_cast<double>(kPaths);
    return sums;
  }

  std::int64_t level(double value) const { return std::llround(value / step_); }

  /// What a ladder answers: the level that is shown; -1 for no improvement.
  std::int64_t ladder_answer(double spl, std::optional<double> best) const {
    if (best && spl < *best + step_ - 1e-9) return -1;
    return level(spl);
  }

  Question random_question(std::size_t group) {
    Question question{group, {}, 0, 0};
    for (Walk& walk : question.walks) {
      walk = {rng_.below(kNearest + kCandidates), rng_.below(kMostDetours + 1)};
    }
    question.known = rng_.below(ballast_of(group).size() + 1);
    question.detours = rng_.below(kMostDetours + 1);
    return question;
  }

  /// Of many, the file whose answer a ladder makes it the hardest to foretell.
  Question best_question(std::optional<double> best) {
    Question chosen;
    double most = -1;
    for (int k = 0; k < 200; ++k) {
      const Question question = random_question(next_group());
      const Sums ballast = ballast_sums(question);
      std::map<std::int64_t, double> answers;
      for (const std::size_t h : beliefs_[question.group].possible) {
        answers[ladder_answer(means_of(question, ballast, h)[2], best)] += 1;
      }
      const double bits = entropy_of(answers);
      if (bits > most) {
        most = bits;
        chosen = question;
      }
    }
    return chosen;
  }

  /// A group that is not known yet, and sooner one that was begun.
  std::size_t next_group() {
    for (int k = 0; k < 20; ++k) {
      const std::size_t group = rng_.below(std::min(kGroups, begun_ + 2));
      if (beliefs_[group].possible.size() > 1) return group;
    }
    return rng_.below(kGroups);
  }

  /// The file about a group whose row on the leaderboard differs the most by its goals.
  Question finest_question(std::size_t group) {
    Question chosen;
    double most = -1;
    for (int k = 0; k < 100; ++k) {
      Question question = random_question(group);
      std::map<std::int64_t, double> answers;
      for (const std::size_t h : beliefs_[group].possible) {
        const Sums means = means_of(question, {}, h);
        std::int64_t row = 0;
        for (const double mean : means) row = row * 1000 + level(mean);
        answers[row] += 1;
      }
      question.known = 0;
      const double bits = entropy_of(answers);
      if (bits > most) {
        most = bits;
        chosen = question;
      }
    }
    return chosen;
  }

  /// Keeps the hypotheses that fit. They include the truth, or the adversary's rules are not the
  /// server's.
  template <class Fits>
  void keep(std::size_t group, const Fits& fits) {
    auto& possible = beliefs_[group].possible;
    std::erase_if(possible, [&fits](std::size_t h) { return !fits(h); });
    ASSERT_FALSE(possible.empty()) << "the adversary was told what cannot be";
    begun_ = std::max(begun_, group + 1);
  }

  /// \returns the best score that was shown to the team so far
  std::optional<double> conclude_from_ladder(const Question& question, std::optional<double> best,
                                             const json& answer) {
    const Sums ballast = ballast_sums(question);
    const bool shown = answer.contains("means");
    if (shown && answer.at("means").size() > 1) {  // more than a ladder should show
      conclude_from_means(question, answer.at("means"));
      return best;
    }
    const double value = shown ? answer.at("means").at("spl").at("mean").get<double>() : 0;
    const std::int64_t told = shown ? level(value) : -1;
    keep(question.group, [&](std::size_t h) {
      return ladder_answer(means_of(question, ballast, h)[2], best) == told;
    });
    return shown ? std::optional(value) : best;
  }

  void conclude_from_means(const Question& question, const json& means) {
    const Sums ballast = ballast_sums(question);
    keep(question.group, [&](std::size_t h) {
      const Sums expected = means_of(question, ballast, h);
      for (std::size_t m = 0; m < kMetrics.size(); ++m) {
        const double told = means.at(kMetrics[m]).at("mean").get<double>();
        // Half a unit of what is told: to a step, or as exact as it is.
        const bool rounded = std::abs(told - static_cast<double>(level(told)) * step_) < 1e-12;
        const double tolerance = (rounded ? step_ / 2 : 0) + 1e-9;
        if (std::abs(expected[m] - told) > tolerance) return false;
      }
      return true;
    });
  }

  void conclude_no_better(const Question& question, double best, const json& row,
                          const httplib::Headers& team) {
    const auto own = target_.served().json("/api/v1/session", team);
    if (own.at("name") != row.at("team")) return;
    keep(question.group,
         [&](std::size_t h) { return means_of(question, {}, h)[2] <= best + step_ / 2 + 1e-9; });
  }

  Target& target_;
  double step_;
  WalkTable table_;
  Rng rng_{7};
  std::vector<Belief> beliefs_ = std::vector<Belief>(kGroups);
  std::size_t begun_ = 0;  // groups below it have been asked
};

/// What it concluded is true, is something, and is no more than the server says.
void expect_within(const Adversary& adversary, const Goals& goals, double stated) {
  for (std::size_t group = 0; group < kGroups; ++group) {
    std::size_t truth = 0;
    for (std::size_t k = kGroup; k-- > 0;) truth = truth * kCandidates + goals[group * kGroup + k];
    const auto& possible = adversary.beliefs()[group].possible;
    EXPECT_TRUE(std::ranges::find(possible, truth) != possible.end()) << group;
  }
  EXPECT_GT(adversary.learned_bits(), 4) << "no attack at all";
  EXPECT_LE(adversary.learned_bits(), stated);
  EXPECT_LE(static_cast<double>(adversary.known_goals()) * kBitsOfAGoal, stated);
  // Else the bound would hold for whoever knows all goals.
  EXPECT_LT(stated, static_cast<double>(kPaths) * kBitsOfAGoal);
  ::testing::Test::RecordProperty("learned_bits", std::to_string(adversary.learned_bits()));
  ::testing::Test::RecordProperty("stated_bits", std::to_string(stated));
}

TEST(SecretGoalsAdversary, WhoClimbsALadderLearnsLessThanIsStated) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Goals goals = draw_goals(seed);
    Target target(goals, R"(, "scores": "ladder", "per_team": 8, "teams": 2)");
    Adversary adversary(target, 0.01);
    adversary.climb(2, 8);
    expect_within(adversary, goals, target.used_bits());
  }
}

// The same goals by another benchmark's ladder, and by the same one under a new name: what is
// stated is of all of them together.
TEST(SecretGoalsAdversary, WhoAsksAllBenchmarksAndNamesLearnsLessThanIsStated) {
  const std::string guides = R"(, "scores": "ladder", "per_team": 6, "teams": 1},
    {"name": "guides", "task": "rxr", "split": "hidden", "annotations": "guides.json",
     "scores": "ladder", "primary": "spl", "per_day": 1000, "per_team": 6, "teams": 2)";
  const Goals goals = draw_goals(1);
  Target target(goals, guides);
  Adversary adversary(target, 0.01);
  adversary.climb(1, 6);
  const double of_one = target.used_bits();
  target.ask("guides", true);
  adversary.climb(2, 6, "guide");
  const double of_two = target.used_bits();
  EXPECT_GT(of_two, 2 * of_one);
  target.ask("test", false);
  target.serve("again", R"(, "scores": "ladder", "per_team": 6, "teams": 1)");
  EXPECT_EQ(target.used_bits(), of_two) << "a new name takes nothing back";
  adversary.climb(1, 6, "renamed");
  expect_within(adversary, goals, target.used_bits());
  const json phases = target.served().json("/api/v1/phases").at("phases");
  EXPECT_EQ(phases[0].at("leakage").at("phases"), (json{"again", "test", "guides"}));
}

TEST(SecretGoalsAdversary, WhoWaitsForTheEndLearnsLessThanIsStated) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Goals goals = draw_goals(seed);
    Target target(goals, std::string(kEnds) + R"(, "per_team": 10, "teams": 2)");
    Adversary adversary(target, 0.01);
    adversary.wait_for_the_end(2, 10);
    expect_within(adversary, goals, target.used_bits());
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
