#include "enfilade/service/phases.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <optional>
#include <string>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Phases, AreReadWithTheirDefaults) {
  const auto phases = parse_phases(
      R"({"phases": [{"name": "val", "split": "val_unseen"},
                     {"name": "test", "title": "Test", "split": "test", "annotations": "a.json",
                      "scores": "hidden", "per_day": 3},
                     {"name": "next", "split": "test", "annotations": "a.json"}]})",
      "phases.json");
  ASSERT_EQ(phases.size(), 3U);
  EXPECT_EQ(phases[0].title, "val");
  EXPECT_EQ(phases[0].scores, Scores::kPublic);
  EXPECT_FALSE(phases[0].goals_secret());
  EXPECT_EQ(phases[0].per_day, 10);
  EXPECT_EQ(phases[0].per_address_day, 50);
  EXPECT_EQ(phases[0].per_team, std::nullopt);
  EXPECT_EQ(phases[0].per_address, std::nullopt);
  EXPECT_EQ(phases[0].ends, std::nullopt);
  EXPECT_EQ(phases[1].scores, Scores::kHidden);
  EXPECT_EQ(phases[1].per_day, 3);
  EXPECT_EQ(phases[1].per_address_day, 15);
  EXPECT_TRUE(phases[1].goals_secret());
  EXPECT_EQ(phases[2].scores, Scores::kAfterEnd);
  EXPECT_EQ(phases[2].benchmark->task, tasks::Task::kR2r);
  EXPECT_EQ(phases[2].scorer->name, "enfilade");
  EXPECT_EQ(phases[2].primary, "spl");
  EXPECT_EQ(phases[2].step, 0.01);
  EXPECT_EQ(phases[2].per_team, 20);
  EXPECT_EQ(phases[2].per_address, 100);
  EXPECT_EQ(phases[2].teams, 20);
}

TEST(Phases, MayBePacked) {
  const tests::TemporaryFolder folder("phases");
  write_file_atomically(folder.path() / "phases.json.gz",
                        gzip(R"({"phases": [{"name": "val", "split": "val_unseen"}]})", 6));
  EXPECT_EQ(load_phases(folder.path() / "phases.json").size(), 1U);
}

TEST(Phases, HaveRulesForSecretGoals) {
  const auto phases = parse_phases(
      R"({"phases": [{"name": "test", "split": "test", "annotations": "a.json", "scores": "ladder",
                      "primary": "success", "step": 0.05, "ends": "2027-03-31T23:59:59Z",
                      "per_team": 7, "per_address_day": 8, "per_address": 9, "teams": 3}]})",
      "phases.json");
  ASSERT_EQ(phases.size(), 1U);
  EXPECT_EQ(phases[0].scores, Scores::kLadder);
  EXPECT_EQ(phases[0].primary, "success");
  EXPECT_EQ(phases[0].step, 0.05);
  EXPECT_EQ(phases[0].ends, 1'806'537'599);  // date -u -d 2027-03-31T23:59:59Z +%s
  EXPECT_EQ(phases[0].per_team, 7);
  EXPECT_EQ(phases[0].per_address_day, 8);
  EXPECT_EQ(phases[0].per_address, 9);
  EXPECT_EQ(phases[0].teams, 3);
}

TEST(Phases, AreOfAnyBenchmark) {
  const auto phases = parse_phases(
      R"({"phases": [{"name": "a", "split": "test", "task": "reverie", "annotations": "a.json"},
                     {"name": "b", "split": "test", "task": "cvdn", "scorer": "hamt"},
                     {"name": "c", "split": "test", "task": "r2r", "scorer": "duet",
                      "annotations": "r.json", "primary": "oracle_sr"}]})",
      "phases.json");
  ASSERT_EQ(phases.size(), 3U);
  EXPECT_EQ(phases[0].benchmark->task, tasks::Task::kReverie);
  EXPECT_EQ(phases[0].scorer->name, "official");
  EXPECT_EQ(phases[0].primary, "rgspl");
  EXPECT_EQ(phases[1].primary, "gp");
  EXPECT_EQ(phases[1].measures().size(), 5U);
  EXPECT_EQ(phases[2].primary, "oracle_sr");
  EXPECT_STREQ(phases[2].primary_measure().column, "OSR");
}

TEST(Phases, HaveTextsForPeople) {
  const auto phases = parse_phases(
      R"({"phases": [{"name": "val", "split": "val_unseen", "rules": "# Rules\n\n1. *One* model."}]})",
      "phases.json");
  ASSERT_EQ(phases.size(), 1U);
  EXPECT_EQ(phases[0].rules, "# Rules\n\n1. *One* model.");
}

