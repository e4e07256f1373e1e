#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/detail/floor_walk.h"

namespace enfilade::graph {
namespace {

using detail::Passage;
using detail::Pockets;
using detail::WalkingDistances;
using mesh::FloorCell;
using mesh::RayTracer;
using mesh::WalkableFloor;

constexpr double kGrid = 0.2;            // metres between candidates
constexpr std::size_t kDirections = 32;  // of rays that measure what is seen
constexpr double kSight = 8;             // metres; things farther away do not make a place better
constexpr double kBelowCeiling = 0.1;    // metres between an eye and the ceiling
// Between a new viewpoint and those there are, on foot, as a share of the separation: gives
// Matterport3D's mean length of edges in furnished homes. See docs/graph.md.
constexpr double kSpacing = 0.66;
constexpr double kTightSpacing = 1.4;  // times that between places next to walls
constexpr double kTooNear = 0.5;       // times the spacing: one viewpoint there is enough
constexpr double kFloorOfOne = 0.85;   // m2 that a viewpoint has, per separation squared

void check_options(const ViewpointOptions& o) {
  check_range("separation", o.separation, 0.2, 100);
  check_range("eye_height", o.eye_height, 0.1, 10);
  check_range("least_clearance", o.least_clearance, 0, 10);
}

// A cell at which a viewpoint could stand.
struct Candidate {
  std::uint32_t cell = 0;
  double score = 0;
  bool roomy = false;  // clear of what the body would touch
};

// Parts of the floor that get viewpoints: the first, and others that have room for two and are
// indoors if the first is.
std::vector<bool> choose_parts(const WalkableFloor& floor, double separation) {
  std::vector<double> cells(floor.areas(), 0), covered(floor.areas(), 0);
  for (const FloorCell& cell : floor.cells()) {
    ++cells[cell.area];
    if (cell.covered) ++covered[cell.area];
  }
  const double m2 = floor.options().cell * floor.options().cell;
  const bool indoors = covered[0] > 0.5 * cells[0];
  std::vector<bool> chosen(floor.areas(), false);
  for (std::size_t p = 0; p < chosen.size(); ++p) {
    const bool large = cells[p] * m2 >= 2 * kFloorOfOne * separation * separation;
    chosen[p] = p == 0 || (large && (!indoors || covered[p] > 0.5 * cells[p]));
  }
  return chosen;
}

// The cell with most room of each square of a coarse grid.
std::vector<Candidate> choose_candidates(const WalkableFloor& floor,
                                         const std::vector<bool>& parts) {
  using Square = std::tuple<std::int32_t, std::int32_t, std::int32_t, std::uint32_t>;
  std::map<Square, std::uint32_t> squares;
  const auto cells = floor.cells();
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    if (!parts[cells[c].area]) continue;
    const auto place = [](float metres, double size) {
      return static_cast<std::int32_t>(std::floor(metres / size));
    };
    const Vec3f p = cells[c].position;
    const Square square{place(p.x, kGrid), place(p.y, kGrid), place(p.z, 0.5), cells[c].area};
    const auto [at, fresh] = squares.emplace(square, c);
    if (!fresh && cells[c].clearance > cells[at->second].clearance) at->second = c;
  }
  std::vector<Candidate> candidates;
  for (const auto& [square, c] : squares) candidates.push_back({c, 0, false});
  return candidates;
}

std::array<Vec3f, kDirections> directions() {
  std::array<Vec3f, kDirections> around;
  for (std::size_t k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kDirections;
    around[k] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0};
  }
  return around;
}

// Radius of the disc as large as what is seen around a point at eye height, metres.
double radius_of_sight(const RayTracer& tracer, Vec3f eye,
                       const std::array<Vec3f, kDirections>& around) {
  std::array<mesh::Ray, kDirections> rays;
  std::array<mesh::Hit, kDirections> hits;
  for (std::size_t k = 0; k < kDirections; ++k) {
    rays[k] = {eye, around[k], 0, static_cast<float>(kSight)};
  }
  tracer.trace(rays, hits);
  double squares = 0;
  for (const mesh::Hit& hit : hits) {
    const double r = hit ? hit.distance : kSight;
    squares += r * r;
  }
  return std::sqrt(squares / kDirections);
}

