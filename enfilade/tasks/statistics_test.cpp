#include "enfilade/tasks/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "enfilade/scan/data_root.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

constexpr double kRounding = 1e-12;  // of a few sums of small numbers

TEST(Summarise, OfFourNumbers) {
  const Summary s = summarise({4, 1, 2, 5});
  EXPECT_EQ(s.count, 4U);
  EXPECT_NEAR(s.mean, 3, kRounding);
  EXPECT_NEAR(s.deviation, std::sqrt(10.0 / 3), kRounding);
  EXPECT_EQ(s.min, 1);
  EXPECT_EQ(s.median, 3);
  EXPECT_EQ(s.max, 5);
  EXPECT_EQ(summarise({7, 9, 8}).median, 8);
}

TEST(Summarise, OfOneAndOfNone) {
  EXPECT_EQ(summarise({2}).deviation, 0);
  EXPECT_EQ(summarise({2}).median, 2);
  EXPECT_EQ(summarise({}).count, 0U);
}

TEST(KolmogorovSmirnov, StatisticByHand) {
  EXPECT_EQ(kolmogorov_smirnov({1, 2, 3}, {1, 2, 3}).statistic, 0);
  EXPECT_EQ(kolmogorov_smirnov({1, 2, 3}, {1, 2, 3}).p_value, 1);
  EXPECT_EQ(kolmogorov_smirnov({1, 2}, {3, 4, 5}).statistic, 1);
  // Below 2: three of four against one of two.
  EXPECT_NEAR(kolmogorov_smirnov({0, 1, 1, 9}, {1, 3}).statistic, 0.25, kRounding);
  // Ties count once: at 1 both are whole but for the 2.
  EXPECT_NEAR(kolmogorov_smirnov({1, 1, 1, 1}, {1, 1, 1, 2}).statistic, 0.25, kRounding);
}

TEST(KolmogorovSmirnov, IsSymmetric) {
  const auto ab = kolmogorov_smirnov({0, 1, 1, 9}, {1, 3});
  const auto ba = kolmogorov_smirnov({1, 3}, {0, 1, 1, 9});
  EXPECT_EQ(ab.statistic, ba.statistic);
  EXPECT_EQ(ab.p_value, ba.p_value);
}

TEST(KolmogorovSmirnov, PValueIsKolmogorovsDistribution) {
  // Critical values of the limiting distribution: 1.3581 at 5 %, 1.6276 at 1 % (Smirnov's table).
  // 20,000 against 20,000 with the distance 1.3581 / 100.
  std::vector<double> a(20000, 0.0);
  std::vector<double> b(20000, 0.0);
  for (std::size_t i = 0; i < 272; ++i) b[i] = 1;              // 0.0136, i.e. x = 1.36
  EXPECT_NEAR(kolmogorov_smirnov(a, b).p_value, 0.05, 0.001);  // x is not quite 1.3581
  for (std::size_t i = 0; i < 326; ++i) b[i] = 1;
  EXPECT_NEAR(kolmogorov_smirnov(a, b).p_value, 0.01, 0.001);  // x = 1.63, not quite 1.6276
}

std::shared_ptr<const graph::GraphSet> square() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("square"));
  return graph::GraphSet::of(std::move(graphs));
}

std::vector<Annotations> two_splits() {
  std::vector<Annotations> splits(2);
  splits[0].split = "train";
  splits[0].paths = {{1,
                      "square",
                      Radians(0),
                      {"v0", "v1", "v2"},
                      4.0,
                      {"Go to the door.", "Go to the sink", "Go.", "go to the door of it"}},
                     {2, "square", Radians(0), {"v0", "v3"}, 2.0, {"Stop"}}};
  splits[1].split = "test";
  splits[1].paths = {{3, "square", Radians(0), {"v0"}, std::nullopt, {"Go to the door"}}};
  return splits;
}

