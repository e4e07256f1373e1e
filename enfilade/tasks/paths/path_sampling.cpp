#include "enfilade/tasks/path_sampling.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <ranges>
#include <set>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"

namespace enfilade::tasks {
namespace {

using graph::NavGraph;

// Streams of one seed: a building's pairs, its headings, the cut to a number of paths, the splits.
enum Stream : std::uint64_t { kPairs, kHeadings, kCut, kBuildings, kValSeen };

std::uint64_t stream_of_scan(const std::string& scan, const SamplingOptions& options) {
  const std::string text = options.draws_of ? options.draws_of(scan) : scan;
  return stream_of(text.data(), text.size());
}

struct StartAndGoal {
  ViewpointIndex start;
  ViewpointIndex goal;
};
// Pairs of which at most one is drawn.
using Choice = std::vector<StartAndGoal>;

// Finds the pairs of start and goal that may be drawn in one building.
class Building {
 public:
  Building(const NavGraph& graph, const scan::RegionMap& regions, const SamplingOptions& options)
      : graph_(graph), options_(options), room_of_(graph.size(), kNoRoom) {
    std::map<std::uint32_t, std::size_t> rooms;
    for (std::size_t i = 0; i < graph.size(); ++i) {
      const ViewpointIndex v(i);
      if (!graph.included(v)) continue;
      const auto region = regions.find(graph.scan(), graph.id(v));
      if (region) room_of_[i] = rooms.emplace(*region, rooms.size()).first->second;
    }
    room_count_ = rooms.size();
  }

  std::vector<Choice> choices() const {
    return options_.pairs == PairRule::kRooms ? room_pairs() : viewpoint_pairs();
  }

 private:
  static constexpr std::size_t kNoRoom = std::numeric_limits<std::size_t>::max();

  std::vector<Choice> room_pairs() const {
    std::vector<Choice> table(room_count_ * room_count_);
    for (std::size_t i = 0; i < graph_.size(); ++i) {
      if (room_of_[i] == kNoRoom) continue;
      const std::vector<ViewpointIndex> nearest = nearest_of_rooms(ViewpointIndex(i));
      for (std::size_t room = 0; room < room_count_; ++room) {
        const StartAndGoal pair{ViewpointIndex(i), nearest[room]};
        if (room == room_of_[i] || !allowed(pair)) continue;
        table[room_of_[i] * room_count_ + room].push_back(pair);
      }
    }
    std::erase_if(table, [](const Choice& choice) { return choice.empty(); });
    return table;
  }

  std::vector<Choice> viewpoint_pairs() const {
    std::vector<Choice> pairs;
    for (std::size_t i = 0; i < graph_.size(); ++i) {
      for (std::size_t j = 0; j < graph_.size(); ++j) {
        if (room_of_[i] == kNoRoom || room_of_[j] == kNoRoom || room_of_[i] == room_of_[j])
          continue;
        const StartAndGoal pair{ViewpointIndex(i), ViewpointIndex(j)};
        if (allowed(pair)) pairs.push_back({pair});
      }
    }
    return pairs;
  }

  // The nearest viewpoint of each room; of equally near ones that with the lowest index.
  std::vector<ViewpointIndex> nearest_of_rooms(ViewpointIndex start) const {
    std::vector<ViewpointIndex> nearest(room_count_, start);
    std::vector<double> distances(room_count_, std::numeric_limits<double>::infinity());
    for (std::size_t j = 0; j < graph_.size(); ++j) {
      if (room_of_[j] == kNoRoom) continue;
      const double distance = graph_.distance(start, ViewpointIndex(j));
      if (distance >= distances[room_of_[j]]) continue;
      distances[room_of_[j]] = distance;
      nearest[room_of_[j]] = ViewpointIndex(j);
    }
    return nearest;  // a room out of reach keeps `start`, which allowed() refuses
  }