// Much in sight, and room around: best first.
void score_candidates(const RayTracer& tracer, const WalkableFloor& floor,
                      const ViewpointOptions& options, std::vector<Candidate>& candidates) {
  const auto around = directions();
  const auto eye = static_cast<float>(
      std::min(options.eye_height, floor.options().body.height - kBelowCeiling / 2));
  parallel_for(candidates.size(), 256, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const FloorCell& cell = floor.cells()[candidates[i].cell];
      const double sight = radius_of_sight(tracer, cell.position + Vec3f{0, 0, eye}, around);
      const double room = std::min(1.0, cell.clearance / std::max(options.least_clearance, 1e-3));
      const double middle = 0.5 * std::min<double>(cell.clearance, 1.5);
      candidates[i].roomy = cell.clearance >= options.least_clearance;
      // The seed decides between places that are about equally good.
      const double taste = 1 + 0.05 * Rng(options.seed, candidates[i].cell).uniform();
      candidates[i].score = (0.3 + 0.7 * room) * (sight + middle) * taste;
    }
  });
  std::ranges::stable_sort(candidates, std::greater<>{}, &Candidate::score);
}

constexpr std::uint32_t kNoRank = std::numeric_limits<std::uint32_t>::max();

// Places of cells in a list, best first: the inverse of it; kNoRank for others.
std::vector<std::uint32_t> ranks_of(const std::vector<std::uint32_t>& cells, std::size_t count) {
  std::vector<std::uint32_t> ranks(count, kNoRank);
  for (std::uint32_t k = 0; k < cells.size(); ++k) ranks[cells[k]] = k;
  return ranks;
}
std::vector<std::uint32_t> cells_of(const std::vector<Candidate>& candidates) {
  std::vector<std::uint32_t> out;
  out.reserve(candidates.size());
  for (const Candidate& c : candidates) out.push_back(c.cell);
  return out;
}

// Cells of viewpoints, far enough from each other.
std::vector<std::uint32_t> spread(const WalkableFloor& floor,
                                  const std::vector<Candidate>& candidates, const Pockets& pockets,
                                  double spacing) {
  std::vector<std::uint32_t> chosen;
  std::vector<char> has_one(pockets.count, 0);
  WalkingDistances near(floor);
  const auto take = [&](std::uint32_t cell) {
    chosen.push_back(cell);
    has_one[pockets.of[cell]] = 1;
    near.add(cell, spacing);
  };
  const std::vector<std::uint32_t> rank = ranks_of(cells_of(candidates), floor.cells().size());
  WalkingDistances around(floor);
  // The best place within a few steps that is not too near other viewpoints.
  const auto best_around = [&](std::uint32_t cell) {
    constexpr double kSteps = 0.8;  // metres: corners of rooms are left, rooms are not
    around.clear();
    around.add(cell, kSteps);
    std::uint32_t best = rank[cell];  // the cell itself is a candidate
    for (const std::uint32_t c : around.reached()) {
      if (rank[c] < best && near[c] >= 0.85 * spacing) best = rank[c];
    }
    return candidates[best].cell;
  };
  // Rooms first, each at its best place; then places that are far from all of them. Corners and
  // narrow places come last, and only if no viewpoint is near.
  for (const Candidate& c : candidates) {
    if (!has_one[pockets.of[c.cell]]) take(c.cell);
  }
  for (const Candidate& c : candidates) {
    if (c.roomy && near[c.cell] >= spacing) take(c.cell);
  }
  for (const Candidate& c : candidates) {
    if (near[c.cell] < kTightSpacing * spacing) continue;
    take(best_around(c.cell));
  }
  return chosen;
}

PlacedViewpoint place(const RayTracer& tracer, const FloorCell& cell, double eye_height) {
  // The ray starts a little above the floor, so that a rug is not taken for the ceiling.
  constexpr float kStart = 0.2F;
  const mesh::Hit above = tracer.trace({cell.position + Vec3f{0, 0, kStart}, {0, 0, 1}});
  double height = eye_height;
  if (above) height = std::min(height, above.distance + kStart - kBelowCeiling);
  height = std::max(height, 0.1);
  return {{cell.position.x, cell.position.y, cell.position.z + height}, height};
}

