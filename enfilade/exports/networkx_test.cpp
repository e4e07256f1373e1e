#include "enfilade/exports/networkx.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "enfilade/exports/detail/pickle_writer.h"
#include "enfilade/graph/graph_set.h"
#include "tests/support/graphs.h"

namespace enfilade::exports {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

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

TEST(PickleWriter, HasPythonsOpcodes) {
  detail::PickleWriter out;
  out.empty_dictionary();
  out.mark();
  out.text("a");
  out.number(1.5);
  out.set_items();
  // pickletools: PROTO 2, EMPTY_DICT, MARK, BINUNICODE 'a', BINFLOAT 1.5, SETITEMS, STOP
  EXPECT_EQ(out.finish(), std::string("\x80\x02}(X\x01\x00\x00\x00"
                                      "aG\x3f\xf8\x00\x00\x00\x00\x00\x00u.",
                                      21));
}

TEST(Networkx, OneWayEdgesMakeADirectedGraph) {
  scan::Connectivity c = graph::testing::square();
  std::vector<graph::NavGraph> both;
  both.emplace_back(c);
  EXPECT_THAT(
      connectivity_pickle(*graph::GraphSet::of(std::move(both))),
      ::testing::AllOf(HasSubstr("cnetworkx.classes.graph\nGraph\n"), Not(HasSubstr("_pred"))));
  c.entries[0].unobstructed = {ViewpointIndex(1)};
  std::vector<graph::NavGraph> one;
  one.emplace_back(c);
  EXPECT_THAT(connectivity_pickle(*graph::GraphSet::of(std::move(one))),
              ::testing::AllOf(HasSubstr("cnetworkx.classes.digraph\nDiGraph\n"),
                               HasSubstr("_pred"), HasSubstr("_succ")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
