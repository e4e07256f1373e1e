// Every reader of foreign ids is given the same hostile ones. All files are SYNTHETIC.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/graph/corrections.h"
#include "enfilade/mesh/house.h"
#include "enfilade/models/decisions.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/scan/matterport_cameras.h"
#include "enfilade/scan/npy.h"
#include "enfilade/scan/regions.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/pose_trace.h"
#include "enfilade/tasks/results.h"
#include "tests/support/graphs.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::bad_input {
namespace EN_UNIT {

using namespace std::string_literals;
using tasks::Task;

std::vector<std::string> hostile_ids() {
  return {"../x", "/etc/passwd", "a/b",     std::string(1'000'000, 'a'),
          "a\n",  "\x1b[2J",     "\0"s,     "-o",
          "a b",  "..",          "\xc3\xa4"};
}

std::string with(std::string text, const std::string& id) {
  for (std::size_t at = text.find("ID"); at != std::string::npos;
       at = text.find("ID", at + id.size())) {
    text.replace(at, 2, id);
  }
  return text;
}

// A JSON text in which each ID, which stands within a string, is replaced.
std::string json_with(const std::string& text, const std::string& id) {
  const std::string quoted = nlohmann::json(id).dump();
  return with(text, quoted.substr(1, quoted.size() - 2));
}

using Parse = std::function<void(const std::string& id)>;

// Faults of a text in which the id is; empty if it was accepted.
std::vector<Diagnostic> faults_of(const Parse& parse, const std::string& id) {
  try {
    parse(id);
  } catch (const InvalidInput& refused) {
    return refused.diagnostics();
  }
  return {};
}

void expect_refused(const std::string& reader, const Parse& parse, const std::string& id) {
  const auto found = faults_of(parse, id);
  const std::string shown = fmt::format("{}, {:?}", reader, id.substr(0, 20));
  const auto bad = std::ranges::find(found, "bad-id", &Diagnostic::code);
  ASSERT_NE(bad, found.end()) << shown << (found.empty() ? " is accepted" : found[0].message);
  for (const Diagnostic& one : found) {
    EXPECT_LT(one.message.size() + one.where.size(), 600U) << shown;
    EXPECT_EQ(one.message.find('\x1b'), std::string::npos) << shown;
  }
}

// The id "v1" is one, whatever else is wrong with the file; the others and "" are not.
void expect_checked(const std::string& reader, const Parse& parse) {
  for (const std::string& id : hostile_ids()) expect_refused(reader, parse, id);
  expect_refused(reader, parse, "");
  for (const Diagnostic& one : faults_of(parse, "v1")) EXPECT_NE(one.code, "bad-id") << reader;
}

struct Document {
  const char* reader;
  std::string text;
};

void expect_all_checked(std::initializer_list<Document> documents,
                        const std::function<void(const std::string& text)>& parse) {
  for (const auto& [reader, text] : documents) {
    expect_checked(reader, [&](const std::string& id) { parse(json_with(text, id)); });
  }
}

TEST(HostileIds, AreRefusedInGraphs) {
  const std::string entry =
      R"([{"image_id": "ID", "pose": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], )"
      R"("included": true, "visible": [false], "unobstructed": [false]}])";
  expect_all_checked({{"image_id", entry}}, [](const std::string& text) {
    scan::parse_connectivity(text, "s", "g.json");
  });
  expect_all_checked({{"scan of regions", R"({"ID": {"0": ["v0"]}})"},
                      {"viewpoint of regions", R"({"one": {"0": ["ID"]}})"}},
                     [](const std::string& text) { scan::RegionMap::parse(text, "r.json"); });
  const std::string corrections =
      R"({"scan": "one", "corrections": [{"action": "add-edge", "who": "me", "why": "so", )";
  expect_all_checked({{"scan of corrections", R"({"scan": "ID", "corrections": []})"},
                      {"from", corrections + R"("from": "ID", "to": "v0"}]})"},
                      {"to", corrections + R"("from": "v0", "to": "ID"}]})"}},
                     [](const std::string& text) { graph::parse_corrections(text, "c.json"); });
}

TEST(HostileIds, AreRefusedInR2rAndItsFamily) {
  const std::string r2r =
      R"([{"path_id": 1, "scan": "one", "heading": 1, "path": ["v0"], "instructions": ["Go."], )";
  const std::string line = R"({"instr_id": "1_0", "scan": "one", "path": ["v0"], )"
                           R"("instr_encoding": [1], )";
  expect_all_checked(
      {{"path_id", R"([{"path_id": "ID", "scan": "one", "heading": 1, "path": ["v0"], )"
                   R"("instructions": ["Go."]}])"},
       {"scan", R"([{"path_id": 1, "scan": "ID", "heading": 1, "path": ["v0"], )"
                R"("instructions": ["Go."]}])"},
       {"path", R"([{"path_id": 1, "scan": "one", "heading": 1, "path": ["v0", "ID"], )"
                R"("instructions": ["Go."]}])"},
       {"scan of a line", R"({"instr_id": "1_0", "scan": "ID", "path": ["v0"], )"
                          R"("instr_encoding": [1]})"},
       {"path of a line", R"({"instr_id": "1_0", "scan": "one", "path": ["ID"], )"
                          R"("instr_encoding": [1]})"},
       {"instr_id of a line", R"({"instr_id": "ID", "scan": "one", "path": ["v0"], )"
                              R"("instr_encoding": [1]})"}},
      [](const std::string& text) {
        tasks::parse_annotations(text, "a.json", "made", Task::kR2r);
      });
  expect_all_checked({{"midstop", r2r + R"("midstop": "ID"}])"},
                      {"midstop of a line", line + R"("midstop": "ID"})"}},
                     [](const std::string& text) {
                       tasks::parse_annotations(text, "a.json", "made", Task::kR2rBack);
                     });
}

TEST(HostileIds, AreRefusedInRxrAndReverie) {
  const auto guide = [](const std::string& text) {
    tasks::parse_annotations(text, "a.jsonl", "made", Task::kRxr);
  };
  const std::string of_rxr = R"("heading": 1, "instruction_id": 7, "language": "en-US", )"
                             R"("instruction": "Go."})";
  expect_all_checked({{"scan", R"({"path_id": 1, "scan": "ID", "path": ["v0"], )" + of_rxr},
                      {"path", R"({"path_id": 1, "scan": "one", "path": ["ID"], )" + of_rxr}},
                     guide);
  expect_all_checked(
      {{"path of a follower",
        R"({"demonstration_id": 1, "instruction_id": 1, "annotator_id": 1, "path": ["ID"], )"
        R"("metrics": {"ne": 0, "sr": 1, "spl": 1, "dtw": 0, "ndtw": 1, "sdtw": 1}})"}},
      [](const std::string& text) { tasks::parse_demonstrations(text, "d.jsonl"); });
  const std::string of_reverie = R"("heading": 1, "instructions": ["Go."]}])";
  const std::string of_lines = R"("objid": 5, "instruction": "Go."})";
  expect_all_checked(
      {{"id", R"([{"id": "ID", "scan": "one", "path": ["v0"], )" + of_reverie},
       {"scan", R"([{"id": "1", "scan": "ID", "path": ["v0"], )" + of_reverie},
       {"path", R"([{"id": "1", "scan": "one", "path": ["ID"], )" + of_reverie},
       {"instr_id",
        R"({"instr_id": "ID", "scan": "one", "path": ["v0"], "pos_vps": ["v0"], )" + of_lines},
       {"scan of a line",
        R"({"instr_id": "1_0", "scan": "ID", "path": ["v0"], "pos_vps": ["v0"], )" + of_lines},
       {"path of a line",
        R"({"instr_id": "1_0", "scan": "one", "path": ["ID"], "pos_vps": ["v0"], )" + of_lines},
       {"pos_vps",
        R"({"instr_id": "1_0", "scan": "one", "path": ["v0"], "pos_vps": ["ID"], )" + of_lines}},
      [](const std::string& text) {
        tasks::parse_annotations(text, "a.json", "made", Task::kReverie);
      });
  expect_all_checked(
      {{"scan of boxes", R"({"ID_v0": {}})"}, {"viewpoint of boxes", R"({"s_ID": {}})"}},
      [](const std::string& text) { tasks::ObjectBoxes::parse(text, "b.json"); });
}

TEST(HostileIds, AreRefusedInCvdnAndSoon) {
  const std::string player =
      R"("end_panos": ["v3"], "planner_path": ["v0"], "player_path": ["v0"])";
  const auto instance = [](const std::string& scan, const std::string& start,
                           const std::string& goal) {
    return fmt::format(R"([{{"inst_idx": 1, "scan": "{}", "target": "t", "start_pano": )"
                       R"({{"heading": 1, "pano": "{}"}}, "dialog_history": [], {}}}])",
                       scan, start, goal);
  };
  const auto encoded = [](const std::string& id, const std::string& scan, const std::string& start,
                          const std::string& end, const std::string& step) {
    return fmt::format(R"([{{"instr_id": "{}", "scan": "{}", "start_pano": "{}", )"
                       R"("start_heading": 1, "end_panos": ["{}"], "nav_steps": ["v0", "{}"], )"
                       R"("nav_idx": 0, "instr_encoding": [1]}}])",
                       id, scan, start, end, step);
  };
  expect_all_checked({{"scan", instance("ID", "v0", player)},
                      {"pano", instance("one", "ID", player)},
                      {"end_panos", instance("one", "v0",
                                             R"("end_panos": ["ID"], "planner_path": ["v0"], )"
                                             R"("player_path": ["v0"])")},
                      {"planner_path", instance("one", "v0",
                                                R"("end_panos": ["v0"], "planner_path": ["ID"], )"
                                                R"("player_path": ["v0"])")},
                      {"player_path", instance("one", "v0",
                                               R"("end_panos": ["v0"], "planner_path": ["v0"], )"
                                               R"("player_path": ["ID"])")},
                      {"instr_id", encoded("ID", "one", "v0", "v1", "v1")},
                      {"scan, encoded", encoded("1", "ID", "v0", "v1", "v1")},
                      {"start_pano", encoded("1", "one", "ID", "v1", "v1")},
                      {"end_panos, encoded", encoded("1", "one", "v0", "ID", "v1")},
                      {"nav_steps", encoded("1", "one", "v0", "v1", "ID")}},
                     [](const std::string& text) {
                       tasks::parse_annotations(text, "a.json", "made", Task::kCvdn);
                     });

  const std::string side = R"({"heading": 0, "elevation": 0})";
  const auto soon = [&](const std::string& path, const std::string& scan, const std::string& box) {
    return fmt::format(R"([{{"path": [["{}"]], "instructions": [["a", "b", "c", "d", "e"]], )"
                       R"("bboxes": [{{"scan": "{}", "image_id": "{}", "target": {{"center": {}, )"
                       R"("left_top": {}, "right_top": {}, "right_bottom": {}, "left_bottom": {}}})"
                       R"(}}]}}])",
                       path, scan, box, side, side, side, side, side);
  };
  const std::string of_lines = R"("instructions": [{"full": "e"}]})";
  expect_all_checked(
      {{"path", soon("ID", "one", "v0")},
       {"scan of a box", soon("v0", "ID", "v0")},
       {"image_id of a box", soon("v0", "one", "ID")},
       {"scan of an entry", R"([{"path": [["v0"]], "scan": "ID", "instructions": []}])"},
       {"instr_id", R"([{"path": [["v0"]], "scan": "one", "instr_id": "ID", "instructions": []}])"},
       {"path_id", R"({"path_id": "ID", "scan": "one", "path": ["v0"], )" + of_lines},
       {"scan of a line", R"({"path_id": "1-0", "scan": "ID", "path": ["v0"], )" + of_lines},
       {"path of a line", R"({"path_id": "1-0", "scan": "one", "path": ["ID"], )" + of_lines}},
      [](const std::string& text) {
        tasks::parse_annotations(text, "a.json", "made", Task::kSoon);
      });
}

tasks::EpisodeSet episodes_of(Task task) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("one"));
  const std::string text = task == Task::kReverie
                               ? R"([{"id": "1", "scan": "one", "heading": 1, "path": ["v0"], )"
                                 R"("instructions": ["Go."]}])"
                               : R"([{"path_id": 1, "scan": "one", "heading": 1, "path": ["v0", )"
                                 R"("v1"], "midstop": "v0", "instructions": ["Go."]}])";
  return tasks::make_episodes(tasks::parse_annotations(text, "a.json", "made", task),
                              graph::GraphSet::of(std::move(graphs)));
}