// Each second cell of a way is tried: they are closer than a body is wide.
constexpr std::size_t kStride = 2;

// Adds viewpoints where the edge rule leaves gaps (doors, bends, stairs) until all viewpoints of
// each part of the floor are connected by edges, or until no cell helps.
class Joiner {
 public:
  Joiner(const WalkableFloor& floor, const Passage& passage,
         const std::function<PlacedViewpoint(std::uint32_t)>& placed,
         std::vector<std::uint32_t>& cells)
      : floor_(floor), passage_(passage), placed_(placed), cells_(cells), ways_(floor) {
    start_from(cells.size());
  }

  // Groups of a part of the floor join their nearest, the smallest first.
  void run() {
    for (std::uint32_t area = 0; area < floor_.areas(); ++area) {
      while (join_next(area)) {
      }
    }
  }

 private:
  std::size_t root(std::size_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }

  std::size_t add(std::uint32_t cell) {
    const std::size_t v = cells_.size();
    cells_.push_back(cell);
    viewpoints_.push_back(placed_(cell));
    parent_.push_back(v);
    for (std::size_t other = 0; other < v; ++other) {
      if (root(other) != root(v) && passage_.is_free(viewpoints_[other], viewpoints_[v])) {
        parent_[root(v)] = root(other);
      }
    }
    return v;
  }

  bool join_next(std::uint32_t area) {
    std::map<std::size_t, std::vector<std::uint32_t>> groups;
    for (std::size_t v = 0; v < cells_.size(); ++v) {
      const std::uint32_t cell = cells_[v];
      if (floor_.cells()[cell].area == area && !given_up_.contains(cell)) {
        groups[root(v)].push_back(cell);
      }
    }
    if (groups.size() < 2) return false;
    const auto smallest =
        std::ranges::min_element(groups, {}, [](const auto& group) { return group.second.size(); });
    std::vector<std::uint32_t> others;
    for (const auto& [name, group] : groups) {
      if (name != smallest->first) others.insert(others.end(), group.begin(), group.end());
    }
    const std::vector<std::uint32_t> way = ways_.find(smallest->second, others);
    if (way.empty() || !walk(way)) {
      // Too narrow for an edge; check_graph() reports the gap.
      given_up_.insert(smallest->second.begin(), smallest->second.end());
    }
    return true;
  }

  std::size_t root_of(std::uint32_t cell) {
    const auto at = std::ranges::find(cells_, cell);
    return root(static_cast<std::size_t>(at - cells_.begin()));
  }

  // Adds viewpoints along the way until its ends are connected.
  bool walk(const std::vector<std::uint32_t>& way) {
    std::size_t here = 0;
    const std::size_t first = cells_.size();
    while (root_of(way.front()) != root_of(way.back())) {
      const std::optional<std::size_t> next = next_stop(way, here);
      if (!next || *next == here) {
        start_from(first);
        return false;
      }
      here = *next;
      add(way[here]);
    }
    return true;
  }

  // A place from which one can go on to the way's end, with most room; else the farthest one.
  std::optional<std::size_t> next_stop(const std::vector<std::uint32_t>& way, std::size_t here) {
    const PlacedViewpoint from = placed_(way[here]), end = placed_(way.back());
    std::optional<std::size_t> farthest, best;
    for (std::size_t i = here + kStride; i + 1 < way.size(); i += kStride) {
      const PlacedViewpoint stop = placed_(way[i]);
      if (!passage_.is_free(from, stop)) continue;
      farthest = i;
      if (!passage_.is_free(stop, end)) continue;
      if (!best || value(way, here, i) > value(way, here, *best)) best = i;
    }
    return best ? best : farthest;
  }

  // Room around, and not too near either end.
  double value(const std::vector<std::uint32_t>& way, std::size_t here, std::size_t i) const {
    const double share = static_cast<double>(i - here) / static_cast<double>(way.size() - here);
    return std::min<double>(floor_.cells()[way[i]].clearance, 0.5) + 2 * share * (1 - share);
  }

