#include "enfilade/tasks/r4r.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <optional>

#include "enfilade/core/detail/json.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/formats/readers.h"
#include "tests/support/graphs.h"
#include "tests/support/recorded_annotations.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Side 2 m. The end of 7 is 4 m from its own start and 2 m from that of 9; the end of 9 is the
// start of 7, and 2 m from its own start.
Annotations two_paths(const std::string& scan = "square") {
  Annotations annotations{"val", "val.json", {}};
  annotations.paths.push_back(
      {7, scan, Radians(0.5), {"v0", "v1", "v2"}, 4.0, {"Go. ", "Walk \"on\". "}});
  annotations.paths.push_back({9,
                               scan,
                               Radians(1),
                               {"v3", "v0"},
                               2.25,
                               {"Stra\xC3\x9F"
                                "e."}});
  return annotations;
}

std::shared_ptr<const graph::GraphSet> squares() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("other"));
  graphs.emplace_back(graph::testing::square("square"));
  return graph::GraphSet::of(std::move(graphs));
}

std::string refusal_of(const Annotations& annotations, const JoinOptions& options = {}) {
  return tests::refusal<ArgumentError>([&] { join_paths(annotations, *squares(), options); });
}

std::vector<std::vector<std::int64_t>> origins(const Joined& joined) {
  std::vector<std::vector<std::int64_t>> from;
  for (const JoinedPath& path : joined.paths) from.push_back(path.from);
  return from;
}

TEST(Join, GoesFromTheEndOfTheFirstToTheStartOfTheSecond) {
  const Joined joined = join_paths(two_paths(), *squares());
  EXPECT_EQ(joined.pairs, 4U);
  EXPECT_THAT(origins(joined),
              ElementsAre(ElementsAre(7, 9), ElementsAre(9, 7), ElementsAre(9, 9)));
  const JoinedPath& across = joined.paths[0];
  EXPECT_EQ(across.path.path_id, 0);
  EXPECT_EQ(across.path.scan, "square");
  EXPECT_EQ(across.path.heading, Radians(0.5));
  EXPECT_THAT(across.path.path, ElementsAre("v0", "v1", "v2", "v3", "v0"));
  EXPECT_EQ(across.path.distance, 4.0 + 2 + 2.25);
  EXPECT_THAT(across.path.instructions, ElementsAre("Go. Stra\xC3\x9F"
                                                    "e.",
                                                    "Walk \"on\". Stra\xC3\x9F"
                                                    "e."));
  EXPECT_THAT(across.shortest, ElementsAre("v0"));
  EXPECT_EQ(across.shortest_distance, 0);
  EXPECT_FALSE(across.path.goal_hidden());
  const JoinedPath& touching = joined.paths[1];
  EXPECT_EQ(touching.path.path_id, 1);
  EXPECT_EQ(touching.path.heading, Radians(1));
  EXPECT_THAT(touching.path.path, ElementsAre("v3", "v0", "v1", "v2"));
  EXPECT_EQ(touching.path.distance, 2.25 + 0 + 4);
  EXPECT_THAT(touching.shortest, ElementsAre("v3", "v2"));
  EXPECT_EQ(touching.shortest_distance, 2);
  const JoinedPath& itself = joined.paths[2];
  EXPECT_THAT(itself.path.path, ElementsAre("v3", "v0", "v3", "v0"));
  EXPECT_EQ(itself.path.distance, 2.25 + 2 + 2.25);
}

TEST(Join, TakesGapsUpToTheLimit) {
  JoinOptions options;
  options.most_gap = 4;
  EXPECT_EQ(join_paths(two_paths(), *squares(), options).paths.size(), 4U);
  options.most_gap = 2;
  EXPECT_EQ(join_paths(two_paths(), *squares(), options).paths.size(), 3U);
  options.most_gap = 0;
  EXPECT_THAT(origins(join_paths(two_paths(), *squares(), options)),
              ElementsAre(ElementsAre(9, 7)));
}

