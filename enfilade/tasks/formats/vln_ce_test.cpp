// SYNTHETIC files of VLN-CE's forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "enfilade/tasks/continuous_episodes.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using Json = nlohmann::json;

const std::string kR2r =
    R"({"episodes": [{"episode_id": 7, "trajectory_id": 15, "scene_id": "mp3d/one/one.glb", )"
    R"("start_position": [1.5, 0.25, -4], "start_rotation": [0, 0.6, 0, -0.8], )"
    R"("info": {"geodesic_distance": 7.5}, "goals": [{"position": [2, 0.25, 3], "radius": 3.0}], )"
    R"("instruction": {"instruction_text": "Walk on. ", "instruction_tokens": [4, 5, 0]}, )"
    R"("reference_path": [[1.5, 0.25, -4], [2, 0.25, 3]]}], "instruction_vocab": {"word_list": )"
    R"(["<pad>", "<unk>"], "word2idx_dict": {"<pad>": 0}, "num_vocab": 2, "UNK_INDEX": 1, )"
    R"("PAD_INDEX": 0}})";
const std::string kTest =
    R"({"episodes": [{"episode_id": 7, "trajectory_id": 15, "scene_id": "one.glb", )"
    R"("start_position": [1, 2, 3], "start_rotation": [0, 0, 0, 1], )"
    R"("instruction": {"instruction_text": "Go."}, "goals": null}]})";
const std::string kRxr =
    R"({"episodes": [{"episode_id": "7", "trajectory_id": "15", "scene_id": "mp3d/one/one.glb", )"
    R"("start_position": [1, 2, 3], "start_rotation": [0, 0, 0, 1], )"
    R"("info": {"geodesic_distance": 7.5, "role": "follower"}, )"
    R"("goals": [{"position": [2, 0.25, 3], "radius": 3.0, "kind": "point"}], "instruction": )"
    R"({"instruction_text": "\u0906", "instruction_id": "26", "language": "hi-IN", )"
    R"("annotator_id": "19", "edit_distance": 0.125, "timed_instruction": )"
    R"([{"start_time": 0.5, "word": "\u0906"}], "split": "x"}, )"
    R"("reference_path": [[1, 2, 3]], "tour": {"part": [1, "a", 2.5]}}], "version": 2})";
const std::string kWalks =
    R"({"302": {"locations": [[1, 2, 3], [1, 2, 3.25]], "forward_steps": 1, "actions": [2, 1, 0]}, )"
    R"("7": {"locations": [[0, 0, 0]], "forward_steps": 0, "actions": [0], "seed": 5}})";

ContinuousEpisodes parsed(const std::string& text) {
  return parse_continuous_episodes(text, "e.json", "made");
}

