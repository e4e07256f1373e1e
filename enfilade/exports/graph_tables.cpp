#include "enfilade/exports/graph_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cmath>
#include <cstdint>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <ranges>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/exports/detail/scan_parts.h"
#include "enfilade/sim/candidates.h"

namespace enfilade::exports {
namespace {

using graph::GraphSet;
using graph::NavGraph;
using sim::Candidate;
using Graphs = std::shared_ptr<const GraphSet>;
using Candidates = std::span<const Candidate>;

/// The shortest text that reads back as this number, with a point or an exponent, so that Python
/// reads a float.
/// \throws ArgumentError for an infinite number or NaN, which JSON does not have
std::string json_number(double value) {
  if (!std::isfinite(value)) {
    throw ArgumentError(fmt::format("{}: a number that JSON cannot say", value));
  }
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

/// In quotes, escaped. \throws ArgumentError for text that is not UTF-8
std::string json_string(std::string_view text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::exception&) {
    throw ArgumentError(fmt::format("a name that is not UTF-8: {:?}", text.substr(0, 80)));
  }
}

/// The text of what stands behind a viewpoint's name.
using WriteViewpoint =
    std::function<std::string(const NavGraph& graph, ViewpointIndex v, Candidates candidates)>;

/// Whether a table has candidates, which take nearly all of the time.
enum class Needs : std::uint8_t { kCandidates, kGraph };

/// One scan's entries, a line each, with "," behind all but the last.
std::string entries_of_scan(const NavGraph& graph, ScanIndex scan, sim::CandidateFinder* finder,
                            const std::string& prefix, const WriteViewpoint& write) {
  std::string text;
  for (const ViewpointIndex v : detail::included(graph)) {
    Candidates candidates;
    if (finder != nullptr) candidates = finder->find({scan, v});
    if (!text.empty()) text += ",\n";
    text += json_string(prefix + graph.id(v)) + ": " + write(graph, v, candidates);
  }
  return text;
}

/// The entries of all scans in one object.
std::string table_of_all(const Graphs& graphs, const ExportOptions& options, Needs needs,
                         const WriteViewpoint& write) {
  std::vector<std::string> parts(graphs->size());
  std::mutex mutex;
  std::size_t done = 0;
  parallel_for(graphs->size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    std::optional<sim::CandidateFinder> finder;
    if (needs == Needs::kCandidates) finder.emplace(graphs);
    for (std::size_t i = begin; i < end; ++i) {
      const NavGraph& graph = graphs->graph(ScanIndex(i));
      parts[i] = entries_of_scan(graph, ScanIndex(i), finder ? &*finder : nullptr,
                                 graph.scan() + "_", write);
      if (!options.progress) continue;
      const std::lock_guard lock(mutex);
      options.progress(++done, graphs->size());
    }
  });
  std::string text = "{\n";
  for (const std::string& part : parts) {
    if (part.empty()) continue;  // no viewpoint is included
    if (text.size() > 2) text += ",\n";
    text += part;
  }
  return text + "\n}\n";
}

/// Joins what `write` says of each candidate.
template <class Write>
std::string joined(char open, Candidates candidates, char close, const Write& write) {
  return fmt::format("{}{}{}", open, fmt::join(candidates | std::views::transform(write), ", "),
                     close);
}

std::string duet_entry(const NavGraph& graph, ViewpointIndex /*v*/, Candidates candidates) {
  return joined('{', candidates, '}', [&](const Candidate& c) {
    return fmt::format("{}: [{}, {}, {}, {}]", json_string(graph.id(c.viewpoint)), c.view,
                       json_number(c.angle), json_number(c.rel_heading.value),
                       json_number(c.rel_elevation.value));
  });
}

std::string langnav_entry(const NavGraph& graph, ViewpointIndex /*v*/, Candidates candidates) {
  const std::string scan = json_string(graph.scan());
  return joined('[', candidates, ']', [&](const Candidate& c) {
    const Vec3f at = graph.position(c.viewpoint);
    const std::string heading = json_number(wrap_heading(c.heading).value);
    return fmt::format(
        R"({{"scanId": {}, "viewpointId": {}, "pointId": {}, "idx": {}, "distance": {}, )"
        R"("heading": {}, "normalized_heading": {}, "elevation": {}, "position": [{}, {}, {}]}})",
        scan, json_string(graph.id(c.viewpoint)), c.view, c.index, json_number(c.angle), heading,
        heading, json_number(c.elevation.value), json_number(at.x), json_number(at.y),
        json_number(at.z));
  });
}

std::string navgpt_entry(const NavGraph& graph, ViewpointIndex /*v*/, Candidates candidates) {
  return joined('{', candidates, '}', [&](const Candidate& c) {
    return fmt::format(R"({}: {{"heading": {}, "elevation": {}, "distance": {}}})",
                       json_string(graph.id(c.viewpoint)),
                       json_number(wrap_heading(c.heading).value), json_number(c.elevation.value),
                       json_number(c.distance));
  });
}

std::string position_entry(const NavGraph& graph, ViewpointIndex v, Candidates /*candidates*/) {
  const Vec3f at = graph.position(v);
  return fmt::format(R"({{"x": {}, "y": {}, "z": {}}})", json_number(at.x), json_number(at.y),
                     json_number(at.z));
}

// --- networkx ---

/// The ids of all viewpoints as JSON has them.
std::vector<std::string> quoted_ids(const NavGraph& graph) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    ids.push_back(json_string(graph.id(ViewpointIndex(i))));
  }
  return ids;
}

