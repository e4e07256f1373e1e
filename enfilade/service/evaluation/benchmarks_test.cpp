// Phases of every benchmark, over real sockets: their files are checked and scored by the scorer of
// the phase, and leaderboards have its columns.
#include <gmock/gmock.h>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/scorer.h"
#include "tests/support/refusal.h"
#include "tests/support/served_benchmarks.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using namespace testing;  // NOLINT(google-build-using-namespace)
using tasks::Task;

/// \param fields more of them, in JSON
std::string phase_of(Task task, const std::string& fields = "") {
  const std::string_view name = tasks::benchmark(task).name;
  return fmt::format(
      R"({{"name": "{0}", "split": "test", "task": "{0}", "annotations": "secret-{0}.json"{1}}})",
      name, fields);
}

class Benchmarks : public ::testing::Test {
 protected:
  void serve(const std::string& phases) {
    write_benchmarks(served_.root(), {});
    served_.restart_with(phases);
    organiser_ = served_.organiser();
    team_ = served_.team("A");
  }
  /// The organisers' view of a submission when it is scored.
  json score(Task task, const std::string& results, const std::string& method = "m") {
    const auto taken =
        served_.submit(team_, std::string(tasks::benchmark(task).name), results, method);
    EXPECT_EQ(taken->status, 202) << taken->body;
    if (taken->status != 202) return {};
    return served_.scored(organiser_, json::parse(taken->body).at("id").get<std::int64_t>());
  }
  json leaderboard(Task task) {
    return served_.json("/api/v1/leaderboards/" + std::string(tasks::benchmark(task).name),
                        organiser_);
  }

  Served served_;
  httplib::Headers organiser_, team_;
};

TEST_F(Benchmarks, EachIsScoredWithColumnsOfItsOwn) {
  std::string phases;
  for (const Task task : kOtherTasks) phases += (phases.empty() ? "" : ", ") + phase_of(task);
  serve(phases);
  for (const Task task : kOtherTasks) {
    const json scored = score(task, benchmark_results(task, 2));
    EXPECT_EQ(scored.at("state"), "scored") << scored;
    const json board = leaderboard(task);
    EXPECT_EQ(board.at("task"), tasks::benchmark(task).name);
    EXPECT_EQ(board.at("primary"), tasks::benchmark(task).headline().name);
    std::vector<std::string> names;
    for (const json& column : board.at("columns"))
      names.push_back(column.at("name").get<std::string>());
    std::vector<std::string> expected;
    for (const tasks::Measure& measure : tasks::benchmark(task).scorers.front().columns)
      expected.emplace_back(measure.name);
    EXPECT_EQ(names, expected) << tasks::benchmark(task).name;
    const json& means = board.at("rows").at(0).at("means");
    EXPECT_EQ(means.size(), names.size()) << means;
    // Each agent here walks the reference path, and says what is true.
    const double best = task == Task::kCvdn ? 2 : 1;
    EXPECT_NEAR(means.at(names.front()).at("mean").get<double>(), best, 1e-12)
        << tasks::benchmark(task).name << means;
  }
}

TEST_F(Benchmarks, ReverieAsksForTheObjectAndRanksByIt) {
  serve(phase_of(Task::kReverie));
  score(Task::kReverie, benchmark_results(Task::kReverie, 2, {.object = 63}), "walks");
  score(Task::kReverie, benchmark_results(Task::kReverie, 0), "names");
  const json board = leaderboard(Task::kReverie);
  const json& rows = board.at("rows");
  ASSERT_EQ(rows.size(), 1U);  // of one team
  // Who stays at v0 does not see the object, and has named it all the same; the way there is 0 m
  // long, so RGSPL is 1.
  EXPECT_EQ(rows[0].at("method"), "names");
  const json& means = rows[0].at("means");
  EXPECT_EQ(means.at("rgspl").at("mean"), 1.0);
  EXPECT_EQ(means.at("rgs").at("mean"), 1.0);
  EXPECT_EQ(means.at("success_rate").at("mean"), 0.5);  // v1 sees all objects
  const json all = served_.json("/api/v1/leaderboards/reverie?all=1", organiser_).at("rows");
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[1].at("means").at("rgs").at("mean"), 0.0);
  EXPECT_EQ(all[1].at("means").at("success_rate").at("mean"), 1.0);
  const std::string csv = served_.get("/api/v1/leaderboards/reverie?format=csv", organiser_)->body;
  EXPECT_THAT(csv, HasSubstr("team,method,created,rgspl,rgspl_low,rgspl_high,rgs,"));
  EXPECT_THAT(csv, Not(HasSubstr("ndtw")));
}

