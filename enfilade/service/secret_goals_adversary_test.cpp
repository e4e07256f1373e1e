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
#include "tests/support/refusal.h"
#include "tests/support/secret_benchmarks.h"

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
// Measures that are 0 for a walk that stays at its start, whatever its goal is: so only the group
// and the walks of known goals count. By their columns.
constexpr std::array<std::string_view, 4> kColumns{"SPL", "SR", "OSR", "sDTW"};
constexpr std::size_t kPrimary = 0;  // of them; all phases here rank by it
using Sums = std::array<double, kColumns.size()>;

std::size_t goal_of(std::size_t hypothesis, std::size_t path) {
  for (; path > 0; --path) hypothesis /= kCandidates;
  return hypothesis % kCandidates;
}

/// What a walk adds to the sums of a benchmark, by its goal.
class WalkTable {
 public:
  explicit WalkTable(const tasks::Benchmark& benchmark)
      : benchmark_(benchmark),
        scorer_(benchmark.scorers.front()),
        graph_(scan::testing::row_of_viewpoints("hall", kLength)) {
    for (std::size_t m = 0; m < kColumns.size(); ++m) {
      const auto found = std::ranges::find(scorer_.columns, kColumns[m], &tasks::Measure::column);
      if (found != scorer_.columns.end()) measures_[m] = &*found;
    }
    for (std::size_t goal = 0; goal < kCandidates; ++goal) {
      for (std::size_t end = 0; end < kEnds; ++end) {
        for (std::size_t detours = 0; detours <= kMostDetours; ++detours) {
          table_[place(goal, {end, detours})] = compute(goal, {end, detours});
        }
      }
    }
    for (std::size_t goal = 0; goal < kCandidates; ++goal) {
      EXPECT_EQ(table_[place(goal, {})], Sums{}) << benchmark.title;
    }
  }
  const Sums& operator()(std::size_t goal, const Walk& walk) const {
    return table_[place(goal, walk)];
  }
  std::string_view title() const { return benchmark_.title; }
  /// What the server calls a column; null: the benchmark has no such one.
  const char* name(std::size_t column) const {
    return measures_[column] == nullptr ? nullptr : measures_[column]->name;
  }

 private:
  static constexpr std::size_t kEnds = kNearest + kCandidates;

  static std::size_t place(std::size_t goal, const Walk& walk) {
    return (goal * kEnds + walk.end) * (kMostDetours + 1) + walk.detours;
  }
  std::vector<double> metrics(std::size_t goal, const Walk& walk) const {
    std::vector<double> values(scorer_.metrics.size());
    if (benchmark_.continuous()) {
      Goals goals{};
      goals[0] = goal;
      const tasks::ContinuousEpisode episode = hall_episodes(&goals).episodes.front();
      const tasks::ContinuousResult result = on_floor(0, walk);
      std::vector<double> distances;
      for (const Vec3f& at : result.positions) {
        distances.push_back(std::abs(episode.goals->front().position.x - at.x));
      }
      const tasks::ScoredWalk scored = tasks::to_score(result, distances);
      scorer_.on_floor(scored.view(), tasks::reference_to_score(*episode.reference_path), values);
      return values;
    }
    tasks::ReferencePath reference;
    const ViewpointIndex end(kNearest + goal);
    for (std::size_t v = 0; v <= end.at(); ++v) reference.viewpoints.emplace_back(v);
    switch (benchmark_.goal) {
      case tasks::GoalKind::kTurningPoint:
        for (std::size_t v = end.at(); v-- > 0;) reference.viewpoints.emplace_back(v);
        reference.goal = tasks::TurningPoint{end};
        break;
      case tasks::GoalKind::kObject:
        reference.goal = tasks::SeenObject{1, {end}};
        break;
      case tasks::GoalKind::kRegion:
        reference.goal = tasks::Region{{end}, reference.viewpoints, reference.viewpoints};
        break;
      case tasks::GoalKind::kBoxes:
        reference.goal = tasks::Boxes{{{end, {}, {}}}, {}};
        break;
      case tasks::GoalKind::kNearEnd:
      case tasks::GoalKind::kPoint:
        break;
    }
    scorer_.on_graph({graph_, reference, on_graph(benchmark_, 0, walk)}, values);
    return values;
  }
  Sums compute(std::size_t goal, const Walk& walk) const {
    const std::vector<double> means = tasks::summarise(scorer_, metrics(goal, walk));
    Sums sums{};
    for (std::size_t m = 0; m < sums.size(); ++m) {
      if (measures_[m] == nullptr) continue;
      sums[m] = means[scorer_.place_of(measures_[m]->name)] / measures_[m]->whole;
    }
    return sums;
  }

