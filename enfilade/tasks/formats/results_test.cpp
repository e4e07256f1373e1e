#include "enfilade/tasks/results.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "enfilade/core/file.h"
#include "tests/support/graphs.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// In a square v0 v1 v2 v3 with v4 excluded and v5 out of reach: path 7 from v0 to v2 with
// instructions 7_0, 7_1 and 7_2, and path 8 from v3 with 8_0 only.
EpisodeSet square_episodes() {
  scan::Connectivity c = graph::testing::connectivity(
      "square", {{0, 0, 1.5}, {2, 0, 1.5}, {2, 2, 1.5}, {0, 2, 1.5}, {4, 0, 1.5}, {9, 0, 1.5}},
      {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {1, 4}});
  c.entries[4].included = false;
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(c);
  Annotations annotations{"val", "val.json", {}};
  annotations.paths.push_back(
      {7, "square", Radians(0), {"v0", "v1", "v2"}, 4.0, {"Go.", "Walk.", "Move."}});
  annotations.paths.push_back({8, "square", Radians(0), {"v3", "v2"}, 2.0, {"Turn."}});
  return make_episodes(annotations, graph::GraphSet::of(std::move(graphs)));
}

const EpisodeSet& episodes() {
  static const EpisodeSet kSet = square_episodes();
  return kSet;
}

// A file whose entry 7_0 has the given trajectory, and good ones for the rest.
std::string file_with(const std::string& trajectory) {
  return fmt::format(R"([{{"instr_id": "7_0", "trajectory": {}}},
      {{"instr_id": "7_1", "trajectory": ["v0"]}}, {{"instr_id": "7_2", "trajectory": ["v0"]}},
      {{"instr_id": "8_0", "trajectory": ["v3"]}}])",
                     trajectory);
}

std::vector<std::size_t> viewpoints(const Trajectory& trajectory) {
  std::vector<std::size_t> result;
  for (const TrajectoryPoint& point : trajectory.points) result.push_back(point.viewpoint.at());
  return result;
}

Results parse(const std::string& text) { return parse_results(text, "r.json", episodes()); }

std::vector<std::size_t> parse_trajectory(const std::string& trajectory) {
  return viewpoints(parse(file_with(trajectory)).trajectories.at(0));
}

// "where: code" of each fault, in order.
std::vector<std::string> faults(const std::string& text) {
  std::vector<std::string> found;
  try {
    parse(text);
  } catch (const InvalidInput& error) {
    for (const Diagnostic& d : error.diagnostics()) found.push_back(d.where + ": " + d.code);
  }
  return found;
}

std::vector<std::string> trajectory_faults(const std::string& trajectory) {
  return faults(file_with(trajectory));
}

