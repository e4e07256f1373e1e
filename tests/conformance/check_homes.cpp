// check_homes: navigation graphs built from the meshes of model homes, against what the generator
// itself knows of walls, doors, furniture and stairs.
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <queue>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/threads.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/compare.h"
#include "enfilade/homes/built_home.h"
#include "tests/support/home_passage.h"

namespace enfilade::tests {
namespace {

using namespace apps;

struct Options {
  std::size_t homes = 20;
  std::uint64_t seed = 1000;
  double area = 0, least_f1 = 0.98;
  bool build_only = false, list = false;
};

Vec3d foot_of(const scan::ConnectivityEntry& viewpoint) {
  Vec3d foot = viewpoint.position();
  foot.z -= viewpoint.height;
  return foot;
}

bool is_free(const homes::Home& home, const scan::Connectivity& graph, std::size_t a, std::size_t b,
             double slack) {
  const graph::EdgeOptions edge;
  return passage_is_free(home, foot_of(graph.entries[a]), foot_of(graph.entries[b]), edge.width,
                         edge.lowest, edge.highest, slack);
}

// The same viewpoints with the edges that are true.
scan::Connectivity true_graph(const homes::Home& home, const scan::Connectivity& found) {
  scan::Connectivity truth = found;
  for (auto& entry : truth.entries) entry.unobstructed.clear();
  const double longest = graph::EdgeOptions().longest;
  for (std::size_t a = 0; a < found.entries.size(); ++a) {
    for (std::size_t b = a + 1; b < found.entries.size(); ++b) {
      const double apart = length(found.entries[a].position() - found.entries[b].position());
      if (apart > longest || !is_free(home, found, a, b, 0)) continue;
      truth.entries[a].unobstructed.emplace_back(b);
      truth.entries[b].unobstructed.emplace_back(a);
    }
  }
  for (auto& entry : truth.entries) std::ranges::sort(entry.unobstructed);
  return truth;
}

// How many metres thinner (negative: thicker) the body would have to be for the truth to change;
// 0.5 if no thickness changes it.
double margin(const homes::Home& home, const scan::Connectivity& graph, graph::ComparedEdge edge,
              bool extra) {
  constexpr double kStep = 0.005, kMost = 0.15;
  for (double slack = kStep; slack <= kMost; slack += kStep) {
    const double s = extra ? slack : -slack;
    if (is_free(home, graph, edge.a.at(), edge.b.at(), s) == extra) return s;
  }
  return 0.5;
}

std::size_t components(const scan::Connectivity& graph) {
  std::vector<char> seen(graph.entries.size());
  std::size_t count = 0;
  for (std::size_t start = 0; start < seen.size(); ++start) {
    if (seen[start] != 0) continue;
    ++count;
    std::queue<std::size_t> open;
    open.push(start);
    seen[start] = 1;
    while (!open.empty()) {
      const std::size_t v = open.front();
      open.pop();
      for (const ViewpointIndex n : graph.entries[v].unobstructed) {
        if (seen[n.at()] != 0) continue;
        seen[n.at()] = 1;
        open.push(n.at());
      }
    }
  }
  return count;
}

// Storeys and rooms in which no viewpoint stands.
std::string not_reached(const homes::Home& home, const scan::Connectivity& graph) {
  std::vector<std::size_t> count(home.plan.rooms.size());
  for (const auto& entry : graph.entries) {
    if (const auto room = homes::room_at(home.plan, foot_of(entry))) ++count[*room];
  }
  std::string text;
  for (std::size_t r = 0; r < count.size(); ++r) {
    if (count[r] > 0) continue;
    const homes::PlanRoom& room = home.plan.rooms[r];
    text += fmt::format(" {} ({:.1f} m2)", room.name, room.floor.area());
  }
  return text;
}

struct Totals {
  std::size_t homes = 0, viewpoints = 0, common = 0, extra = 0, missing = 0, parts = 0;
  double home_seconds = 0, graph_seconds = 0;  // making meshes; floors, viewpoints and edges
  double f1() const {
    return 2.0 * static_cast<double>(common) /
           std::max(1.0, static_cast<double>(2 * common + extra + missing));
  }
};

void list_differences(const homes::Home& home, const scan::Connectivity& found,
                      const graph::GraphComparison& compared) {
  const auto print = [&](const char* what, const graph::ComparedEdge& edge, bool extra) {
    const Vec3d a = found.entries[edge.a.at()].position(),
                b = found.entries[edge.b.at()].position();
    fmt::print(
        "    {} {}-{}, {:.2f} m, ({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f}), margin "
        "{:.3f} m\n",
        what, edge.a.value, edge.b.value, edge.length, a.x, a.y, a.z, b.x, b.y, b.z,
        margin(home, found, edge, extra));
  };
  for (const auto& edge : compared.extra) print("extra", edge, true);
  for (const auto& edge : compared.missing) print("missing", edge, false);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Made {
  homes::BuiltHome built;
  scan::Connectivity graph;
};

Made make(const Options& options, std::uint64_t seed, Totals& totals) {
  homes::PlanOptions plan;
  plan.seed = seed;
  plan.area = options.area;
  const auto start = std::chrono::steady_clock::now();
  Made made{homes::build_home(plan), {}};
  totals.home_seconds += seconds_since(start);
  const auto built = std::chrono::steady_clock::now();
  made.graph = homes::build_graph(made.built, fmt::format("seed_{}", seed), 0);
  totals.graph_seconds += seconds_since(built);
  ++totals.homes;
  totals.viewpoints += made.graph.entries.size();
  totals.parts += components(made.graph);
  return made;
}

void check_home(const Options& options, std::uint64_t seed, Totals& totals) {
  const auto [built, found] = make(options, seed, totals);
  const auto truth = true_graph(built.home, found);
  const auto compared = graph::compare(graph::NavGraph(found), graph::NavGraph(truth));
  fmt::print("{:>8} {:<7}{:>3}{:>7}{:>7}{:>7}{:>7}{:>9.4f}{:>7}   {}\n", seed,
             enum_name(built.home.plan.kind), built.home.plan.storeys.size(), found.entries.size(),
             compared.common, compared.extra.size(), compared.missing.size(), compared.f1(),
             components(found), not_reached(built.home, found));
  if (options.list) list_differences(built.home, found, compared);
  totals.common += compared.common;
  totals.extra += compared.extra.size();
  totals.missing += compared.missing.size();
}

int check(const Options& options) {
  Totals totals;
  const Progress progress = progress_bar("homes");
  if (!options.build_only) {
    fmt::print("{:>8} {:<7}{:>3}{:>7}{:>7}{:>7}{:>7}{:>9}{:>7}   rooms with no viewpoint\n", "seed",
               "kind", "st", "views", "edges", "extra", "missing", "F1", "parts");
  }
  for (std::size_t i = 0; i < options.homes; ++i) {
    if (options.build_only) {
      make(options, options.seed + i, totals);
    } else {
      check_home(options, options.seed + i, totals);
    }
    if (progress) progress(i + 1, options.homes);
  }
  fmt::print("{} viewpoints; {:.2f} s for homes, {:.2f} s for floors, viewpoints and edges\n",
             totals.viewpoints, totals.home_seconds, totals.graph_seconds);
  if (options.build_only) {
    fmt::print("{} homes built, graphs of {} pieces in all\n", totals.homes, totals.parts);
    return totals.parts == totals.homes ? kSuccess : kFaultsFound;
  }
  fmt::print(
      "SYNTHETIC: {} homes, {} viewpoints, edges {} right, {} extra, {} missing, F1 {:.4f}; {} "
      "pieces\n",
      totals.homes, totals.viewpoints, totals.common, totals.extra, totals.missing, totals.f1(),
      totals.parts);
  return totals.f1() >= options.least_f1 && totals.parts == totals.homes ? kSuccess : kFaultsFound;
}

}  // namespace
}  // namespace enfilade::tests

int main(int argc, char** argv) {
  using namespace enfilade::tests;
  CLI::App app{"Checks navigation graphs of model homes against the generator's own knowledge."};
  Options options;
  int status = kSuccess;
  app.add_option("--homes", options.homes, "How many")
      ->check(whole_number(1))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Of the first; then one after another")
      ->check(whole_number())
      ->capture_default_str();
  app.add_option("--area", options.area, "Square metres; 0: drawn")->check(finite_number());
  app.add_option("--least-f1", options.least_f1, "Below it, exit status 1")
      ->check(finite_number(0, 1))
      ->capture_default_str();
  app.add_flag("--list", options.list, "Each edge that differs, and by how much");
  app.add_flag("--build-only", options.build_only, "Only see that homes and graphs get built");
  set_examples(
      app, {"check_homes --homes 20 --seed 5000 --list", "check_homes --homes 200 --build-only"});
  app.callback([&] { status = check(options); });
  return run_program(app, argc, argv, status);
}
