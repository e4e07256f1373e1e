// Episodes of every benchmark as the viewer gets them, over real sockets.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/tasks/files.h"
#include "enfilade/tasks/pose_trace.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using testing::Served;

constexpr const char* kSecretTest =
    R"({"name": "test", "title": "Test", "split": "test", "annotations": "secret.json"})";

void write(const Served& served, const std::string& name, const std::string& text) {
  const auto file = served.root() / "data" / name;
  std::filesystem::create_directories(file.parent_path());
  write_file_atomically(file, text);
}

// REVERIE with goals in two splits, of which a phase keeps the second secret; CVDN; RxR.
void add_benchmarks(Served& served) {
  const std::string reverie =
      R"([{"id": "1_66", "path": ["v0", "v1", "v2"], "objId": 66, "heading": 1.5, "scan": "row", )"
      R"("path_id": 1, "instructions": ["Water the plant."]}])";
  write(served, "reverie/REVERIE_val_seen.json", reverie);
  write(served, "reverie/REVERIE_test.json", reverie);
  write(served, "reverie/BBoxes.json",
        R"({"row_v2": {"66": {"name": "plant#pot", "visible_pos": [12], )"
        R"("bbox2d": [[270, 190, 100, 100]]}}, "row_v3": {}})");
  write(served, "cvdn/val_seen.json",
        R"([{"inst_idx": 12, "scan": "row", "target": "chair", "start_pano": {"heading": 1.25, )"
        R"("elevation": 0.0, "pano": "v0"}, "nav_camera": [], "dialog_history": [)"
        R"({"nav_idx": 0, "role": "navigator", "message": "Left?"}, )"
        R"({"nav_idx": 2, "role": "oracle", "message": "Yes."}], )"
        R"("nav_history": ["v0"], "game_idx": 3, "end_panos": ["v2", "v3"], )"
        R"("player_path": ["v0", "v1", "v2"], "planner_path": ["v0", "v1"]}])");
  write(served, "rxr/rxr_val_seen_guide.jsonl",
        R"({"path_id": 11, "split": "val_seen", "scan": "row", "heading": 3.25, )"
        R"("path": ["v0", "v1"], "instruction_id": 26, "annotator_id": 19, )"
        R"("language": "te-IN", "instruction": "Go on", "timed_instruction": )"
        R"([{"start_time": 0.4, "word": "Go", "end_time": 1.0}, {"word": "on"}]})"
        "\n");
  served.restart_with(kSecretTest);
}

nlohmann::json episode(Served& served, const std::string& split, const std::string& query) {
  const auto answer = served.json("/api/v1/splits/" + split + "/episodes?" + query);
  const auto list = answer.value("episodes", nlohmann::json::array());
  EXPECT_EQ(list.size(), 1U) << answer;
  return list.empty() ? nlohmann::json() : list[0];
}

TEST(EpisodeJson, SplitsSayTheirBenchmark) {
  Served served;
  add_benchmarks(served);
  std::vector<std::string> found;
  const auto list = served.json("/api/v1/splits?task=all");
  for (const auto& split : list.at("splits")) {
    found.push_back(split.at("title").get<std::string>() + " " +
                    split.at("split").get<std::string>());
  }
  EXPECT_THAT(found, ::testing::ElementsAre("R2R val_seen", "R2R test", "RxR val_seen",
                                            "REVERIE val_seen", "REVERIE test", "CVDN val_seen"));
  EXPECT_EQ(served.json("/api/v1/splits/val_seen/episodes").at("matching"), 6) << "R2R's";
  const auto reverie = served.json("/api/v1/splits/val_seen/episodes?task=reverie");
  EXPECT_EQ(reverie.at("matching"), 1);
  EXPECT_EQ(reverie.at("title"), "REVERIE");
  EXPECT_EQ(list.at("continuous"), nlohmann::json::array());
  EXPECT_EQ(served.get("/api/v1/splits/val_seen/episodes?task=soon")->status, 404);
  EXPECT_EQ(served.get("/api/v1/splits/val_seen/episodes?task=none")->status, 404);
}