TEST_F(Benchmarks, FaultsOfAFileAreThoseOfItsBenchmark) {
  serve(phase_of(Task::kReverie));
  const auto refused = served_.submit(team_, "reverie", benchmark_results(Task::kR2rLast, 2));
  EXPECT_EQ(refused->status, 422);
  EXPECT_THAT(refused->body, HasSubstr("neither predObjId nor pred_objid"));
}

TEST_F(Benchmarks, SharesAreFromZeroToOneWhateverTheScorerPrints) {
  serve(phase_of(Task::kReverie, R"(, "scorer": "duet", "primary": "sr")"));
  const json means = score(Task::kReverie, benchmark_results(Task::kReverie, 0)).at("means");
  EXPECT_EQ(means.at("sr").at("mean"), 0.5);
  EXPECT_LE(means.at("sr").at("high").get<double>(), 1.0);
  EXPECT_EQ(means.at("lengths").at("mean"), 0.0);
  EXPECT_EQ(leaderboard(Task::kReverie).at("scorer"), "duet");
}

TEST_F(Benchmarks, AChangedScorerLeavesOldScoresOut) {
  serve(phase_of(Task::kReverie));
  const json scored = score(Task::kReverie, benchmark_results(Task::kReverie, 2));
  served_.restart_with(phase_of(Task::kReverie, R"(, "scorer": "hamt")"));
  EXPECT_EQ(leaderboard(Task::kReverie).at("rows").size(), 0U);
  const json now = served_.json("/api/v1/submissions/" + scored.at("id").dump(), organiser_);
  EXPECT_EQ(now.at("withheld"), "other-scorer");
  EXPECT_FALSE(now.contains("means"));
}

TEST_F(Benchmarks, ALadderOfProgressIsInMetres) {
  serve(phase_of(Task::kCvdn, R"(, "scores": "ladder", "step": 0.1)"));
  const auto told = [this](std::size_t moves) {
    const json scored = score(Task::kCvdn, benchmark_results(Task::kCvdn, moves));
    return served_.json("/api/v1/submissions/" + scored.at("id").dump(), team_);
  };
  const json shown{{"dist_to_end_reduction", {{"mean", 0.0}}}};
  EXPECT_EQ(told(0).at("means"), shown);
  EXPECT_EQ(told(1).at("means").at("dist_to_end_reduction").at("mean"), 1.0);
  EXPECT_EQ(told(2).at("means").at("dist_to_end_reduction").at("mean"), 2.0);
  EXPECT_EQ(told(3).at("withheld"), "no-improvement");  // past the region, 1 m of progress
  const json phase = served_.json("/api/v1/phases").at("phases").at(0);
  EXPECT_EQ(phase.at("task"), "cvdn");
  EXPECT_EQ(phase.at("primary"), "dist_to_end_reduction");
}

TEST_F(Benchmarks, AnswersCountForNearCopies) {
  serve(phase_of(Task::kReverie));
  score(Task::kReverie, benchmark_results(Task::kReverie, 2), "first");
  auto results = json::parse(benchmark_results(Task::kReverie, 2));
  results[3]["predObjId"] = 69;
  const json near = score(Task::kReverie, results.dump(), "nearly");
  EXPECT_EQ(near.at("near_copy").at("differing"), 1);
  EXPECT_FALSE(score(Task::kReverie, benchmark_results(Task::kReverie, 2, {.object = 65}), "apart")
                   .contains("near_copy"));
}

