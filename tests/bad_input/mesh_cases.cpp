#include <string>

#include "enfilade/core/gzip.h"
#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

using Damage = std::function<void(Files&)>;

// Meshes in OBJ's text: z up.
constexpr const char* kFloor = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n";
constexpr const char* kWall = "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nf 1 2 3 4\n";
constexpr const char* kPainted =
    "mtllib m.mtl\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nvt 0 0\nusemtl oak\nf 1/1 2/1 3/1 4/1\n";

// A square of four vertices and a face.
constexpr const char* kPlyHeader =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

// A level square of 4 m, and what goes wrong with it or with what is asked of it.
Case scanned(std::string input, const std::string& options, int exit_code, std::string says,
             Damage damage = {}) {
  return {"Scans from meshes",
          std::move(input),
          "scan-mesh {}/m.obj -o {}/new --parts depth --size 16" + options,
          exit_code,
          std::move(says),
          [damage = std::move(damage)](Files& files) {
            files.write("m.obj", kFloor);
            if (damage) damage(files);
          }};
}

void pack(Files& files) {
  files.write(std::string(kGraph) + ".gz", gzip(files.content(kGraph), 6)).remove(kGraph);
}

Damage mesh(const std::string& content) {
  return [=](Files& files) { files.write("m.obj", content); };
}

Case read(std::string input, const std::string& file, int exit_code, std::string says,
          const std::string& content) {
  return {"Scans from meshes",
          std::move(input),
          "scan-mesh {}/" + file + " -o {}/new --parts depth --size 16",
          exit_code,
          std::move(says),
          [=](Files& files) { files.write(file, content); }};
}

// The mesh of a scan, in a folder of its name.
Case in_folder(std::string input, const std::string& folder, const std::string& scan,
               const std::string& file, const std::string& content) {
  return {"Scans from meshes",
          std::move(input),
          "scan-mesh {}/" + folder + scan + " -o {}/new --parts depth --size 16",
          0,
          "enfilade graph draw " + scan + " --data {}/new",
          [=](Files& files) { files.write(folder + scan + "/" + file, content); }};
}

