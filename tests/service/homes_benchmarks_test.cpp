// The test split of each benchmark that homes have, by the program alone: an agent's results are
// served, handed in and scored against `hidden/`, as an organiser and a team do it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <chrono>
#include <filesystem>
#include <map>
#include <set>
#include <thread>

#include "enfilade/service/server.h"
#include "enfilade/tasks/benchmark.h"
#include "tests/service/program.h"
#include "tests/support/databases.h"
#include "tests/support/small_homes.h"

namespace enfilade::service {
namespace EN_UNIT {

namespace fs = std::filesystem;
using nlohmann::json;

/// A benchmark's test split, and the same with its goals.
struct TestSplit {
  const char* task;
  const char* goals;  ///< a file in secret/
};
// R4R has none: its paths are joined from two.
constexpr auto kTestSplits = std::to_array<TestSplit>({{"r2r", "R2R_test.json"},
                                                       {"r2r-last", "r2r-last/R2R_test.json"},
                                                       {"r2r-back", "r2r-back/R2R_test.json"},
                                                       {"rxr", "rxr/rxr_test_guide.jsonl"},
                                                       {"reverie", "reverie/REVERIE_test.json"},
                                                       {"cvdn", "cvdn/test_cleaned.json"},
                                                       {"soon", "soon/test.json"},
                                                       {"r2r-ce", "vlnce/test.json.gz"},
                                                       {"rxr-ce", "vlnce/test_guide.json.gz"}});

class HomesBenchmarks : public ::testing::Test {
 protected:
  /// data/, which everybody has; secret/, which the organiser has; whole/, the data with the goals,
  /// of which continuous episodes are made.
  HomesBenchmarks() {
    tests::write_small_homes(data_);
    fs::rename(data_ / "hidden", secret_);
    fs::copy(data_, whole_, fs::copy_options::recursive);
    constexpr auto kOver = fs::copy_options::overwrite_existing;
    fs::copy_file(secret_ / "R2R_test.json", whole_ / "r2r/R2R_test.json", kOver);
    fs::copy_file(secret_ / "rxr/rxr_test_guide.jsonl", whole_ / "rxr/rxr_test_guide.jsonl", kOver);
    for (const fs::path& folder : {data_, whole_}) {
      for (const char* task : {"r2r-ce", "rxr-ce"}) run({"continuous", folder, "--task", task});
    }
    fs::create_directory(secret_ / "vlnce");
    for (const char* file : {"vlnce/test.json.gz", "vlnce/test_guide.json.gz"}) {
      fs::copy_file(whole_ / file, secret_ / file);
    }
  }

  /// Expects that the program succeeds.
  void run(std::vector<std::string> words, const std::map<std::string, std::string>& more = {}) {
    const std::string what = fmt::format("{} {}", words[0], words[1]);
    words.insert(words.begin(), EN_PROGRAM);
    tests::Process process(words, root_ / "said", more, root_ / "errors");
    EXPECT_EQ(process.wait(), 0) << what << "\n" << read_file(root_ / "errors");
  }

  fs::path results(const TestSplit& of) const { return root_ / fmt::format("{}.json", of.task); }

  /// The means by `enfilade score`, with the goals.
  json score(const TestSplit& of) {
    const fs::path file = root_ / fmt::format("{}-score.json", of.task);
    std::vector<std::string> words{"score", results(of), "--task", of.task, "--json", file};
    if (tasks::benchmark(of.task).continuous()) {
      words.insert(words.end(), {"--data", whole_, "--split", "test"});
    } else {
      words.insert(words.end(), {"--data", data_, "--annotations", secret_ / of.goals});
    }
    run(words);
    return json::parse(read_file(file)).at("means");
  }

  tests::TemporaryFolder folder_{"homes_benchmarks"};
  fs::path root_ = folder_.path(), data_ = root_ / "data", secret_ = root_ / "secret",
           whole_ = root_ / "whole";
};

/// The rows of a phase, once it has one.
json rows_of(httplib::Client& client, const httplib::Headers& organiser, const char* phase) {
  const std::string target = fmt::format("/api/v1/leaderboards/{}", phase);
  json rows;
  for (int k = 0; k < 2000; ++k) {
    const auto answer = client.Get(target, organiser);
    if (!answer) continue;  // it has waited for long
    rows = json::parse(answer->body).value("rows", json::array());
    if (!rows.empty()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return rows;
}

TEST_F(HomesBenchmarks, AreRunServedSubmittedAndScored) {
  json phases = json::array();
  std::set<std::string> folders{"R2R_test.json", "fgr2r"};  // which is no benchmark
  for (const TestSplit& of : kTestSplits) {
    folders.insert(fs::path(of.goals).begin()->string());
    phases.push_back({{"name", of.task},
                      {"split", "test"},
                      {"task", of.task},
                      {"annotations", (secret_ / of.goals).string()},
                      {"scores", "hidden"}});
    // `score` compares continuous trajectories with the experts' too.
    for (const fs::path& experts : tasks::expert_places(tasks::benchmark(of.task), "test")) {
      if (fs::exists(whole_ / experts)) phases.back()["experts"] = (whole_ / experts).string();
    }
    run({"run", "--task", of.task, "--data", data_, "--split", "test", "--agent", "random", "-o",
         results(of)});
  }
  for (const auto& one : fs::directory_iterator(secret_)) {
    EXPECT_TRUE(folders.contains(one.path().filename().string())) << one.path() << ": no row";
  }
  write_file_atomically(root_ / "phases.json", json{{"phases", phases}}.dump());
  const std::string database = testing::new_database(root_ / "service.sqlite");
  const std::string token = create_team(database, "Ours");
  const httplib::Headers organiser{
      {"Authorization",
       "Bearer " + create_token(database, TokenRole::kOrganiser, "Ada", std::nullopt)}};
  testing::Program server(EN_PROGRAM, data_, database, {"--phases", root_ / "phases.json"});
  server.start();
  httplib::Client client("127.0.0.1", server.port());
  const std::string address = fmt::format("http://127.0.0.1:{}", server.port());
  for (const TestSplit& of : kTestSplits) {
    run({"submit", results(of), "--server", address, "--phase", of.task, "--method", "random"},
        {{"ENFILADE_TOKEN", token}});
    const json rows = rows_of(client, organiser, of.task);
    ASSERT_EQ(rows.size(), 1U) << of.task;
    const json means = score(of);
    for (const tasks::Measure& one : tasks::benchmark(of.task).scorers.front().columns) {
      // The API has shares, whatever the scorer prints.
      EXPECT_NEAR(rows[0].at("means").at(one.name).at("mean").get<double>() * one.whole,
                  means.at(one.name).at("mean").get<double>(), 1e-9)
          << of.task << " " << one.name;
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
