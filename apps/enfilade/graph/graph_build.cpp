// enfilade graph build: viewpoints and edges from any mesh; enfilade graph compare: how far two
// graphs of one building agree.
#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/compare.h"
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
  const auto made = std::make_shared<const mesh::Mesh>(read_mesh_file(a.mesh.file, a.mesh.read()));
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
  say("{}", table(built, graph));
  const auto notes = graph::check_graph(built.connectivity, {a.edges.longest, 0.05});
  if (!notes.empty()) print_diagnostics(notes);
  say("{}\n", scan::connectivity_file(a.output, scan).string());
  if (a.plan.empty()) return;
  const draw::PlanUnderlay underlay = draw::plan_underlay(*built.mesh, graph);
  draw::FloorPlanOptions options;
  options.underlay = &underlay;
  write_output(a.plan, draw::floor_plan_svg(graph, {}, options));
  if (a.plan != "-") say("{}\n", a.plan);
}

}  // namespace

void add(CLI::App& graph, int& /*status*/) {
  CLI::App& verb = *graph.add_subcommand("build", "Build a navigation graph from a mesh");
  const auto a = std::make_shared<BuildArguments>();
  add_mesh_options(verb, a->mesh);
  add_value(verb, "-o,--output", a->output, "DIR", "Output folder; made if missing")->required();
  add_metres_option(verb, "--separation", a->viewpoints.separation,
                    "Mean length of edges in furnished homes");
  add_metres_option(verb, "--eye-height", a->viewpoints.eye_height,
                    "Camera height above the floor");
  add_whole_number(verb, "--seed", a->viewpoints.seed, "Selects among equally good viewpoints", 0);
  add_metres_option(verb, "--body-radius", a->walk.body.radius, "Radius of the walking body");
  add_metres_option(verb, "--body-height", a->walk.body.height, "Height of the walking body");
  add_metres_option(verb, "--step", a->walk.body.step, "Highest step");
  add_setting(verb, "--slope", a->walk.body.slope, "", "Steepest floor, degrees", finite_number());
  add_metres_option(verb, "--cell", a->walk.cell, "Grid spacing of the floor");
  add_metres_option(verb, "--longest-edge", a->edges.longest, "Longest edge");
  add_metres_option(verb, "--body-width", a->edges.width, "Free width along an edge");
  add_value(verb, "--corrections", a->corrections, "FILE",
            "Edges and viewpoints to add or remove: docs/graph.md");
  add_value(verb, "--plan", a->plan, "FILE", "Draw a floor plan as SVG; - for standard output");
  add_threads_option(verb, a->threads);
  set_examples(verb, {"enfilade graph build house.glb -o my-scans --plan house.svg",
                      "enfilade graph build flat.obj -o my-scans --up y --scale 0.01",
                      "enfilade graph build flat.obj -o my-scans --corrections flat.json"});
  verb.callback([a] { run(*a); });
}

}  // namespace graph_build_verb

namespace graph_compare_verb {
namespace {

using graph::ComparedEdge;
using graph::NavGraph;

struct CompareArguments {
  std::string found, truth, plan;
  std::optional<double> least_f1;
  bool labels = false;
};

NavGraph load(const std::string& file) {
  const std::string name = std::filesystem::path(file).filename().string();
  return NavGraph(scan::load_connectivity_file(file, scan::scan_of_file(file).value_or(name)));
}

std::string list(const NavGraph& found, const std::vector<ComparedEdge>& edges, const char* what) {
  std::string text;
  for (const ComparedEdge& e : edges) {
    text += fmt::format("{:<9}{:>5} - {:<5}{:>6.2f} m  {} {}\n", what, e.a.at(), e.b.at(), e.length,
                        found.id(e.a), found.id(e.b));
  }
  return text;
}

int run(const CompareArguments& a) {
  const NavGraph found = load(a.found), truth = load(a.truth);
  const graph::GraphComparison c = graph::compare(found, truth);
  const std::string report =
      list(found, c.extra, "extra") + list(found, c.missing, "missing") +
      fmt::format("viewpoints  {} in both, {} only in A, {} only in B\n", c.matched,
                  c.only_found.size(), c.only_truth.size()) +
      fmt::format("edges       {} in both, {} extra, {} missing\n", c.common, c.extra.size(),
                  c.missing.size()) +
      fmt::format("precision   {:.4f}\nrecall      {:.4f}\nF1          {:.4f}\n", c.precision(),
                  c.recall(), c.f1());
  if (a.plan != "-") say("{}", report);
  if (!a.plan.empty()) {
    draw::ComparisonPlanOptions options;
    options.title = found.scan() + " against " + truth.scan();
    options.label_viewpoints = a.labels;
    write_output(a.plan, draw::graph_comparison_svg(found, c, options));
    if (a.plan != "-") say("{}\n", a.plan);
  }
  return a.least_f1 && c.f1() < *a.least_f1 ? kFaultsFound : kSuccess;
}

}  // namespace

void add(CLI::App& graph, int& status) {
  CLI::App& verb = *graph.add_subcommand(
      "compare", "Compare a navigation graph with a reference: precision, recall, F1");
  const auto a = std::make_shared<CompareArguments>();
  add_value(verb, "A", a->found, "FILE", "Connectivity file")->required();
  add_value(verb, "B", a->truth, "FILE", "Connectivity file of the reference")->required();
  add_value(verb, "--plan", a->plan, "FILE",
            "Draw the difference as SVG; - for standard output, without the report");
  verb.add_flag("--labels", a->labels, "Write indices beside viewpoints of the plan");
  add_value(verb, "--least-f1", a->least_f1, "X", "Exit code 1 if F1 is lower")
      ->check(finite_number(0, 1));
  set_examples(verb, {"enfilade graph compare built/x_connectivity.json x_connectivity.json",
                      "enfilade graph compare A.json B.json --plan difference.svg",
                      "enfilade graph compare A.json B.json --least-f1 0.98"});
  verb.callback([a, &status] { status = run(*a); });
}

}  // namespace graph_compare_verb

}  // namespace enfilade::apps