  bool allowed(StartAndGoal pair) const {
    const double length = graph_.distance(pair.start, pair.goal);
    if (!std::isfinite(length) || length < options_.min_length) return false;
    std::size_t edges = 0;
    for (auto v = std::optional(pair.goal); *v != pair.start; v = graph_.before(pair.start, *v)) {
      if (++edges > options_.max_edges) return false;
    }
    return edges >= options_.min_edges;
  }

  const NavGraph& graph_;
  const SamplingOptions& options_;
  std::vector<std::size_t> room_of_;
  std::size_t room_count_ = 0;
};

double rounded(double value, double steps) { return std::floor(value * steps + 0.5) / steps; }

PathAnnotation annotate(const NavGraph& graph, StartAndGoal pair, const SamplingOptions& options) {
  PathAnnotation entry;
  entry.scan = graph.scan();
  // R2R has one heading for each start viewpoint, in thousandths. Rounded down: 2 pi is no heading.
  Rng rng(options.seed, stream_of_scan(graph.scan(), options), kHeadings + (pair.start.at() << 8U));
  entry.heading = Radians(std::floor(2 * kPi * rng.uniform() * 1000) / 1000);
  const auto path = graph.path(pair.start, pair.goal);
  for (const ViewpointIndex v : path.value()) entry.path.push_back(graph.id(v));
  entry.distance = rounded(graph.distance(pair.start, pair.goal), 100);
  return entry;
}

std::vector<PathAnnotation> sample_building(const NavGraph& graph, const scan::RegionMap& regions,
                                            const SamplingOptions& options) {
  std::vector<Choice> choices = Building(graph, regions, options).choices();
  Rng rng(options.seed, stream_of_scan(graph.scan(), options), kPairs);
  rng.shuffle(std::span(choices));
  std::vector<PathAnnotation> paths;
  for (std::size_t k = 0; k < std::min(options.per_building, choices.size()); ++k) {
    const Choice& choice = choices[k];
    paths.push_back(annotate(graph, choice[rng.below(choice.size())], options));
  }
  return paths;
}

void check(const SamplingOptions& options) {
  if (options.min_edges < 1 || options.min_edges > options.max_edges) {
    throw ArgumentError(fmt::format("min_edges {}, max_edges {}: 1 <= min_edges <= max_edges",
                                    options.min_edges, options.max_edges));
  }
  if (!std::isfinite(options.min_length) || options.min_length < 0) {
    throw ArgumentError(
        fmt::format("min_length {}: a length in metres, 0 or more", options.min_length));
  }
  if (options.per_building < 1) throw ArgumentError("per_building 0: at least 1");
}

// Keeps `n` of `items`, each set of n equally likely, in their order.
template <class T>
std::vector<T> random_subset(std::vector<T> items, std::size_t n, Rng rng) {
  if (n >= items.size()) return items;
  std::vector<std::size_t> order(items.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  rng.shuffle(std::span(order));
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(n));
  std::vector<T> kept;
  for (std::size_t k = 0; k < n; ++k) kept.push_back(std::move(items[order[k]]));
  return kept;
}

// Divides `total` in proportion to `shares`, at least 1 for each share that is not 0: each unit
// goes to the share that is furthest below its proportion.
std::array<std::size_t, 3> apportion(const std::array<std::size_t, 3>& shares, std::size_t total) {
  const std::size_t sum = shares[0] + shares[1] + shares[2];
  std::array<std::size_t, 3> counts{};
  for (std::size_t k = 0; k < 3; ++k) counts[k] = shares[k] > 0 ? 1 : 0;
  std::size_t given = counts[0] + counts[1] + counts[2];
  if (given == 0 || given > total) {
    throw ArgumentError(fmt::format(
        "{} buildings cannot be split {} / {} / {}: each share that is not 0 needs at least one",
        total, shares[0], shares[1], shares[2]));
  }
  for (; given < total; ++given) {
    const auto due = [&](std::size_t k) {
      return static_cast<double>(shares[k] * total) / static_cast<double>(sum) -
             static_cast<double>(counts[k]);
    };
    ++counts[*std::ranges::max_element(std::views::iota(std::size_t{0}, shares.size()), {}, due)];
  }
  return counts;
}

PathAnnotation without_goal(PathAnnotation entry) {
  entry.path.resize(1);
  entry.distance.reset();
  return entry;
}

// Moves a random share of train's paths to val_seen.
void split_off_val_seen(std::vector<PathAnnotation>& train, std::vector<PathAnnotation>& val_seen,
                        const SplitOptions& options) {
  if (options.val_seen_share <= 0 || train.size() < 2) return;
  const auto wanted = static_cast<std::size_t>(
      rounded(options.val_seen_share * static_cast<double>(train.size()), 1));
  std::vector<std::size_t> all(train.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const std::vector<std::size_t> chosen = random_subset(
      all, std::clamp<std::size_t>(wanted, 1, train.size() - 1), Rng(options.seed, kValSeen));
  std::vector<PathAnnotation> rest;
  for (std::size_t i = 0; i < train.size(); ++i) {
    const bool seen = std::ranges::binary_search(chosen, i);
    (seen ? val_seen : rest).push_back(std::move(train[i]));
  }
  train = std::move(rest);
}

}  // namespace

std::vector<PathAnnotation> sample_paths(const graph::GraphSet& graphs,
                                         const scan::RegionMap& regions,
                                         const SamplingOptions& options, const Progress& progress) {
  check(options);
  std::vector<std::vector<PathAnnotation>> buildings(graphs.size());
  std::mutex mutex;
  std::size_t done = 0;
  parallel_for(graphs.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      buildings[i] = sample_building(graphs.graph(ScanIndex(i)), regions, options);
      const std::scoped_lock lock(mutex);
      if (progress) progress(++done, graphs.size());
    }
  });
  std::vector<PathAnnotation> paths;
  for (std::vector<PathAnnotation>& building : buildings) {
    std::ranges::move(building, std::back_inserter(paths));
  }
  if (options.paths > 0) {
    paths = random_subset(std::move(paths), options.paths, Rng(options.seed, kCut));
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    paths[i].path_id = static_cast<std::int64_t>(i) + 1;
  }
  return paths;
}