/// Everything that a visitor can ask for of the splits.
std::string everything(Served& served) {
  std::string all = served.get("/api/v1/phases")->body + served.get("/api/v1/splits")->body +
                    served.get("/api/v1/splits/test/episodes")->body;
  for (const Task task : kOtherTasks) {
    const std::string query = "?task=" + std::string(tasks::benchmark(task).name);
    all += served.get("/api/v1/splits" + query)->body;
    all += served.get("/api/v1/splits/test/episodes" + query)->body;
  }
  return all;
}

/// What a team is told of a file for each phase, before the end.
std::string told_to_team(Served& served) {
  const auto team = served.team("A");
  std::string told;
  for (const Task task : kOtherTasks) {
    const auto taken = served.submit(team, std::string(tasks::benchmark(task).name),
                                     benchmark_results(task, 1, {.object = 62}));
    told += taken->body;
    const json id = json::parse(taken->body).value("id", json());
    if (!id.is_null()) told += served.scored(team, id.get<std::int64_t>()).dump();
  }
  return told;
}

// Object ids, regions, boxes, turning points, paths: what is told is the same to the byte whatever
// they are, also where the data set has them by mistake.
TEST(SecretGoalsOfBenchmarks, NothingDependsOnThem) {
  std::string phases;
  for (const Task task : kOtherTasks) phases += (phases.empty() ? "" : ", ") + phase_of(task);
  std::set<std::string> told;
  std::set<std::string> shown;
  for (const HiddenThings goal : {HiddenThings{0, 0}, HiddenThings{1, 3}}) {
    for (const bool mistaken : {false, true}) {
      ServerConfig config;
      config.clock = [] { return std::int64_t{1'000'000}; };
      Served served(config);
      write_benchmarks(served.root(), goal, mistaken);
      served.restart_with(phases);
      shown.insert(everything(served));
      told.insert(told_to_team(served));
    }
  }
  // Entries of REVERIE have another path_id where the goal is there: two sets of answers.
  EXPECT_EQ(shown.size(), 2U);
  EXPECT_EQ(told.size(), 1U);
  for (const std::string& text : shown) {
    for (const char* secret : {"\"v3\"", "\"v4\"", "\"6", "_60", "_61", "_63", "_64", "\"path\"",
                               "midstop", "objId", "bboxes", "end_panos"}) {
      EXPECT_THAT(text, Not(HasSubstr(secret)));
    }
    EXPECT_THAT(text, HasSubstr("Walk to the vase."));
  }
}

// R2R's split of the same name has the same paths.
TEST(SecretGoalsOfBenchmarks, HideThePathsOfR2rToo) {
  Served served;
  write_benchmarks(served.root(), {});
  write_file_atomically(served.root() / "data/r2r/R2R_test.json",
                        to_json(row_annotations("test", true)));
  served.restart_with(phase_of(Task::kCvdn));
  EXPECT_THAT(served.get("/api/v1/splits/test/episodes")->body, HasSubstr("\"path\""));
  EXPECT_EQ(served.get("/api/v1/splits/test/episodes?task=r4r")->status, 200);
  served.restart_with(phase_of(Task::kReverie));
  EXPECT_THAT(served.get("/api/v1/splits/test/episodes")->body, Not(HasSubstr("\"path\"")));
  EXPECT_EQ(served.get("/api/v1/splits/test/episodes?task=r4r")->status, 404)
      << "its joined texts tell where paths of R2R end";
}

