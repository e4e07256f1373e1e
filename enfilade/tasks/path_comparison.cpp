#include "enfilade/tasks/path_comparison.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <functional>
#include <ranges>
#include <set>
#include <tuple>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::tasks {
namespace {

constexpr double kBin = 2;  // metres

struct Sample {
  std::vector<double> lengths;
  std::vector<double> edges;

  void add(double length, std::size_t n) {
    lengths.push_back(length);
    edges.push_back(static_cast<double>(n));
  }
  PathDistance distance(const Sample& other) const {
    return {kolmogorov_smirnov(lengths, other.lengths), kolmogorov_smirnov(edges, other.edges)};
  }
};

// Gathers lengths, numbers of edges and PathFacts of a set of paths.
class PathGathering {
 public:
  PathGathering(const graph::GraphSet& graphs, const scan::RegionMap& regions)
      : graphs_(graphs), regions_(regions) {}

  void add(const ReferencePath& path) {
    if (path.viewpoints.size() < 2) return;  // a hidden goal
    const graph::NavGraph& graph = graphs_.graph(path.scan);
    const double length = length_of(path, graph);
    const double shortest = graph.distance(path.viewpoints.front(), path.viewpoints.back());
    sample.add(length, path.viewpoints.size() - 1);
    ++facts_.edges[path.viewpoints.size() - 1];
    ++facts_.metres[static_cast<std::size_t>(length / kBin)];
    ++buildings[path.scan];
    if (length > shortest + 1e-3) ++facts_.not_shortest;
    if (add_rooms(path, graph)) between_rooms.add(length, path.viewpoints.size() - 1);
  }

  PathFacts finish() {
    facts_.paths = sample.lengths.size();
    facts_.buildings = buildings.size();
    facts_.length = summarise(sample.lengths);
    for (const auto& [scan, n] : buildings) {
      facts_.most_in_a_building = std::max(facts_.most_in_a_building, n);
    }
    facts_.buildings_with_most = static_cast<std::size_t>(
        std::ranges::count(std::views::values(buildings), facts_.most_in_a_building));
    return facts_;
  }

  Sample sample;
  Sample between_rooms;
  std::map<ScanIndex, std::size_t> buildings;

 private:
  // Whether the path leads from one room to another.
  bool add_rooms(const ReferencePath& path, const graph::NavGraph& graph) {
    const ViewpointIndex start = path.viewpoints.front();
    const ViewpointIndex goal = path.viewpoints.back();
    const auto from = regions_.find(graph.scan(), graph.id(start));
    const auto to = regions_.find(graph.scan(), graph.id(goal));
    if (!from || !to) {
      ++facts_.outside_map;
      return false;
    }
    if (from == to) {
      ++facts_.in_one_room;
      return false;
    }
    ++facts_.between_rooms;
    if (!pairs_.emplace(path.scan, *from, *to).second) ++facts_.repeated_pairs;
    bool nearer = false;
    for (std::size_t i = 0; i < graph.size() && !nearer; ++i) {
      const ViewpointIndex v(i);
      nearer = graph.distance(start, v) < graph.distance(start, goal) &&
               regions_.find(graph.scan(), graph.id(v)) == to;
    }
    facts_.to_nearest += nearer ? 0 : 1;
    return true;
  }

