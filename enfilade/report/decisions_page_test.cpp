// The page of agents that choose among viewpoints: maps, probabilities, agents side by side.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/models/decisions.h"
#include "enfilade/report/parts/gallery.h"
#include "enfilade/report/parts/page.h"
#include "enfilade/report/report.h"
#include "tests/support/made_run.h"
#include "tests/support/page.h"

namespace enfilade::report {
namespace EN_UNIT {

using models::DecisionStep;
using models::EpisodeDecisions;
using testing::data_of;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::occurrences;

// From v0 to v1, whence it could go on; stops at v1 and goes back to v0, where stop was likelier.
EpisodeDecisions duet_walk(const std::string& word) {
  DecisionStep first{.viewpoint = "v0",
                     .heading = 1.5,
                     .attention = {},
                     .choices = {{"", 0.25, 0.5, 0.125}, {"v1", 0.75, 0.5, 0.875}},
                     .chosen = 1,
                     .way = {"v1"},
                     .map_share = 0.4,
                     .nodes = {{"v0", true, 0.25}, {"v1", false, {}}},
                     .object = {}};
  DecisionStep second = first;
  second.viewpoint = "v1";
  second.choices = {{"", 0.9, 0.8, 0.95}, {"v2", 0.1, 0.2, 0.05}};
  second.chosen = 0;
  second.way.clear();
  second.nodes = {{"v0", true, 0.25}, {"v1", true, 0.9}, {"v2", false, {}}};
  second.object = "66";
  return {"duet", {word, "on"}, {first, second}};
}

// With attention to its two words; jumps from v0 to v2 at once, which is no neighbour.
EpisodeDecisions panoramic_walk() {
  const DecisionStep step{.viewpoint = "v0",
                          .attention = {0.25, 0.75},
                          .choices = {{"", 0.4, {}, {}}, {"v2", 0.6, {}, {}}},
                          .chosen = 1,
                          .way = {},
                          .map_share = {},
                          .nodes = {},
                          .object = {}};
  return {"panoramic", {"walk", "on"}, {step}};
}

class DecisionsPage : public ::testing::Test {
 protected:
  void SetUp() override {
    if (parts::kD3.empty()) GTEST_SKIP() << "this build has no D3 (EN_WITH_D3 is OFF)";
    made_.write_pictures();
    made_.write_results(made_.run() / "results/random_val_unseen.json", 1);
    made_.write_model("student-1", 0);
    made_.write_attention("student-1", "val_unseen", "walk");
  }
  void write(const std::string& agent, const EpisodeDecisions& walk) const {
    made_.write_model(agent, 0);
    const std::vector<std::pair<std::string, EpisodeDecisions>> all{{"1_0", walk}, {"2_1", walk}};
    write_file_atomically(models_of(agent) / "results/val_unseen.attention.json",
                          models::decisions_json(all));
  }
  std::filesystem::path models_of(const std::string& agent) const {
    return made_.run() / "models" / agent;
  }
  std::string report() const {
    ReportConfig config;
    config.runs = {made_.run()};
    return make_report(config, dataset::Dataset(made_.data()));
  }
  testing::MadeRun made_;
};

TEST_F(DecisionsPage, IsOfTheAgentThatChoosesWithOthersBesideIt) {
  write("duet", duet_walk("walk"));
  write("duet-2", duet_walk("walk"));
  const nlohmann::json gallery = data_of(report())["gallery"];
  EXPECT_EQ(gallery["agent"], "duet");
  EXPECT_EQ(gallery["withAttention"], 2);
  ASSERT_EQ(gallery["episodes"].size(), 2U) << "those that were recorded";
  const nlohmann::json& episode = gallery["episodes"][0];
  EXPECT_FALSE(episode.contains("words")) << "it has no attention";
  const nlohmann::json& step = episode["steps"][0];
  EXPECT_EQ(step["action"], "go");
  EXPECT_EQ(step["share"], 0.4);
  EXPECT_EQ(step["choices"][0]["v"], nullptr);
  EXPECT_EQ(step["choices"][0]["view"], 0.125);
  EXPECT_EQ(step["choices"][1]["v"], 1);
  EXPECT_NEAR(step["choices"][1]["heading"].get<double>(), kPi / 2, 0.001) << "v1 lies east";
  EXPECT_EQ(step["nodes"][1], nlohmann::json::parse("[1, false, null]"));
  EXPECT_EQ(step["way"], nlohmann::json::parse("[1]"));
  EXPECT_EQ(step["frame"], nullptr) << "nothing is outlined; the panorama shows it all";
  EXPECT_TRUE(gallery["panoramas"].contains(step["panorama"].get<std::string>()));
  EXPECT_EQ(episode["steps"][1]["object"], "66");
  ASSERT_EQ(episode["others"].size(), 1U) << "another seed of it is not another agent";
  EXPECT_EQ(episode["others"][0]["agent"], "student-1");
  EXPECT_TRUE(episode["others"][0].contains("words") ||
              gallery["episodes"][1]["others"][0].contains("words"));
}

TEST_F(DecisionsPage, WithoutSuchAgentsNothingStandsBesideTheModel) {
  made_.write_model("teacher", 0);
  made_.write_attention("teacher", "val_unseen", "walk");
  const nlohmann::json gallery = data_of(report())["gallery"];
  EXPECT_EQ(gallery["agent"], "student-1");
  EXPECT_FALSE(gallery.contains("panoramas"));
  EXPECT_FALSE(gallery["episodes"][0].contains("others"));
  EXPECT_FALSE(gallery["episodes"][0]["steps"][0]["frame"].is_null());
}

TEST_F(DecisionsPage, AFileOfOtherDataIsRefused) {
  EpisodeDecisions walk = duet_walk("walk");
  walk.steps[1].nodes[2].viewpoint = "nowhere";
  write("duet", walk);
  EXPECT_THROW((void)report(), LookupError);
}

TEST_F(DecisionsPage, ABrowserDrawsMapsAndProbabilities) {
  const auto browser = testing::find_browser();
  if (!browser) GTEST_SKIP() << "no browser: chromium is not installed";
  write("duet", duet_walk("</script><b>walk"));
  write("panoramic", panoramic_walk());
  const std::filesystem::path page = made_.run() / "page.html";
  write_file_atomically(page, report());
  const std::string dom = testing::open_in_browser(*browser, page);
  EXPECT_THAT(dom, HasSubstr("data-ready=\"yes\""));
  EXPECT_THAT(dom, Not(HasSubstr("data-failures"))) << dom.substr(dom.find("id=\"failures\""), 500);
  for (const auto& [mark, least] : std::vector<std::pair<std::string, std::size_t>>{
           {"class=\"column\"", 3},         // DUET, panoramic, student
           {"class=\"panorama\"", 3},       // what is all around each
           {"class=\"candidate", 1},        // v1 from v0
           {"class=\"option", 2},           // on the maps
           {"class=\"visited\"", 2},        //
           {"class=\"open\"", 2},           //
           {"class=\"goes\"", 1},           //
           {"class=\"probability\"", 4},    // two choices of two agents
           {"class=\"fusion-bar\"", 1}}) {  // of DUET alone
    EXPECT_GE(occurrences(dom, mark), least) << mark;
  }
}

graph::NavGraph row() {
  return graph::NavGraph(graph::testing::connectivity(
      "row", {{0, 0, 1.5}, {2, 0, 1.5}, {4, 0, 1.5}, {6, 0, 1.5}}, {{0, 1}, {1, 2}, {2, 3}}));
}

TEST(Moments, SayHowAnEpisodeEnds) {
  const graph::NavGraph graph = row();
  const EpisodeDecisions walk = duet_walk("walk");
  tasks::Trajectory trajectory;
  trajectory.points = {{ViewpointIndex(0), {}, {}}, {ViewpointIndex(1), {}, {}}};
  auto moments = parts::moments_of(walk, graph, trajectory);
  ASSERT_EQ(moments.size(), 2U);
  EXPECT_EQ(moments[1].action, "end");
  trajectory.points.push_back({ViewpointIndex(0), {}, {}});
  moments = parts::moments_of(walk, graph, trajectory);
  ASSERT_EQ(moments.size(), 3U);
  EXPECT_EQ(moments[2].action, "back");
  EXPECT_EQ(moments[2].decision, nullptr);
  const EpisodeDecisions jump = panoramic_walk();
  trajectory.points.back().viewpoint = ViewpointIndex(2);
  moments = parts::moments_of(jump, graph, trajectory);
  ASSERT_EQ(moments.size(), 2U);
  EXPECT_EQ(moments[0].action, "jump") << "v2 is no neighbour";
  EXPECT_EQ(moments[1].action, "") << "out of steps";
  EXPECT_FALSE(parts::moment_json(moments[0], graph)["choices"][1].contains("heading"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::report