  const tasks::Benchmark& benchmark_;
  const tasks::Scorer& scorer_;
  graph::NavGraph graph_;
  std::array<const tasks::Measure*, kColumns.size()> measures_{};
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
  Adversary(Target& target, double phase_step) : target_(target), step_(phase_step) {
    ask(tasks::benchmark("r2r"));
  }
  /// From now on files are of this benchmark.
  void ask(const tasks::Benchmark& benchmark) {
    table_ = &tables_.try_emplace(&benchmark, benchmark).first->second;
  }

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

  /// Hands files in without being told anything, each about a group of its own.
  /// \param tries of how many files it takes the finest
  void hand_in(std::size_t teams, std::size_t submissions, const std::string& phase,
               int tries = 100) {
    for (std::size_t t = 0; t < teams; ++t) {
      const std::string name = fmt::format("{} waiter {}", phase, t);
      const auto team = target_.served().team(name);
      for (std::size_t k = 0; k < submissions; ++k) {
        const Question question = finest_question(sent_.size() % kGroups, tries);
        const json answer = target_.submit(team, file_of(question), fmt::format("m{}", k));
        sent_.push_back({answer.at("id").get<std::int64_t>(), team, name, question, phase, table_});
      }
    }
  }
  /// Reads whatever it can see when the phases have ended.
  void read_the_end() {
    target_.end();
    std::map<std::string, json> rows;
    for (const Sent& sent : sent_) {
      const std::string board = "/api/v1/leaderboards/" + sent.phase;
      if (!rows.contains(sent.phase)) {
        rows[sent.phase] = target_.served().json(board).at("rows");
      }
      table_ = sent.table;
      const json seen =
          target_.served().json("/api/v1/submissions/" + std::to_string(sent.id), sent.team);
      if (seen.contains("means")) conclude_from_means(sent.question, seen.at("means"));
      // A team's other files are no better than the one that stands for it.
      for (const json& row : rows[sent.phase]) conclude_no_better(sent, row);
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
      add(sums, (*table_)(goal, ballast_walk(question, ballast[k], k + 1 == question.known)));
    }
    return sums;
  }

  static void add(Sums& sums, const Sums& more) {
    for (std::size_t m = 0; m < sums.size(); ++m) sums[m] += more[m];
  }

  Sums means_of(const Question& question, const Sums& ballast, std::size_t hypothesis) const {
    Sums sums = ballast;
    for (std::size_t k = 0; k < kGroup; ++k) {
      add(sums, (*table_)(goal_of(hypothesis, k), question.walks[k]));
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
        answers[ladder_answer(means_of(question, ballast, h)[kPrimary], best)] += 1;
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
  Question finest_question(std::size_t group, int tries) {
    Question chosen;
    double most = -1;
    for (int k = 0; k < tries; ++k) {
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
    ASSERT_FALSE(possible.empty()) << table_->title() << ": the adversary was told what cannot be";
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
    const double value =
        shown ? answer.at("means").at(table_->name(kPrimary)).at("mean").get<double>() : 0;
    const std::int64_t told = shown ? level(value) : -1;
    keep(question.group, [&](std::size_t h) {
      return ladder_answer(means_of(question, ballast, h)[kPrimary], best) == told;
    });
    return shown ? std::optional(value) : best;
  }

  void conclude_from_means(const Question& question, const json& means) {
    const Sums ballast = ballast_sums(question);
    keep(question.group, [&](std::size_t h) {
      const Sums expected = means_of(question, ballast, h);
      for (std::size_t m = 0; m < kColumns.size(); ++m) {
        if (table_->name(m) == nullptr) continue;
        const double told = means.at(table_->name(m)).at("mean").get<double>();
        // Half a unit of what is told: to a step, or as exact as it is.
        const bool rounded = std::abs(told - static_cast<double>(level(told)) * step_) < 1e-12;
        const double tolerance = (rounded ? step_ / 2 : 0) + 1e-9;
        if (std::abs(expected[m] - told) > tolerance) return false;
      }
      return true;
    });
  }

  /// A file whose means are shown to a team when the phase has ended, or not.
  struct Sent {
    std::int64_t id = 0;
    httplib::Headers team;
    std::string name;  // of the team
    Question question;
    std::string phase;
    const WalkTable* table;
  };

  void conclude_no_better(const Sent& sent, const json& row) {
    if (row.at("team").get<std::string>() != sent.name) return;
    const double best = row.at("means").at(table_->name(kPrimary)).at("mean").get<double>();
    keep(sent.question.group, [&](std::size_t h) {
      return means_of(sent.question, {}, h)[kPrimary] <= best + step_ / 2 + 1e-9;
    });
  }

  Target& target_;
  double step_;
  std::map<const tasks::Benchmark*, WalkTable> tables_;
  const WalkTable* table_ = nullptr;  // of the benchmark that is asked
  std::vector<Sent> sent_;
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

TEST(SecretGoalsAdversary, WhoWaitsForTheEndLearnsLessThanIsStated) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Goals goals = draw_goals(seed);
    Target target(goals, std::string(kEnds) + R"(, "per_team": 10, "teams": 2)");
    Adversary adversary(target, 0.01);
    adversary.hand_in(2, 10, "test");
    adversary.read_the_end();
    expect_within(adversary, goals, target.used_bits());
  }
}

/// The same goals as phases of all benchmarks, which have their names.
class AllBenchmarks {
 public:
  AllBenchmarks() : target_(goals_, "") {
    write_secret_benchmarks(target_.served().root(), goals_);
    const dataset::Dataset data(target_.served().root() / "data");
    for (const tasks::Benchmark& one : tasks::benchmarks()) {
      splits_.emplace(&one, data.split(one, "test"));
    }
  }
  /// \param rules of each phase \param before of their names
  void serve(const std::string& rules, const std::string& before = "") {
    std::string list;
    for (const auto& [benchmark, split] : splits_) {
      list += fmt::format(
          R"({}{{"name": "{}{}", "task": "{}", "split": "test", "annotations": "{}",
              "primary": "spl", "per_day": 1000, "per_address_day": 1000{}}})",
          list.empty() ? "" : ", ", before, benchmark->name, benchmark->name,
          secret_file(*benchmark), rules);
    }
    before_ = before;
    target_.served().restart_with(list);
  }
  /// Calls a function for each benchmark, while the adversary asks it.
  template <class Attack>
  void attack(Adversary& adversary, const Attack& how) {
    for (const auto& [benchmark, split] : splits_) {
      const std::string phase = before_ + std::string(benchmark->name);
      target_.ask(phase, [&split](const Walks& walks) { return results_of(split, walks); });
      adversary.ask(*benchmark);
      how(phase);
    }
  }

  const Goals& goals() const { return goals_; }
  Target& target() { return target_; }
  /// What all phases say of all of them together.
  json leakage() {
    const json phases = target_.served().json("/api/v1/phases", target_.organiser()).at("phases");
    for (const json& one : phases) {
      EXPECT_EQ(one.at("leakage").at("used_bits"), phases[0].at("leakage").at("used_bits"));
      EXPECT_GE(one.at("leakage").at("phases").size(), splits_.size()) << one.at("name");
    }
    return phases[0].at("leakage");
  }

 private:
  Goals goals_ = draw_goals(1);
  Target target_;
  std::map<const tasks::Benchmark*, tasks::Split> splits_;
  std::string before_;
};