  // Keeps the first `count` viewpoints only.
  void start_from(std::size_t count) {
    const std::vector<std::uint32_t> kept(cells_.begin(),
                                          cells_.begin() + static_cast<std::ptrdiff_t>(count));
    cells_.clear();
    viewpoints_.clear();
    parent_.clear();
    for (const std::uint32_t cell : kept) add(cell);
  }

  const WalkableFloor& floor_;
  const Passage& passage_;
  const std::function<PlacedViewpoint(std::uint32_t)>& placed_;
  std::vector<std::uint32_t>& cells_;
  detail::WaySearch ways_;
  std::vector<PlacedViewpoint> viewpoints_;
  std::vector<std::size_t> parent_;
  std::set<std::uint32_t> given_up_;
};

// What thinning out starts from.
struct ThinningInput {
  const WalkableFloor& floor;
  const Passage& passage;
  const Pockets& pockets;
  const std::vector<std::uint32_t>& candidates;
  double least;  // metres
  std::size_t first;
  std::function<PlacedViewpoint(std::uint32_t)> placed;  // the viewpoint at a cell
};

// Replaces two viewpoints less than `least` metres apart, in view of each other, by one. That is
// at a cell of `candidates` (best first) or at one of the two. Does so only if nothing is lost:
// their neighbours stay connected, and no pocket is left without a viewpoint. The first `first`
// viewpoints were chosen for their surroundings. They move by half of `least` at most, along the
// floor; two of them are never replaced by one.
class Thinner {
 public:
  Thinner(const ThinningInput& input, std::vector<std::uint32_t>& cells)
      : in_(input),
        cells_(cells),
        rank_(ranks_of(input.candidates, input.floor.cells().size())),
        near_(input.floor) {
    for (const std::uint32_t cell : cells_) viewpoints_.push_back(in_.placed(cell));
  }

  // The nearest two first; two that have to stay are not asked about again.
  void run() {
    std::set<std::pair<std::uint32_t, std::uint32_t>> kept;
    while (const auto pair = nearest_pair(kept)) {
      const auto [a, b] = *pair;
      if (const auto one = instead_of(a, b)) {
        replace(a, b, *one);
      } else {
        kept.emplace(cells_[a], cells_[b]);
      }
    }
  }

 private:
  using Pair = std::pair<std::size_t, std::size_t>;