  const graph::GraphSet& graphs_;
  const scan::RegionMap& regions_;
  PathFacts facts_;
  std::set<std::tuple<ScanIndex, std::uint32_t, std::uint32_t>> pairs_;
};

using Columns = std::array<const PathFacts*, 3>;

void add_row(std::string& text, const std::string& label, const Columns& columns,
             const std::function<std::string(const PathFacts&)>& value) {
  text += fmt::format("{:<34}", label);
  for (const PathFacts* facts : columns) text += fmt::format("{:>16}", value(*facts));
  text += '\n';
}

std::string percent(std::size_t n, std::size_t of) {
  if (of == 0) return "-";
  return fmt::format("{:.1f} %", 100 * static_cast<double>(n) / static_cast<double>(of));
}

void add_counts(std::string& text, const Columns& columns) {
  using Member = std::size_t PathFacts::*;
  const auto add = [&](const char* label, Member member) {
    add_row(text, label, columns,
            [member](const PathFacts& f) { return std::to_string(f.*member); });
  };
  add("paths", &PathFacts::paths);
  add("buildings", &PathFacts::buildings);
  add("most in a building", &PathFacts::most_in_a_building);
  add("  buildings with as many", &PathFacts::buildings_with_most);
  add("longer than the shortest path", &PathFacts::not_shortest);
  add("start and goal in different rooms", &PathFacts::between_rooms);
  add("  pair of rooms came before", &PathFacts::repeated_pairs);
  add_row(text, "  goal nearest of its room", columns,
          [](const PathFacts& f) { return percent(f.to_nearest, f.between_rooms); });
  add("in one room", &PathFacts::in_one_room);
  add("start or goal in no room", &PathFacts::outside_map);
}

// One of the two histograms. `label` gives the name of a bin's row.
void add_histogram(std::string& text, const Columns& columns,
                   std::map<std::size_t, std::size_t> PathFacts::*member,
                   const std::function<std::string(std::size_t)>& label) {
  std::set<std::size_t> bins;
  for (const PathFacts* facts : columns) {
    for (const auto& [bin, n] : facts->*member) bins.insert(bin);
  }
  for (const std::size_t bin : bins) {
    add_row(text, label(bin), columns, [member, bin](const PathFacts& f) {
      const auto found = (f.*member).find(bin);
      return percent(found == (f.*member).end() ? 0 : found->second, f.paths);
    });
  }
}

void add_distance(std::string& text, const char* label, const PathDistance& distance) {
  text +=
      fmt::format("{:<34}{:>16.4f}{:>16.2g}{:>16.4f}{:>16.2g}\n", label, distance.length.statistic,
                  distance.length.p_value, distance.edges.statistic, distance.edges.p_value);
}

}  // namespace

PathComparison compare_paths(const Annotations& drawn, std::span<const Annotations> reference,
                             const graph::GraphSet& graphs, const scan::RegionMap& regions) {
  PathGathering theirs(graphs, regions);
  for (const Annotations& annotations : reference) {
    for (const ReferencePath& path : look_up_paths(annotations, graphs)) theirs.add(path);
  }
  PathGathering ours(graphs, regions);
  PathGathering there(graphs, regions);
  for (const ReferencePath& path : look_up_paths(drawn, graphs)) {
    ours.add(path);
    if (theirs.buildings.contains(path.scan)) there.add(path);
  }
  if (there.sample.lengths.empty()) {
    throw ArgumentError(
        fmt::format("{} drawn paths and {} to compare with have no building in common",
                    ours.sample.lengths.size(), theirs.sample.lengths.size()));
  }
  PathComparison result{ours.finish(),
                        there.finish(),
                        theirs.finish(),
                        ours.sample.distance(theirs.sample),
                        there.sample.distance(theirs.sample),
                        std::nullopt};
  if (!there.between_rooms.edges.empty() && !theirs.between_rooms.edges.empty()) {
    result.between_rooms = there.between_rooms.distance(theirs.between_rooms);
  }
  return result;
}

std::string to_table(const PathComparison& comparison) {
  const Columns columns{&comparison.drawn, &comparison.drawn_there, &comparison.reference};
  std::string text =
      fmt::format("{:<34}{:>16}{:>16}{:>16}\n", "", "drawn", "same buildings", "data set");
  add_counts(text, columns);
  add_row(text, "mean length (m)", columns,
          [](const PathFacts& f) { return fmt::format("{:.2f}", f.length.mean); });
  add_row(text, "  standard deviation", columns,
          [](const PathFacts& f) { return fmt::format("{:.2f}", f.length.deviation); });
  add_histogram(text, columns, &PathFacts::metres, [](std::size_t bin) {
    return fmt::format("  {} to {} m", kBin * static_cast<double>(bin),
                       kBin * static_cast<double>(bin + 1));
  });
  add_histogram(text, columns, &PathFacts::edges,
                [](std::size_t n) { return fmt::format("  {} edge{}", n, n == 1 ? "" : "s"); });
  text += fmt::format("\n{:<34}{:>16}{:>16}{:>16}{:>16}\n", "Kolmogorov-Smirnov distance",
                      "of lengths", "p", "of edges", "p");
  add_distance(text, "drawn : data set", comparison.all);
  add_distance(text, "  in the same buildings", comparison.there);
  if (comparison.between_rooms) {
    add_distance(text, "  and between different rooms", *comparison.between_rooms);
  }
  return text;
}

}  // namespace enfilade::tasks