std::string edited(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string faults(const std::string& from, const std::string& to, const std::string& text = kR2r) {
  return tests::refusal<InvalidInput>([&] { parsed(edited(text, from, to)); });
}

TEST(ContinuousEpisodes, ReadsAnEpisodeIntoOurFrame) {
  const ContinuousEpisodes read = parsed(kR2r);
  EXPECT_EQ(read.split, "made");
  EXPECT_EQ(read.file, "e.json");
  ASSERT_EQ(read.episodes.size(), 1U);
  const ContinuousEpisode& one = read.episodes[0];
  EXPECT_EQ(one.id, FileId(7));
  EXPECT_EQ(text_of(one.trajectory_id), "15");
  EXPECT_EQ(one.scan(), "one");
  EXPECT_EQ(one.start, (Vec3d{1.5, 4, 0.25}));  // up is z, and north their -z
  // psi = 2 atan2(0.6, -0.8) counter-clockwise, so that the heading is 360 - 2 * 143.13 degrees
  EXPECT_NEAR(to_degrees(one.start_heading()), 360 - 2 * 143.13010235415598, 1e-9);
  EXPECT_EQ(one.info->geodesic_distance, 7.5);
  EXPECT_FALSE(one.goal_hidden());
  EXPECT_EQ(one.goals->at(0).position, (Vec3d{2, -3, 0.25}));
  EXPECT_EQ(one.goals->at(0).radius, 3.0);
  EXPECT_EQ(one.instruction.text, "Walk on. ");
  EXPECT_THAT(*one.instruction.tokens, ElementsAre(4, 5, 0));
  EXPECT_THAT(*one.reference_path, ElementsAre(Vec3d{1.5, 4, 0.25}, Vec3d{2, -3, 0.25}));
  EXPECT_THAT(read.vocabulary->words, ElementsAre("<pad>", "<unk>"));
  EXPECT_EQ(read.vocabulary->size, 2);
  EXPECT_EQ(read.vocabulary->unknown, 1);
  EXPECT_EQ(read.vocabulary->padding, 0);
  EXPECT_THAT(read.vocabulary->others, ElementsAre(Pair("word2idx_dict", R"({"<pad>":0})")));
}

TEST(ContinuousEpisodes, HideGoalsInTestSplits) {
  const ContinuousEpisodes read = parsed(kTest);
  const ContinuousEpisode& one = read.episodes[0];
  EXPECT_TRUE(one.goal_hidden());
  EXPECT_FALSE(one.info || one.reference_path || read.vocabulary || one.instruction.tokens);
  EXPECT_EQ(one.scan(), "one");
  EXPECT_EQ(one.start_heading(), Radians(0));
}

TEST(ContinuousEpisodes, ReadRxr) {
  const ContinuousEpisodes read = parsed(kRxr);
  const ContinuousEpisode& one = read.episodes[0];
  EXPECT_EQ(one.id, FileId("7"));
  EXPECT_EQ(one.info->role, AnnotationRole::kFollower);
  EXPECT_EQ(one.instruction.id, FileId("26"));
  EXPECT_EQ(one.instruction.language, "hi-IN");
  EXPECT_EQ(one.instruction.annotator, FileId("19"));
  EXPECT_EQ(one.instruction.edit_distance, 0.125);
  EXPECT_THAT(*one.instruction.words, ElementsAre(TimedWord{"\xE0\xA4\x86", 0.5, {}}));
}

TEST(ContinuousEpisodes, KeepFieldsThatTheModelDoesNotHave) {
  const ContinuousEpisodes read = parsed(kRxr);
  EXPECT_THAT(read.others, ElementsAre(Pair("version", "2")));
  EXPECT_THAT(read.episodes[0].others, ElementsAre(Pair("tour", R"({"part":[1,"a",2.5]})")));
  EXPECT_THAT(read.episodes[0].goals->at(0).others, ElementsAre(Pair("kind", "\"point\"")));
  EXPECT_THAT(read.episodes[0].instruction.others, ElementsAre(Pair("split", "\"x\"")));
}

TEST(ContinuousEpisodes, NameTheirScansAsTheirDataSetsDo) {
  for (const auto& [scene, scan] : std::vector<std::pair<std::string, std::string>>{
           {"mp3d/zsNo4HB9uLZ/zsNo4HB9uLZ.glb", "zsNo4HB9uLZ"},
           {"zsNo4HB9uLZ.glb", "zsNo4HB9uLZ"},
           {"zsNo4HB9uLZ", "zsNo4HB9uLZ"},
           {"data/scene_datasets/gibson/Cantwell.glb", "Cantwell"},
           {"mp3d\\\\one\\\\one.glb", "one"},
           // HM3D's: the folder has the number, which graphs have too.
           {"hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb", "00800-TEEsavR23oF"},
           {"/data/hm3d_v0.2/val/00800-TEEsavR23oF/TEEsavR23oF.glb", "00800-TEEsavR23oF"},
           {"00800-TEEsavR23oF/TEEsavR23oF.basis.glb", "00800-TEEsavR23oF"},
           {"hm3d/00800-TEEsavR23oF/00800-TEEsavR23oF.glb", "00800-TEEsavR23oF"},
           {"hm3d/00800-TEEsavR23oF.glb", "00800-TEEsavR23oF"},
           {"hm3d/00800-other/TEEsavR23oF.basis.glb", "TEEsavR23oF"},
           {"hm3d/val-TEEsavR23oF/TEEsavR23oF.basis.glb", "TEEsavR23oF"},
           {"hm3d/00800/TEEsavR23oF.basis.glb", "TEEsavR23oF"},
           {"lab/room.2/room.2.glb", "room.2"},
           {"lab/room/room.2.glb", "room"},
           {"/one.glb", "one"}}) {
    EXPECT_EQ(parsed(edited(kR2r, "mp3d/one/one.glb", scene)).episodes.at(0).scan(), scan) << scene;
  }
  for (const char* scene : {"", "/", "mp3d/one/", ".glb", "a/.glb"}) {
    EXPECT_EQ(scan_of_scene(scene), "") << scene;
  }
}

TEST(ContinuousEpisodes, GetTheScenesOfTheirScans) {
  for (const auto& [scan, scene] : std::vector<std::pair<std::string, std::string>>{
           {"zsNo4HB9uLZ", "mp3d/zsNo4HB9uLZ/zsNo4HB9uLZ.glb"},
           {"room.2", "mp3d/room.2/room.2.glb"},
           {"00000-kfPV7w3FaU5", "hm3d/train/00000-kfPV7w3FaU5/kfPV7w3FaU5.basis.glb"},
           {"00744-1S7LAXRdDqK", "hm3d/train/00744-1S7LAXRdDqK/1S7LAXRdDqK.basis.glb"},
           {"00800-TEEsavR23oF", "hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb"},
           {"00900-XRJ2muKkwAV", "hm3d/test/00900-XRJ2muKkwAV/XRJ2muKkwAV.basis.glb"},
           {"01000-room", "hm3d/01000-room/room.basis.glb"},
           {"2026-room", "mp3d/2026-room/2026-room.glb"}}) {
    EXPECT_EQ(scene_of_scan(scan, "mp3d"), scene);
    EXPECT_EQ(scan_of_scene(scene), scan);
  }
}

TEST(ContinuousEpisodes, AreWrittenBackEqual) {
  for (const std::string& text : {kR2r, edited(kTest, ", \"goals\": null", ""), kRxr}) {
    const ContinuousEpisodes read = parsed(text);
    const std::string written = to_json(read);
    EXPECT_EQ(Json::parse(written), Json::parse(text));
    const ContinuousEpisodes again = parsed(written);
    EXPECT_EQ(again.episodes, read.episodes);
    EXPECT_EQ(again.vocabulary, read.vocabulary);
    EXPECT_EQ(again.others, read.others);
  }
  EXPECT_EQ(Json::parse(to_json(ContinuousEpisodes{})), Json::parse(R"({"episodes": []})"));
}

TEST(ContinuousEpisodes, ReportFaultsWithTheirPaths) {
  EXPECT_THAT(faults("\"episodes\"", "\"all\""), HasSubstr("$: has no field \"episodes\""));
  EXPECT_THAT(faults("\"episode_id\": 7", "\"episode_id\": 7.5"),
              HasSubstr("$.episodes[0].episode_id: number 7.5, neither a whole number nor a text"));
  EXPECT_THAT(faults("\"episode_id\": 7", "\"episode_id\": \"\""),
              HasSubstr("$.episodes[0].episode_id: an empty id"));
  EXPECT_THAT(faults("mp3d/one/one.glb", "mp3d/one/"),
              HasSubstr("$.episodes[0].scene_id: \"mp3d/one/\" names no scan"));
  EXPECT_THAT(faults("[1.5, 0.25, -4], \"start_r", "[1.5, 0.25], \"start_r"),
              HasSubstr("$.episodes[0].start_position: 2 numbers, not 3"));
  EXPECT_THAT(faults("[1.5, 0.25, -4], \"start_r", "[1.5, \"up\", -4], \"start_r"),
              HasSubstr("$.episodes[0].start_position[1]: string \"up\", not a number"));
  EXPECT_THAT(faults("[0, 0.6, 0, -0.8]", "[0, 0.6, 0]"),
              HasSubstr("$.episodes[0].start_rotation: 3 numbers, not 4"));
  EXPECT_THAT(faults("[0, 0.6, 0, -0.8]", "[0.6, 0, 0, -0.8]"),
              HasSubstr("$.episodes[0].start_rotation: [0.6, 0, 0, -0.8] is no rotation about"));
  EXPECT_THAT(faults("[0, 0.6, 0, -0.8]", "[0, 0, 0, 0]"), HasSubstr("of length 1 is"));
  EXPECT_THAT(faults("7.5", "-7.5"),
              HasSubstr("$.episodes[0].info.geodesic_distance: -7.5 is no distance in metres"));
  EXPECT_THAT(faults("[{\"position\": [2, 0.25, 3], \"radius\": 3.0}]", "[]"),
              HasSubstr("$.episodes[0].goals: no goal"));
  EXPECT_THAT(faults("\"radius\": 3.0", "\"radius\": -3"),
              HasSubstr("$.episodes[0].goals[0].radius: -3 is no radius in metres"));
  EXPECT_THAT(faults("\"instruction_text\"", "\"text\""),
              HasSubstr("$.episodes[0].instruction: has no field \"instruction_text\""));
  EXPECT_THAT(faults("[4, 5, 0]", "[4, -5, 0]"),
              HasSubstr("$.episodes[0].instruction.instruction_tokens[1]: -5 is no token"));
  EXPECT_THAT(faults("[[1.5, 0.25, -4], [2, 0.25, 3]]", "[]"),
              HasSubstr("$.episodes[0].reference_path: no point"));
  EXPECT_THAT(faults("\"<unk>\"", "3"), HasSubstr("$.instruction_vocab.word_list[1]: number 3"));
  EXPECT_THAT(faults("\"PAD_INDEX\": 0", "\"PAD_INDEX\": -1"),
              HasSubstr("$.instruction_vocab.PAD_INDEX: -1 is no token"));
  EXPECT_THAT(faults("follower", "leader", kRxr),
              HasSubstr("$.episodes[0].info.role: \"leader\", neither \"guide\" nor \"follower\""));
  EXPECT_THAT(faults("\"word\"", "\"said\"", kRxr),
              HasSubstr("$.episodes[0].instruction.timed_instruction[0]: has no field \"word\""));
  EXPECT_THAT(faults("\"version\": 2", "\"version\": 2, \"version\": 2", kRxr),
              HasSubstr("$.version: given twice in one object"));
  EXPECT_THAT(faults("2.5]", "{\"b\": 1, \"b\": 2}]", kRxr),
              HasSubstr("$.episodes[0].tour.part[2].b: given twice in one object"));
  EXPECT_THAT(tests::refusal<InvalidInput>([] { parsed(kR2r.substr(0, 300)); }),
              HasSubstr("the file ends too early"));
  EXPECT_THAT(faults("[4, 5, 0]", "[4, 5, NaN]"),
              HasSubstr("$.episodes[0].instruction.instruction_tokens[2]: line 1, column"));
  EXPECT_THAT(tests::refusal<InvalidInput>([] { parsed(R"({"episodes": {"1": 2}})"); }),
              HasSubstr("$.episodes: object, not an array"));
  EXPECT_THAT(tests::refusal<InvalidInput>([] { parsed("[]"); }),
              HasSubstr("$: array, not an object"));
  EXPECT_THAT(tests::refusal<InvalidInput>([] { parsed(""); }), HasSubstr("the file is empty"));
  EXPECT_THAT(faults("\"reference_path\"",
                     "\"x\": \"" + std::string(5U << 20U, 'x') + "\", \"reference_path\""),
              HasSubstr("$.episodes[0]: 5243"));
}

TEST(ContinuousEpisodes, ReportAnIdThatIsThereTwiceAsNumberOrText) {
  const std::string one = kTest.substr(14, kTest.size() - 16);
  const std::string two = "{\"episodes\": [" + one + ", " +
                          edited(one, "\"episode_id\": 7", "\"episode_id\": \"7\"") + "]}";
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { parsed(two); }),
              HasSubstr("$.episodes[1].episode_id: \"7\" stands at $.episodes[0] already"));
}

