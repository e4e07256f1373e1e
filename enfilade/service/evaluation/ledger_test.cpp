// The account of what was given away: by goals, whatever phases are called.
#include "enfilade/service/evaluation/ledger.h"

#include <gmock/gmock.h>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/evaluation/leakage.h"
#include "enfilade/service/store/database.h"
#include "tests/support/refusal.h"
#include "tests/support/served_data.h"

namespace enfilade::service::evaluation {
namespace EN_UNIT {

using nlohmann::json;
using service::testing::row_results;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int64_t kEnd = 2'000'000;  // the clock begins at 1,000,000
const double kOneOfALadder = std::log2(101);

class LedgerTest : public service::testing::ServedByAClock {
 protected:
  /// Serves one phase of the split test. \param fields more of them, in JSON
  void serve(const std::string& name, const std::string& fields) {
    served_.restart_with(R"({"split": "test", "annotations": "secret.json", "name": ")" + name +
                         '"' + fields + "}");
  }
  static std::string ends() { return R"(, "ends": ")" + detail::iso_time(kEnd) + '"'; }
  void submit(const std::string& team, const std::string& phase, std::size_t moves = 3) {
    const auto taken = served_.submit(served_.team(team), phase, row_results(moves));
    ASSERT_EQ(taken->status, 202) << taken->body;
    served_.scored(organiser_, json::parse(taken->body).at("id").get<std::int64_t>());
  }
  json leakage() {
    return served_.json("/api/v1/phases", organiser_).at("phases")[0].at("leakage");
  }
  double used() { return leakage().at("used_bits").get<double>(); }
};

constexpr const char* kLadder = R"(, "scores": "ladder")";

TEST_F(LedgerTest, ANewNameTakesNothingBack) {
  serve("test", kLadder);
  submit("A", "test");
  EXPECT_EQ(used(), std::ceil(kOneOfALadder));
  const double most = leakage().at("most_bits").get<double>();
  serve("again", kLadder);
  EXPECT_EQ(used(), std::ceil(kOneOfALadder));
  EXPECT_EQ(leakage().at("phases"), (json{"again", "test"}));
  EXPECT_NEAR(leakage().at("most_bits").get<double>(), most + kOneOfALadder, 1);
  submit("B", "again");
  EXPECT_EQ(used(), std::ceil(2 * kOneOfALadder));
  serve("test", kLadder);
  EXPECT_EQ(used(), std::ceil(2 * kOneOfALadder));
}

TEST_F(LedgerTest, RowsThatWereShownStayCounted) {
  serve("test", ends());
  submit("A", "test");
  now_ = kEnd;
  const double row = used();
  EXPECT_EQ(row, std::ceil(6 * std::log2(101) + std::log2(301)));
  serve("again", "");
  EXPECT_EQ(used(), row);
  // The same rows once more, rounded otherwise, tell more.
  serve("test", ends() + R"(, "step": 0.02)");
  EXPECT_EQ(used(),
            std::ceil(6 * std::log2(101) + std::log2(301) + 6 * std::log2(51) + std::log2(151)));
  serve("test", ends() + R"(, "scores": "hidden")");
  EXPECT_GT(used(), row);
}

TEST_F(LedgerTest, RowsThatNobodySawAreNotCounted) {
  serve("test", ends());
  submit("A", "test");
  now_ = kEnd;  // and nobody asks
  serve("again", "");
  EXPECT_EQ(used(), 0);
  EXPECT_EQ(leakage().at("phases"), json::array({"again"}));
}

TEST_F(LedgerTest, ScoresOfOlderProgramsCountAsOfTheRuleOfNow) {
  serve("test", kLadder);
  submit("A", "test");
  served_.stop();
  const std::string& database = served_.config().database;
  service::testing::run_sql(database, "UPDATE submission SET rule = NULL");
  service::testing::run_sql(database, "DELETE FROM phase_rule");
  serve("test", kLadder);
  EXPECT_EQ(used(), std::ceil(kOneOfALadder));
}

TEST_F(LedgerTest, WhatOlderProgramsShowedCountsWhereItIsHiddenNow) {
  serve("test", ends() + kLadder);
  submit("A", "test");
  now_ = kEnd;
  const double seen = used();
  EXPECT_GT(seen, std::ceil(kOneOfALadder));
  served_.stop();
  const std::string& database = served_.config().database;
  service::testing::run_sql(database, "UPDATE submission SET rule = NULL");
  service::testing::run_sql(database, "DELETE FROM phase_rule");
  serve("test", ends() + R"(, "scores": "hidden")");
  EXPECT_EQ(used(), seen);
}

TEST_F(LedgerTest, SubmissionsOfLargerLimitsCount) {
  const auto most = [this] { return leakage().at("most_bits").get<double>(); };
  serve("test", R"(, "scores": "hidden", "teams": 3)");
  const auto first = served_.team("first");
  EXPECT_EQ(served_.submit(first, "test", row_results(3))->status, 202);
  for (const char* team : {"A", "B"}) submit(team, "test");
  EXPECT_EQ(most(), 0);
  serve("test", R"(, "teams": 3)");
  const double of_three = most();
  serve("test", R"(, "teams": 1)");
  EXPECT_EQ(most(), of_three);
  serve("test", R"(, "teams": 4)");
  EXPECT_NEAR(most(), of_three * 4 / 3, 1);
  // Files that were taken beyond the limit of today.
  EXPECT_EQ(served_.submit(first, "test", row_results(2))->status, 202);
  serve("test", R"(, "teams": 3, "per_team": 1)");
  const double of_one = 6 * std::log2(101) + std::log2(301);
  EXPECT_EQ(most(), std::ceil(3 * of_one + std::log2(2)));
}

TEST_F(LedgerTest, OtherBenchmarksShareByTheirGoals) {
  const auto guides = [](bool with_goals) {
    std::string lines;
    for (const auto& one : service::testing::row_annotations("test", with_goals).paths) {
      lines += json{{"path_id", one.path_id},    {"instruction_id", one.path_id},
                    {"scan", one.scan},          {"heading", 1.5},
                    {"path", one.path},          {"language", "en-IN"},
                    {"instruction", "Walk on."}, {"timed_instruction", json::array()}}
                   .dump() +
               "\n";
    }
    return lines;
  };
  make_folder(served_.root() / "data/rxr");
  write_file_atomically(served_.root() / "data/rxr/rxr_other_guide.jsonl", guides(false));
  write_file_atomically(served_.root() / "guides.jsonl", guides(true));
  serve("test", std::string(kLadder) + R"(}, {"name": "guides", "task": "rxr", "split": "other",
    "annotations": "guides.jsonl", "scores": "ladder")");
  const json phases = served_.json("/api/v1/phases").at("phases");
  EXPECT_EQ(phases[0].at("leakage").at("phases"), (json{"test", "guides"}));
  EXPECT_EQ(phases[1].at("leakage").at("most_bits"), phases[0].at("leakage").at("most_bits"));
  EXPECT_EQ(phases[1].at("leakage").at("goal_bits"), 7);
}

TEST_F(LedgerTest, NearCopiesAreOfTheSameEpisodes) {
  for (const auto& [file, with_goals] :
       {std::pair("data/r2r/R2R_other.json", false), std::pair("other.json", true)}) {
    tasks::Annotations other = service::testing::row_annotations("test", with_goals);
    other.split = "other";
    write_file_atomically(served_.root() / file, to_json(other));
  }
  serve("test", R"(}, {"name": "other", "split": "other", "annotations": "other.json"},
    {"name": "again", "split": "test", "annotations": "secret.json")");
  for (const char* phase : {"test", "other", "again"}) submit(phase, phase);
  const json phases = served_.json("/api/v1/phases", organiser_).at("phases");
  EXPECT_EQ(phases[0].at("leakage").at("phases"), (json{"test", "other", "again"}));
  EXPECT_EQ(phases[1].at("near_copies"), 0);  // by another split, although goals are the same
  EXPECT_EQ(phases[2].at("near_copies"), 1);
}

TEST_F(LedgerTest, LimitsThatGiveTheGoalsAwayAreRefused) {
  serve("test", "");
  served_.stop();
  ServerConfig config = served_.config();
  config.accept_leak = false;
  std::vector<std::string> warned;
  config.warn = [&warned](std::string_view text) { warned.emplace_back(text); };
  const auto open = [&](const std::string& fields) {
    return tests::refusal<InvalidInput>([&] {
      write_file_atomically(served_.root() / "phases.json",
                            R"({"phases": [{"name": "test", "split": "test",
                                "annotations": "secret.json")" +
                                fields + "}]}");
      const Server server(
          Site::open(served_.root() / "data", load_phases(served_.root() / "phases.json")), config);
    });
  };
  EXPECT_THAT(open(""), AllOf(HasSubstr("phase test: its limits give away up to 1051 bits, and its "
                                        "goals have 7"),
                              HasSubstr("\"hidden\""), HasSubstr("\"teams\"")));
  // Seven bits: a row on the coarsest grid has 12 and more.
  EXPECT_EQ(open(R"(, "scores": "hidden")"), "accepted");
  EXPECT_THAT(warned, IsEmpty());
  config.accept_leak = true;
  EXPECT_EQ(open(""), "accepted");
  EXPECT_THAT(warned, ElementsAre(HasSubstr("1051 bits")));
  warned.clear();
  EXPECT_EQ(open(R"(}, {"name": "again", "split": "test", "annotations": "secret.json")"),
            "accepted");
  EXPECT_THAT(warned, ElementsAre(HasSubstr("phases test, again share goals")));
  // What was given away under another name counts too.
  config.accept_leak = false;
  serve("former", kLadder);
  submit("A", "former", 0);
  submit("B", "former", 3);
  served_.stop();
  EXPECT_THAT(open(R"(, "scores": "hidden")"),
              HasSubstr("phases test, former share goals: their limits give away up to 14 bits"));
}

TEST_F(LedgerTest, ARefusedServerLeavesNoRules) {
  served_.stop();
  store::Database db(served_.config().database);
  const auto rules = [&db] {
    return db.select<std::string>("SELECT phase FROM phase_rule ORDER BY phase");
  };
  ASSERT_THAT(rules(), ElementsAre("final", "test"));
  write_file_atomically(served_.root() / "phases.json",
                        R"({"phases": [{"name": "other", "split": "test",
                                        "annotations": "secret.json"}]})");
  const auto site =
      Site::open(served_.root() / "data", load_phases(served_.root() / "phases.json"));
  EXPECT_THAT(
      tests::refusal<InvalidInput>([&] { const Ledger ledger(*site, db, Leaks::kRefused); }),
      HasSubstr("[goals-given-away]"));
  EXPECT_THAT(rules(), ElementsAre("final", "test"));
  const Ledger ledger(*site, db, Leaks::kAccepted);
  EXPECT_THAT(rules(), ElementsAre("final", "other", "test"));
}

TEST_F(LedgerTest, RowsOfAnOlderProgramWithoutKnownGoalsAreTold) {
  served_.stop();
  service::testing::run_sql(served_.config().database,
                            "INSERT INTO phase_end (phase, at) VALUES ('old', 1)");
  ServerConfig config = served_.config();
  std::vector<std::string> warned;
  config.warn = [&warned](std::string_view text) { warned.emplace_back(text); };
  const Server server(Site::open(served_.root() / "data"), config);
  EXPECT_THAT(warned, ElementsAre(HasSubstr("rows of phase old")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service::evaluation