TEST(Join, TakesScansInTheOrderInWhichTheyAppear) {
  Annotations annotations = two_paths("square");
  const Annotations others = two_paths("other");
  annotations.paths.insert(annotations.paths.begin() + 1, others.paths.begin(), others.paths.end());
  for (std::size_t i = 0; i < 4; ++i) annotations.paths[i].path_id = static_cast<int>(i);
  const Joined joined = join_paths(annotations, *squares());
  EXPECT_EQ(joined.pairs, 8U);
  ASSERT_EQ(joined.paths.size(), 6U);
  EXPECT_THAT(origins(joined),
              ElementsAre(ElementsAre(0, 3), ElementsAre(3, 0), ElementsAre(3, 3),
                          ElementsAre(1, 2), ElementsAre(2, 1), ElementsAre(2, 2)));
  EXPECT_EQ(joined.paths[3].path.scan, "other");
  EXPECT_EQ(joined.paths[3].path.path_id, 3);
}

TEST(Join, GoesOnForThreeAndMore) {
  JoinOptions options;
  options.paths = 3;
  const Joined joined = join_paths(two_paths(), *squares(), options);
  EXPECT_EQ(joined.pairs, 6U) << "three pairs, each with both";
  EXPECT_THAT(origins(joined),
              ElementsAre(ElementsAre(7, 9, 7), ElementsAre(7, 9, 9), ElementsAre(9, 7, 9),
                          ElementsAre(9, 9, 7), ElementsAre(9, 9, 9)));
  const PathAnnotation& first = joined.paths[0].path;
  EXPECT_THAT(first.path, ElementsAre("v0", "v1", "v2", "v3", "v0", "v1", "v2"));
  EXPECT_EQ(first.distance, 4.0 + 2 + 2.25 + 0 + 4);
  ASSERT_EQ(first.instructions.size(), 4U);
  EXPECT_EQ(first.instructions[1],
            "Go. Stra\xC3\x9F"
            "e.Walk \"on\". ");
  options.paths = 4;
  EXPECT_EQ(join_paths(two_paths(), *squares(), options).paths.size(), 8U);
  options.most_gap = 0;
  options.paths = 5;
  EXPECT_EQ(join_paths(two_paths(), *squares(), options).pairs, 0U) << "no three of them";
}

TEST(Join, RefusesWhatCannotBeJoined) {
  JoinOptions options;
  options.paths = 1;
  EXPECT_THAT(refusal_of(two_paths(), options), HasSubstr("1 paths to join; at least 2"));
  options.paths = 2;
  for (const double gap :
       {-0.5, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    options.most_gap = gap;
    EXPECT_THAT(refusal_of(two_paths(), options), HasSubstr("a finite number from 0 is allowed"));
  }
  Annotations annotations = two_paths();
  annotations.paths[1].path = {"v3"};
  EXPECT_THAT(refusal_of(annotations), HasSubstr("path 9: its goal is hidden"));
  annotations = two_paths();
  annotations.paths[1].goal = HiddenGoal{};
  EXPECT_THAT(refusal_of(annotations), HasSubstr("path 9: its goal is hidden"));
  annotations = two_paths();
  annotations.paths[0].path.clear();
  EXPECT_THAT(refusal_of(annotations), HasSubstr("path 7: its goal is hidden"));
  annotations = two_paths();
  annotations.paths[0].distance.reset();
  EXPECT_THAT(refusal_of(annotations), HasSubstr("path 7: has no distance"));
  annotations = two_paths();
  annotations.paths[0].path[1] = "v2";
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { join_paths(annotations, *squares()); }),
              HasSubstr("val.json: $[0].path[1]: no edge leads from"));
}

TEST(Join, RefusesPathsThatJumpOutOfReach) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::connectivity(
      "split", {{0, 0, 0}, {1, 0, 0}, {50, 0, 0}, {51, 0, 0}}, {{0, 1}, {2, 3}}));
  Annotations annotations{"val", "val.json", {}, Task::kCvdn};
  annotations.paths.push_back({1, "split", Radians(0), {"v0", "v3"}, 51.0, {"Jump."}});
  annotations.paths.push_back({2, "split", Radians(0), {"v3", "v2"}, 1.0, {"Walk."}});
  const auto set = graph::GraphSet::of(std::move(graphs));
  const std::string refused = tests::refusal<ArgumentError>([&] { join_paths(annotations, *set); });
  EXPECT_THAT(refused, HasSubstr("would end at v2, out of reach from its start v0"));
}