std::string fault_of(const std::string& entries) {
  return tests::refusal<InvalidInput>(
      [&] { parse_phases(R"({"phases": [)" + entries + "]}", "phases.json"); });
}

TEST(Phases, EveryFaultIsNamedWithItsPath) {
  const std::string said = fault_of(
      R"({"name": "Val!", "split": "x"}, {"split": "x"},
         {"name": "a", "split": "b", "scores": "secret"}, {"name": "b", "split": "b", "per_day": 0},
         {"name": "c", "split": "b"}, {"name": "c", "split": "b"})");
  EXPECT_THAT(said, HasSubstr("phases.json: $.phases[0].name: \"Val!\", not 1 to 40 of a-z"));
  EXPECT_THAT(said, HasSubstr("$.phases[1]"));
  EXPECT_THAT(said, HasSubstr("$.phases[2].scores: \"secret\", not \"public\", \"after-end\", "
                              "\"ladder\" or \"hidden\""));
  EXPECT_THAT(said, HasSubstr("$.phases[3].per_day: 0, not from 1 to 1000"));
  EXPECT_THAT(said, HasSubstr("$.phases[5]: \"c\" is there twice"));
}

TEST(Phases, MisspelledFieldsAreNamedWithTheNearestRightOne) {
  const std::string said =
      fault_of(R"({"name": "a", "split": "test", "annotations": "a.json", "per_taem": 1, "team": 1,
                   "socres": "hidden", "endss": "2027-03-31T23:59:59Z", "comment": ""},
                  {"name": "b", "split": "b"})");
  for (const auto& [wrong, right] : {std::pair("per_taem", "per_team"),
                                     {"team", "teams"},
                                     {"socres", "scores"},
                                     {"endss", "ends"}}) {
    EXPECT_THAT(said, HasSubstr(fmt::format("$.phases[0]: unknown field \"{}\"; the nearest is "
                                            "\"{}\" [unknown-field]",
                                            wrong, right)));
  }
  EXPECT_THAT(fault_of(R"({"name": "a", "split": "b", "score": "hidden"})"),
              HasSubstr("unknown field \"score\"; the nearest are \"scorer\", \"scores\""));
  EXPECT_THAT(said, HasSubstr("unknown field \"comment\"; allowed are name, split, title, rules"));
  EXPECT_THAT(tests::refusal<InvalidInput>([] { parse_phases(R"({"phase": []})", "phases.json"); }),
              HasSubstr("$: unknown field \"phase\"; the nearest is \"phases\""));
}

TEST(Phases, AMisspelledFieldIsTheOnlyReasonGiven) {
  const std::string said = fault_of(
      R"({"name": "a", "split": "test", "annotation": "a.json", "scores": "ladder", "step": 0.1})");
  EXPECT_THAT(said, HasSubstr("unknown field \"annotation\"; the nearest is \"annotations\""));
  EXPECT_THAT(said, Not(HasSubstr("secret goals")));
}

TEST(Phases, FieldsForSecretGoalsAreNotForOpenOnes) {
  const std::string said = fault_of(R"({"name": "a", "split": "b", "step": 0.1, "teams": 3})");
  EXPECT_THAT(said, HasSubstr("$.phases[0].step: this is for secret goals, and the phase has no "
                              "\"annotations\" of its own [field-without-use]"));
  EXPECT_THAT(said, HasSubstr("$.phases[0].teams: this is for secret goals"));
}

TEST(Phases, AreAHundredAtMost) {
  const auto many = [](std::size_t count) {
    std::string list;
    for (std::size_t k = 0; k < count; ++k) {
      list += fmt::format(R"({}{{"name": "p{}", "split": "b"}})", k == 0 ? "" : ", ", k);
    }
    return list;
  };
  EXPECT_EQ(parse_phases(R"({"phases": [)" + many(100) + "]}", "phases.json").size(), 100U);
  EXPECT_THAT(fault_of(many(101)), HasSubstr("$.phases: 101 phases; 100 are allowed [too-many]"));
  EXPECT_THAT(fault_of(many(100'000)),
              HasSubstr("$: more than 4000 values and keys; 100 phases are allowed [too-large]"));
}

TEST(Phases, NamesAreIds) {
  EXPECT_THAT(fault_of(R"({"name": "-a", "split": "--help"})"),
              AllOf(HasSubstr("$.phases[0].name: \"-a\" is not an id"),
                    HasSubstr("$.phases[0].split: \"--help\" is not an id")));
}

TEST(Phases, ASplitOfTwoNamesHasOne) {
  const auto phases = parse_phases(
      R"({"phases": [{"name": "a", "split": "test_cleaned", "task": "cvdn"},
                     {"name": "b", "split": "test_cleaned", "task": "r2r"}]})",
      "phases.json");
  EXPECT_EQ(phases[0].split, "test");
  EXPECT_EQ(phases[1].split, "test_cleaned");
  EXPECT_THAT(fault_of(R"({"name": "a", "split": "test", "task": "cvdn"},
                {"name": "b", "split": "test_cleaned", "task": "cvdn", "annotations": "a.json"})"),
              HasSubstr("\"test\" has secret goals in phase \"b\""));
}

