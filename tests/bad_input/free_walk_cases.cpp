// Continuous environments: navigation meshes, VLN-CE's episodes, and results. All of it is
// SYNTHETIC.
#include <string>

#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

using Damage = std::function<void(Files&)>;

constexpr const char* kMesh = "meshes/one.obj";
constexpr const char* kEpisodes = "vlnce/made.json.gz";
constexpr const char* kWalks = "walks.json";
constexpr const char* kFloors = "continuous {} --floors-only";

// A level floor under the six viewpoints of building one, one episode along it in Habitat's frame,
// and a walk that stops where it starts.
void add_good(Files& files) {
  files.write(kMesh, "v -2 -2 0\nv 12 -2 0\nv 12 2 0\nv -2 2 0\nf 1 2 3 4\n");
  files.write(
      kEpisodes,
      R"({"episodes": [{"episode_id": 1, "trajectory_id": 1, "scene_id": "mp3d/one/one.glb", )"
      R"("start_position": [0, 0, 0], "start_rotation": [0, 0, 0, 1], )"
      R"("info": {"geodesic_distance": 4}, "goals": [{"position": [4, 0, 0], "radius": 3}], )"
      R"("instruction": {"instruction_text": "Walk on."}, )"
      R"("reference_path": [[0, 0, 0], [2, 0, 0], [4, 0, 0]]}], )"
      R"("instruction_vocab": {"word_list": []}})");
  files.write(kWalks, R"({"1": [{"position": [0, 0, 0], "heading": 0, "stop": false}, )"
                      R"({"position": [0, 0, 0], "heading": 0, "stop": true}]})");
}

Damage damaged(Damage damage) {
  return [damage = std::move(damage)](Files& files) {
    add_good(files);
    if (damage) damage(files);
  };
}

Damage edit(const std::string& file, const std::string& from, const std::string& to) {
  return [=](Files& files) { files.edit(file, from, to); };
}

// Scan 00800-one, whose floor is where HM3D has it, in a folder of all scans.
Damage in_hm3d(const std::string& folder) {
  return [=](Files& f) {
    f.write(kScans, "00800-one\n").remove(kMesh);
    f.write("connectivity/00800-one_connectivity.json", std::string(f.content(kGraph)));
    f.write(folder + "/00800-one/one.basis.glb", glb_of_hm3d());
  };
}

Case floors(std::string input, const std::string& command, int exit_code, std::string says,
            Damage damage = {}) {
  return {"Navigation meshes", std::move(input), command,
          exit_code,           std::move(says),  damaged(std::move(damage))};
}

// Run by the shortest-path agent, once the floor is made.
Case walked(std::string input, int exit_code, std::string says, Damage damage = {}) {
  return {"Continuous episodes",
          std::move(input),
          "run --task r2r-ce --data {} --split made --agent shortest",
          exit_code,
          std::move(says),
          damaged(std::move(damage)),
          false,
          kFloors};
}

Case scored(std::string input, int exit_code, std::string says, Damage damage = {}) {
  return {"Continuous results",
          std::move(input),
          "score walks.json --task r2r-ce --data {} --split made",
          exit_code,
          std::move(says),
          damaged(std::move(damage)),
          false,
          kFloors};
}

// Training the continuous agent; `floors` are made before.
Case trained(std::string input, const std::string& options, int exit_code, std::string says,
             bool floors = true) {
  return {"Training of the continuous agent",
          std::move(input),
          "train --data {} --splits made -o model --threads 1 " + options,
          exit_code,
          std::move(says),
          damaged({}),
          true,
          floors ? kFloors : ""};
}