/// A text of every pair that is in reach, by from and to.
template <class Write>
std::string all_pairs(const NavGraph& graph, const std::vector<std::string>& ids,
                      const Write& write) {
  const std::vector<ViewpointIndex> all = detail::included(graph);
  std::string text = "{";
  for (const ViewpointIndex a : all) {
    text += text.size() > 1 ? ",\n" : "\n";
    text += ids[a.at()] + ": {";
    bool first = true;
    for (const ViewpointIndex b : all) {
      if (!std::isfinite(graph.distance(a, b))) continue;
      if (!std::exchange(first, false)) text += ", ";
      text += ids[b.at()] + ": ";
      text += write(a, b);
    }
    text += '}';
  }
  return text + "\n}\n";
}

}  // namespace

std::string duet_candidates(const Graphs& graphs, const ExportOptions& options) {
  return table_of_all(graphs, options, Needs::kCandidates, duet_entry);
}

std::string langnav_adjacency(const Graphs& graphs, const ExportOptions& options) {
  return table_of_all(graphs, options, Needs::kCandidates, langnav_entry);
}

std::string navgpt_navigable(const Graphs& graphs, ScanIndex scan) {
  sim::CandidateFinder finder(graphs);
  return "{\n" + entries_of_scan(graphs->graph(scan), scan, &finder, "", navgpt_entry) + "\n}\n";
}

std::string gridmm_viewpoints(const Graphs& graphs, const ExportOptions& options) {
  return table_of_all(graphs, options, Needs::kGraph, position_entry);
}

std::string all_distances(const NavGraph& graph) {
  return all_pairs(graph, quoted_ids(graph), [&](ViewpointIndex a, ViewpointIndex b) {
    return json_number(graph.distance(a, b));
  });
}

std::string all_paths(const NavGraph& graph) {
  const std::vector<std::string> ids = quoted_ids(graph);
  return all_pairs(graph, ids, [&](ViewpointIndex a, ViewpointIndex b) {
    const std::optional<std::vector<ViewpointIndex>> path = graph.path(a, b);
    const auto names = *path | std::views::transform([&](ViewpointIndex v) -> const std::string& {
      return ids[v.at()];
    });
    return fmt::format("[{}]", fmt::join(names, ", "));
  });
}

std::string all_edges(const NavGraph& graph) {
  const std::vector<std::string> ids = quoted_ids(graph);
  std::string text = "{";
  for (const ViewpointIndex v : detail::included(graph)) {
    const Vec3f at = graph.position(v);
    const auto edges = graph.edges(v) | std::views::transform([&](const graph::Edge& edge) {
                         return ids[edge.target.at()] + ": " + json_number(edge.length);
                       });
    text += fmt::format(R"({}{}: {{"position": [{}, {}, {}], "edges": {{{}}}}})",
                        text.size() > 1 ? ",\n" : "\n", ids[v.at()], json_number(at.x),
                        json_number(at.y), json_number(at.z), fmt::join(edges, ", "));
  }
  return text + "\n}\n";
}

}  // namespace enfilade::exports