// What is stated is of all phases together, also after a new name.
TEST(SecretGoalsAdversary, WhoAsksAllBenchmarksAndNamesLearnsLessThanIsStated) {
  AllBenchmarks all;
  Adversary adversary(all.target(), 0.01);
  all.serve(R"(, "scores": "ladder", "per_team": 1, "teams": 1)");
  all.attack(adversary, [&](const std::string& phase) { adversary.climb(1, 1, phase); });
  const double used = all.leakage().at("used_bits").get<double>();
  const double learned = adversary.learned_bits();
  all.serve(R"(, "scores": "ladder", "per_team": 1, "teams": 1)", "again-");
  EXPECT_EQ(all.leakage().at("used_bits").get<double>(), used) << "a new name takes nothing back";
  all.attack(adversary, [&](const std::string& phase) { adversary.climb(1, 1, phase); });
  EXPECT_GT(adversary.learned_bits(), learned);
  expect_within(adversary, all.goals(), all.leakage().at("used_bits").get<double>());
}

// Twenty teams at the default limits would know most of sixty goals. So the server does not start,
// and where that is accepted it says so.
TEST(SecretGoalsAdversary, AtTheDefaultLimitsSixtyGoalsAreRefused) {
  AllBenchmarks all;
  Adversary adversary(all.target(), 0.01);
  all.serve(std::string(kEnds) + R"(, "per_address": 1000)");
  ServerConfig strict = all.target().served().config();
  strict.accept_leak = false;
  const std::filesystem::path root = all.target().served().root();
  const auto site = [&root] {
    return Site::open(root / "data", load_phases(root / "phases.json"));
  };
  EXPECT_THAT(tests::refusal([&] { const Server server(site(), strict); }),
              ::testing::HasSubstr("--accept-leak"));
  all.attack(adversary, [&](const std::string& phase) { adversary.hand_in(20, 1, phase, 5); });
  EXPECT_EQ(adversary.learned_bits(), 0);
  EXPECT_EQ(all.leakage().at("used_bits").get<double>(), 0);
  adversary.read_the_end();
  const json stated = all.leakage();
  EXPECT_GT(stated.at("most_bits").get<double>(), stated.at("goal_bits").get<double>());
  EXPECT_LE(adversary.learned_bits(), stated.at("used_bits").get<double>());
  EXPECT_GT(2 * adversary.known_goals(), kPaths) << "so the limits were too wide indeed";
  RecordProperty("learned_bits", std::to_string(adversary.learned_bits()));
  RecordProperty("used_bits", stated.at("used_bits").dump());
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