std::vector<Case> training() {
  const std::string blind =
      "--task r2r-ce --recipe small --inputs language --hidden 2 --sets 1 --epochs 1 ";
  return {
      trained("the continuous agent, and nothing wrong", blind, 0, "model: trained, 1 iter"),
      trained("no encoder for an agent that sees", "--task r2r-ce", 2,
              "train: --weights FILE is needed, of --encoder"),
      trained("features of the graph for the continuous agent", blind + "--features f.safetensors",
              2, "train: --features: pictures of the graph's"),
      trained("weights of an encoder for an agent of the graph",
              "--inputs none --weights w.safetensors", 2,
              "train: --weights: of --task r2r-ce alone"),
      trained("an agent that is not continuous", "--task r2r-ce --agent duet", 2,
              "--agent duet: walks in the graph; --task r2r-ce has seq2seq alone"),
      trained("an option of the graph's agents", blind + "--iterations 5", 2,
              "--iterations: not an option of --agent seq2seq --task r2r-ce"),
      trained("an option of the continuous agent", "--inputs none --sets 2", 2,
              "--sets: not an option of --agent seq2seq"),
      trained("a share of the teacher's above 1", blind + "--teacher-share 1.5", 2,
              "teacher_share: 1.5"),
      trained("weights of an encoder that are not there",
              "--task r2r-ce --weights none.safetensors", 3, "none.safetensors"),
      trained("no floors to walk on", blind, 3,
              "{}/navmesh/r2r-ce: no such folder of navigation meshes; `enfilade continuous {}` "
              "makes it",
              false),
      trained("no continuous episodes", blind + "--splits val", 3,
              "no episodes of r2r-ce val: tried {}/vlnce/val.json.gz"),
  };
}

std::vector<Case> navigation() {
  const std::string made = "navigation meshes: 1 made, 0 were there";
  const std::string no_mesh = "no building has a mesh to walk on";
  return {
      floors("a mesh of one building of two", kFloors, 0, made),
      floors("a mesh where HM3D has it", kFloors, 0, made, in_hm3d("hm3d/train")),
      floors("a split of HM3D elsewhere", "continuous {} --floors-only --meshes {}/new/hm3d/train",
             0, made, in_hm3d("new/hm3d/train")),
      floors("no mesh at all", kFloors, 2, no_mesh, [](Files& f) { f.remove(kMesh); }),
      floors("a folder of meshes that is not there", "continuous {} --meshes {}/none", 3,
             "{}/none: not a folder (looked for meshes there)"),
      floors("a data set that is not there", "continuous {}/none", 3,
             "{}/none: not a folder (looked for a data set there)"),
      floors("a task that is no walk", "continuous {} --task r2r", 2,
             "--task: r2r not in {r2r-ce,rxr-ce}"),
      floors("Habitat's floor", "continuous {} --floors-only --navmesh habitat", 0,
             "navigation meshes: 1 made, 0 were there (floor: habitat 0.3.3)"),
      floors("a floor that is none", "continuous {} --navmesh mars", 2,
             "--navmesh: mars not in {enfilade,habitat}"),
      floors("Habitat's files on our floor", "continuous {} --parts habitat", 2,
             "--parts habitat: wants --navmesh habitat and --task r2r-ce, and no --floors-only"),
      floors("Habitat's files without episodes",
             "continuous {} --floors-only --navmesh habitat --parts habitat", 2,
             "--parts habitat: wants --navmesh habitat and --task r2r-ce, and no --floors-only"),
      floors("a mesh without a level surface, for Habitat's floor",
             "continuous {} --floors-only --navmesh habitat", 1,
             "{}/meshes/one.obj: nowhere is room for a body to stand [no-floor]",
             [](Files& f) { f.write(kMesh, "v 0 0 0\nv 1 0 0\nv 1 1 6\nv 0 1 6\nf 1 2 3 4\n"); }),
      floors("floors of both kinds", "run --task r2r-ce --data {} --split made --agent shortest", 3,
             "two.navmesh: another floor than one.navmesh has",
             [](Files& f) {
               f.write("navmesh/r2r-ce/one.navmesh", "Enfilade navigation mesh, version 1\n");
               f.write("navmesh/r2r-ce/two.navmesh", "TESM");
             }),
      floors("Habitat's navigation mesh, cut off in its head",
             "run --task r2r-ce --data {} --split made --agent shortest", 3,
             "one.navmesh: it ends within its head: 0 bytes of 4 [truncated]",
             [](Files& f) { f.write("navmesh/r2r-ce/one.navmesh", "TESM"); }),
      floors("a mesh without a level surface", kFloors, 1, "nowhere to stand",
             [](Files& f) { f.write(kMesh, "v 0 0 0\nv 9 0 0\nv 9 1 6\nv 0 1 6\nf 1 2 3 4\n"); }),
      floors("a mesh far from the viewpoints", kFloors, 1,
             "nothing of the mesh lies in the box that was asked for [no-floor]",
             [](Files& f) { f.write(kMesh, "v 90 0 0\nv 99 0 0\nv 99 9 0\nf 1 2 3\n"); }),
      floors("a mesh without triangles", kFloors, 1,
             "{}/meshes/one.obj: no triangles, at least 1 is needed [no-triangles]",
             [](Files& f) { f.write(kMesh, "v 0 0 0\nv 1 0 0\n"); }),
      floors(
          "a mesh of text", kFloors, 1,
          "{}/meshes/one.obj: line 1: 2 numbers, not 3, and the face of line 2 uses it [bad-value]",
          [](Files& f) { f.write(kMesh, "v 0 0\nf 1 1 1\n"); }),
      floors("text in a navigation mesh's place", kFloors, 3,
             "one.navmesh: does not begin with \"Enfilade navigation mesh, version",
             [](Files& f) { f.write("navmesh/r2r-ce/one.navmesh", "hello\n"); }),
      floors("a navigation mesh of another version",
             "run --task r2r-ce --data {} --split made --agent shortest", 3, "[other-version]",
             [](Files& f) {
               f.write("navmesh/r2r-ce/one.navmesh", "Enfilade navigation mesh, version 9\n");
             }),
      floors("a navigation mesh cut off after its first line",
             "run --task r2r-ce --data {} --split made --agent shortest", 3, "[truncated]",
             [](Files& f) {
               f.write("navmesh/r2r-ce/one.navmesh", "Enfilade navigation mesh, version 1\n");
             }),
      floors("no navigation meshes", "run --task r2r-ce --data {} --split made --agent shortest", 3,
             "{}/navmesh/r2r-ce: no such folder of navigation meshes; `enfilade continuous {}` "
             "makes it"),
  };
}