TEST(HostileIds, AreRefusedInResults) {
  const tasks::EpisodeSet back = episodes_of(Task::kR2rBack), reverie = episodes_of(Task::kReverie);
  expect_all_checked(
      {{"instr_id", R"([{"instr_id": "ID", "midstop": null, "trajectory": ["v0"]}])"},
       {"viewpoint", R"([{"instr_id": "1_0", "midstop": null, "trajectory": ["ID"]}])"},
       {"[viewpoint]", R"([{"instr_id": "1_0", "midstop": null, "trajectory": [["ID"]]}])"},
       {"[viewpoint, heading, elevation]",
        R"([{"instr_id": "1_0", "midstop": null, "trajectory": [["ID", 0, 0]]}])"},
       {"viewpoint of an unknown instruction",
        R"([{"instr_id": "9_0", "midstop": null, "trajectory": ["ID"]}])"},
       {"midstop", R"([{"instr_id": "1_0", "midstop": "ID", "trajectory": ["v0"]}])"}},
      [&](const std::string& text) { tasks::parse_results(text, "r.json", back); });
  const Parse object = [&](const std::string& id) {
    tasks::parse_results(
        json_with(R"([{"instr_id": "1_0", "predObjId": "ID", "trajectory": ["v0"]}])", id),
        "r.json", reverie);
  };
  for (const std::string& id : hostile_ids()) {
    const bool wrong_answer = id == "-o" || id == "a b" || id == "\xc3\xa4";
    if (!wrong_answer) expect_refused("predObjId", object, id);
  }
  // Public scorers count these as wrong, and read the file.
  for (const char* id : {"", "-1", "128 ", "66"}) EXPECT_TRUE(faults_of(object, id).empty()) << id;
}

