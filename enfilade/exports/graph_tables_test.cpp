#include "enfilade/exports/graph_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/graph/graph_set.h"
#include "tests/support/graphs.h"

namespace enfilade::exports {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::ElementsAre;

// v1 is 10 m east of v0 and 10 tan(5 deg) higher; v2 is south-west of it, 20 degrees from south;
// v3 is excluded.
std::shared_ptr<const graph::GraphSet> corner() {
  const double up = 10 * std::tan(kPi / 36);
  const double x = -10 * std::sin(kPi / 9);
  const double y = -10 * std::cos(kPi / 9);
  scan::Connectivity c = graph::testing::connectivity(
      "corner", {{0, 0, 1}, {10, 0, 1 + up}, {x, y, 1}, {1, 1, 1}}, {{0, 1}, {0, 2}, {0, 3}});
  c.entries[3].included = false;
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(c);
  graphs.emplace_back(graph::testing::square("square"));
  return graph::GraphSet::of(std::move(graphs));
}

TEST(GraphTables, DuetHasViewAndAnglesFromItsMiddle) {
  const json table = json::parse(duet_candidates(corner()));
  ASSERT_EQ(table.size(), 3U + 4U);
  const json& from = table.at("corner_v0");
  ASSERT_EQ(from.size(), 2U) << "excluded viewpoints are no candidates";
  // East is 90 degrees: heading step 3 of the level row, 12 + 3, five degrees above its middle.
  const json& east = from.at("v1");
  EXPECT_EQ(east.at(0), 15);
  EXPECT_NEAR(east.at(1).get<double>(), kPi / 36, 1e-6);
  EXPECT_NEAR(east.at(2).get<double>(), 0, 1e-6);
  EXPECT_NEAR(east.at(3).get<double>(), kPi / 36, 1e-6);
  // 200 degrees: nearest to the view at 210, 12 + 7, ten degrees left of its middle.
  const json& south = from.at("v2");
  EXPECT_EQ(south.at(0), 19);
  EXPECT_NEAR(south.at(1).get<double>(), kPi / 18, 1e-6);
  EXPECT_NEAR(south.at(2).get<double>(), -kPi / 18, 1e-6);
  EXPECT_NEAR(south.at(3).get<double>(), 0, 1e-6);
  EXPECT_TRUE(table.at("corner_v1").contains("v0"));
  EXPECT_FALSE(table.contains("corner_v3"));
}

TEST(GraphTables, LangNavHasWhatItsEnvironmentReads) {
  const json table = json::parse(langnav_adjacency(corner()));
  const json& from = table.at("corner_v0");
  ASSERT_EQ(from.size(), 2U) << "as many as the graph has neighbours";
  const json& east = from.at(0).at("viewpointId") == "v1" ? from.at(0) : from.at(1);
  EXPECT_EQ(east.at("scanId"), "corner");
  EXPECT_EQ(east.at("pointId"), 15);
  EXPECT_EQ(east.at("idx"), 1);
  EXPECT_NEAR(east.at("distance").get<double>(), kPi / 36, 1e-6);
  EXPECT_NEAR(east.at("normalized_heading").get<double>(), kPi / 2, 1e-6);
  EXPECT_EQ(east.at("heading"), east.at("normalized_heading"));
  EXPECT_NEAR(east.at("elevation").get<double>(), kPi / 36, 1e-6);
  EXPECT_FLOAT_EQ(east.at("position").at(0).get<float>(), 10);
}

TEST(GraphTables, NavGptHasWorldAnglesAndMetres) {
  const auto graphs = corner();
  const json table = json::parse(navgpt_navigable(graphs, ScanIndex(0)));
  ASSERT_EQ(table.size(), 3U);
  const json& south = table.at("v0").at("v2");
  EXPECT_NEAR(south.at("heading").get<double>(), 200 * kPi / 180, 1e-6);
  EXPECT_NEAR(south.at("elevation").get<double>(), 0, 1e-6);
  EXPECT_NEAR(south.at("distance").get<double>(), 10, 1e-5);
  // 20 degrees east of north, as seen from the other end.
  EXPECT_NEAR(table.at("v2").at("v0").at("heading").get<double>(), 20 * kPi / 180, 1e-6);
  EXPECT_EQ(json::parse(navgpt_navigable(graphs, ScanIndex(1))).size(), 4U);
}

TEST(GraphTables, GridMmHasPositions) {
  const json table = json::parse(gridmm_viewpoints(corner()));
  ASSERT_EQ(table.size(), 7U);
  EXPECT_EQ(table.at("square_v2"), json::parse(R"({"x": 2.0, "y": 2.0, "z": 1.5})"));
}

TEST(GraphTables, AViewpointWithoutNeighboursHasAnEmptyEntry) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::connectivity("s", {{0, 0, 0}}, {}));
  const auto set = graph::GraphSet::of(std::move(graphs));
  EXPECT_EQ(json::parse(duet_candidates(set)), json::parse(R"({"s_v0": {}})"));
  EXPECT_EQ(json::parse(langnav_adjacency(set)), json::parse(R"({"s_v0": []})"));
}

TEST(GraphTables, ThreadsChangeNothingAndProgressEndsAtTheTotal) {
  const auto graphs = corner();
  std::vector<std::size_t> seen;
  const std::string one = duet_candidates(graphs, {.threads = 1});
  const std::string two =
      duet_candidates(graphs, {.threads = 2, .progress = [&](std::size_t done, std::size_t total) {
                                 EXPECT_EQ(total, 2U);
                                 seen.push_back(done);
                               }});
  EXPECT_EQ(one, two);
  EXPECT_THAT(seen, ElementsAre(1, 2));
}

TEST(Networkx, DistancesAndPathsAreOfAllPairsInReach) {
  // A triangle with legs 3 and 4 in a row, and one viewpoint apart.
  const graph::NavGraph graph(graph::testing::connectivity(
      "s", {{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {9, 9, 0}}, {{0, 1}, {1, 2}}));
  const json distances = json::parse(all_distances(graph));
  EXPECT_EQ(distances.at("v0"), json::parse(R"({"v0": 0.0, "v1": 3.0, "v2": 7.0})"));
  EXPECT_EQ(distances.at("v3"), json::parse(R"({"v3": 0.0})"));
  const json paths = json::parse(all_paths(graph));
  EXPECT_EQ(paths.at("v2").at("v0"), json::parse(R"(["v2", "v1", "v0"])"));
  EXPECT_EQ(paths.at("v1").at("v1"), json::parse(R"(["v1"])"));
  const json edges = json::parse(all_edges(graph));
  EXPECT_EQ(edges.size(), 4U);
  EXPECT_EQ(edges.at("v1"), json::parse(R"({"position": [3.0, 0.0, 0.0],
                                            "edges": {"v0": 3.0, "v2": 4.0}})"));
  EXPECT_EQ(edges.at("v3").at("edges"), json::object());
}

TEST(Networkx, NumbersAreFloatsAndNamesAreEscaped) {
  scan::Connectivity c =
      graph::testing::connectivity("s", {{0, 0, 0}, {0.125, 0, 0}, {3, 0, 0}}, {{0, 1}, {1, 2}});
  c.entries[0].id = "a\"b";
  const std::string text = all_distances(graph::NavGraph(c));
  EXPECT_THAT(text, ::testing::HasSubstr(R"("a\"b": {"a\"b": 0.0, "v1": 0.125, "v2": 3.0})"));
  c.entries[0].id = "\xff";
  EXPECT_THROW(all_distances(graph::NavGraph(c)), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