std::vector<Case> episodes() {
  return {
      walked("episodes that are good", 0, "shortest on made of R2R-CE: 1 episodes"),
      walked("episodes that were unpacked", 0, "shortest on made of R2R-CE: 1 episodes",
             [](Files& f) {
               f.write("vlnce/made.json", std::string(f.content(kEpisodes))).remove(kEpisodes);
             }),
      walked("episodes of HM3D, with a byte-order mark", 0,
             "shortest on made of R2R-CE: 1 episodes",
             [](Files& f) {
               f.write(kScans, "00800-one\n");
               f.write("connectivity/00800-one_connectivity.json", std::string(f.content(kGraph)));
               f.write("meshes/00800-one.obj", std::string(f.content(kMesh)));
               f.edit(kEpisodes, "mp3d/one/one.glb", "hm3d/val/00800-one/one.basis.glb");
               f.edit(kEpisodes, "{\"episodes\"", "\xef\xbb\xbf{\"episodes\"");
             }),
      walked("no file of that split", 3, "no episodes of r2r-ce made: tried {}/vlnce/made.json.gz",
             [](Files& f) { f.remove(kEpisodes); }),
      walked("an empty file", 3, "the file is empty, not JSON",
             [](Files& f) { f.write(kEpisodes, ""); }),
      walked("a file cut off in the middle", 3, "the file ends too early",
             [](Files& f) { f.write(kEpisodes, f.content(kEpisodes).substr(0, 120)); }),
      walked("an array instead of the object", 3, "$: array, not an object",
             [](Files& f) { f.write(kEpisodes, "[]"); }),
      walked("no episodes", 3, "$: has no field \"episodes\"",
             edit(kEpisodes, "\"episodes\"", "\"episode\"")),
      walked("an episode without a start", 3,
             "$.episodes[0]: has no field \"start_position\" [missing-field]",
             edit(kEpisodes, "\"start_position\"", "\"position\"")),
      walked("a start of two numbers", 3, "$.episodes[0].start_position: 2 numbers, not 3",
             edit(kEpisodes, "\"start_position\": [0, 0, 0]", "\"start_position\": [0, 0]")),
      walked("a start in words", 3, "$.episodes[0].start_position[0]: string \"here\"",
             edit(kEpisodes, "\"start_position\": [0,", "\"start_position\": [\"here\",")),
      walked(
          "a rotation that tilts the body", 3,
          "$.episodes[0].start_rotation: [0.7, 0, 0, 0.7] is no rotation about the vertical axis",
          edit(kEpisodes, "\"start_rotation\": [0, 0, 0, 1]",
               "\"start_rotation\": [0.7, 0, 0, 0.7]")),
      walked("no goal in the list", 3, "$.episodes[0].goals: no goal; one at least is expected",
             edit(kEpisodes, "[{\"position\": [4, 0, 0], \"radius\": 3}]", "[]")),
      walked("a radius below 0", 3, "$.episodes[0].goals[0].radius: -3 is no radius in metres",
             edit(kEpisodes, "\"radius\": 3", "\"radius\": -3")),
      walked("a building without a navigation mesh", 2, "no navigation mesh of scan \"two\"",
             edit(kEpisodes, "mp3d/one/one.glb", "mp3d/two/two.glb")),
      walked("a start off the floor", 3, "$.episodes[0].start_position: no floor of one within",
             edit(kEpisodes, "\"start_position\": [0, 0, 0]", "\"start_position\": [0, 9, 0]")),
      walked("a goal off the floor", 3,
             "$.episodes[0].goals: no floor of one within 1 m of any goal [goal-off-floor]",
             edit(kEpisodes, "\"position\": [4, 0, 0]", "\"position\": [4, 0, 90]")),
      walked("goals that are hidden, and an agent that needs them", 2, "hides its goal",
             [](Files& f) {
               f.edit(kEpisodes, "\"goals\": [{\"position\": [4, 0, 0], \"radius\": 3}], ", "");
             }),
  };
}