TEST(EpisodeJson, AnEpisodeHasItsNeighboursInTheList) {
  Served served;
  const auto second = episode(served, "val_seen", "id=2_0");
  EXPECT_EQ(second.at("number"), 3);
  EXPECT_EQ(second.at("of"), 6);
  EXPECT_EQ(second.at("previous"), "1_1");
  EXPECT_EQ(second.at("next"), "2_1");
  EXPECT_FALSE(episode(served, "val_seen", "id=1_0").contains("previous"));
  EXPECT_FALSE(episode(served, "val_seen", "id=3_1").contains("next"));
  // Among those with a word.
  const auto table = episode(served, "val_seen", "id=2_1&q=TABLE");
  EXPECT_EQ(table.at("number"), 2);
  EXPECT_EQ(table.at("of"), 3);
  EXPECT_EQ(table.at("previous"), "1_1");
  EXPECT_EQ(table.at("next"), "3_1");
  const auto aside = episode(served, "val_seen", "id=2_0&q=TABLE");
  EXPECT_EQ(aside.at("instruction_id"), "2_0") << "an id finds it, whatever the list is";
  for (const char* field : {"number", "of", "previous", "next"}) {
    EXPECT_FALSE(aside.contains(field)) << field;
  }
  EXPECT_FALSE(episode(served, "val_seen", "id=2_0&scan=wing").contains("number"));
  EXPECT_EQ(served.json("/api/v1/splits/val_seen/episodes?id=9_9").at("matching"), 0);
}

std::vector<std::string> instructions_of(const nlohmann::json& episode) {
  std::vector<std::string> ids;
  for (const auto& one : episode.at("instructions")) {
    ids.push_back(one.at("instruction_id").get<std::string>());
  }
  return ids;
}

// A guide's line. \param path ids in JSON
std::string guide(int path_id, int number, const char* language, const char* path) {
  return fmt::format(
      R"({{"path_id": {}, "split": "x", "scan": "row", "heading": 3.25, "path": {}, )"
      R"("instruction_id": {}, "annotator_id": 1, "language": "{}", "instruction": "Go on", )"
      R"("timed_instruction": []}})"
      "\n",
      path_id, path, number, language);
}

TEST(EpisodeJson, AnEpisodeHasAllInstructionsOfItsPath) {
  Served served;
  write(served, "rxr/rxr_val_unseen_guide.jsonl",
        guide(11, 1, "en-IN", R"(["v0", "v1"])") + guide(12, 2, "en-IN", R"(["v1", "v2"])") +
            guide(11, 3, "te-IN", R"(["v0", "v1"])"));
  add_benchmarks(served);
  const auto r2r = episode(served, "val_seen", "id=2_1");
  EXPECT_THAT(instructions_of(r2r), ::testing::ElementsAre("2_0", "2_1"));
  EXPECT_EQ(r2r["instructions"][1].at("instruction"), "Go past the <b>table</b>.");
  EXPECT_FALSE(r2r["instructions"][1].contains("language"));
  const auto rxr = episode(served, "val_unseen", "task=rxr&id=11_3");
  EXPECT_THAT(instructions_of(rxr), ::testing::ElementsAre("11_1", "11_3"));
  EXPECT_EQ(rxr["instructions"][1].at("language"), "te-IN");
  EXPECT_FALSE(
      served.json("/api/v1/splits/val_seen/episodes").at("episodes")[0].contains("instructions"))
      << "of one that is asked for only";
}

// Fine-grained R2R of the row's annotations: each first instruction in two pieces.
std::string fine_grained(const std::string& split) {
  tasks::Annotations annotations = testing::row_annotations(split, true);
  for (tasks::PathAnnotation& path : annotations.paths) {
    path.details.resize(path.instructions.size());
    path.details[0].parts = {{{"walk", "on"}, std::pair<std::size_t, std::size_t>{0, 2}},
                             {{"stop"}, std::pair<std::size_t, std::size_t>{2, 3}}};
    path.details[1].parts = {{{"go"}, std::pair<std::size_t, std::size_t>{0, 3}}};
  }
  return tasks::to_text(annotations);
}