/// What `serve` says of a phase whose goals have another split, or which has no public file.
TEST(SecretGoalsOfBenchmarks, EpisodesAreThoseOfThePublicFile) {
  Served served;
  write_benchmarks(served.root(), {});
  const auto said = [&served](const std::string& phase) {
    served.stop();
    return tests::refusal<InvalidInput>([&] { served.restart_with(phase); });
  };
  for (const Task task : kOtherTasks) {
    const std::string_view name = tasks::benchmark(task).name;
    const auto file = served.root() / fmt::format("secret-{}.json", name);
    const std::string whole = read_file(file);
    EXPECT_EQ(said(phase_of(task)), "accepted") << name;
    // The same episodes but for the first one's id.
    std::string other = whole;
    const std::string id = task == Task::kSoon      ? R"("4-1")"
                           : task == Task::kCvdn    ? R"("inst_idx":1)"
                           : task == Task::kRxr     ? R"("instruction_id":1)"
                           : task == Task::kReverie ? R"("id":"1")"
                                                    : R"("path_id":1)";
    const std::size_t at = other.find(id);
    ASSERT_NE(at, std::string::npos) << name << whole;
    other.insert(at + id.find('1'), "7");
    write_file_atomically(file, other);
    const std::string fault = said(phase_of(task));
    EXPECT_THAT(fault, HasSubstr("[ids-differ]")) << name;
    EXPECT_THAT(fault, HasSubstr("only here, such as \"")) << name;
    EXPECT_THAT(fault, HasSubstr("only there, such as \"")) << name;
    write_file_atomically(file, whole);
    std::filesystem::remove(served.root() / "data" /
                            tasks::episode_places(tasks::benchmark(task), "test").front());
    EXPECT_THAT(said(phase_of(task)), HasSubstr("[no-public-file]")) << name;
  }
}

TEST(SecretGoalsOfBenchmarks, TheTestSplitOfCvdnHasOneName) {
  Served served;
  write_benchmarks(served.root(), {});
  const auto folder = served.root() / "data/cvdn";
  std::filesystem::rename(folder / "test.json", folder / "test_cleaned.json");
  const auto phase = [](const char* split) {
    return fmt::format(
        R"({{"name": "a", "split": "{}", "task": "cvdn", "annotations": "secret-cvdn.json"}})",
        split);
  };
  for (const char* split : {"test", "test_cleaned"}) {
    served.restart_with(phase(split));
    const json splits = served.json("/api/v1/splits?task=cvdn").at("splits");
    ASSERT_EQ(splits.size(), 1U) << splits;
    EXPECT_EQ(splits[0].at("split"), "test");
    for (const char* asked : {"test", "test_cleaned"}) {
      EXPECT_EQ(served.get(fmt::format("/api/v1/splits/{}/episodes?task=cvdn", asked))->status,
                200);
    }
  }
}

TEST(SecretGoalsOfBenchmarks, IdsThatNameTheObjectAreRefused) {
  Served served;
  write_benchmarks(served.root(), {});
  served.stop();
  write_file_atomically(served.root() / "secret-reverie.json",
                        R"([{"id": "7_66", "path_id": 7, "objId": 66, "scan": "row", "heading": 1,
           "path": ["v0", "v1"], "instructions": ["Go."]}])");
  const std::string said =
      tests::refusal<InvalidInput>([&] { served.restart_with(phase_of(Task::kReverie)); });
  EXPECT_THAT(said, HasSubstr("$[0].id: \"7_66\" names the object that is secret"));
  write_file_atomically(served.root() / "secret-reverie.json",
                        R"({"instr_id": "7_66_0", "scan": "row", "heading": 1, "objid": "66", )"
                        R"("path": ["v0", "v1"], "pos_vps": ["v1"], "instruction": "Go."})"
                        "\n");
  const std::string of_lines =
      tests::refusal<InvalidInput>([&] { served.restart_with(phase_of(Task::kReverie)); });
  EXPECT_THAT(of_lines, HasSubstr("$[0].id: \"7_66_0\" names the object that is secret"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
