#include "enfilade/tasks/results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "enfilade/core/errors.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/files.h"
#include "tests/support/graphs.h"
#include "tests/support/recorded_annotations.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

// Entry 7 with two paths from v0 and one from v1, and two instructions; entry b_7 with one of each.
EpisodeSet episodes(bool named = true) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square());
  EpisodeSet set{"val", graph::GraphSet::of(std::move(graphs)), {}, {}, Task::kSoon};
  set.paths.push_back({0, ScanIndex(0), Radians(0), {v(0), v(1), v(2)}});
  set.paths.push_back({1, ScanIndex(0), Radians(0), {v(1), v(2)}});
  set.paths.push_back({2, ScanIndex(0), Radians(0), {v(0), v(3), v(2)}});
  set.paths.push_back({3, ScanIndex(0), Radians(0), {v(3)}});
  const auto add = [&](const std::string& entry, std::size_t path, std::size_t k) {
    InstructionDetails details;
    if (named) details.entry = entry;
    set.episodes.push_back({"9-" + std::to_string(path) + "_" + std::to_string(k), path, k, "It.",
                            std::move(details)});
  };
  for (const std::size_t path : {0U, 1U, 2U}) {
    for (const std::size_t k : {0U, 1U}) add("7", path, k);
  }
  add("b_7", 3, 0);
  return set;
}

// Each stays at its start, and points at its number.
std::vector<Trajectory> stays(const EpisodeSet& set) {
  std::vector<Trajectory> all;
  for (std::size_t i = 0; i < set.episodes.size(); ++i) {
    Trajectory& one = all.emplace_back();
    one.episode = i;
    one.points = {{set.path_of(set.episodes[i]).viewpoints.front(), Radians(0.5), Radians(0)}};
    one.point = SpherePoint{static_cast<double>(i) / 8, 0.5};
  }
  return all;
}

std::string faults_of(const std::string& entries) {
  return tests::refusal<InvalidInput>(
      [&] { parse_results("[" + entries + "]", "r.json", episodes(), Coverage::kPart); });
}

std::string answer(const std::string& start, const std::string& heading = "0.25") {
  return R"({"path": [[")" + start + R"(", 1.5, 0]], "obj_heading": )" + heading +
         R"(, "obj_elevation": 0.5})";
}
std::string entry(const std::string& id, const std::string& answers) {
  return R"({"instr_id": ")" + id + R"(", "trajectory": [)" + answers + "]}";
}

TEST(SoonSubmission, AnInstructionIsAnEntryWithItsAlternatives) {
  const EpisodeSet set = episodes();
  auto written = stays(set);
  written[6].point.reset();
  const std::string text = to_released_soon(written, set);
  EXPECT_THAT(text, HasSubstr("{\"instr_id\":\"7\",\"trajectory\":[{\"path\":[[\"v0\",0.5,0.0]],"
                              "\"obj_heading\":0.0,\"obj_elevation\":0.5},{\"path\":[[\"v1\""));
  EXPECT_THAT(text, HasSubstr("\"obj_heading\":null,\"obj_elevation\":null}]}\n]"));
  EXPECT_EQ(find_task_of_results(text), Task::kSoon);
  const auto read = parse_results(text, "r.json", set).trajectories;
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) EXPECT_EQ(read[i].point, written[i].point) << i;
  EXPECT_EQ(read[1].points[0].heading, Radians(0.5));
  EXPECT_EQ(to_released_soon(read, set), text);
}

TEST(SoonSubmission, AnAnswerIsOfTheFirstPathWithItsStartThatHasNone) {
  const EpisodeSet set = episodes();
  const std::string text =
      "[" + entry("7_1", answer("v0", "0.1") + ", " + answer("v1", "0.2")) + ", " +
      entry("7", answer("v0", "0.3")) + ", " + entry("7", answer("v0", "0.4")) + ", " +
      entry("7", answer("v0", "0.6")) + ", " + entry("b_7", answer("v3", "0.7")) + "]";
  std::vector<std::pair<std::size_t, double>> found;
  for (const auto& one : parse_results(text, "r.json", set, Coverage::kPart).trajectories) {
    found.emplace_back(one.episode, one.point->heading);
  }
  // Episodes 0 and 1 are path 0 by instructions 0 and 1; 4 and 5 are path 2, from v0 too.
  EXPECT_THAT(found, ElementsAre(std::pair(0, 0.3), std::pair(1, 0.1), std::pair(3, 0.2),
                                 std::pair(4, 0.4), std::pair(5, 0.6), std::pair(6, 0.7)));
}