TEST(Join, WritesWhatIsReadBackEqual) {
  Joined joined = join_paths(two_paths(), *squares());
  joined.paths.resize(2);
  joined.paths[1].path.instructions = {"A\tb\x01\n", "c\\d"};
  const std::string text = to_json(joined);
  EXPECT_EQ(text,
            "[\n{\"distance\":8.25,\"first_path_id\":7,\"second_path_id\":9,\"heading\":0.5,"
            "\"instructions\":[\"Go. Stra\xC3\x9F"
            "e.\",\"Walk \\\"on\\\". Stra\xC3\x9F"
            "e.\"],"
            "\"path\":[\"v0\",\"v1\",\"v2\",\"v3\",\"v0\"],\"path_id\":0,\"scan\":\"square\","
            "\"shortest_path\":[\"v0\"],\"shortest_path_distance\":0.0},\n"
            "{\"distance\":6.25,\"first_path_id\":9,\"second_path_id\":7,\"heading\":1.0,"
            "\"instructions\":[\"A\\tb\\u0001\\n\",\"c\\\\d\"],"
            "\"path\":[\"v3\",\"v0\",\"v1\",\"v2\"],\"path_id\":1,\"scan\":\"square\","
            "\"shortest_path\":[\"v3\",\"v2\"],\"shortest_path_distance\":2.0}\n]\n");
  const Annotations read = formats::parse_r2r_family(text, "r4r.json", "val", Task::kR4r);
  ASSERT_EQ(read.paths.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(read.paths[i], joined.paths[i].path);
}

TEST(Join, WritesInPartsWhatItWritesAtOnce) {
  for (const std::size_t paths : {2U, 3U, 4U}) {
    JoinOptions options;
    options.paths = paths;
    const Joined joined = join_paths(two_paths(), *squares(), options);
    std::string text;
    const JoinTotals totals = write_joined(two_paths(), *squares(), options,
                                           [&text](std::string_view part) { text += part; });
    EXPECT_EQ(text, to_json(joined));
    EXPECT_EQ(totals.paths, joined.paths.size());
    EXPECT_EQ(totals.pairs, joined.pairs);
    double length = 0;
    std::size_t instructions = 0;
    for (const JoinedPath& one : joined.paths) {
      length += *one.path.distance;
      instructions += one.path.instructions.size();
    }
    EXPECT_DOUBLE_EQ(totals.length, length);
    EXPECT_EQ(totals.instructions, instructions);
  }
  JoinOptions apart;
  apart.most_gap = 0;
  Annotations one = two_paths();
  one.paths.pop_back();
  std::string text;
  write_joined(one, *squares(), apart, [&text](std::string_view part) { text += part; });
  EXPECT_EQ(text, "[\n]\n");
}

TEST(Join, WritesTheIdsOfThreeAndMoreAsAList) {
  JoinOptions options;
  options.paths = 3;
  const std::string text = to_json(join_paths(two_paths(), *squares(), options));
  EXPECT_THAT(text, HasSubstr("{\"distance\":12.25,\"path_ids\":[7,9,7],\"heading\":0.5,"));
  EXPECT_EQ(to_json(Joined()), "[\n]\n");
}

TEST(Join, DoesNotWriteWhatJsonCannotSay) {
  const Joined good = join_paths(two_paths(), *squares());
  const auto refused = [](const Joined& joined) {
    return tests::refusal<ArgumentError>([&] { to_json(joined); });
  };
  Joined bad = good;
  bad.paths[1].path.instructions[0] = "Wait\xFF";
  EXPECT_THAT(refused(bad), HasSubstr("path 1: holds text that is not UTF-8"));
  bad = good;
  bad.paths[2].shortest_distance = std::numeric_limits<double>::infinity();
  EXPECT_THAT(refused(bad), HasSubstr("path 2: holds"));
}

// Compared with what a Python program gave for the same rule and the same graphs.
class JoinOfRealSplits : public ::testing::Test {
 protected:
  void SetUp() override {
    data_ = scan::DataRoot::from_environment();
    if (!data_) GTEST_SKIP() << "ENFILADE_DATA is not set: no real annotations";
    graphs_ = graph::GraphSet::open(data_->connectivity());
  }
  Joined joined(const std::string& split, int threads = 0) const {
    JoinOptions options;
    options.threads = threads;
    return join_paths(load_annotations(data_->annotations(split), split), *graphs_, options);
  }

  std::optional<scan::DataRoot> data_;
  std::shared_ptr<const graph::GraphSet> graphs_;
};

struct Totals {
  std::size_t paths = 0, instructions = 0;
  double distance = 0, shortest = 0, nodes = 0, shortest_nodes = 0;
};

Totals totals_of(const std::vector<JoinedPath>& paths) {
  Totals totals;
  totals.paths = paths.size();
  for (const JoinedPath& path : paths) {
    totals.instructions += path.path.instructions.size();
    totals.distance += *path.path.distance;
    totals.shortest += path.shortest_distance;
    totals.nodes += static_cast<double>(path.path.path.size());
    totals.shortest_nodes += static_cast<double>(path.shortest.size());
  }
  return totals;
}

TEST_F(JoinOfRealSplits, GivesTheRecordedCountsAndMeans) {
  const auto text = tests::recorded_annotations("../r4r.json");
  if (!text) GTEST_SKIP() << tests::kNoRecordedAnnotations;
  const json::Document document = json::Document::parse(*text, "r4r.json");
  for (const std::string split : {"train", "val_seen", "val_unseen"}) {
    SCOPED_TRACE(split);
    const auto recorded = document.root()["generation"][split];
    const auto count = [&](const char* name) {
      return static_cast<std::size_t>(recorded[name].get_uint64().value());
    };
    const auto mean = [&](const char* name) { return recorded[name].get_double().value(); };
    const Joined all = joined(split);
    const Totals totals = totals_of(all.paths);
    EXPECT_EQ(all.pairs, count("pairs"));
    EXPECT_EQ(totals.paths, count("paths"));
    EXPECT_EQ(totals.instructions, count("instructions"));
    const auto n = static_cast<double>(totals.paths);
    EXPECT_NEAR(totals.distance / n, mean("mean_distance"), 1e-6);
    EXPECT_NEAR(totals.shortest / n, mean("mean_shortest_path_distance"), 1e-6);
    EXPECT_NEAR(totals.nodes / n, mean("mean_path_nodes"), 1e-6);
    EXPECT_NEAR(totals.shortest_nodes / n, mean("mean_shortest_path_nodes"), 1e-6);
    std::map<std::string, std::vector<JoinedPath>> by_scan;
    for (const JoinedPath& path : all.paths) by_scan[path.path.scan].push_back(path);
    const auto scans =
        document.root()["paths_and_instructions_by_scan"][split].get_object().value();
    EXPECT_GT(scans.size(), 0U) << "about half of them are recorded";
    for (const auto scan : scans) {
      const Totals of_scan = totals_of(by_scan[std::string(scan.key)]);
      EXPECT_EQ(of_scan.paths, scan.value["paths"].get_uint64().value()) << scan.key;
      EXPECT_EQ(of_scan.instructions, scan.value["instructions"].get_uint64().value()) << scan.key;
    }
  }
}

TEST_F(JoinOfRealSplits, GivesTheRecordedPathsToTheLastBit) {
  for (const std::string split : {"val_seen", "val_unseen"}) {
    const auto text = tests::recorded_annotations("r4r_" + split + "_subset.json.gz");
    if (!text) GTEST_SKIP() << tests::kNoRecordedAnnotations;
    const Annotations subset = formats::parse_r2r_family(*text, "r4r.json", split, Task::kR4r);
    const Joined all = joined(split);
    EXPECT_FALSE(subset.paths.empty());
    for (const PathAnnotation& path : subset.paths) {
      ASSERT_LT(static_cast<std::size_t>(path.path_id), all.paths.size());
      EXPECT_EQ(all.paths[static_cast<std::size_t>(path.path_id)].path, path) << path.path_id;
    }
  }
}

TEST_F(JoinOfRealSplits, IsTheSameOnAnyNumberOfThreadsAndReadBackEqual) {
  const Joined all = joined("val_unseen", 1);
  const std::string text = to_json(all);
  EXPECT_EQ(to_json(joined("val_unseen", 2)), text);
  EXPECT_EQ(to_json(joined("val_unseen", 7)), text);
  const Annotations read = formats::parse_r2r_family(text, "r4r.json", "val_unseen", Task::kR4r);
  ASSERT_EQ(read.paths.size(), all.paths.size());
  for (std::size_t i = 0; i < all.paths.size(); ++i) ASSERT_EQ(read.paths[i], all.paths[i].path);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