  std::optional<Pair> nearest_pair(
      const std::set<std::pair<std::uint32_t, std::uint32_t>>& kept) const {
    // In the order of x: partners are within `least` there. Of equal distances the first pair.
    std::vector<std::size_t> order(cells_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t v) { return viewpoints_[v].eye.x; });
    std::optional<Pair> nearest;
    double metres = in_.least;
    for (std::size_t i = 0; i < order.size(); ++i) {
      for (std::size_t k = i + 1; k < order.size(); ++k) {
        const auto [a, b] = std::minmax(order[i], order[k]);
        if (viewpoints_[order[k]].eye.x - viewpoints_[order[i]].eye.x > metres) break;
        const double apart = length(viewpoints_[b].eye - viewpoints_[a].eye);
        const bool nearer = apart < metres || (nearest && apart == metres && Pair(a, b) < *nearest);
        if (!nearer || kept.contains({cells_[a], cells_[b]})) continue;
        if (!in_.passage.in_sight(viewpoints_[a], viewpoints_[b])) continue;
        metres = apart;
        nearest = Pair(a, b);
      }
    }
    return nearest;
  }

  std::optional<std::uint32_t> instead_of(std::size_t a, std::size_t b) {
    const auto pocket_a = in_.pockets.of[cells_[a]], pocket_b = in_.pockets.of[cells_[b]];
    const bool alone_a = is_alone(a, b), alone_b = is_alone(b, a);
    if (b < in_.first || (alone_a && alone_b && pocket_a != pocket_b)) return std::nullopt;
    const auto groups = groups_around(a, b);
    near_.clear();
    const double reach = a < in_.first ? in_.least / 2 : in_.least;
    near_.add(cells_[a], reach);
    if (a >= in_.first) near_.add(cells_[b], reach);
    const auto good = [&](std::uint32_t cell) {
      if (!(near_[cell] <= reach)) return false;
      if (alone_a && in_.pockets.of[cell] != pocket_a) return false;
      if (alone_b && in_.pockets.of[cell] != pocket_b) return false;
      return reaches_all(in_.placed(cell), groups);
    };
    if (good(cells_[a])) return cells_[a];
    if (good(cells_[b])) return cells_[b];
    std::vector<std::uint32_t> ranks;  // of candidates that are near
    for (const std::uint32_t cell : near_.reached()) {
      if (rank_[cell] != kNoRank) ranks.push_back(rank_[cell]);
    }
    std::ranges::sort(ranks);
    for (const std::uint32_t rank : ranks) {
      if (good(in_.candidates[rank])) return in_.candidates[rank];
    }
    return std::nullopt;
  }

  // Whether no viewpoint but these two is in a's pocket.
  bool is_alone(std::size_t a, std::size_t b) const {
    for (std::size_t v = 0; v < cells_.size(); ++v) {
      if (v != a && v != b && in_.pockets.of[cells_[v]] == in_.pockets.of[cells_[a]]) return false;
    }
    return true;
  }

  // Neighbours of the two, those together that have edges between them.
  std::vector<std::vector<std::size_t>> groups_around(std::size_t a, std::size_t b) const {
    std::vector<std::vector<std::size_t>> groups;
    for (std::size_t v = 0; v < cells_.size(); ++v) {
      if (v == a || v == b || !(is_free(a, v) || is_free(b, v))) continue;
      std::vector<std::size_t> own{v};
      std::erase_if(groups, [&](const std::vector<std::size_t>& group) {
        const bool joined =
            std::ranges::any_of(group, [&](std::size_t other) { return is_free(v, other); });
        if (joined) own.insert(own.end(), group.begin(), group.end());
        return joined;
      });
      groups.push_back(std::move(own));
    }
    return groups;
  }

  bool is_free(std::size_t a, std::size_t b) const {
    return in_.passage.is_free(viewpoints_[std::min(a, b)], viewpoints_[std::max(a, b)]);
  }

  bool reaches_all(const PlacedViewpoint& one,
                   const std::vector<std::vector<std::size_t>>& groups) const {
    return std::ranges::all_of(groups, [&](const std::vector<std::size_t>& group) {
      return std::ranges::any_of(
          group, [&](std::size_t v) { return in_.passage.is_free(viewpoints_[v], one); });
    });
  }

  void replace(std::size_t a, std::size_t b, std::uint32_t one) {
    cells_[a] = one;
    viewpoints_[a] = in_.placed(one);
    cells_.erase(cells_.begin() + static_cast<std::ptrdiff_t>(b));
    viewpoints_.erase(viewpoints_.begin() + static_cast<std::ptrdiff_t>(b));
  }

  const ThinningInput& in_;
  std::vector<std::uint32_t>& cells_;
  std::vector<std::uint32_t> rank_;  // of each cell among the candidates
  WalkingDistances near_;
  std::vector<PlacedViewpoint> viewpoints_;
};

}  // namespace

std::vector<PlacedViewpoint> place_viewpoints(const RayTracer& tracer, const WalkableFloor& floor,
                                              const ViewpointOptions& options) {
  check_options(options);
  std::vector<Candidate> candidates =
      choose_candidates(floor, choose_parts(floor, options.separation));
  score_candidates(tracer, floor, options, candidates);
  const double spacing = kSpacing * options.separation;
  const Pockets pockets = detail::find_pockets(floor);
  std::vector<std::uint32_t> cells = spread(floor, candidates, pockets, spacing);
  const std::size_t first = cells.size();
  const auto placed = [&](std::uint32_t cell) {
    return place(tracer, floor.cells()[cell], options.eye_height);
  };
  const Passage passage(tracer, floor, EdgeOptions());
  Joiner(floor, passage, placed, cells).run();
  const std::vector<std::uint32_t> others = cells_of(candidates);
  Thinner({floor, passage, pockets, others, kTooNear * spacing, first, placed}, cells).run();
  std::vector<PlacedViewpoint> viewpoints;
  for (const std::uint32_t cell : cells) viewpoints.push_back(placed(cell));
  return viewpoints;
}

}  // namespace enfilade::graph