std::map<std::string, std::string> splits_of_buildings(std::vector<std::string> scans,
                                                       const SplitOptions& options) {
  std::ranges::sort(scans);
  Rng rng(options.seed, kBuildings);
  rng.shuffle(std::span(scans));
  const auto [train, val_unseen, test] =
      apportion({options.train_scans, options.val_unseen_scans, options.test_scans}, scans.size());
  std::map<std::string, std::string> split_of;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    split_of[scans[i]] = i < train ? "train" : i < train + val_unseen ? "val_unseen" : "test";
  }
  return split_of;
}

std::map<std::string, Annotations> split_by_building(const std::vector<PathAnnotation>& paths,
                                                     const SplitOptions& options) {
  if (!(options.val_seen_share >= 0 && options.val_seen_share < 1)) {
    throw ArgumentError(
        fmt::format("val_seen_share {}: from 0 to below 1", options.val_seen_share));
  }
  std::set<std::string> names;
  for (const PathAnnotation& entry : paths) names.insert(entry.scan);
  auto split_of = splits_of_buildings({names.begin(), names.end()}, options);
  std::map<std::string, Annotations> splits;
  for (const char* split : {"train", "val_seen", "val_unseen", "test", "test_hidden"}) {
    splits[split] = {split, fmt::format("R2R_{}.json", split), {}};
  }
  for (const PathAnnotation& entry : paths) {
    const std::string& split = split_of[entry.scan];
    splits[split == "test" ? "test_hidden" : split].paths.push_back(entry);
  }
  for (const PathAnnotation& entry : splits["test_hidden"].paths) {
    splits["test"].paths.push_back(without_goal(entry));
  }
  split_off_val_seen(splits["train"].paths, splits["val_seen"].paths, options);
  return splits;
}

}  // namespace enfilade::tasks
