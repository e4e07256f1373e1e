// Attacks on secret goals, over real sockets: what is said to give nothing away must be the same to
// the byte whatever the goals are.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <set>

#include "tests/support/secret_phase.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using namespace testing;  // NOLINT(google-build-using-namespace)

/// The attack that read 59 of 60 goals: one trajectory is changed at a time, and the means tell
/// what that did to its error. \returns all that the team was told
std::string change_one_at_a_time(Target& target, std::size_t submissions) {
  const auto team = target.served().team("A");
  Walks walks{};
  std::string told = target.submit(team, walks, "m").dump();
  for (std::size_t k = 1; k < submissions; ++k) {
    walks[k] = {.end = 10};
    told += target.submit(team, walks, "m").dump();
  }
  return told + target.everything(team);
}

TEST(SecretGoalsAttacks, BeforeTheEndNothingDependsOnTheGoals) {
  for (const std::string scores : {"after-end", "hidden"}) {
    const std::string rules = kEnds + (R"(, "scores": ")" + scores + '"');
    std::set<std::string> told;
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      Target target(draw_goals(seed), rules);
      told.insert(change_one_at_a_time(target, 20));
      EXPECT_EQ(target.used_bits(), 0);
    }
    EXPECT_EQ(told.size(), 1U) << scores << ": an answer depends on where the goals are";
  }
}

TEST(SecretGoalsAttacks, ThirtyTwoTeamsAreNotMoreThanTheirApproval) {
  Target target(draw_goals(1), R"(, "teams": 2, "scores": "ladder")");
  std::vector<httplib::Headers> teams;
  for (int k = 0; k < 32; ++k) teams.push_back(target.served().stranger(fmt::format("t{}", k)));
  for (const auto& team : teams) {
    EXPECT_EQ(target.submit(team, {}, "m").at("error").at("code"), "forbidden");
  }
  EXPECT_EQ(target.used_bits(), 0);
  for (int k = 0; k < 32; ++k) {
    set_approval(target.served().config().database, fmt::format("t{}", k), Approval::kGiven);
  }
  std::size_t taken = 0;
  for (const auto& team : teams) taken += target.submit(team, {}, "m").contains("id") ? 1 : 0;
  EXPECT_EQ(taken, 2U);
}

TEST(SecretGoalsAttacks, FromOneAddressAllTeamsShareItsLimit) {
  Target target(draw_goals(1), R"(, "per_address": 10)");
  std::size_t taken = 0;
  for (int k = 0; k < 8; ++k) {
    const auto team = target.served().team(fmt::format("t{}", k));
    for (std::size_t end = 0; end < 3; ++end) {
      Walks walks{};
      walks[0].end = end;
      taken += target.submit(team, walks, "m").contains("id") ? 1 : 0;
    }
  }
  EXPECT_EQ(taken, 10U);
}

TEST(SecretGoalsAttacks, ATeamHasOneRowByWhateverRoad) {
  Target target(draw_goals(1), std::string(kEnds) + R"(, "scores": "after-end")");
  const auto team = target.served().team("A");
  std::vector<std::int64_t> ids;
  for (std::size_t k = 0; k < 6; ++k) {
    Walks walks{};
    for (std::size_t path = 0; path < kPaths; ++path) walks[path].end = (path * 7 + k) % 11;
    ids.push_back(target.submit(team, walks, "m").at("id").get<std::int64_t>());
  }
  target.end();
  std::set<std::string> means;
  const auto look = [&] {
    for (const std::int64_t id : ids) {
      const json one = target.served().json("/api/v1/submissions/" + std::to_string(id), team);
      if (one.contains("means")) means.insert(one.at("means").dump());
    }
    for (const char* query : {"", "?all=1"}) {
      const std::string board = std::string("/api/v1/leaderboards/test") + query;
      const json shown = target.served().json(board, team);
      for (const json& row : shown.at("rows")) {
        means.insert(row.at("means").dump());
      }
    }
    const json sent = target.served().json("/api/v1/submissions", team);
    for (const json& one : sent.at("submissions")) {
      if (one.contains("means")) means.insert(one.at("means").dump());
    }
  };
  look();
  for (const std::int64_t id : ids) {  // whoever withdraws the best sees the next best
    target.served().client().Delete("/api/v1/submissions/" + std::to_string(id), team);
    look();
  }
  EXPECT_EQ(means.size(), 1U);
}

// The exact means of two teams whose shown ones are equal: the order of rows must not tell.
TEST(SecretGoalsAttacks, TheOrderOfEqualRowsTellsNothing) {
  const Goals goals = draw_goals(1);
  for (const bool first_is_better : {true, false}) {
    Target target(goals, std::string(kEnds) + R"(, "step": 0.1)");
    // One success of sixty more or less is no difference of 0.1.
    Walks better{};
    Walks worse{};
    for (std::size_t path = 0; path < 31; ++path) {
      better[path].end = kNearest + goals[path];
      if (path > 0) worse[path].end = kNearest + goals[path];
    }
    target.submit(target.served().team("A"), first_is_better ? better : worse, "m");
    target.submit(target.served().team("B"), first_is_better ? worse : better, "m");
    target.end();
    const json rows = target.served().json("/api/v1/leaderboards/test").at("rows");
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0].at("means").at("spl"), rows[1].at("means").at("spl"));
    EXPECT_EQ(rows[0].at("team"), "A");
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
