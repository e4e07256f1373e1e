#include "enfilade/graph/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>

#include "enfilade/core/errors.h"

namespace enfilade::graph {
namespace {

constexpr double kNear = 0.5;  // metres between viewpoints that stand for each other

// The partner of each viewpoint in the other graph.
struct Matching {
  std::vector<std::optional<ViewpointIndex>> of_found, of_truth;
  std::size_t pairs = 0;

  void join(std::size_t found, std::size_t truth) {
    of_found[found] = ViewpointIndex(truth);
    of_truth[truth] = ViewpointIndex(found);
    ++pairs;
  }
};

Matching match_ids(const NavGraph& found, const NavGraph& truth, Matching matching) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    const ViewpointIndex v(i);
    const auto partner = truth.find(found.id(v));
    if (partner && found.included(v) && truth.included(*partner)) matching.join(i, partner->at());
  }
  return matching;
}

// Nearest pairs first.
Matching match_places(const NavGraph& found, const NavGraph& truth, Matching matching) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found.included(ViewpointIndex(i))) continue;
    for (std::size_t j = 0; j < truth.size(); ++j) {
      if (!truth.included(ViewpointIndex(j))) continue;
      const double apart =
          length(found.position(ViewpointIndex(i)) - truth.position(ViewpointIndex(j)));
      if (apart <= kNear) pairs.emplace_back(apart, i, j);
    }
  }
  std::ranges::sort(pairs);
  for (const auto& [apart, i, j] : pairs) {
    if (!matching.of_found[i] && !matching.of_truth[j]) matching.join(i, j);
  }
  return matching;
}

bool linked(const NavGraph& graph, ViewpointIndex a, ViewpointIndex b) {
  return graph.edge(a, b) != nullptr || graph.edge(b, a) != nullptr;
}

// Calls `visit` with each undirected edge once, from the end that has it.
template <class Visit>
void each_edge(const NavGraph& graph, const Visit& visit) {
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (const Edge& edge : graph.edges(ViewpointIndex(i))) {
      const bool seen = edge.target.at() < i && graph.edge(edge.target, ViewpointIndex(i));
      if (!seen) visit(ViewpointIndex(i), edge.target, edge.length);
    }
  }
}

std::vector<std::string> unmatched(const NavGraph& graph,
                                   const std::vector<std::optional<ViewpointIndex>>& partners) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    if (graph.included(v) && !partners[i]) ids.push_back(graph.id(v));
  }
  return ids;
}

double share(std::size_t part, std::size_t rest) {
  const std::size_t all = part + rest;
  return all == 0 ? 1 : static_cast<double>(part) / static_cast<double>(all);
}

}  // namespace

double GraphComparison::precision() const noexcept { return share(common, extra.size()); }
double GraphComparison::recall() const noexcept { return share(common, missing.size()); }
double GraphComparison::f1() const noexcept {
  return share(2 * common, extra.size() + missing.size());
}

GraphComparison compare(const NavGraph& found, const NavGraph& truth) {
  Matching empty;
  empty.of_found.resize(found.size());
  empty.of_truth.resize(truth.size());
  Matching matching = match_ids(found, truth, empty);
  if (matching.pairs == 0) matching = match_places(found, truth, empty);
  if (matching.pairs == 0) {
    throw ArgumentError(fmt::format(
        "graphs {} ({} viewpoints) and {} ({}): no viewpoint of one has its id in the "
        "other, or is within {} m of one there",
        found.scan(), found.included_count(), truth.scan(), truth.included_count(), kNear));
  }
  GraphComparison out;
  out.matched = matching.pairs;
  out.only_found = unmatched(found, matching.of_found);
  out.only_truth = unmatched(truth, matching.of_truth);
  each_edge(found, [&](ViewpointIndex a, ViewpointIndex b, double metres) {
    const auto ta = matching.of_found[a.at()], tb = matching.of_found[b.at()];
    if (!ta || !tb) return;
    if (linked(truth, *ta, *tb)) {
      ++out.common;
    } else {
      out.extra.push_back({std::min(a, b), std::max(a, b), metres});
    }
  });
  each_edge(truth, [&](ViewpointIndex a, ViewpointIndex b, double metres) {
    const auto fa = matching.of_truth[a.at()], fb = matching.of_truth[b.at()];
    if (!fa || !fb || linked(found, *fa, *fb)) return;
    out.missing.push_back({std::min(*fa, *fb), std::max(*fa, *fb), metres});
  });
  const auto by_ends = [](const ComparedEdge& e) { return std::pair(e.a, e.b); };
  std::ranges::sort(out.extra, {}, by_ends);
  std::ranges::sort(out.missing, {}, by_ends);
  return out;
}

}  // namespace enfilade::graph