std::vector<Case> files() {
  return {
      scanned("a mesh that is not there", "", 3, "{}/m.obj: cannot open: No such file",
              [](Files& f) { f.remove("m.obj"); }),
      scanned("a folder in the mesh's place", "", 3, "{}/m.obj: cannot read: Is a directory",
              [](Files& f) { f.remove("m.obj").write("m.obj/x", ""); }),
      scanned("a pipe in the mesh's place", "", 3, "m.obj: cannot read: a pipe that no program",
              mesh(kPipe)),
      scanned("a face that goes round four points 10,000 times", "", 0,
              "39742 triangles dropped: more than 64 have the same corners",
              [](Files& f) {
                std::string face = kFloor;
                face.pop_back();
                for (int k = 1; k < 10'000; ++k) face += " 1 2 3 4";
                f.write("m.obj", face + "\n");
              }),
      in_folder("a scan's folder in the mesh's place", "", "room", "room.obj", kFloor),
      in_folder("a scan's folder as HM3D has it", "hm3d/val/", "00800-one", "one.basis.glb",
                glb_of_hm3d()),
      read("an ending that is no mesh's", "m.stl", 2,
           "m.stl: ending \".stl\", not .glb, .gltf, .obj or .ply", "solid"),
      scanned("an empty mesh file", "", 3, "{}/m.obj: no triangles, at least 1 is needed",
              mesh("")),
      scanned("vertices and no triangles", "", 3, "[no-triangles]", mesh("v 0 0 0\nv 1 0 0\n")),
      scanned("a vertex at NaN", "", 3, "{}/m.obj: line 3: \"nan\", not a finite number",
              mesh("v 0 0 0\nv 4 0 0\nv 4 nan 0\nf 1 2 3\n")),
      scanned("a vertex at 1e39", "", 3, "{}/m.obj: line 3: \"1e39\", not a finite number",
              mesh("v 0 0 0\nv 4 0 0\nv 4 1e39 0\nf 1 2 3\n")),
      scanned("a vertex at NaN that no face uses", "", 0,
              "warning: {}/m.obj: line 6: 1 positions are not finite numbers; no face uses them "
              "[not-finite]",
              mesh(std::string(kFloor) + "v -nan(ind) 0 0\n")),
      scanned("normals that are not finite", "", 0,
              "warning: {}/m.obj: line 5: 2 normals are not finite numbers: those of the faces "
              "are taken [not-finite]",
              mesh("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nvn nan nan nan\nvn 0 1.#QNAN 1\n"
                   "f 1//1 2//1 3//2 4//2\n")),
      scanned("texture points that are not finite", "", 0,
              "warning: {}/m.obj: line 5: 1 texture points are not finite numbers: taken as 0",
              mesh("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nvt nan 0\nf 1/1 2/1 3/1 4/1\n")),
      scanned("a corner whose normal is missing", "", 0,
              "warning: {}/m.obj: line 5: 1 corners name a normal that is missing",
              mesh("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1//9 2 3 4\n")),
      scanned("colours of 0 to 255", "", 0,
              "note: {}/m.obj: colours of up to 255, taken as 0 to 255 [colour-bytes]",
              mesh("v 0 0 0 255 0 0\nv 4 0 0 0 0 255\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n")),
      scanned("a corner that is no vertex", "", 3,
              "{}/m.obj: line 5: position \"9\", not one of the 4 before it [bad-index]",
              mesh("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 9\n")),
      scanned("materials that are not there", "", 0,
              "warning: {}/m.obj: line 1: {}/m.mtl: cannot open: No such file or directory "
              "[missing-material]",
              mesh(kPainted)),
      scanned("a texture that is not there", "", 0,
              "warning: {}/m.mtl: oak: {}/none.png: cannot open: No such file or directory "
              "[missing-texture]",
              [](Files& f) {
                f.write("m.obj", kPainted).write("m.mtl", "newmtl oak\nmap_Kd none.png\n");
              }),
      scanned("a texture that is no picture", "", 0, "[missing-texture]",
              [](Files& f) {
                f.write("m.obj", kPainted)
                    .write("m.mtl", "newmtl oak\nmap_Kd oak.png\n")
                    .write("oak.png", "GIF89a");
              }),
      scanned("a texture by its path on another computer", "", 0, "[moved-file]",
              [](Files& f) {
                f.write("m.obj", kPainted)
                    .write("M.MTL", "newmtl oak\nmap_Kd C:\\Users\\a b\\none.png\n");
              }),
      scanned("text in UTF-16", "", 0, "{}/m.obj: 2 triangles", mesh(utf16(kFloor))),
      read("a PLY whose rows have more values than its header says", "m.ply", 0,
           "warning: {}/m.ply: line 10, vertex 0: 4 rows have more values than the header says",
           kPlyHeader + std::string("0 0 0 9\n4 0 0 9\n4 4 0 9\n0 4 0 9\n4 0 1 2 3\n")),
      read("a PLY with free text in its header", "m.ply", 0,
           "warning: {}/m.ply: line 3: 1 lines of the header are free text",
           std::string(kPlyHeader).insert(21, "made by hand\n") +
               "0 0 0\n4 0 0\n4 4 0\n0 4 0\n4 0 1 2 3\n"),
      read("a PLY whose texture is missing", "m.ply", 0, "none.png: cannot open",
           "ply\nformat ascii 1.0\ncomment TextureFile none.png\nelement vertex 4\n"
           "property float x\nproperty float y\nproperty float z\nproperty float s\n"
           "property float t\nelement face 1\nproperty list uchar int vertex_indices\n"
           "end_header\n0 0 0 0 0\n4 0 0 1 0\n4 4 0 1 1\n0 4 0 0 1\n4 0 1 2 3\n"),
      read("a glTF that requires Basis textures", "m.gltf", 0,
           "warning: {}/m.gltf: 1 textures in KHR_texture_basisu, which is not read",
           R"({"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_texture_basisu"],
"images": [{"uri": "oak.ktx2"}], "textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}],
"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "mode": 6}]}], "nodes": [{"mesh": 0}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}],
"bufferViews": [{"buffer": 0, "byteLength": 48}], "buffers": [{"byteLength": 48,
"uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAIBAAACAQAAAAAAAAIBAAACAQAAAAAAAAAAA"}]})"),
      read("a glTF that requires an unknown extension", "m.gltf", 3,
           "\"EXT_own\" is required, but not known here [unknown-extension]",
           R"({"asset": {"version": "2.0"}, "extensionsRequired": ["EXT_own"]})"),
      read("a GLB cut off in the middle", "m.glb", 3,
           "{}/m.glb: ", std::string("glTF\2\0\0\0\144\0\0\0", 12)),
      read("a glTF without its buffer", "m.gltf", 3, "m.bin",
           R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "m.bin", "byteLength": 9}]})"),
      read("a PLY cut off in the middle", "m.ply", 3, "{}/m.ply: ",
           "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
           "end_header\n0 0 0\n4 0 0\n"),
  };
}