TEST(Statistics, OfAHandMadeDataSet) {
  const DatasetStatistics s = compute_statistics(two_splits(), square(), 2);
  ASSERT_EQ(s.splits.size(), 2U);
  const SplitStatistics& train = s.splits[0];
  EXPECT_EQ(train.split, "train");
  EXPECT_EQ(train.scans, 1U);
  EXPECT_EQ(train.paths, 2U);
  EXPECT_EQ(train.instructions, 5U);
  EXPECT_EQ(train.scored_instructions, 4U);
  EXPECT_NEAR(train.path_length.mean, 3, kRounding);
  EXPECT_THAT(train.path_edges, ElementsAre(Pair(1, 1), Pair(2, 1)));
  // 5, 4, 2 and 1 tokens; the fourth instruction is not scored.
  EXPECT_NEAR(train.instruction_length.mean, 3, kRounding);
  EXPECT_EQ(train.vocabulary, 9U) << "go to the door . sink of it stop";
  EXPECT_EQ(train.vocabulary_5, 0U);
  EXPECT_EQ(s.splits[1].path_length.count, 0U) << "hidden goals have no length";
  EXPECT_EQ(s.splits[1].paths, 1U);
  EXPECT_EQ(s.all.split, "all");
  EXPECT_EQ(s.all.scans, 1U);
  EXPECT_EQ(s.all.paths, 3U);
  EXPECT_EQ(s.all.path_length.count, 2U);
  EXPECT_EQ(s.all.vocabulary, 9U);
  EXPECT_EQ(s.all.vocabulary_5, 1U) << "go";
  EXPECT_THAT(s.first_words, ElementsAre(Pair("go to the door", 3), Pair("go .", 1)));
}

TEST(Statistics, OfGraphs) {
  const GraphStatistics g = compute_statistics({}, square()).graphs;
  EXPECT_EQ(g.graphs, 1U);
  EXPECT_EQ(g.viewpoints, 4U);
  EXPECT_EQ(g.viewpoints_per_graph, 4);
  EXPECT_EQ(g.degree, 2);
  EXPECT_EQ(g.edge_length.count, 4U);
  EXPECT_EQ(g.edge_length.mean, 2);
}

TEST(Statistics, CountAOneWayEdgeOnce) {
  scan::Connectivity c = graph::testing::square("square");
  c.entries[0].unobstructed.clear();  // 1 -> 0 and 3 -> 0 remain
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(c);
  const auto g = compute_statistics({}, graph::GraphSet::of(std::move(graphs))).graphs;
  EXPECT_EQ(g.edge_length.count, 4U);
  EXPECT_EQ(g.degree, 1.5);
}

TEST(Statistics, RefuseWhatDoesNotFitTheGraphs) {
  auto splits = two_splits();
  splits[0].paths[0].path[1] = "v7";
  EXPECT_THROW(compute_statistics(splits, square()), InvalidInput);
}

TEST(Statistics, TableHasARowForEachNumberAndAColumnForEachSplit) {
  const std::string table = to_table(compute_statistics(two_splits(), square(), 2));
  EXPECT_THAT(table, HasSubstr("train      test       all\n"));
  EXPECT_THAT(table, HasSubstr("paths                          2         1         3\n"));
  EXPECT_THAT(table, HasSubstr("path length (m)             3.00         -      3.00\n"));
  EXPECT_THAT(table, HasSubstr("  of 2 edges              50.0 %         -    50.0 %\n"));
  EXPECT_THAT(table, HasSubstr("       3  go to the door\n"));
}

TEST(Statistics, JsonHasTheSameNumbers) {
  const auto json = nlohmann::json::parse(to_json(compute_statistics(two_splits(), square(), 2)));
  EXPECT_EQ(json["splits"][0]["split"], "train");
  EXPECT_EQ(json["splits"][0]["path_length"]["count"], 2);
  EXPECT_EQ(json["all"]["path_edges"]["2"], 1);
  EXPECT_EQ(json["all"]["scored_instructions"], 5);
  EXPECT_EQ(json["graphs"]["degree"], 2.0);
  EXPECT_EQ(json["first_words"][0]["count"], 3);
}

TEST(Statistics, OfRoomToRoom) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real annotations";
  std::vector<Annotations> splits;
  for (const char* split : {"train", "val_seen", "val_unseen", "test"}) {
    splits.push_back(load_annotations(data->annotations(split), split));
  }
  const DatasetStatistics s =
      compute_statistics(splits, graph::GraphSet::open(data->connectivity()));
  // The paper's section 4: 7,189 paths with three instructions each, about 117 viewpoints a graph
  // of degree 4.1, 29 words, a vocabulary of 3.1k, 1.2k of it with five or more mentions.
  EXPECT_EQ(s.all.paths, 7189U);
  EXPECT_EQ(s.all.scored_instructions, 21567U);
  EXPECT_EQ(s.all.scans, 90U);
  EXPECT_EQ(s.all.vocabulary, 3141U);
  EXPECT_EQ(s.all.vocabulary_5, 1192U);
  EXPECT_NEAR(s.all.instruction_length.mean, 29.4, 0.05);  // counted once by another program
  EXPECT_NEAR(s.graphs.viewpoints_per_graph, 117.4, 0.05);
  EXPECT_NEAR(s.graphs.degree, 4.06, 0.005);
  EXPECT_EQ(s.all.path_edges.at(3), 17U);
  EXPECT_EQ(s.all.path_length.count, 7189U - 1391U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