TEST(ContinuousEpisodes, AreNotWrittenWhereJsonCannotSayThem) {
  const auto refusal = [](const auto& damage) {
    ContinuousEpisodes episodes = parsed(kR2r);
    damage(episodes);
    return tests::refusal<ArgumentError>([&] { to_json(episodes); });
  };
  EXPECT_THAT(
      refusal([](auto& all) { all.episodes[0].start.x = std::numeric_limits<double>::infinity(); }),
      HasSubstr("episode 7: inf, not a finite number"));
  EXPECT_THAT(refusal([](auto& all) { all.episodes[0].instruction.text = "\xFF"; }),
              HasSubstr("episode 7: holds text that is not UTF-8"));
  EXPECT_THAT(refusal([](auto& all) {
                all.episodes[0].others = {{"tour", "{"}};
              }),
              HasSubstr("episode 7: field \"tour\" is no JSON"));
  EXPECT_THAT(refusal([](auto& all) {
                all.others = {{"episodes", "1"}};
              }),
              HasSubstr("the file: \"episodes\" is no other field"));
}

TEST(StartRotation, GoesToAHeadingAndBack) {
  EXPECT_EQ(StartRotation::of(Radians(0)).heading(), Radians(0));
  for (double heading = 0.125; heading < 6.28; heading += 0.25) {
    EXPECT_NEAR(StartRotation::of(Radians(heading)).heading().value, heading, 1e-12);
  }
  // Turning left by psi: forward is (-sin psi, 0, -cos psi) in Habitat, and our heading -psi.
  EXPECT_NEAR((StartRotation{0, std::sin(0.1), 0, std::cos(0.1)}.heading().value), 2 * kPi - 0.2,
              1e-12);
}

