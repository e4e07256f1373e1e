#include "enfilade/exports/networkx.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/exports/detail/json_text.h"

namespace enfilade::exports {
namespace {

using graph::NavGraph;

std::vector<ViewpointIndex> included(const NavGraph& graph) {
  std::vector<ViewpointIndex> found;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (graph.included(ViewpointIndex(i))) found.emplace_back(i);
  }
  return found;
}

/// The ids of all viewpoints as JSON has them.
std::vector<std::string> quoted_ids(const NavGraph& graph) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    ids.push_back(detail::json_string(graph.id(ViewpointIndex(i))));
  }
  return ids;
}

/// A text of every pair that is in reach, by from and to.
template <class Write>
std::string all_pairs(const NavGraph& graph, const std::vector<std::string>& ids,
                      const Write& write) {
  const std::vector<ViewpointIndex> all = included(graph);
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

std::string all_distances(const NavGraph& graph) {
  return all_pairs(graph, quoted_ids(graph), [&](ViewpointIndex a, ViewpointIndex b) {
    return detail::json_number(graph.distance(a, b));
  });
}

std::string all_paths(const NavGraph& graph) {
  const std::vector<std::string> ids = quoted_ids(graph);
  return all_pairs(graph, ids, [&](ViewpointIndex a, ViewpointIndex b) {
    const std::optional<std::vector<ViewpointIndex>> path = graph.path(a, b);
    std::string text = "[";
    for (const ViewpointIndex v : *path) {
      if (text.size() > 1) text += ", ";
      text += ids[v.at()];
    }
    return text + "]";
  });
}

}  // namespace enfilade::exports