TEST(EpisodeJson, PiecesOfFineGrainedR2rComeWithR2rsInstructions) {
  Served served;
  tasks::Annotations other =
      tasks::parse_annotations(fine_grained("val_seen"), "", "val_seen", tasks::Task::kR2r);
  other.paths[1].path.pop_back();  // of another version
  for (auto& details : other.paths[1].details) details.parts.pop_back();
  other.paths[2].instructions[0] += " Now.";
  write(served, "fgr2r/FGR2R_val_seen.json", tasks::to_text(other));
  const auto parts = episode(served, "val_seen", "id=1_0").at("parts");
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].at("words"), nlohmann::json({"walk", "on"}));
  EXPECT_EQ(parts[0].at("places"), nlohmann::json({0, 2}));
  EXPECT_EQ(parts[1].at("places"), nlohmann::json({2, 3}));
  EXPECT_FALSE(episode(served, "val_seen", "id=2_0").contains("parts")) << "another path";
  EXPECT_FALSE(episode(served, "val_seen", "id=3_0").contains("parts")) << "another text";
  EXPECT_EQ(episode(served, "val_seen", "id=3_1").at("parts").size(), 1U);
  EXPECT_FALSE(episode(served, "val_seen", "id=1_0").contains("parts_problem"));
  served.stop();
  write(served, "fgr2r/FGR2R_val_seen.json", "[{");
  served.start();
  const auto broken = episode(served, "val_seen", "id=1_0");
  EXPECT_FALSE(broken.contains("parts"));
  EXPECT_TRUE(broken.contains("parts_problem"));
  EXPECT_EQ(broken.at("path").size(), 4U);
}

TEST(EpisodeJson, AnObjectHasItsOutline) {
  Served served;
  add_benchmarks(served);
  const auto brief =
      served.json("/api/v1/splits/val_seen/episodes?task=reverie").at("episodes").at(0);
  EXPECT_EQ(brief.at("instruction_id"), "1_66_0");
  EXPECT_FALSE(brief.contains("goal")) << "of one that is asked for only";
  const auto goal = episode(served, "val_seen", "task=reverie&id=1_66_0").at("goal");
  EXPECT_EQ(goal.at("kind"), "object");
  EXPECT_EQ(goal.at("object"), 66);
  EXPECT_EQ(goal.at("name"), "plant");
  EXPECT_EQ(goal.at("viewpoints"), nlohmann::json({"v2"}));
  ASSERT_EQ(goal.at("outlines").size(), 1U);
  const auto& outline = goal["outlines"][0];
  EXPECT_EQ(outline.at("viewpoint"), "v2");
  EXPECT_EQ(outline.at("label"), "plant");
  // The box is around the middle of view 12, which looks north: its left top corner is 50 pixels
  // to the left of, and above, a picture whose focal length is 240 / tan 30.
  const double slope = 50 / (240 / std::tan(std::numbers::pi / 6));
  EXPECT_NEAR(outline.at("rim").at(0).get<double>(), 2 * std::numbers::pi - std::atan(slope), 1e-4);
  EXPECT_NEAR(outline["rim"].at(1).get<double>(), std::atan(slope / std::sqrt(1 + slope * slope)),
              1e-4);
}

TEST(EpisodeJson, ADialogueHasTurnsAndARegion) {
  Served served;
  add_benchmarks(served);
  const auto id = served.json("/api/v1/splits/val_seen/episodes?task=cvdn")
                      .at("episodes")
                      .at(0)
                      .at("instruction_id")
                      .get<std::string>();
  const auto one = episode(served, "val_seen", "task=cvdn&id=" + id);
  EXPECT_EQ(one.at("task"), "cvdn");
  ASSERT_EQ(one.at("turns").size(), 2U);
  EXPECT_EQ(one["turns"][1].at("role"), "oracle");
  EXPECT_EQ(one["turns"][1].at("nav_step"), 2);
  EXPECT_EQ(one.at("goal").at("kind"), "region");
  EXPECT_EQ(one["goal"].at("name"), "chair");
  EXPECT_EQ(one["goal"].at("viewpoints"), nlohmann::json({"v2", "v3"}));
}

TEST(EpisodeJson, WordsHaveTheirTimesAndLanguage) {
  Served served;
  add_benchmarks(served);
  const auto one = episode(served, "val_seen", "task=rxr&id=11_26");
  EXPECT_EQ(one.at("language"), "te-IN");
  ASSERT_EQ(one.at("words").size(), 2U);
  EXPECT_EQ(one["words"][0].at("start"), 0.4);
  EXPECT_FALSE(one["words"][1].contains("start"));
  EXPECT_EQ(one.at("goal").at("kind"), "end");
}

