// enfilade graph compare: how far two graphs of one building agree.
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "apps/common/program.h"
#include "apps/enfilade/graph/graph_verbs.h"
#include "enfilade/core/file.h"
#include "enfilade/draw/graph_comparison.h"
#include "enfilade/graph/compare.h"

namespace enfilade::apps {
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
  constexpr std::string_view kSuffix = "_connectivity.json";
  std::string scan = std::filesystem::path(file).filename().string();
  if (scan.ends_with(kSuffix)) scan.resize(scan.size() - kSuffix.size());
  return NavGraph(scan::parse_connectivity(read_file(file), scan, file));
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
  if (a.plan != "-") fmt::print("{}", report);
  if (!a.plan.empty()) {
    draw::ComparisonPlanOptions options;
    options.title = found.scan() + " against " + truth.scan();
    options.label_viewpoints = a.labels;
    write_output(a.plan, draw::graph_comparison_svg(found, c, options));
    if (a.plan != "-") fmt::print("{}\n", a.plan);
  }
  return a.least_f1 && c.f1() < *a.least_f1 ? kFaultsFound : kSuccess;
}

void add_verb(CLI::App& graph, int& status) {
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

}  // namespace
}  // namespace graph_compare_verb

void add_graph_compare(CLI::App& graph, int& status) {
  graph_compare_verb::add_verb(graph, status);
}

}  // namespace enfilade::apps
