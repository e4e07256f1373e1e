#include "enfilade/report/run_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/navigation_mesh.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/report/report.h"
#include "enfilade/report/results_table.h"
#include "tests/support/made_meshes.h"
#include "tests/support/made_run.h"

namespace enfilade::report {
namespace EN_UNIT {
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// The made-up graph data beside a room of 6 m by 4 m with two episodes of two trajectories.
class ScoredWalks : public ::testing::Test {
 protected:
  ScoredWalks() : data_(made_.data()) {
    const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(
        mesh::testing::Maker().room(0, 0, 6, 4).box({2.5F, 0, 0}, {3, 2.5F, 2.6F}).mesh));
    make_folder(made_.data() / "navmesh/r2r-ce");
    make_folder(made_.data() / "vlnce");
    continuous::save_navigation_mesh(mesh::make_floor_polygons(tracer),
                                     made_.data() / "navmesh/r2r-ce/room.navmesh");
    for (const std::int64_t id : {1, 2}) {
      tasks::ContinuousEpisode e;
      e.id = e.trajectory_id = id;
      e.scene = "mp3d/room/room.glb";
      e.start = {1, 1, 0};
      e.rotation = tasks::StartRotation::of(degrees(90));
      e.goals = {{{id == 1 ? 5.0 : 4.0, 1, 0}, 3}};
      e.instruction.text = "Walk around the <wall>.";
      e.reference_path = {{1, 1, 0}, {2.7, 3.2, 0}, e.goals->front().position};
      episodes_.episodes.push_back(e);
    }
    episodes_.split = "val_unseen";
    write("val_unseen", episodes_);
    tasks::ContinuousEpisodes hidden = episodes_;
    for (tasks::ContinuousEpisode& e : hidden.episodes) {
      e.goals.reset();
      e.reference_path.reset();
    }
    write("test", hidden);
  }

  void write(const std::string& split, const tasks::ContinuousEpisodes& episodes) const {
    write_file_atomically(made_.data() / "vlnce" / (split + ".json.gz"),
                          gzip(to_json(episodes), 6));
  }
  void run(const std::string& agent, const std::string& as, std::uint64_t seed = 1,
           const std::string& split = "val_unseen") const {
    const auto walker = agents::make_continuous_agent(agent);
    const auto walks = agents::run_continuous(
        *walker, episodes_,
        std::make_shared<const continuous::Buildings>(made_.data() / "navmesh/r2r-ce"),
        {.batch_size = 2,
         .seed = seed,
         .simulator = agents::continuous_setup(benchmark_).simulator});
    write_file_atomically(made_.run() / (as + "_" + split + ".json"),
                          to_json(walks, episodes_, tasks::ContinuousForm::kR2r));
  }
  RunDirectory found() const {
    return find_runs(std::vector<fs::path>{made_.run()}, data_, benchmark_);
  }

  testing::MadeRun made_;
  dataset::Dataset data_;
  tasks::ContinuousEpisodes episodes_;
  const tasks::Benchmark& benchmark_ = tasks::benchmark("r2r-ce");
};

TEST_F(ScoredWalks, HaveATableWithSeedsInOneRow) {
  run("shortest", "shortest");
  run("random", "random-1", 1);
  run("random", "random-2", 2);
  const ScoredRuns runs = score_runs(found(), data_);
  const ResultsTable table = make_table(runs, true);
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0].agent, "shortest");
  EXPECT_EQ(table.rows[0].episodes, 2U);
  EXPECT_THAT(table.rows[1].runs, ElementsAre("random-1", "random-2"));
  EXPECT_EQ(table.columns[2].metric, "success");
  EXPECT_EQ(table.rows[0].values[2].mean, 1);
  EXPECT_EQ(table.rows[0].values[2].mean, runs.runs[0].scores.ours.means[2].mean);
  const auto json = nlohmann::json::parse(to_json(table));
  EXPECT_EQ(json["task"], "r2r-ce");
  EXPECT_EQ(json["scorer"], "vln-ce");
  EXPECT_TRUE(json["synthetic"]);
  EXPECT_EQ(json["rows"][0]["success"]["mean"], 1.0);
  EXPECT_THAT(to_text(table), HasSubstr("SDTW"));
}

TEST_F(ScoredWalks, StandBesideResultsOfTheGraph) {
  run("shortest", "shortest");
  made_.write_results(made_.run() / "random_val_seen.json", 2);
  EXPECT_EQ(found().results.size(), 1U);
  const std::vector<fs::path> folder{made_.run()};
  const RunDirectory graph = find_runs(folder, data_);
  ASSERT_EQ(graph.results.size(), 1U);
  EXPECT_EQ(graph.results[0].agent, "random");
  // By names, results of the graph come first.
  EXPECT_EQ(find_benchmark_of_runs(folder), nullptr);
  fs::remove(made_.run() / "random_val_seen.json");
  EXPECT_EQ(find_benchmark_of_runs(folder), &benchmark_);
}

TEST_F(ScoredWalks, HiddenGoalsAreLeftOut) {
  run("shortest", "shortest", 1, "test");
  const ScoredRuns runs = score_runs(found(), data_);
  EXPECT_TRUE(runs.runs.empty());
  ASSERT_EQ(runs.left_out.size(), 1U);
  EXPECT_THAT(runs.left_out[0], HasSubstr("hidden"));
}

TEST_F(ScoredWalks, FaultsOfAFileAreNamed) {
  run("shortest", "shortest");
  const fs::path file = made_.run() / "shortest_val_unseen.json";
  std::string text = read_file(file);
  text.replace(text.find("\"position\""), 10, "\"place\"");
  write_file_atomically(file, text);
  try {
    score_runs(found(), data_);
    FAIL() << "a pose without a position was taken";
  } catch (const InvalidInput& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("position"));
  }
}

TEST_F(ScoredWalks, ReportHasMapsAndNoPartsOfTheGraph) {
  run("shortest", "shortest");
  run("random", "random");
  ReportConfig config;
  config.runs = {made_.run()};
  config.benchmark = &benchmark_;
  const std::string page = make_report(config, data_);
  for (const char* part : {"\"walks\"", "\"table\"", "\"errors\"", "data:image/svg+xml"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  EXPECT_EQ(page.find("\"gallery\":"), std::string::npos);
}

}  // namespace EN_UNIT
}  // namespace enfilade::report