std::vector<Case> floors() {
  return {
      scanned("a mesh without a level surface", "", 3,
              "{}/m.obj: nowhere to stand: no surface is flatter than 40 degrees [no-floor]",
              mesh(kWall)),
      scanned("a mesh of another axis up", " --up y", 3, "no surface is flatter than 40 degrees"),
      scanned("a mesh with nothing around its floor", "", 0,
              "of directions meet nothing: has the mesh no floor, or another axis up (--up)?"),
      scanned("a mesh in the wrong units, far too small", " --scale 0.001", 3,
              "less than 0.5 m: wrong units? [absurd-size]"),
      scanned("a mesh in the wrong units, far too large", " --scale 1000", 2,
              "take larger cells, or check the mesh's scale"),
      scanned("a scale of 0", " --scale 0", 2, "scale 0, not above 0"),
      scanned("a scale below 0", " --scale -1", 2, "--scale: \"-1\" is not a finite number"),
      scanned("a scale that is no number", " --scale nan", 2, "--scale: \"nan\" is not"),
      scanned("an axis that is none", " --up w", 2, "--up: w not in {format,y,z}"),
  };
}

std::vector<Case> scans() {
  const std::string graph = " --graph {}/connectivity/one_connectivity.json";
  return {
      scanned("a scan id that is a path", " --scan ../x", 2,
              "--scan \"../x\": letters, digits, _, - and . are allowed, not first a - or a ."),
      scanned("a scan id that would be hidden", " --scan .x", 2, "--scan \".x\": letters"),
      scanned("faces too small", " --size 8", 2, "--size: "),
      scanned("three rays a pixel", " --samples 3", 2, "--samples: 3 not in {1,4,9,16}"),
      scanned("a part that is none", " --parts smell", 2, "--parts: smell not in {skybox,"),
      scanned("an exposure that is no number", " --exposure nan", 2, "--exposure: \"nan\" is not"),
      scanned("a quality past 100", " --quality 101", 2, "--quality: "),
      scanned("viewpoints below 0", " --limit -1", 2, "--limit: \"-1\" is not"),
      scanned("a graph that is not there", " --graph {}/none.json", 2, "{}/none.json"),
      scanned("a graph that is no JSON", " --graph {}/m.obj", 3, "{}/m.obj: $: line 1, column 1"),
      scanned("a graph whose pose is no pose", graph, 3, "one_connectivity.json: $[0].pose",
              [](Files& f) { f.edit(kGraph, "[1.0,", "[\"1\","); }),
      scanned("a graph that was packed", graph, 0, "enfilade graph draw one --data {}/new", pack),
      scanned("labels that are not there", " --labels {}/none", 2, "{}/none"),
      scanned("labels without their files", " --labels {}/r2r", 3,
              "{}/r2r/m.house: cannot open: No such file"),
      scanned("labels of a building and a request to write them", " --parts house --labels {}/r2r",
              2, "--parts house: those files are what --labels gives"),
      scanned("pictures of somebody else in the way", "", 3, "is in the way: not made by Enfilade",
              [](Files& f) { f.write("new/connectivity/m_connectivity.json", "[]"); }),
      scanned("a list of pictures that is broken", "", 3, "enfilade_scan.json: not a list that",
              [](Files& f) { f.write("new/v1/scans/m/enfilade_scan.json", "{"); }),
      {"Scans from meshes", "an output that is a file",
       "scan-mesh {}/m.obj -o {}/results.json --parts depth --size 16", 3,
       "cannot make the folder: Not a directory", mesh(kFloor)},
  };
}

Case built(std::string input, const std::string& options, int exit_code, std::string says,
           const std::string& mesh = kFloor, const std::string& corrections = "") {
  return {"Graphs from meshes",
          std::move(input),
          "graph build {}/m.obj -o {}/built " + options,
          exit_code,
          std::move(says),
          [=](Files& f) { f.write("m.obj", mesh).write("c.json", corrections); }};
}