TEST(HostileIds, AreRefusedInContinuousFiles) {
  const auto episode = [](const std::string& id, const std::string& path, const std::string& scan,
                          const std::string& instruction) {
    return fmt::format(R"({{"episodes": [{{"episode_id": "{}", "trajectory_id": "{}", "scene_id": )"
                       R"("mp3d/{}.glb", "start_position": [0, 0, 0], "start_rotation": [0, 0, 0, )"
                       R"(1], "instruction": {{"instruction_text": "Go.", "instruction_id": "{}", )"
                       R"("annotator_id": "1"}}}}]}})",
                       id, path, scan, instruction);
  };
  const auto parse = [](const std::string& text) {
    return tasks::parse_continuous_episodes(text, "e.json", "made");
  };
  expect_all_checked({{"episode_id", episode("ID", "1", "one", "1")},
                      {"trajectory_id", episode("1", "ID", "one", "1")},
                      {"instruction_id", episode("1", "1", "one", "ID")}},
                     parse);
  for (const char* id :
       {"a b", "-o", "\\u001b"}) {  // a scene is a path, of which the scan is a part
    expect_refused(
        "scene_id", [&](const std::string& text) { parse(text); }, episode("1", "1", id, "1"));
  }
  expect_all_checked({{"key of walks",
                       R"({"ID": {"locations": [[0, 0, 0]], "forward_steps": 0, "actions": []}})"}},
                     [](const std::string& text) { tasks::parse_expert_walks(text, "w.json"); });
  const tasks::ContinuousEpisodes episodes = parse(episode("1", "1", "one", "1"));
  expect_all_checked(
      {{"key of results", R"({"ID": []})"},
       {"id of results", R"({"instruction_id": "ID", "path": [[0, 0, 0]]})"}},
      [&](const std::string& text) { tasks::parse_continuous_results(text, "r.json", episodes); });
}

