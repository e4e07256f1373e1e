// enfilade scan-mesh: a walkable scan in Matterport3D's files, from any mesh.
#include <fmt/format.h>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/capture/plain_room.h"
#include "enfilade/capture/scan_files.h"
#include "enfilade/core/gzip.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/mesh/lighting.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::apps::scan_mesh_verb {
namespace {

struct Arguments {
  MeshOptions mesh;
  std::string output, graph, labels;
  std::vector<std::string> parts;
  capture::ScanFilesOptions files;
  std::size_t limit = 0;
  bool room = false;
};

capture::ScanParts parts_of(const Arguments& a) {
  std::vector<std::string> names = a.parts;
  if (names.empty()) names = {"skybox", "strips", "mesh"};
  if (a.parts.empty() && a.labels.empty()) names.emplace_back("house");
  capture::ScanParts parts = capture::scan_parts(names);
  if (parts.house && !a.labels.empty()) {
    if (std::ranges::find(names, "house") != names.end()) {
      throw UsageError("--parts house: those files are what --labels gives");
    }
    parts.house = false;  // "all"
  }
  return parts;
}

mesh::Mesh read(const Arguments& a) {
  mesh::Mesh mesh = read_mesh_file(a.mesh.file, a.mesh.read());
  const mesh::Box box = mesh::bounds(mesh);
  say("{}: {} triangles, {} materials, {} objects, {:.1f} x {:.1f} x {:.1f} m\n", a.mesh.file,
      mesh.triangles.size(), mesh.materials.size(), mesh.objects.size(), box.high.x - box.low.x,
      box.high.y - box.low.y, box.high.z - box.low.z);
  std::fflush(stdout);
  if (a.room) capture::add_plain_room(mesh);
  return mesh;
}

scan::Connectivity graph_of(const Arguments& a, const mesh::RayTracer& tracer,
                            const std::string& scan) {
  if (!a.graph.empty()) {
    scan::Connectivity graph = scan::load_connectivity_file(a.graph, scan);
    std::size_t taken = 0;
    for (scan::ConnectivityEntry& entry : graph.entries) {
      if (entry.included && a.limit != 0) entry.included = taken++ < a.limit;
    }
    return graph;
  }
  const mesh::WalkableFloor floor = find_floor(tracer.mesh(), a.mesh, {.growing_cell = true});
  if (const double cell = floor.options().cell; cell > mesh::WalkableOptions{}.cell) {
    say(stderr, "note: the mesh is large: its floor is searched in steps of {:.2f} m\n", cell);
  }
  std::vector<graph::PlacedViewpoint> viewpoints = graph::place_viewpoints(tracer, floor);
  if (a.limit != 0 && viewpoints.size() > a.limit) viewpoints.resize(a.limit);
  return graph::connect_viewpoints(tracer, floor, viewpoints, scan, {}, a.files.threads,
                                   progress_bar("graph"));
}

void warn_of_emptiness(const mesh::RayTracer& tracer, const scan::Connectivity& graph) {
  const double empty = capture::share_of_nothing_below(tracer, graph);
  if (empty < .5) return;
  say(stderr,
      "warning: looking down from the viewpoints, {:.0f} % of directions meet nothing: has "
      "the mesh no floor, or another axis up (--up)? --room puts things into a plain room\n",
      100 * empty);
}

void report(const Arguments& a, const scan::Connectivity& graph,
            const capture::ScanFilesReport& report, double seconds) {
  say("{}: {} viewpoints, {} edges; {} pictures{} in {:.1f} s, {:.1f} MB\n", report.folder.string(),
      report.viewpoints, graph::NavGraph(graph).edge_count() / 2, report.written,
      report.kept == 0 ? "" : fmt::format(" ({} more were there)", report.kept), seconds,
      static_cast<double>(report.bytes) / 1e6);
  say("Next:\n"
      "  enfilade contact-sheet {0} --data {1} -o {0}.png\n"
      "  enfilade graph draw {0} --data {1}\n"
      "  enfilade render {0} 0 --data {1}\n"
      "  enfilade pack --data {1} -o {1}/store\n",
      graph.scan, a.output);
}

void run(Arguments a) {
  const Stopwatch watch;
  a.files.parts = parts_of(a);
  const std::string scan = scan_of(a.mesh, a.graph);
  const auto tracer =
      std::make_shared<const mesh::RayTracer>(std::make_shared<const mesh::Mesh>(read(a)));
  const scan::Connectivity graph = graph_of(a, *tracer, scan);
  warn_of_emptiness(*tracer, graph);
  mesh::BakeOptions bake = a.files.parts.coloured() ? mesh::BakeOptions{} : capture::least_light();
  bake.threads = a.files.threads;
  const mesh::LitMesh lit(tracer, mesh::studio_lights(tracer->mesh()), bake, progress_bar("light"));
  std::unique_ptr<const mesh::LitMesh> labels;
  if (!a.labels.empty()) {
    std::vector<Diagnostic> warnings;
    labels = capture::read_label_mesh(a.labels, scan, &warnings);
    if (!warnings.empty()) print_diagnostics(warnings);
  }
  a.files.label_mesh = labels.get();
  const auto files = write_scan(lit, graph, a.output, a.files, progress_bar("pictures"));
  report(a, graph, files, watch.seconds());
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("scan-mesh", "Make a scan from a mesh, in Matterport3D's files");
  const auto arguments = std::make_shared<Arguments>();
  add_mesh_options(verb, arguments->mesh);
  add_value(verb, "-o,--output", arguments->output, "ROOT",
            "Data set to write into, made if missing; other scans stay")
      ->required();
  verb.add_flag("--room", arguments->room,
                "Put the mesh into a plain room, for objects without one");
  add_value(verb, "--graph", arguments->graph, "CONNECTIVITY.json",
            "Viewpoints and edges (default: placed on the mesh's walkable floor)")
      ->check(
          [](const std::string& file) { return CLI::ExistingFile(find_text_file(file).string()); });
  add_whole_number(verb, "--limit", arguments->limit, "Make the first N viewpoints only; 0: all", 0)
      ->type_name("N");
  add_value(verb, "--labels", arguments->labels, "DIR",
            "Matterport3D's house_segmentations of the scan, for classes and instances")
      ->check(CLI::ExistingDirectory);
  add_value(verb, "--parts", arguments->parts, "PART,...",
            "Parts to write, comma-separated: docs/capture.md (default: skybox,strips,house,mesh)")
      ->delimiter(',')
      ->check(CLI::IsMember(capture::scan_part_names()));
  add_setting(verb, "--size", arguments->files.face_size, "",
              "Texels along the edge of a sky-box's face", CLI::Range(16, 4096));
  add_setting(verb, "--image-width", arguments->files.image_width, "",
              "Width of undistorted images, pixels; the height is 4/5 of it", CLI::Range(10, 4096));
  add_setting(verb, "--samples", arguments->files.samples, "1|4|9|16", "Colour rays per pixel",
              CLI::IsMember({1, 4, 9, 16}));
  add_setting(verb, "--exposure", arguments->files.exposure, "",
              "Stops brighter (or darker) than automatic exposure", finite_number(-10));
  add_setting(verb, "--quality", arguments->files.jpeg_quality, "", "JPEG quality, 1 to 100",
              CLI::Range(1, 100));
  add_threads_option(verb, arguments->files.threads);
  set_examples(
      verb,
      {"enfilade scan-mesh house.glb -o my-scans",
       "enfilade scan-mesh tavern_furniture.glb -o my-scans --room",
       "enfilade scan-mesh flat.obj -o my-scans --scale 0.01 --up y --limit 4 --size 256",
       "enfilade scan-mesh house.glb -o my-scans --parts all",
       ("enfilade scan-mesh S/house_segmentations/S.ply --scan S --labels "
        "S/house_segmentations --graph S_connectivity.json --parts labels,depth -o labels")},
      "An interrupted run resumes. Parts and viewpoints may be added later.");
  verb.callback([arguments] { run(*arguments); });
}

}  // namespace enfilade::apps::scan_mesh_verb
