
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/graph/build.h"
#include "enfilade/graph/detail/floor_walk.h"
#include "enfilade/graph/detail/join_parts.h"
#include "enfilade/graph/detail/passage.h"
#include "enfilade/graph/detail/thin_out.h"

namespace enfilade::graph {
namespace {

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

// The best place within a few steps that is not too near other viewpoints.
std::uint32_t best_around(const WalkableFloor& floor, const std::vector<Candidate>& candidates,
                          const detail::WalkingDistances& near, double spacing,
                          std::uint32_t cell) {
  constexpr double kSteps = 0.8;  // metres: corners of rooms are left, rooms are not
  detail::WalkingDistances around(floor);
  around.add(cell, kSteps);
  const auto best = std::ranges::find_if(candidates, [&](const Candidate& c) {
    return around[c.cell] <= kSteps && near[c.cell] >= 0.85 * spacing;
  });
  return best->cell;  // sorted by score, and the cell itself is one of them
}

// Cells of viewpoints, far enough from each other.
std::vector<std::uint32_t> spread(const WalkableFloor& floor,
                                  const std::vector<Candidate>& candidates,
                                  const detail::Pockets& pockets, double spacing) {
  std::vector<std::uint32_t> chosen;
  std::vector<char> has_one(pockets.count, 0);
  detail::WalkingDistances near(floor);
  const auto take = [&](std::uint32_t cell) {
    chosen.push_back(cell);
    has_one[pockets.of[cell]] = 1;
    near.add(cell, spacing);
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
    take(best_around(floor, candidates, near, spacing, c.cell));
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

}  // namespace

std::vector<PlacedViewpoint> place_viewpoints(const RayTracer& tracer, const WalkableFloor& floor,
                                              const ViewpointOptions& options) {
  check_options(options);
  std::vector<Candidate> candidates =
      choose_candidates(floor, choose_parts(floor, options.separation));
  score_candidates(tracer, floor, options, candidates);
  const double spacing = kSpacing * options.separation;
  const detail::Pockets pockets = detail::find_pockets(floor);
  std::vector<std::uint32_t> cells = spread(floor, candidates, pockets, spacing);
  const std::size_t first = cells.size();
  const auto placed = [&](std::uint32_t cell) {
    return place(tracer, floor.cells()[cell], options.eye_height);
  };
  const detail::Passage passage(tracer, floor, EdgeOptions());
  detail::join_parts(floor, passage, placed, cells);
  std::vector<std::uint32_t> others;
  for (const Candidate& c : candidates) others.push_back(c.cell);
  detail::thin_out({floor, passage, pockets, others, kTooNear * spacing, first, placed}, cells);
  std::vector<PlacedViewpoint> viewpoints;
  for (const std::uint32_t cell : cells) viewpoints.push_back(placed(cell));
  return viewpoints;
}

}  // namespace enfilade::graph