TEST(HostileIds, AreRefusedInDecisions) {
  const auto step = [](const std::string& more) {
    return R"({"1_0": {"agent": "duet", "words": [], "steps": [{"heading": 0, "elevation": 0, )"
           R"("chosen": 0, )" +
           more + "}]}}";
  };
  const std::string stop = R"("choices": [{"viewpoint": null, "probability": 1}], )";
  expect_all_checked(
      {{"key", R"({"ID": {"agent": "duet", "words": [], "steps": []}})"},
       {"viewpoint", step(stop + R"("viewpoint": "ID")")},
       {"choice", step(R"("viewpoint": "v0", "choices": [{"viewpoint": "ID", "probability": 1}])")},
       {"way", step(stop + R"("viewpoint": "v0", "way": ["ID"])")},
       {"node",
        step(stop + R"("viewpoint": "v0", "nodes": [{"viewpoint": "ID", "visited": true}])")},
       {"object", step(stop + R"("viewpoint": "v0", "object": "ID")")},
       {"key of attention", R"({"ID": {"words": [], "steps": []}})"},
       {"viewpoint of attention", R"({"1_0": {"words": [], "steps": [{"action": "stop", )"
                                  R"("attention": [], "viewpoint": "ID", "heading": 0, )"
                                  R"("elevation": 0}]}})"}},
      [](const std::string& text) { models::parse_recorded_split(text, "d.json"); });
}