std::string message(const std::string& text) {
  try {
    parse(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Results, TakeEveryFormInTheWild) {
  const auto expected = ElementsAre(0, 1, 1, 2);
  EXPECT_THAT(parse_trajectory(R"([["v0", 0, 0], ["v1", 1, 0], ["v1", 2, 0.5], ["v2", 2, 0]])"),
              expected);
  EXPECT_THAT(parse_trajectory(R"([["v0"], ["v1"], ["v1"], ["v2"]])"), expected);
  EXPECT_THAT(parse_trajectory(R"(["v0", "v1", "v1", "v2"])"), expected);
  EXPECT_THAT(parse_trajectory(R"([["v0"], ["v1", "v1", "v2"]])"), expected);
  EXPECT_THAT(parse_trajectory(R"([["v0"], [], ["v1", "v1"], ["v2"], []])"), expected);
  EXPECT_THAT(parse_trajectory(R"([[["v0", 0, 0], ["v1", 1, 0]], [["v1", 1, 0]], [["v2", 1, 0]]])"),
              expected);
  EXPECT_THAT(parse_trajectory(R"(["v0", ["v1", 0.5, 0], [["v1"], "v2"]])"), expected)
      << "any mixture";
  EXPECT_THAT(parse_trajectory(R"([["v0", "v1"], ["v1", "v2"]])"), expected);
}

TEST(Results, KeepAnglesAndTheOrderOfTheEpisodes) {
  const Results results = parse(R"([{"instr_id": "8_0", "trajectory": ["v3"], "pred_objid": 4},
      {"trajectory": [["v0", 0.5, -0.25], "v1"], "a_t": [1, 2], "instr_id": "7_1"},
      {"instr_id": "7_2", "trajectory": ["v0"]}, {"instr_id": "7_0", "trajectory": ["v0"]}])");
  EXPECT_THAT(results.warnings, IsEmpty());
  ASSERT_EQ(results.trajectories.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(results.trajectories[i].episode, i);
  const Trajectory& second = results.trajectories[1];
  EXPECT_THAT(viewpoints(second), ElementsAre(0, 1));
  EXPECT_EQ(second.points[0].heading, Radians(0.5));
  EXPECT_EQ(second.points[0].elevation, Radians(-0.25));
  EXPECT_EQ(second.points[1].heading, Radians(0));
  EXPECT_THAT(viewpoints(results.trajectories[3]), ElementsAre(3));
}

TEST(Results, AreReadBackAsTheyWereWritten) {
  std::vector<Trajectory> written = parse(file_with(R"(["v0", "v1"])")).trajectories;
  written[0].points[0].heading = Radians(0.1);
  written[0].points[0].elevation = Radians(-1e-300);
  written[0].points[1].heading = Radians(-0.0);
  written[1].points[0].heading = Radians(1234.5678901234568);
  const std::string text = to_json(written, episodes());
  EXPECT_THAT(
      text,
      HasSubstr(R"({"instr_id": "7_0", "trajectory": [["v0", 0.1, -1e-300], ["v1", 0, 0]]},)"));
  const std::vector<Trajectory> read = parse(text).trajectories;
  EXPECT_EQ(to_json(read, episodes()), text);
  EXPECT_EQ(read[0].points[0].heading, Radians(0.1));
  EXPECT_EQ(read[1].points[0].heading, written[1].points[0].heading);
  written[0].points[0].heading = Radians(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(to_json(written, episodes()), ArgumentError);
}

TEST(Results, RefuseWhatIsNotOfTheForm) {
  EXPECT_THAT(faults("{}"), ElementsAre("$: not-an-array"));
  EXPECT_THAT(message(""), HasSubstr("the file is empty"));
  EXPECT_THAT(message(file_with(R"([["v0", NaN, 0]])")),
              AllOf(HasSubstr("$[0].trajectory[0][1]"), HasSubstr("NaN")));
  EXPECT_THAT(message(file_with(R"([["v0", 1e999, 0]])")), HasSubstr("not-json"));
  EXPECT_THAT(trajectory_faults("7"), ElementsAre("$[0].trajectory: not-an-array"));
  EXPECT_THAT(trajectory_faults("[]"), ElementsAre("$[0].trajectory: empty-trajectory"));
  EXPECT_THAT(trajectory_faults("[[], []]"), ElementsAre("$[0].trajectory: empty-trajectory"));
  EXPECT_THAT(trajectory_faults(R"(["v0", 7])"), ElementsAre("$[0].trajectory[1]: bad-entry"));
  EXPECT_THAT(trajectory_faults(R"(["v0", {"viewpoint": "v1"}])"),
              ElementsAre("$[0].trajectory[1]: bad-entry"));
  EXPECT_THAT(trajectory_faults(R"([["v0", 1]])"), ElementsAre("$[0].trajectory[0]: bad-entry"));
  EXPECT_THAT(trajectory_faults(R"([["v0", 1, 0, 3]])"),
              ElementsAre("$[0].trajectory[0]: bad-entry"));
  EXPECT_THAT(
      trajectory_faults(R"([["v0", "left", null]])"),
      ElementsAre("$[0].trajectory[0][1]: not-a-number", "$[0].trajectory[0][2]: not-a-number"));
  EXPECT_THAT(trajectory_faults("[[7, 1, 0]]"), ElementsAre("$[0].trajectory[0][0]: not-a-string"));
  EXPECT_THAT(trajectory_faults(R"([[[["v0"]]]])"),
              ElementsAre("$[0].trajectory[0][0]: bad-entry"));
  EXPECT_THAT(trajectory_faults(R"([[["v0", "v1"]]])"),
              ElementsAre("$[0].trajectory[0][0]: bad-entry"));
}

TEST(Results, RefuseWhatCannotBeWalked) {
  EXPECT_THAT(trajectory_faults(R"(["v1", "v2"])"), ElementsAre("$[0].trajectory[0]: wrong-start"));
  EXPECT_THAT(trajectory_faults(R"([["v0", 0, 0], ["v2", 0, 0], ["v1", 0, 0]])"),
              ElementsAre("$[0].trajectory[1][0]: not-adjacent"));
  EXPECT_THAT(trajectory_faults(R"([["v0"], ["v1", "v3"]])"),
              ElementsAre("$[0].trajectory[1][1]: not-adjacent"));
  EXPECT_THAT(trajectory_faults(R"(["v0", "v9", "v2"])"),
              ElementsAre("$[0].trajectory[1]: unknown-viewpoint"))
      << "a step from an unknown place is not judged";
  EXPECT_THAT(trajectory_faults(R"(["v4"])"),
              ElementsAre("$[0].trajectory[0]: excluded-viewpoint"));
  EXPECT_THAT(message(file_with(R"(["v0", "v2"])")),
              HasSubstr(R"(no edge leads from "v0" to "v2": 2.83 m apart, 4.00 m to walk)"));
  EXPECT_THAT(message(file_with(R"(["v0", "v5"])")), HasSubstr("9.00 m apart, out of reach"));
  EXPECT_THAT(message(file_with(R"(["v0", "v4"])")), HasSubstr("exists but is excluded"));
  EXPECT_THAT(message(file_with("[\"" + std::string(5000, 'x') + "\"]")).size(),
              ::testing::Lt(300U))
      << "a long id is cut";
}

TEST(Results, NeedEachInstructionOnce) {
  EXPECT_THAT(
      faults(R"([{"instr_id": "7_0", "trajectory": ["v0"]},
                         {"instr_id": "7_1", "trajectory": ["v0"]},
                         {"instr_id": "7_0", "trajectory": ["v9"]},
                         {"instr_id": "9_0", "trajectory": ["v9", 7]},
                         {"instr_id": 8, "trajectory": "v0"},
                         {"trajectory": ["v0"]},
                         {"instr_id": "8_0"},
                         [],
                         {"instr_id": "8_0", "instr_id": "8_0", "trajectory": ["v3"]}])"),
      ElementsAre("$[2].instr_id: repeated-instr-id", "$[2].trajectory[0]: unknown-viewpoint",
                  "$[3].instr_id: unknown-instr-id", "$[3].trajectory[1]: bad-entry",
                  "$[4].instr_id: not-a-string", "$[4].trajectory: not-an-array",
                  "$[5]: missing-field", "$[6]: missing-field", "$[7]: not-an-object",
                  "$[8].instr_id: repeated-field", "$[8].instr_id: repeated-instr-id",
                  "$: missing-instr-id"));
  EXPECT_THAT(message("[]"), AllOf(HasSubstr(R"($: no entry for instr_id "7_0" of split val)"),
                                   HasSubstr(R"(instr_id "8_0")")));
}

TEST(Results, CountManyMissingOnes) {
  EpisodeSet many = episodes();
  for (int i = 0; i < 30; ++i) {
    many.episodes.push_back({fmt::format("100_{}", i), 0, 0, "Go."});
  }
  try {
    parse_results(R"([{"instr_id": "7_0", "trajectory": ["v0"]}])", "r.json", many);
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.diagnostics().size(), 1U);
    EXPECT_THAT(error.diagnostics()[0].message,
                AllOf(HasSubstr("33 of the 34"), HasSubstr("\"7_1\", \"7_2\", \"8_0\", \"100_0\""),
                      HasSubstr("\"100_16\" and 13 more")));
  }
}

TEST(Results, LeaveAFourthInstructionOut) {
  std::string text = file_with(R"(["v0"])");
  text.insert(1, R"({"instr_id": "7_3", "trajectory": ["anything"]}, )");
  const Results results = parse(text);
  ASSERT_EQ(results.warnings.size(), 1U);
  EXPECT_EQ(results.warnings[0].severity, Severity::kWarning);
  EXPECT_EQ(results.warnings[0].where, "$[0].instr_id");
  EXPECT_EQ(results.trajectories.size(), 4U);
  for (const std::string id : {"7_4", "7_03", "8_3", "9_3", "_3", "7_3_3"}) {
    text = file_with(R"(["v0"])");
    text.insert(1, fmt::format(R"({{"instr_id": "{}", "trajectory": ["v0"]}}, )", id));
    EXPECT_THAT(faults(text), ElementsAre("$[0].instr_id: unknown-instr-id")) << id;
  }
}

TEST(Results, KeepAFourthInstructionThatIsAnEpisode) {
  EpisodeSet all = episodes();
  all.episodes.push_back({"7_3", 0, 3, "Once more."});
  std::string text = file_with(R"(["v0"])");
  EXPECT_THROW(parse_results(text, "r.json", all), InvalidInput);
  text.insert(1, R"({"instr_id": "7_3", "trajectory": ["v0", "v1"]}, )");
  const Results results = parse_results(text, "r.json", all);
  EXPECT_THAT(results.warnings, IsEmpty());
  EXPECT_THAT(viewpoints(results.trajectories.back()), ElementsAre(0, 1));
}

TEST(Results, MayBeOfAPartOfASplit) {
  const std::string text = R"([{"instr_id": "8_0", "trajectory": ["v3", "v2"]},
                               {"instr_id": "7_1", "trajectory": ["v0"]}])";
  EXPECT_THROW(parse(text), InvalidInput);
  Results results = parse_results(text, "r.json", episodes(), Coverage::kPart);
  ASSERT_EQ(results.trajectories.size(), 2U);
  EXPECT_EQ(results.trajectories[0].episode, 1U);
  EXPECT_EQ(results.trajectories[1].episode, 3U);
  const EpisodeSet part = part_of(episodes(), results.trajectories);
  ASSERT_EQ(part.episodes.size(), 2U);
  EXPECT_EQ(part.episodes[0].instruction_id, "7_1");
  EXPECT_EQ(part.episodes[1].instruction_id, "8_0");
  EXPECT_EQ(results.trajectories[1].episode, 1U);
  EXPECT_EQ(part.path_of(part.episodes[1]).path_id, 8);
  for (
      const std::string wrong :
      {R"([])", R"([{"instr_id": "9_0", "trajectory": ["v0"]}])",
       R"([{"instr_id": "7_1", "trajectory": ["v0"]}, {"instr_id": "7_1", "trajectory": ["v0"]}])"}) {
    EXPECT_THROW(parse_results(wrong, "r.json", episodes(), Coverage::kPart), InvalidInput)
        << wrong;
  }
}