std::vector<Case> results() {
  const std::string end = R"(, {"position": [0, 0, 0], "heading": 0, "stop": true})";
  return {
      scored("results that are good", 0, "1 episodes of 1 trajectories"),
      scored("results that are not there", 3, "walks.json: cannot open",
             [](Files& f) { f.remove(kWalks); }),
      scored("an empty file", 1, "the file is empty, not JSON",
             [](Files& f) { f.write(kWalks, ""); }),
      scored("a file cut off in the middle", 1,
             "walks.json: $.1[0].heading: line 1, column 40: the file ends too early",
             [](Files& f) { f.write(kWalks, f.content(kWalks).substr(0, 40)); }),
      scored("an episode that the split does not have", 1,
             "walks.json: $.7: \"7\" is not one of the 1 values of episode_id in split made",
             edit(kWalks, "\"1\"", "\"7\"")),
      scored("an episode that is not answered", 1,
             "no walk for 1 of the 1 episodes of split made: \"1\" [missing-episode]",
             [](Files& f) { f.write(kWalks, "{}"); }),
      scored("a walk without a pose", 1,
             "walks.json: $.1: no pose; the start at least is expected [no-pose]",
             [](Files& f) { f.write(kWalks, R"({"1": []})"); }),
      scored("a start that is not the episode's", 1,
             "$.1[0]: [1, 0, 0] is 1.000 m off the episode's start, [0, 0, 0] [wrong-start]",
             edit(kWalks, "\"position\": [0, 0, 0]", "\"position\": [1, 0, 0]")),
      scored("a position of two numbers", 1,
             "$.1[1].position: 2 numbers, not 3: x, y (up) and z in metres [bad-point]",
             edit(kWalks, end, R"(, {"position": [0, 0], "heading": 0, "stop": true})")),
      scored("poses after stop", 1, "$.1[2]: a pose after stop was called [after-stop]",
             edit(kWalks, end, end + end)),
      scored("a heading in words", 1,
             "$.1[0].heading: string \"left\", not a number [not-a-number]",
             edit(kWalks, "\"heading\": 0, \"stop\": false",
                  "\"heading\": \"left\", \"stop\": false")),
      scored("results of the graph", 1, "walks.json: $: array, not an object",
             [](Files& f) { f.write(kWalks, f.content(kResults)); }),
      scored("goals that are hidden", 2, "the goals of split made are hidden",
             [](Files& f) {
               f.edit(kEpisodes, "\"goals\": [{\"position\": [4, 0, 0], \"radius\": 3}], ", "");
             }),
  };
}

}  // namespace

std::vector<Case> free_walk_cases() {
  std::vector<Case> cases = navigation();
  for (std::vector<Case> more : {episodes(), results(), training()}) {
    cases.insert(cases.end(), more.begin(), more.end());
  }
  return cases;
}

}  // namespace enfilade::bad_input
