// enfilade graph build: viewpoints and edges out of any mesh.
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/graph_verbs.h"
#include "apps/enfilade/mesh_files.h"
#include "enfilade/core/file.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/corrections.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;
using graph::NavGraph;

struct BuildArguments {
  MeshOptions mesh;
  std::string output, corrections, plan;
  mesh::WalkableOptions walk;
  graph::ViewpointOptions viewpoints;
  graph::EdgeOptions edges;
  int threads = 0;
};

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// What was made, and how long it took.
struct Built {
  scan::Connectivity connectivity;
  double floor_m2 = 0;
  std::size_t parts = 0;
  double seconds = 0;  // without reading the mesh
  std::shared_ptr<const mesh::Mesh> mesh;
};

Built build(const BuildArguments& a, const std::string& scan) {
  graph::Corrections corrections;
  if (!a.corrections.empty()) corrections = graph::load_corrections(a.corrections);
  const auto made = std::make_shared<const mesh::Mesh>(read_mesh_file(a.mesh));
  const Stopwatch watch;
  const mesh::RayTracer tracer(made);
  const mesh::WalkableFloor floor = find_floor(*made, a.mesh, a.walk);
  const auto viewpoints = graph::place_viewpoints(tracer, floor, a.viewpoints);
  Built built{graph::connect_viewpoints(tracer, floor, viewpoints, scan, a.edges, a.threads,
                                        progress_bar("edges")),
              floor.area_m2(), floor.areas(), watch.seconds(), made};
  if (!a.corrections.empty()) {
    auto corrected = graph::apply(built.connectivity, corrections, a.corrections);
    if (!corrected.notes.empty()) print_diagnostics(corrected.notes);
    built.connectivity = std::move(corrected.connectivity);
  }
  return built;
}

// Mean distance of included viewpoints to the nearest other.
double mean_nearest(const NavGraph& graph) {
  double sum = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < graph.size(); ++j) {
      if (i == j || !graph.included(ViewpointIndex(j))) continue;
      nearest = std::min<double>(
          nearest, length(graph.position(ViewpointIndex(i)) - graph.position(ViewpointIndex(j))));
    }
    if (graph.included(ViewpointIndex(i))) sum += nearest;
  }
  return sum / static_cast<double>(graph.included_count());
}

std::string table(const Built& built, const NavGraph& graph) {
  double metres = 0, longest = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (const graph::Edge& edge : graph.edges(ViewpointIndex(i))) {
      metres += edge.length;
      longest = std::max(longest, edge.length);
    }
  }
  const auto directed = static_cast<double>(graph.edge_count());
  std::string text;
  const auto row = [&text](const char* what, const std::string& value) {
    text += fmt::format("{:<22}{}\n", what, value);
  };
  row("viewpoints", fmt::format("{}", graph.included_count()));
  row("edges", fmt::format("{}", graph.edge_count() / 2));
  row("degree",
      fmt::format("{:.2f}, at most {}", directed / static_cast<double>(graph.included_count()),
                  graph.max_degree()));
  if (directed > 0) {
    row("edge length", fmt::format("{:.2f} m, at most {:.2f}", metres / directed, longest));
  }
  if (graph.included_count() > 1) {
    row("nearest viewpoint", fmt::format("{:.2f} m", mean_nearest(graph)));
  }
  row("walkable floor", fmt::format("{:.0f} m2 in {} {}", built.floor_m2, built.parts,
                                    built.parts == 1 ? "part" : "parts"));
  row("time", fmt::format("{:.2f} s", built.seconds));
  return text;
}

// Adds the scan to the folder's list.
void list_scan(const fs::path& folder, const std::string& scan) {
  const fs::path file = folder / "scans.txt";
  std::string text;
  if (fs::exists(file)) {
    const std::vector<std::string> scans = scan::load_scan_list(folder);
    if (std::ranges::find(scans, scan) != scans.end()) return;
    text = read_file(file);
    if (!text.empty() && text.back() != '\n') text += '\n';
  }
  write_file_atomically(file, text + scan + "\n");
}

void run(const BuildArguments& a) {
  const std::string scan = scan_of(a.mesh);
  const Built built = build(a, scan);
  const fs::path folder = a.output;
  make_folder(folder);
  const fs::path file = scan::connectivity_file(folder, scan);
  write_file_atomically(file, scan::to_json(built.connectivity));
  list_scan(folder, scan);
  const NavGraph graph(built.connectivity);
  fmt::print("{}", table(built, graph));
  const auto notes = graph::check_graph(built.connectivity, {a.edges.longest, 0.05});
  if (!notes.empty()) print_diagnostics(notes);
  fmt::print("{}\n", file.string());
  if (a.plan.empty()) return;
  const draw::PlanUnderlay underlay = draw::plan_underlay(*built.mesh, graph);
  draw::FloorPlanOptions options;
  options.underlay = &underlay;
  write_output(a.plan, draw::floor_plan_svg(graph, {}, options));
  if (a.plan != "-") fmt::print("{}\n", a.plan);
}

template <class T>
void add_metres(CLI::App& verb, const char* name, T& value, const char* what) {
  verb.add_option(name, value, what)->check(finite_number())->capture_default_str()->type_name("M");
}

void add_body(CLI::App& verb, BuildArguments& a) {
  add_metres(verb, "--body-radius", a.walk.body.radius, "Radius of the walking body");
  add_metres(verb, "--body-height", a.walk.body.height, "Height of the walking body");
  add_metres(verb, "--step", a.walk.body.step, "Highest step");
  verb.add_option("--slope", a.walk.body.slope, "Steepest floor, degrees")
      ->check(finite_number())
      ->capture_default_str();
  add_metres(verb, "--cell", a.walk.cell, "Grid spacing of the floor");
  add_metres(verb, "--longest-edge", a.edges.longest, "Longest edge");
  add_metres(verb, "--body-width", a.edges.width, "Width that must be free along an edge");
}

}  // namespace

void add_graph_build(CLI::App& graph, int& status) {
  CLI::App& verb = *graph.add_subcommand(
      "build",
      "Find where one can walk in a mesh, spread viewpoints over it, trace the edges between them, "
      "and write a connectivity file and scans.txt");
  const auto a = std::make_shared<BuildArguments>();
  add_mesh_options(verb, a->mesh);
  verb.add_option("-o,--output", a->output, "Output folder; made if missing")
      ->required()
      ->type_name("DIR");
  add_metres(verb, "--separation", a->viewpoints.separation,
             "Mean length of edges in furnished homes");
  add_metres(verb, "--eye-height", a->viewpoints.eye_height, "Camera height above the floor");
  verb.add_option("--seed", a->viewpoints.seed, "Selects among equally good viewpoints")
      ->check(whole_number())
      ->capture_default_str();
  add_body(verb, *a);
  verb.add_option("--corrections", a->corrections,
                  "Edges and viewpoints to add or remove: docs/graph.md")
      ->type_name("FILE");
  verb.add_option("--plan", a->plan, "Draw a floor plan as SVG; - for standard output")
      ->type_name("FILE");
  verb.add_option("--threads", a->threads, "0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  set_examples(verb, {"enfilade graph build house.glb -o my-scans --plan house.svg",
                      "enfilade graph build flat.obj -o my-scans --up y --scale 0.01",
                      "enfilade graph build flat.obj -o my-scans --corrections flat.json"});
  verb.callback([a, &status] {
    run(*a);
    status = kSuccess;
  });
}

}  // namespace enfilade::apps
