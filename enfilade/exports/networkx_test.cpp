#include "enfilade/exports/networkx.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/graphs.h"

namespace enfilade::exports {
namespace EN_UNIT {

using nlohmann::json;

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
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