TEST(Phases, RulesForSecretGoalsAreChecked) {
  const std::string said = fault_of(
      R"({"name": "d", "split": "b", "step": 0.6, "ends": "2027-02-29T00:00:00Z", "per_team": 0,
          "primary": "tl", "teams": 0, "per_address_day": 0, "per_address": 1.5})");
  EXPECT_THAT(said, HasSubstr("$.phases[0].step: 0.6, not from 0.001 to 0.5"));
  EXPECT_THAT(said, HasSubstr("$.phases[0].ends: \"2027-02-29T00:00:00Z\", not a time in UTC"));
  EXPECT_THAT(said, HasSubstr("$.phases[0].per_team: 0, not from 1 to"));
  EXPECT_THAT(said,
              HasSubstr("$.phases[0].primary: \"tl\", not one of spl, success, oracle_success, "
                        "ndtw_collapsed, sdtw_collapsed, cls"));
  EXPECT_THAT(said, HasSubstr("$.phases[0].teams: 0"));
  EXPECT_THAT(said, HasSubstr("$.phases[0].per_address_day: 0"));
  EXPECT_THAT(said, HasSubstr("$.phases[0].per_address"));
}

TEST(Phases, TasksAndScorersAreThoseThatThereAre) {
  const std::string said = fault_of(
      R"({"name": "a", "split": "b", "task": "alfred"},
         {"name": "c", "split": "b", "task": "soon", "scorer": "hamt"},
         {"name": "d", "split": "b", "task": "soon", "primary": "nav_error"},
         {"name": "e", "split": "b", "task": 7})");
  EXPECT_THAT(said, HasSubstr("$.phases[0].task: \"alfred\", not one of r2r, r2r-last, r2r-back, "
                              "r4r, rxr, reverie, cvdn, soon"));
  EXPECT_THAT(said, HasSubstr("$.phases[1].scorer: \"hamt\", not one of duet, official"));
  EXPECT_THAT(said, HasSubstr("$.phases[2].primary: \"nav_error\", not one of det_spl, det_sr"));
  EXPECT_THAT(said, HasSubstr("$.phases[3].task"));
}

TEST(Phases, PublicScoresOfSecretGoalsAreRefused) {
  const std::string said =
      fault_of(R"({"name": "a", "split": "test", "annotations": "a.json", "scores": "public"})");
  EXPECT_THAT(said, HasSubstr("$.phases[0].scores: \"public\" scores would tell where"));
  EXPECT_THAT(said, HasSubstr("write \"after-end\""));
  EXPECT_THAT(fault_of(R"({"name": "a", "split": "test", "scores": "ladder"})"),
              HasSubstr("$.phases[0].scores: this is for secret goals"));
}

TEST(Phases, GoalsAreNotSecretInOnePhaseAndOpenInAnother) {
  EXPECT_THAT(fault_of(R"({"name": "a", "split": "test"},
                          {"name": "b", "split": "test", "annotations": "a.json"})"),
              HasSubstr("$.phases[0].split: \"test\" has secret goals in phase \"b\""));
  // REVERIE's paths are R2R's; CVDN's are not.
  EXPECT_THAT(fault_of(R"({"name": "a", "split": "test"},
                  {"name": "b", "split": "test", "task": "reverie", "annotations": "a.json"})"),
              HasSubstr("$.phases[0].split: \"test\" has secret goals in phase \"b\""));
  EXPECT_NO_THROW(parse_phases(
      R"({"phases": [{"name": "a", "split": "test"},
                     {"name": "b", "split": "test", "task": "cvdn", "annotations": "a.json"}]})",
      "phases.json"));
}

TEST(Phases, TimesAreOfOneForm) {
  for (const char* time : {"2027-03-31", "2027-03-31T23:59:59", "2027-03-31T23:59:59+01:00",
                           "2027-03-31T24:00:00Z", "2027-13-01T00:00:00Z", "2027-03-31t23:59:59Z",
                           "2027-03-31T23:59:60Z", "+027-03-31T23:59:59Z", ""}) {
    EXPECT_THAT(fault_of(std::string(R"({"name": "a", "split": "b", "ends": ")") + time + "\"}"),
                HasSubstr("$.phases[0].ends"))
        << time;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