// --- Files that are not JSON --------------------------------------------------------------------

// Without those that end a word, a line or a text.
void expect_word_checked(const std::string& reader, const Parse& parse) {
  for (const std::string& id : hostile_ids()) {
    const bool breaks = id.find_first_of(" \n") != std::string::npos;
    if (!breaks) expect_refused(reader, parse, id);
  }
  for (const Diagnostic& one : faults_of(parse, "v1")) EXPECT_NE(one.code, "bad-id") << reader;
}

TEST(HostileIds, AreRefusedInTexts) {
  const tests::TemporaryFolder folder("hostile_ids");
  expect_word_checked("scans.txt", [&](const std::string& id) {
    write_file_atomically(folder.path() / "scans.txt", "one\n" + id + "\n");
    scan::load_scan_list(folder.path());
  });
  const std::string camera = "intrinsics_matrix 1 0 1 0 1 1 0 0 1\nscan ";
  const std::string pose = " 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n";
  const auto read_cameras = [&](const std::string& names) {
    scan::parse_undistorted_cameras(camera + names + pose, "s.conf");
  };
  expect_word_checked("depth picture",
                      [&](const std::string& id) { read_cameras(id + "_d0_0.png v0_i0_0.jpg"); });
  expect_word_checked("colour picture",
                      [&](const std::string& id) { read_cameras("v0_d0_0.png " + id); });
  const std::string header =
      "ASCII 1.1\nH a b 0 1 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n";
  expect_word_checked("panorama of a house", [&](const std::string& id) {
    mesh::parse_house(header + "P " + id + " 0 -1 0 0 0 0 0 0 0 0 0\n", "a.house");
  });
}

