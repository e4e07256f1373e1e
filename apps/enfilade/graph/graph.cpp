// enfilade graph: what is odd about navigation graphs, and floor plans of them.
#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/drawn_path.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/building_plan.h"

namespace enfilade::apps::graph_verb {
namespace {

using draw::PlannedPath;

struct CheckArguments {
  std::string directory, data, json;
  bool strict = false;
  graph::CheckOptions options;
};

// How often one code occurs, and in how many files.
struct CodeCount {
  Severity severity = Severity::kNote;
  std::size_t count = 0;
  std::set<std::string> files;
};

struct Summary {
  std::map<std::string, CodeCount> codes;
  std::map<Severity, std::size_t> severities;
  std::size_t viewpoints = 0, included = 0, edges = 0;
};

Summary summarise(const std::vector<graph::FileReport>& reports) {
  Summary summary;
  for (const graph::FileReport& report : reports) {
    summary.viewpoints += report.viewpoints;
    summary.included += report.included;
    summary.edges += report.edges;
    for (const Diagnostic& d : report.diagnostics) {
      CodeCount& code = summary.codes[d.code];
      code.severity = std::max(code.severity, d.severity);
      ++code.count;
      code.files.insert(d.file);
      ++summary.severities[d.severity];
    }
  }
  return summary;
}

std::string to_text(const std::vector<graph::FileReport>& reports, Summary& summary) {
  std::string text;
  for (const graph::FileReport& report : reports) {
    for (const Diagnostic& d : report.diagnostics) text += to_string(d) + "\n";
  }
  if (!summary.codes.empty()) {
    text += fmt::format("\n{:<24}{:<10}{:>7}{:>7}\n", "code", "severity", "count", "files");
  }
  for (const auto& [code, n] : summary.codes) {
    text += fmt::format("{:<24}{:<10}{:>7}{:>7}\n", code, to_string(n.severity), n.count,
                        n.files.size());
  }
  return text + fmt::format(
                    "\n{} files, {} viewpoints ({} included), {} edges between them: "
                    "{} errors, {} warnings, {} notes\n",
                    reports.size(), summary.viewpoints, summary.included, summary.edges,
                    summary.severities[Severity::kError], summary.severities[Severity::kWarning],
                    summary.severities[Severity::kNote]);
}

std::string to_json(const std::vector<graph::FileReport>& reports, const Summary& summary) {
  using Json = nlohmann::ordered_json;
  Json files = Json::array();
  for (const graph::FileReport& report : reports) {
    Json diagnostics = Json::array();
    for (const Diagnostic& d : report.diagnostics) {
      diagnostics.push_back({{"severity", to_string(d.severity)},
                             {"file", d.file},
                             {"where", d.where},
                             {"code", d.code},
                             {"message", d.message}});
    }
    files.push_back({{"scan", report.scan},
                     {"viewpoints", report.viewpoints},
                     {"included", report.included},
                     {"edges", report.edges},
                     {"diagnostics", std::move(diagnostics)}});
  }
  Json codes = Json::object();
  for (const auto& [code, n] : summary.codes) {
    codes[code] = {
        {"severity", to_string(n.severity)}, {"count", n.count}, {"files", n.files.size()}};
  }
  const Json report{{"viewpoints", summary.viewpoints},
                    {"included", summary.included},
                    {"edges", summary.edges},
                    {"codes", std::move(codes)},
                    {"files", std::move(files)}};
  // Messages quote what files hold, which need not be UTF-8.
  return report.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

int check(const CheckArguments& arguments) {
  if (!(arguments.options.longest_edge > 0)) {
    throw UsageError(
        fmt::format("--longest-edge: {}, not above 0 metres", arguments.options.longest_edge));
  }
  const std::filesystem::path directory = arguments.directory.empty()
                                              ? open_data(arguments.data).connectivity_folder()
                                              : std::filesystem::path(arguments.directory);
  const auto reports = graph::check_folder(directory, arguments.options);
  Summary summary = summarise(reports);
  if (arguments.json != "-") write_output("-", to_text(reports, summary));
  if (!arguments.json.empty()) write_output(arguments.json, to_json(reports, summary));
  const bool faults = summary.severities[Severity::kError] > 0 ||
                      (arguments.strict && summary.severities[Severity::kWarning] > 0);
  return faults ? kFaultsFound : kSuccess;
}

struct DrawArguments {
  std::string scan, output, data, mesh;
  PathOptions path;
  bool labels = false;
};

double length_of(const graph::NavGraph& graph, const std::vector<ViewpointIndex>& path) {
  double metres = 0;
  for (std::size_t i = 1; i < path.size(); ++i) metres += graph.distance(path[i - 1], path[i]);
  return metres;
}

PlannedPath agent(const graph::NavGraph& graph, const tasks::ReferencePath& path,
                  const tasks::Trajectory& trajectory) {
  PlannedPath found;
  for (const tasks::TrajectoryPoint& point : trajectory.points) {
    found.viewpoints.push_back(point.viewpoint);
  }
  found.label = fmt::format("agent\u2019s path, {:.1f} m", length_of(graph, found.viewpoints));
  if (path.viewpoints.size() > 1 && !draw::planned_goal(path)) {
    found.label += fmt::format(", ends {:.1f} m from the goal",
                               graph.distance(found.viewpoints.back(), path.viewpoints.back()));
  }
  return found;
}

std::vector<PlannedPath> paths_of(const DrawnPath& drawn) {
  const graph::NavGraph& graph = drawn.graph();
  const std::vector<ViewpointIndex>& reference = drawn.path().viewpoints;
  std::vector<PlannedPath> paths{
      {draw::PathRole::kReference, reference,
       fmt::format("reference path, {:.1f} m", length_of(graph, reference))}};
  if (drawn.walk) paths.push_back(agent(graph, drawn.path(), *drawn.walk));
  return paths;
}

// Drawn from --mesh, else from what the data set tells of the building.
homes::BuildingPlan plan_of(const DrawArguments& a, const dataset::Dataset& data,
                            const graph::NavGraph& graph) {
  if (!a.mesh.empty()) return {{}, draw::plan_underlay(read_mesh_file(a.mesh, {}), graph)};
  return homes::read_building_plan(data.folder(), data.panorama_places().images, graph);
}

void draw_plan(const DrawArguments& a) {
  validate(a.path, a.scan);
  const dataset::Dataset data = open_data(a.data);
  std::string scan = a.scan;
  std::vector<PlannedPath> paths;
  draw::FloorPlanOptions options;
  options.label_viewpoints = a.labels;
  if (!a.path.split.empty()) {
    const DrawnPath drawn = find_path(a.path, a.scan, data);
    const bool hidden = tasks::goal_hidden(drawn.path());
    scan = drawn.graph().scan();
    paths = paths_of(drawn);
    options.title = drawn.title() + (hidden ? ", goal hidden" : "");
    options.lines = drawn.lines();
    options.goal = draw::planned_goal(drawn.path(), drawn.goal_name());
  }
  const graph::NavGraph& graph = data.graphs()->graph(scan);
  const homes::BuildingPlan plan = plan_of(a, data, graph);
  options.underlay = plan.drawn();
  if (data.synthetic()) {
    options.title = (options.title.empty() ? graph.scan() : options.title) + " (synthetic)";
  }
  const std::string output = a.output.empty() ? scan + ".svg" : a.output;
  write_output(output, floor_plan_svg(graph, paths, options));
  if (output != "-") say("{}\n", output);
}

void add_check(CLI::App& graph, int& status) {
  CLI::App& verb = *graph.add_subcommand(
      "check", "Check navigation graphs for broken files, odd edges and isolated parts");
  const auto arguments = std::make_shared<CheckArguments>();
  add_value(verb, "directory", arguments->directory, "DIR",
            "Folder of *_connectivity.json (default: that of the data set)");
  add_data_option(verb, arguments->data);
  add_value(verb, "--json", arguments->json, "FILE",
            "Write the report as JSON; - for standard output, without the text");
  add_metres_option(verb, "--longest-edge", arguments->options.longest_edge,
                    "Report edges that are longer; metres");
  verb.add_flag("--strict", arguments->strict, "Exit code 1 for warnings too");
  set_examples(verb,
               {"enfilade graph check", "enfilade graph check my-scans --strict",
                "enfilade graph check --json - | jq .codes"},
               "Exit code 1 if there is an error: a file that cannot be used.");
  verb.callback([arguments, &status] { status = check(*arguments); });
}

void add_draw(CLI::App& graph) {
  CLI::App& verb = *graph.add_subcommand("draw", "Draw a floor plan as SVG, one panel per storey");
  const auto a = std::make_shared<DrawArguments>();
  add_scan_argument(verb, a->scan);
  add_value(verb, "-o,--output", a->output, "FILE",
            "SVG file (default: SCAN.svg); - for standard output");
  add_data_option(verb, a->data);
  add_value(verb, "--mesh", a->mesh, "FILE",
            "Mesh for walls, in the graph's frame: GLB, glTF, OBJ, PLY; homes need none");
  add_path_options(verb, a->path, "draw the agent's path of --instr too");
  verb.add_flag("--labels", a->labels, "Write indices beside viewpoints");
  set_examples(verb,
               {"enfilade graph draw 17DRP5sb8fy -o plan.svg",
                "enfilade graph draw home0001 --data homes -o home.svg",
                "enfilade graph draw 17DRP5sb8fy --mesh 17DRP5sb8fy.ply -o plan.svg",
                "enfilade graph draw --split val_unseen --path 4332",
                "enfilade graph draw --task reverie --split val_unseen --instr 4332_57_0",
                "enfilade graph draw --split val_unseen --instr 4332_0 --results results.json"});
  verb.callback([a] { draw_plan(*a); });
}

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb =
      *app.add_subcommand("graph", "Build, check and compare navigation graphs, draw floor plans");
  verb.require_subcommand(1);
  add_check(verb, status);
  add_draw(verb);
  graph_build_verb::add(verb, status);
  graph_compare_verb::add(verb, status);
}

}  // namespace enfilade::apps::graph_verb