TEST(EpisodeJson, AGuidesLooksComeWithTheWords) {
  Served served;
  add_benchmarks(served);
  tasks::PoseTrace trace;
  const auto look = [&trace](const char* viewpoint, double time, double heading) {
    tasks::CameraLook at;
    at.position = {0, 0, 1.5};
    at.heading = degrees(heading);
    at.view_angle = degrees(75);
    at.aspect = 1.5;
    trace.snapshots.push_back(tasks::snapshot_of(viewpoint, time, at));
  };
  look("v0", 0, 90);
  look("v0", 0.01, 91);  // too soon after the last one
  look("v0", 1, 120);
  look("v1", 1.01, 45);  // a step always counts
  const std::string name = "rxr/pose_traces/rxr_val_seen/000026_guide_pose_trace.npz";
  write(served, name, tasks::to_npz(trace));
  const auto got = episode(served, "val_seen", "task=rxr&id=11_26").at("trace");
  EXPECT_EQ(got.at("times"), nlohmann::json({0.0, 1.0, 1.01}));
  EXPECT_EQ(got.at("viewpoints"), nlohmann::json({"v0", "v0", "v1"}));
  ASSERT_EQ(got.at("headings").size(), 3U);
  EXPECT_NEAR(got["headings"][1].get<double>(), degrees(120).value, 1e-4);
  EXPECT_NEAR(got.at("elevations")[0].get<double>(), 0, 1e-4);
  write(served, name, "no archive");
  const auto broken = episode(served, "val_seen", "task=rxr&id=11_26");
  EXPECT_FALSE(broken.contains("trace"));
  EXPECT_TRUE(broken.contains("trace_problem"));
  EXPECT_EQ(broken.at("words").size(), 2U);
}

// The data set's own file of the benchmark has the goals; a phase of that split keeps R2R's secret,
// and the same paths are in both.
TEST(EpisodeJson, GoalsOfASecretSplitAreHiddenInEveryBenchmark) {
  Served served;
  add_benchmarks(served);
  const std::string body = served.get("/api/v1/splits/test/episodes?task=reverie&id=1_0")->body;
  const auto one = nlohmann::json::parse(body).at("episodes").at(0);
  EXPECT_EQ(one.at("start"), "v0");
  EXPECT_FALSE(one.contains("goal"));
  EXPECT_FALSE(one.contains("path"));
  EXPECT_EQ(body.find("v2"), std::string::npos);
  EXPECT_EQ(body.find("66"), std::string::npos) << "the object";
}

// What is new about an episode tells nothing of a secret split: fine-grained R2R has whole paths,
// and RxR has an entry for each instruction of a path.
TEST(EpisodeJson, PiecesAndOtherEntriesOfASecretSplitAreHidden) {
  Served served;
  write(served, "fgr2r/FGR2R_test.json", fine_grained("test"));
  const std::string guides =
      guide(5, 1, "en-IN", R"(["v0", "v1", "v2"])") + guide(5, 2, "te-IN", R"(["v0", "v1", "v2"])");
  write(served, "rxr/rxr_test_guide.jsonl", guides);
  write_file_atomically(served.root() / "secret-rxr.jsonl", guides);
  served.restart_with(std::string(kSecretTest) +
                      R"(, {"name": "rxr", "split": "test", "task": "rxr", )"
                      R"("annotations": "secret-rxr.jsonl"})");
  const auto r2r = served.get("/api/v1/splits/test/episodes?id=1_0");
  EXPECT_THAT(r2r->body, ::testing::Not(::testing::HasSubstr("parts")));
  for (const char* secret : {"\"v1\"", "\"v2\"", "\"v3\""}) {
    EXPECT_THAT(r2r->body, ::testing::Not(::testing::HasSubstr(secret)));
  }
  const auto one = nlohmann::json::parse(r2r->body).at("episodes").at(0);
  EXPECT_THAT(instructions_of(one), ::testing::ElementsAre("1_0", "1_1"));
  EXPECT_EQ(one.at("next"), "1_1") << "the list has the order of the file, too";
  const auto rxr = episode(served, "test", "task=rxr&id=5_1");
  EXPECT_FALSE(rxr.contains("path"));
  EXPECT_THAT(instructions_of(rxr), ::testing::ElementsAre("5_1"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