TEST(HostileIds, AreRefusedInFeatures) {
  const tests::TemporaryFolder folder("hostile_ids");
  const std::string numbers = [] {  // of 36 views of one number each
    std::string text;
    for (int i = 0; i < 48; ++i) text += "AAAA";
    return text;
  }();
  const auto read_row = [&](const std::string& scan, const std::string& viewpoint) {
    write_file_atomically(folder.path() / "f.tsv",
                          scan + '\t' + viewpoint + "\t640\t480\t60\t" + numbers + '\n');
    features::FeatureSet::open(folder.path() / "f.tsv");
  };
  expect_word_checked("scan of a row", [&](const std::string& id) { read_row(id, "v0"); });
  expect_word_checked("viewpoint of a row", [&](const std::string& id) { read_row("one", id); });
  expect_checked("array", [&](const std::string& id) {
    const std::vector<std::byte> zeros(4);
    const features::NamedArray array{"one_" + id, features::DType::kFloat32, {1, 1}, zeros};
    features::write_safetensors(folder.path() / "f.safetensors", {&array, 1});
    features::FeatureSet::open(folder.path() / "f.safetensors");
  });
}

TEST(HostileIds, AreRefusedInPoseTraces) {
  const std::vector<float> zero(1), matrix(16);
  expect_checked("pano", [&](const std::string& id) {
    const std::vector<std::string> panos{id.substr(0, 4096)};  // more is not written
    const std::vector<scan::ZipEntry> entries{
        {"pano.npy", scan::write_npy(panos, {1, 1})},
        {"time.npy", scan::write_npy(zero, {1, 1})},
        {"extrinsic_matrix.npy", scan::write_npy(matrix, {1, 16})},
        {"intrinsic_matrix.npy", scan::write_npy(matrix, {1, 16})}};
    tasks::parse_pose_trace(scan::zip(entries), "t.npz");
  });
}

// --- Other values -------------------------------------------------------------------------------

TEST(LongValues, AreQuotedInShort) {
  const auto check = [](const std::string& reader, const std::string& text,
                        const std::function<void(const std::string& text)>& parse) {
    const auto found = faults_of([&](const std::string& value) { parse(json_with(text, value)); },
                                 std::string(1'000'000, 'x'));
    EXPECT_FALSE(found.empty()) << reader;
    for (const Diagnostic& one : found) {
      EXPECT_LT(one.message.size() + one.where.size(), 600U) << reader;
    }
  };
  const auto annotations = [](Task task) {
    return
        [task](const std::string& text) { tasks::parse_annotations(text, "a.json", "made", task); };
  };
  check("language",
        R"({"path_id": 1, "scan": "one", "path": ["v0"], "heading": 1, )"
        R"("instruction_id": 7, "language": "ID", "instruction": "Go."})",
        annotations(Task::kRxr));
  check("role",
        R"([{"inst_idx": 1, "scan": "one", "target": "t", "start_pano": {"heading": 1, )"
        R"("pano": "v0"}, "dialog_history": [{"role": "ID", "message": "", "nav_idx": 0}]}])",
        annotations(Task::kCvdn));
  check("objid",
        R"({"instr_id": "1_0", "scan": "one", "path": ["v0"], "pos_vps": ["v0"], )"
        R"("objid": "ID", "instruction": "Go."})",
        annotations(Task::kReverie));
  check("region", R"({"one": {"ID": []}})",
        [](const std::string& text) { scan::RegionMap::parse(text, "r.json"); });
  check("key of boxes", R"({"ID": {}})",
        [](const std::string& text) { tasks::ObjectBoxes::parse(text, "b.json"); });
  check("object of boxes", R"({"s_v": {"ID": {}}})",
        [](const std::string& text) { tasks::ObjectBoxes::parse(text, "b.json"); });
  check("action",
        R"({"scan": "s", "corrections": [{"action": "ID", "from": "a", "who": "me", )"
        R"("why": "so"}]})",
        [](const std::string& text) { graph::parse_corrections(text, "c.json"); });
  check("scene_id",
        R"({"episodes": [{"episode_id": 1, "trajectory_id": 1, "scene_id": "ID/", )"
        R"("start_position": [0, 0, 0], "start_rotation": [0, 0, 0, 1], )"
        R"("instruction": {"instruction_text": "Go."}}]})",
        [](const std::string& text) { tasks::parse_continuous_episodes(text, "e.json", "made"); });
}

}  // namespace EN_UNIT
}  // namespace enfilade::bad_input