TEST(Results, NameTheirFile) {
  const tests::TemporaryFolder folder("results");
  const auto file = folder.path() / "results.json";
  write_file_atomically(file, file_with(R"(["v0", "v1"])"));
  EXPECT_EQ(load_results(file, episodes()).trajectories.size(), 4U);
  write_file_atomically(file, "[");
  try {
    load_results(file, episodes());
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.diagnostics().at(0).file, file.string());
  }
  std::filesystem::remove(file);
  EXPECT_THROW(load_results(file, episodes()), FileError);
}

TEST(Results, StopReadingAFileOfFaults) {
  std::string text = "[";
  for (int k = 0; k < 100'000; ++k) text += "{},";
  std::vector<Diagnostic> found;
  try {
    parse(text + "{}]");
  } catch (const InvalidInput& error) {
    found = error.diagnostics();
  }
  ASSERT_EQ(found.size(), kMostFaultsKept + 1);  // no instr_id and no trajectory, 500 times
  EXPECT_EQ(found.front().where, "$[0]");
  EXPECT_EQ(found.back().where, "$[500]");
  EXPECT_EQ(found.back().code, kMoreFaults);
  EXPECT_THAT(message(text), HasSubstr("$[500]: not read from here on, after 1000 errors"))
      << "that the list does not end is not seen";
  // The faults of one entry, the file's last.
  std::string trajectory = "[";
  for (int k = 0; k < 5000; ++k) trajectory += "0,";
  const std::string last =
      fmt::format(R"([{{"instr_id": "7_0", "trajectory": {}0]}}])", trajectory);
  EXPECT_THAT(message(last), HasSubstr("$[0].trajectory[1000]: not read from here on"));
}

TEST(Results, AnEntryOfMegabytesIsRefusedAndTheRestIsRead) {
  const std::string large = "\"" + std::string(std::size_t{1} << 20U, 'x') + "\"";
  EXPECT_THAT(trajectory_faults(R"(["v0"], "note": )" + large),
              ElementsAre("$[0]: too-large", "$: missing-instr-id"));
  EXPECT_THAT(message(file_with(R"(["v0"], "note": )" + large)),
              HasSubstr("bytes; 1048576 are allowed"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
