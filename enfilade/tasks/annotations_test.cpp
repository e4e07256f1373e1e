#include "enfilade/tasks/annotations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "enfilade/scan/data_root.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// In graph::testing::square(): v0 - v1 - v2, and a start whose goal is hidden.
Annotations two_paths() {
  Annotations annotations{"val", "val.json", {}};
  annotations.paths.push_back({7,
                               "square",
                               Radians(0.5),
                               {"v0", "v1", "v2"},
                               4.0,
                               {"Go.", "Walk \"on\".",
                                "Gehe ums Eck, Stra\xC3\x9F"
                                "e.",
                                "4th"}});
  annotations.paths.push_back({9, "square", Radians(0), {"v3"}, std::nullopt, {"Wait."}});
  return annotations;
}

std::shared_ptr<const graph::GraphSet> squares() {
  scan::Connectivity holed = graph::testing::square("holed");
  holed.entries[3].included = false;
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("square"));
  graphs.emplace_back(holed);
  return graph::GraphSet::of(std::move(graphs));
}

template <class F>
std::string faults_of(const F& read) {
  try {
    read();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

std::string parse_faults(const std::string& text) {
  return faults_of([&] { parse_annotations(text, "r.json", "val"); });
}

std::string edited(const std::string& from, const std::string& to) {
  std::string text = to_json(two_paths());
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Annotations, ReadsWhatItWrites) {
  const Annotations written = two_paths();
  const Annotations read = parse_annotations(to_json(written), "val.json", "val");
  ASSERT_EQ(read.paths.size(), 2U);
  EXPECT_EQ(read.split, "val");
  EXPECT_EQ(read.file, "val.json");
  EXPECT_EQ(read.paths[0].path_id, 7);
  EXPECT_EQ(read.paths[0].scan, "square");
  EXPECT_EQ(read.paths[0].heading, Radians(0.5));
  EXPECT_THAT(read.paths[0].path, ElementsAre("v0", "v1", "v2"));
  EXPECT_EQ(read.paths[0].distance, 4.0);
  EXPECT_EQ(read.paths[0].instructions, written.paths[0].instructions);
  EXPECT_FALSE(read.paths[0].goal_hidden());
  EXPECT_TRUE(read.paths[1].goal_hidden());
  EXPECT_EQ(read.paths[1].distance, std::nullopt);
  EXPECT_EQ(to_json(read), to_json(written));
}

TEST(Annotations, NamesFieldPlaceAndWhatIsAllowed) {
  EXPECT_THAT(parse_faults("{}"), HasSubstr("r.json: $: object, not an array"));
  EXPECT_THAT(parse_faults("[3]"), HasSubstr("$[0]: number 3, not an object"));
  EXPECT_THAT(parse_faults("[NaN]"), HasSubstr("$[0]: line 1, column 2"));
  EXPECT_THAT(parse_faults(edited("\"scan\":\"square\",", "")), HasSubstr("$[0]: has no field"));
  EXPECT_THAT(parse_faults(edited("\"path_id\":7", "\"path_id\":\"\"")),
              HasSubstr("$[0].path_id: an empty id"));
  EXPECT_THAT(parse_faults(edited("\"path_id\":7", "\"path_id\":null")),
              HasSubstr("$[0].path_id: null, not a whole number"));
  EXPECT_THAT(parse_faults(edited("\"path_id\":7", "\"path_id\":7.5")),
              HasSubstr("$[0].path_id: number 7.5, not"));
  EXPECT_THAT(parse_faults(edited("\"heading\":0.5", "\"heading\":null")),
              HasSubstr("$[0].heading: null, not a number"));
  EXPECT_THAT(parse_faults(edited("\"v1\"", "1")), HasSubstr("$[0].path[1]: number 1, not"));
  EXPECT_THAT(parse_faults(edited("[\"v3\"]", "[]")), HasSubstr("$[1].path: no viewpoint"));
  EXPECT_THAT(parse_faults(edited("[\"v3\"]", "\"v3\"")),
              HasSubstr("$[1].path: string \"v3\", not an array"));
  EXPECT_THAT(parse_faults(edited("4.0", "-4.0")), HasSubstr("$[0].distance: -4 is no length"));
  EXPECT_THAT(parse_faults(edited("[\"Wait.\"]", "[\"Wait.\",[]]")),
              HasSubstr("$[1].instructions[1]: array"));
  EXPECT_THAT(parse_faults(edited("\"path_id\":9", "\"path_id\":7")),
              HasSubstr("$[1].path_id: 7 stands at $[0] already"));
  EXPECT_THAT(parse_faults(edited("\"path_id\":9", "\"path_id\":9,\"path_id\":8")),
              HasSubstr("$[1]"));
}

TEST(Annotations, ListsAllFaultsAtOnce) {
  EXPECT_THAT(parse_faults("[{\"path_id\": 1}, 2]"),
              AllOf(HasSubstr("\"scan\""), HasSubstr("\"heading\""), HasSubstr("$[1]: number 2")));
}

TEST(Annotations, TakesWhatItDoesNotNeedAsItComes) {
  EXPECT_EQ(parse_faults(edited("\"distance\":4.0", "\"extra\":{}")), "accepted");
  EXPECT_EQ(parse_faults(edited("[\"Wait.\"]", "[]")), "accepted") << "a path without words yet";
  EXPECT_EQ(parse_faults("[]"), "accepted");
}

TEST(Annotations, DoesNotWriteWhatItCouldNotRead) {
  Annotations annotations = two_paths();
  annotations.paths[1].heading = Radians(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(to_json(annotations), ArgumentError);
  annotations = two_paths();
  annotations.paths[1].instructions[0] = "Wait\xFF";
  EXPECT_THROW(to_json(annotations), ArgumentError);
}

TEST(Episodes, AreTheFirstThreeInstructionsOfEachPath) {
  const EpisodeSet set = make_episodes(two_paths(), squares());
  ASSERT_EQ(set.paths.size(), 2U);
  EXPECT_EQ(set.split, "val");
  EXPECT_THAT(set.paths[0].viewpoints,
              ElementsAre(ViewpointIndex(0), ViewpointIndex(1), ViewpointIndex(2)));
  std::vector<std::string> ids;
  for (const Episode& e : set.episodes) ids.push_back(e.instruction_id);
  EXPECT_THAT(ids, ElementsAre("7_0", "7_1", "7_2", "9_0"));
  EXPECT_EQ(set.episodes[1].text, "Walk \"on\".");
  EXPECT_EQ(set.path_of(set.episodes[3]).path_id, 9);
  EXPECT_EQ(set.graph_of(set.episodes[3]).scan(), "square");
}

TEST(Episodes, NameWhatDoesNotFitTheGraphs) {
  Annotations bad = two_paths();
  bad.paths[0].path = {"v0", "v2", "v9", "v1"};
  bad.paths[1].scan = "holed";
  bad.paths[1].instructions.clear();
  bad.paths.push_back({10, "nowhere", Radians(0), {"v0"}, std::nullopt, {"Go."}});
  const std::string all = faults_of([&] { make_episodes(bad, squares()); });
  EXPECT_THAT(all, HasSubstr("val.json: $[0].path[1]: no edge leads from \"v0\" to \"v2\""));
  EXPECT_THAT(all, HasSubstr("$[0].path[2]: viewpoint \"v9\" is not one of the 4 of scan square"));
  EXPECT_THAT(all, ::testing::Not(HasSubstr("$[0].path[3]"))) << "v9 -> v1 says nothing new";
  EXPECT_THAT(all, HasSubstr("$[1].path[0]: viewpoint \"v3\" of scan holed is excluded"));
  EXPECT_THAT(all, HasSubstr("$[1].instructions: path 9 has none"));
  EXPECT_THAT(all, HasSubstr("$[2].scan: scan \"nowhere\" is not one of the 2"));
  const std::string paths = faults_of([&] { look_up_paths(bad, *squares()); });
  EXPECT_THAT(paths, ::testing::Not(HasSubstr("instructions")));
}

TEST(Episodes, OfRealSplits) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real annotations";
  const auto graphs = graph::GraphSet::open(data->connectivity());
  // Paths and scored instructions as the paper's section 4.3 has them; 14 fourth instructions are
  // in train, all of them unscored.
  const std::map<std::string, std::size_t> paths{
      {"train", 4675}, {"val_seen", 340}, {"val_unseen", 783}, {"test", 1391}};
  for (const auto& [split, n] : paths) {
    const Annotations annotations = load_annotations(data->annotations(split), split);
    const EpisodeSet set = make_episodes(annotations, graphs);
    EXPECT_EQ(set.paths.size(), n) << split;
    EXPECT_EQ(set.episodes.size(), 3 * n) << split;
    EXPECT_EQ(to_json(parse_annotations(to_json(annotations), "", split)), to_json(annotations));
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(annotations.paths[i].goal_hidden(), split == "test");
      EXPECT_GE(annotations.paths[i].heading.value, 0);
      EXPECT_LT(annotations.paths[i].heading.value, 2 * kPi);
      if (!annotations.paths[i].distance) continue;
      const auto& v = set.paths[i].viewpoints;
      const graph::NavGraph& graph = graphs->graph(set.paths[i].scan);
      double length = 0;
      for (std::size_t k = 1; k < v.size(); ++k) length += graph.edge(v[k - 1], v[k])->length;
      EXPECT_NEAR(length, *annotations.paths[i].distance, 0.0051) << "rounded to centimetres";
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
