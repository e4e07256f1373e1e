// enfilade graph build: viewpoints and edges from any mesh.
#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/graph/graph_verbs.h"
#include "apps/enfilade/mesh_files.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/corrections.h"

namespace enfilade::apps {
namespace graph_build_verb {
namespace {

using graph::NavGraph;

struct BuildArguments {
  MeshOptions mesh;
  std::string output, corrections, plan;
  mesh::WalkableOptions walk;
  graph::ViewpointOptions viewpoints;
  graph::EdgeOptions edges;
  int threads = 0;
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
  row("walkable floor",
      fmt::format("{:.0f} m2 in {}", built.floor_m2, counted(built.parts, "part")));
  row("time", fmt::format("{:.2f} s", built.seconds));
  return text;
}

void run(const BuildArguments& a) {
  const std::string scan = scan_of(a.mesh);
  const Built built = build(a, scan);
  scan::save_connectivity(a.output, built.connectivity);
  const NavGraph graph(built.connectivity);
  fmt::print("{}", table(built, graph));
  const auto notes = graph::check_graph(built.connectivity, {a.edges.longest, 0.05});
  if (!notes.empty()) print_diagnostics(notes);
  fmt::print("{}\n", scan::connectivity_file(a.output, scan).string());
  if (a.plan.empty()) return;
  const draw::PlanUnderlay underlay = draw::plan_underlay(*built.mesh, graph);
  draw::FloorPlanOptions options;
  options.underlay = &underlay;
  write_output(a.plan, draw::floor_plan_svg(graph, {}, options));
  if (a.plan != "-") fmt::print("{}\n", a.plan);
}

void add_body(CLI::App& verb, BuildArguments& a) {
  add_metres_option(verb, "--body-radius", a.walk.body.radius, "Radius of the walking body");
  add_metres_option(verb, "--body-height", a.walk.body.height, "Height of the walking body");
  add_metres_option(verb, "--step", a.walk.body.step, "Highest step");
  add_setting(verb, "--slope", a.walk.body.slope, "", "Steepest floor, degrees", finite_number());
  add_metres_option(verb, "--cell", a.walk.cell, "Grid spacing of the floor");
  add_metres_option(verb, "--longest-edge", a.edges.longest, "Longest edge");
  add_metres_option(verb, "--body-width", a.edges.width, "Free width along an edge");
}

void add_verb(CLI::App& graph, int& /*status*/) {
  CLI::App& verb = *graph.add_subcommand("build", "Build a navigation graph from a mesh");
  const auto a = std::make_shared<BuildArguments>();
  add_mesh_options(verb, a->mesh);
  add_value(verb, "-o,--output", a->output, "DIR", "Output folder; made if missing")->required();
  add_metres_option(verb, "--separation", a->viewpoints.separation,
                    "Mean length of edges in furnished homes");
  add_metres_option(verb, "--eye-height", a->viewpoints.eye_height,
                    "Camera height above the floor");
  add_whole_number(verb, "--seed", a->viewpoints.seed, "Selects among equally good viewpoints", 0);
  add_body(verb, *a);
  add_value(verb, "--corrections", a->corrections, "FILE",
            "Edges and viewpoints to add or remove: docs/graph.md");
  add_value(verb, "--plan", a->plan, "FILE", "Draw a floor plan as SVG; - for standard output");
  add_threads_option(verb, a->threads);
  set_examples(verb, {"enfilade graph build house.glb -o my-scans --plan house.svg",
                      "enfilade graph build flat.obj -o my-scans --up y --scale 0.01",
                      "enfilade graph build flat.obj -o my-scans --corrections flat.json"});
  verb.callback([a] { run(*a); });
}

}  // namespace
}  // namespace graph_build_verb

void add_graph_build(CLI::App& graph, int& status) { graph_build_verb::add_verb(graph, status); }

}  // namespace enfilade::apps