TEST(SoonSubmission, NamesFieldPlaceAndWhatIsAllowed) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {entry("8", answer("v0")), "$[0].instr_id: \"8\" is not one of the 2 entries that split val"},
      {entry("7_2", answer("v0")), "$[0].instr_id: \"7_2\" is not one of the 2 entries"},
      {entry("7", ""), "$[0].trajectory: no alternative; one or more are expected"},
      {entry("7", answer("v3")), "$[0].trajectory[0].path: starts at \"v3\", but no path of entry"},
      {entry("7", answer("v1") + ", " + answer("v1") + ", " + answer("v1")),
       "$[0].trajectory[2]: all paths of entry \"7\" that begin at \"v1\" have an answer already"},
      {entry("7", answer("v0", "[0.25]")), "$[0].trajectory[0].obj_heading: array of 1, not a"},
      {entry("7", "7"), "$[0].trajectory[0]: number 7, not an object"},
      {entry("7", "{\"path\": [], \"obj_heading\": 1, \"obj_elevation\": 1}"),
       "$[0].trajectory[0].path: no viewpoint; the start at least is expected"},
      {entry("7", "{\"obj_heading\": 1, \"obj_elevation\": 1}"),
       "$[0].trajectory[0]: has no field \"path\""},
      {R"({"trajectory": []})", "$[0]: has no field \"instr_id\""},
  };
  for (const auto& [text, message] : cases)
    EXPECT_THAT(faults_of(text), HasSubstr(message)) << text;
  EXPECT_THAT(faults_of(entry("7", answer("v3")) + ", " + entry("9", "{}")),
              ::testing::AllOf(HasSubstr("$[0].trajectory[0].path"), HasSubstr("$[1].instr_id"),
                               HasSubstr("$[1].trajectory[0]")));
  EXPECT_EQ(faults_of(entry("7", answer("v0"))), "accepted");
}

TEST(SoonSubmission, NeedsToKnowTheEntries) {
  const EpisodeSet set = episodes(false);
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { to_released_soon(stays(set), set); }),
              HasSubstr("9-0_0: its annotations do not say which entry it belongs to"));
  EXPECT_THAT(tests::refusal<InvalidInput>(
                  [&] { parse_results("[" + entry("7", answer("v0")) + "]", "r.json", set); }),
              HasSubstr("\"7\" is not one of the 0 entries that split val names"));
}

// Each recorded answer stands in both forms.
TEST(SoonSubmissionRecorded, SaysWhatDuetsFormSays) {
  const auto data = scan::DataRoot::from_environment();
  const std::string split = "val_seen_instrs";
  const auto text = tests::recorded_annotations("soon_" + split + "_synthetic.json.gz");
  const auto duet = tests::recorded_annotations("../results/soon_" + split + "_duet.json.gz");
  const auto own = tests::recorded_annotations("../results/soon_" + split + "_official.json.gz");
  if (!text || !duet || !own) GTEST_SKIP() << tests::kNoRecordedAnnotations;
  const auto annotations = parse_annotations(*text, "soon", split, Task::kSoon);
  const EpisodeSet set = make_episodes(annotations, graph::GraphSet::open(data->connectivity()));
  const auto theirs = nlohmann::json::parse(*duet), ours = nlohmann::json::parse(*own);
  ASSERT_EQ(theirs.size(), 157U);
  ASSERT_EQ(ours.size(), theirs.size());
  const auto one = [&set](const nlohmann::json& entry) -> std::optional<Trajectory> {
    const std::string list = nlohmann::json::array({entry}).dump();
    try {
      return parse_results(list, "r", set, Coverage::kPart).trajectories.at(0);
    } catch (const InvalidInput&) {
      return std::nullopt;  // it jumps
    }
  };
  std::size_t read = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const auto a = one(theirs[i]), b = one(ours[i]);
    ASSERT_EQ(a.has_value(), b.has_value()) << i;
    if (!a) continue;
    ++read;
    const auto& goal = std::get<Boxes>(set.path_of(set.episodes[a->episode]).goal);
    if (goal.first_alternative.empty()) {
      // Two alternatives may be the same path.
      EXPECT_EQ(set.path_of(set.episodes[a->episode]).viewpoints,
                set.path_of(set.episodes[b->episode]).viewpoints)
          << i;
    }
    EXPECT_TRUE(std::ranges::equal(a->points, b->points, {}, &TrajectoryPoint::viewpoint,
                                   &TrajectoryPoint::viewpoint))
        << i;
    EXPECT_EQ(a->point, b->point) << i;
  }
  EXPECT_EQ(read, 151U) << "the others jump";
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