std::vector<Case> graphs() {
  const std::string correct = "--corrections {}/c.json";
  const auto correction = [](const std::string& fields) {
    return R"({"scan":"m","corrections":[{)" + fields + R"(,"who":"Ada","why":"a rope"}]})";
  };
  return {
      built("a mesh without a level surface", "", 3, "{}/m.obj: nowhere to stand", kWall),
      built("a mesh without triangles", "", 3, "{}/m.obj: no triangles", "v 0 0 0\n"),
      built("a vertex at infinity", "", 3, "{}/m.obj: line 1: \"inf\", not a finite number",
            "v inf 0 0\nv 4 0 0\nv 4 4 0\nf 1 2 3\n"),
      built("a texture that is not there", "", 0, "[missing-material]", kPainted),
      built("a floor in the wrong units", "--scale 0.01", 3, "no-floor"),
      built("a mesh far too large for its cells", "--scale 1000", 2, "cell: 0.07 m on a mesh of"),
      built("no room for the body", "--body-radius 3", 3,
            "no surface has room for a body of radius 3 m"),
      built("a body that is no number", "--body-height nan", 2, "--body-height: \"nan\" is not"),
      built("a separation of 0", "--separation 0", 2, "separation: 0, not from 0.2 to 100"),
      built("a seed below 0", "--seed -1", 2, "--seed: \"-1\" is not a whole number"),
      built("an axis that is none", "--up w", 2, "--up"),
      built("a scan id that is a path", "--scan ../x", 2,
            "--scan \"../x\": letters, digits, _, - and . are allowed"),
      built("an output below a file", "-o {}/m.obj/x", 2, "-o"),
      built("corrections that are not there", "--corrections {}/none.json", 3, "cannot open"),
      built("corrections that are no JSON", correct, 3, "not JSON", kFloor, "add 1 2"),
      built("a correction nobody signed", correct, 3, "$.corrections[0].who: is empty", kFloor,
            R"({"scan":"m","corrections":[{"action":"exclude","from":"a","who":"","why":"b"}]})"),
      built(
          "an action that is none", correct, 3,
          "$.corrections[0].action: string \"cut\", not add-edge, remove-edge, exclude or include",
          kFloor, correction(R"("action":"cut","from":"a")")),
      built("an edge to itself", correct, 3, "$.corrections[0]: an edge from \"a\" to itself",
            kFloor, correction(R"("action":"add-edge","from":"a","to":"a")")),
      built("an edge to nowhere", correct, 3, "$.corrections[0]: add-edge needs \"to\"", kFloor,
            correction(R"("action":"add-edge","from":"a")")),
      built("corrections of another building", correct, 3, "and the graph is of \"m\"", kFloor,
            R"({"scan":"n","corrections":[]})"),
      built("a correction of a viewpoint that is not there", correct, 3,
            "\"a\" is no viewpoint of m", kFloor, correction(R"("action":"exclude","from":"a")")),
  };
}

Case compared(std::string input, std::string command, int exit_code, std::string says,
              Damage damage = {}) {
  return {"Graphs that are compared",
          std::move(input),
          "graph compare " + std::move(command),
          exit_code,
          std::move(says),
          std::move(damage)};
}

std::vector<Case> comparisons() {
  const std::string one = std::string("{}/") + kGraph;
  const std::string both = one + " {}/connectivity/two_connectivity.json";
  return {
      compared("one graph", one, 2, "B is required"),
      compared("a graph that is not there", one + " {}/none.json", 3, "{}/none.json: cannot open"),
      compared("a folder in a graph's place", one + " {}/r2r", 3,
               "{}/r2r: cannot read: Is a directory"),
      compared("a graph that is annotations", one + " {}/r2r/R2R_made.json", 3, "missing-field"),
      compared("a graph cut off in the middle", both, 3, "one_connectivity.json: $",
               [](Files& f) { f.write(kGraph, f.content(kGraph).substr(0, 500)); }),
      compared("a graph that was packed", both, 0, "edges       4 in both, 0 extra, 0 missing",
               pack),
      compared("a mesh in a graph's place", one + " {}/m.obj", 3, "{}/m.obj: $: line 1, column 1",
               [](Files& f) { f.write("m.obj", kFloor); }),
      compared("buildings that share nothing", one + " {}/b.json", 2, "no viewpoint of one",
               [](Files& f) { f.write("b.json", "[]"); }),
      compared("an F1 that is no number", both + " --least-f1 nan", 2,
               "--least-f1: \"nan\" is not a finite number from 0 to 1"),
      compared("an F1 above 1", both + " --least-f1 98", 2, "--least-f1: \"98\" is not"),
      compared("a plan that cannot be written", both + " --plan {}/no/plan.svg", 3,
               "{}/no/plan.svg: cannot write"),
      compared("graphs that agree less than asked", both + " --least-f1 1", 1,
               "edges       3 in both, 0 extra, 1 missing",
               [](Files& f) {
                 f.edit(kGraph, "\"unobstructed\":[false,true,", "\"unobstructed\":[false,false,")
                     .edit(kGraph, "\"unobstructed\":[true,", "\"unobstructed\":[false,");
               }),
  };
}

}  // namespace

std::vector<Case> mesh_cases() {
  std::vector<Case> all;
  for (const auto& part : {graphs(), comparisons(), files(), floors(), scans()}) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

}  // namespace enfilade::bad_input