TEST(ExpertWalks, AreReadAndWrittenBackEqual) {
  const ExpertWalks walks = parse_expert_walks(kWalks, "gt.json");
  ASSERT_EQ(walks.size(), 2U);
  const ExpertWalk& walk = walks.at("302");
  EXPECT_THAT(walk.locations, ElementsAre(Vec3d{1, -3, 2}, Vec3d{1, -3.25, 2}));
  EXPECT_EQ(walk.forward_steps, 1);
  EXPECT_THAT(walk.actions, ElementsAre(2, 1, 0));
  EXPECT_THAT(walks.at("7").others, ElementsAre(Pair("seed", "5")));
  const std::string written = to_json(walks);
  EXPECT_EQ(Json::parse(written), Json::parse(kWalks));
  EXPECT_EQ(parse_expert_walks(written, "gt.json"), walks);
}

TEST(ExpertWalks, ReportFaultsWithTheirPaths) {
  const auto refused = [](const std::string& from, const std::string& to) {
    return tests::refusal<InvalidInput>(
        [&] { parse_expert_walks(edited(kWalks, from, to), "gt.json"); });
  };
  EXPECT_THAT(refused("[2, 1, 0]", "[2, 6, 0]"),
              HasSubstr("$.302.actions[1]: 6 is no action; 0 to 5 are"));
  EXPECT_THAT(refused("[[0, 0, 0]]", "[]"), HasSubstr("$.7.locations: no point"));
  EXPECT_THAT(refused("\"forward_steps\": 1", "\"forward_steps\": -1"),
              HasSubstr("$.302.forward_steps: -1 is no number of steps"));
  EXPECT_THAT(refused("\"7\"", "\"302\""), HasSubstr("$.302: a walk of this episode"));
  EXPECT_THAT(refused("\"actions\": [2, 1, 0]", "\"steps\": []"),
              HasSubstr("$.302: has no field \"actions\""));
  EXPECT_THAT(tests::refusal<InvalidInput>([] { parse_expert_walks("[]", "gt.json"); }),
              AllOf(HasSubstr("gt.json: $: array, not an object"), HasSubstr("not-an-object")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
