#include "enfilade/mesh/detail/floor_field.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::mesh::detail {

namespace {

// Recast counts spans in 24 bits, heights in 13.
constexpr double kMostColumns = (1 << 24) - 1;
constexpr double kMostLevels = RC_SPAN_MAX_HEIGHT - 2;
// Heights are looked up exactly later; the levels only have to tell steps apart.
constexpr double kLevel = 0.02, kCoarsestLevel = 0.05;
constexpr int kMargin = 2;      // columns around the mesh, so that its rim is a ledge
constexpr double kIndoors = 8;  // m2 below a ceiling that make a mesh a building

void check_options(const WalkableOptions& o) {
  check_range("cell", o.cell, 0.005, 1);
  check_range("least_area", o.least_area, 0, 1e6);
  check_range("body.radius", o.body.radius, 0, 5);
  check_range("body.height", o.body.height, 0.1, 10);
  check_range("body.step", o.body.step, 0.02, 2);
  check_range("body.slope", o.body.slope, 0, 85);
  check_range("body.radius / cell", o.body.radius / o.cell, 0, 120);  // eroded in 8-bit half cells
}

using Heightfield = std::unique_ptr<rcHeightfield, void (*)(rcHeightfield*)>;

void require(bool done, const char* what) {
  if (!done) throw Error(fmt::format("walkable floor: {}: out of memory", what));
}

// Recast has y up. The sign of a normal does not count: meshes do not agree on which side of a
// triangle is its front.
struct RecastTriangles {
  std::vector<float> corners;
  std::vector<int> places;
  std::vector<unsigned char> areas;
};

RecastTriangles to_recast(const Mesh& mesh, double slope) {
  RecastTriangles t;
  t.corners.reserve(3 * mesh.positions.size());
  for (const Vec3f p : mesh.positions) t.corners.insert(t.corners.end(), {p.x, p.z, p.y});
  const double flattest = std::cos(slope * std::numbers::pi / 180);
  t.places.reserve(3 * mesh.triangles.size());
  t.areas.reserve(mesh.triangles.size());
  for (const auto& [i, j, k] : mesh.triangles) {
    for (const auto corner : {i, j, k}) t.places.push_back(static_cast<int>(corner));
    const Vec3f a = mesh.positions[j] - mesh.positions[i],
                b = mesh.positions[k] - mesh.positions[i];
    const Vec3d normal{static_cast<double>(a.y) * b.z - static_cast<double>(a.z) * b.y,
                       static_cast<double>(a.z) * b.x - static_cast<double>(a.x) * b.z,
                       static_cast<double>(a.x) * b.y - static_cast<double>(a.y) * b.x};
    const bool flat = std::abs(normal.z) >= flattest * length(normal) && normal.z != 0;
    t.areas.push_back(flat ? RC_WALKABLE_AREA : RC_NULL_AREA);
  }
  return t;
}

[[noreturn]] void no_floor(const std::string& why) {
  refuse("<mesh>", "", "no-floor", "nowhere to stand: " + why);
}

Box box_of(const Mesh& mesh, const WalkableOptions& options) {
  Box box = bounds(mesh);
  if (!options.within) return box;
  const auto [low, high] = *options.within;
  box.low = {std::max(box.low.x, low.x), std::max(box.low.y, low.y), std::max(box.low.z, low.z)};
  box.high = {std::min(box.high.x, high.x), std::min(box.high.y, high.y),
              std::min(box.high.z, high.z)};
  // A level floor alone has no height.
  if (!(box.low.x < box.high.x && box.low.y < box.high.y && box.low.z <= box.high.z)) {
    no_floor("nothing of the mesh lies in the box that was asked for");
  }
  return box;
}

Heightfield rasterise(const Mesh& mesh, const WalkableOptions& options, const FloorLattice& lattice,
                      rcContext& context) {
  const auto [low, high] = lattice.box;
  const std::array bottom{low.x, low.z, low.y}, top{high.x, high.z, high.y};
  Heightfield solid(rcAllocHeightfield(), rcFreeHeightField);
  require(solid && rcCreateHeightfield(&context, *solid, lattice.width, lattice.depth,
                                       bottom.data(), top.data(), static_cast<float>(lattice.cell),
                                       static_cast<float>(lattice.level)),
          "columns");
  const RecastTriangles t = to_recast(mesh, options.body.slope);
  const int climb = climb_of(options, lattice);
  require(rcRasterizeTriangles(&context, t.corners.data(), static_cast<int>(mesh.positions.size()),
                               t.places.data(), t.areas.data(), static_cast<int>(t.areas.size()),
                               *solid, climb),
          "spans");
  return solid;
}

std::size_t count_walkable(const rcCompactHeightfield& field) {
  return static_cast<std::size_t>(
      std::count_if(field.areas, field.areas + field.spanCount, [](auto a) { return a != 0; }));
}

// In the order that Recast gives the spans of the compact field.
std::vector<bool> find_covered(const rcHeightfield& solid) {
  std::vector<bool> covered;
  for (int c = 0; c < solid.width * solid.height; ++c) {
    for (const rcSpan* s = solid.spans[c]; s != nullptr; s = s->next) {
      if (s->area != RC_NULL_AREA) covered.push_back(s->next != nullptr);
    }
  }
  return covered;
}

// What a connected part is ranked by.
struct Part {
  std::uint32_t cells = 0, covered = 0;
  std::uint32_t above_others = 0;  // cells that have some other part below them

  bool is_roof() const { return 10 * covered < cells && 2 * above_others > cells; }
};

struct Parts {
  std::vector<std::uint32_t> of;  // by span: its part or kNoSpan
  std::vector<Part> list;
};

void fill_part(const FloorField& field, std::uint32_t first, Parts& parts) {
  const auto number = static_cast<std::uint32_t>(parts.list.size());
  Part& part = parts.list.emplace_back();
  std::vector<std::uint32_t> open{first};
  parts.of[first] = number;
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    open.pop_back();
    ++part.cells;
    part.covered += field.covered(at) ? 1 : 0;
    for (int d = 0; d < 4; ++d) {
      const std::uint32_t next = field.step(at, d);
      if (next == kNoSpan || parts.of[next] != kNoSpan) continue;
      parts.of[next] = number;
      open.push_back(next);
    }
  }
}

Parts find_parts(const FloorField& field) {
  Parts parts;
  parts.of.assign(field.spans(), kNoSpan);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (field.walkable(s) && parts.of[s] == kNoSpan) fill_part(field, s, parts);
  }
  std::uint32_t lower = kNoSpan;  // spans of a column are in ascending order
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (parts.of[s] == kNoSpan) continue;
    const bool above = lower != kNoSpan && field.column(lower) == field.column(s);
    if (above && parts.of[lower] != parts.of[s]) ++parts.list[parts.of[s]].above_others;
    lower = s;
  }
  return parts;
}

// The rank of each part; kNoSpan for those that are left out.
std::vector<std::uint32_t> rank(const Parts& parts, const WalkableOptions& options) {
  std::vector<std::uint32_t> order(parts.list.size());
  std::iota(order.begin(), order.end(), 0U);
  const double cell_m2 = options.cell * options.cell;
  const bool indoors = std::ranges::any_of(
      parts.list, [&](const Part& part) { return part.covered * cell_m2 >= kIndoors; });
  std::ranges::stable_sort(order, std::greater<>{}, [&](std::uint32_t p) {
    return std::pair(indoors ? parts.list[p].covered : 0, parts.list[p].cells);
  });
  std::vector<std::uint32_t> ranks(order.size(), kNoSpan);
  std::uint32_t next = 0, most = 0;
  for (const std::uint32_t p : order) {
    const Part& part = parts.list[p];
    if (!part.is_roof()) most = std::max(most, part.cells);
    if (part.cells * cell_m2 >= options.least_area && !part.is_roof()) ranks[p] = next++;
  }
  if (next == 0) {
    no_floor(fmt::format("the largest connected floor has {:.2f} m2, less than {}", most * cell_m2,
                         options.least_area));
  }
  return ranks;
}

// Where the nearest cell that is not floor lies, in cells.
struct Offset {
  std::int16_t x = 0, y = 0;
  bool known = false;

  int squared() const { return known ? x * x + y * y : std::numeric_limits<int>::max(); }
};

// Recast's directions: west, north, east, south; a diagonal is one and the next.
constexpr std::array<int, 4> kX{-1, 0, 1, 0}, kY{0, 1, 0, -1};

// Passes on, from cell to cell, which one that is not floor is nearest: four sweeps (Danielsson
// 1980, "Euclidean distance mapping"), along the steps that the body can take. Off by a fraction of
// a cell at most.
class NearestWalls {
 public:
  explicit NearestWalls(const FloorField& field) : field_(field), offsets_(field.spans()) {
    for (std::uint32_t s = 0; s < field.spans(); ++s) {
      if (field.walkable(s)) start(s);
    }
    const std::uint32_t count = field.spans();
    // Spans are in the order of rows, and in a row from west to east.
    for (std::uint32_t s = 0; s < count; ++s) take(s, {0, 3}, {3, 3});
    for (std::uint32_t s = count; s-- > 0;) take(s, {2, 1}, {1, 0});
    for (std::uint32_t s = 0; s < count; ++s) take(s, {0, 3}, {3, 2});
    for (std::uint32_t s = count; s-- > 0;) take(s, {2, 1}, {0, 1});
  }

  double cells_away(std::uint32_t span) const {
    return std::sqrt(static_cast<double>(offsets_[span].squared()));
  }

 private:
  void start(std::uint32_t s) {
    for (int d = 0; d < 4; ++d) {
      const int e = (d + 1) & 3;
      const std::uint32_t next = field_.step(s, d);
      if (next == kNoSpan) {
        offer(s, {at(kX, d), at(kY, d), true});
      } else if (field_.step(next, e) == kNoSpan) {
        offer(s, {static_cast<std::int16_t>(at(kX, d) + at(kX, e)),
                  static_cast<std::int16_t>(at(kY, d) + at(kY, e)), true});
      }
    }
  }

  // From two straight neighbours, and from the diagonal ones that follow these directions.
  void take(std::uint32_t s, std::array<int, 2> straight, std::array<int, 2> diagonal) {
    if (!field_.walkable(s)) return;
    for (const int d : straight) take_from(s, field_.step(s, d), at(kX, d), at(kY, d));
    for (const int d : diagonal) {
      const int e = (d + 1) & 3;
      const std::uint32_t side = field_.step(s, d);
      if (side == kNoSpan) continue;
      take_from(s, field_.step(side, e), static_cast<std::int16_t>(at(kX, d) + at(kX, e)),
                static_cast<std::int16_t>(at(kY, d) + at(kY, e)));
    }
  }

  void take_from(std::uint32_t s, std::uint32_t other, std::int16_t x, std::int16_t y) {
    if (other == kNoSpan || !offsets_[other].known) return;
    offer(s, {static_cast<std::int16_t>(offsets_[other].x + x),
              static_cast<std::int16_t>(offsets_[other].y + y), true});
  }

  void offer(std::uint32_t s, Offset offset) {
    if (offset.squared() < offsets_[s].squared()) offsets_[s] = offset;
  }

  static std::int16_t at(const std::array<int, 4>& list, int d) {
    return static_cast<std::int16_t>(list[static_cast<std::size_t>(d)]);
  }

  const FloorField& field_;
  std::vector<Offset> offsets_;
};

}  // namespace

void check_walkable_input(const Mesh& mesh, const WalkableOptions& options) {
  check_options(options);
  std::vector<Diagnostic> faults = check(mesh, "<mesh>");
  if (count(faults, Severity::kError) > 0) throw InvalidInput(std::move(faults));
}

double fitting_cell(const Mesh& mesh, const WalkableOptions& options) {
  const auto [low, high] = box_of(mesh, options);
  const auto columns = [&](double cell) {
    return (std::ceil((high.x - low.x) / cell) + 2 * kMargin + 1) *
           (std::ceil((high.y - low.y) / cell) + 2 * kMargin + 1);
  };
  double cell = options.cell;
  // Storeys, furniture and roofs make several places to stand in a column.
  constexpr double kPlaces = 5;
  while (columns(cell) > kMostColumns / kPlaces && cell < 1) cell *= 1.25;
  return cell;
}

FloorLattice make_lattice(const Mesh& mesh, const WalkableOptions& options) {
  const double cell = options.cell;
  FloorLattice lattice;
  lattice.cell = cell;
  lattice.box = box_of(mesh, options);
  const auto [low, high] = lattice.box;
  const double across = std::ceil((high.x - low.x) / cell) + 2 * kMargin + 1;
  const double deep = std::ceil((high.y - low.y) / cell) + 2 * kMargin + 1;
  const double tall = static_cast<double>(high.z) - low.z;
  lattice.level = std::max(kLevel, tall / kMostLevels);
  if (across * deep > kMostColumns || lattice.level > kCoarsestLevel) {
    throw ArgumentError(
        fmt::format("cell: {} m on a mesh of {:.1f} x {:.1f} x {:.1f} m makes {:.0f} columns of "
                    "{:.0f} levels, more than {:.0f} of {:.0f}; take larger cells, or check the "
                    "mesh's scale",
                    cell, high.x - low.x, high.y - low.y, tall, across * deep, tall / kLevel,
                    kMostColumns, kMostLevels * kCoarsestLevel / kLevel));
  }
  lattice.width = static_cast<int>(across);
  lattice.depth = static_cast<int>(deep);
  const auto margin = static_cast<float>(kMargin * cell);
  lattice.box.low = low - Vec3f{margin, margin, 0};
  lattice.box.high = high + Vec3f{margin, margin, static_cast<float>(2 * lattice.level)};
  return lattice;
}

int climb_of(const WalkableOptions& options, const FloorLattice& lattice) {
  return static_cast<int>(std::floor(options.body.step / lattice.level + 1e-6));
}

int headroom_of(const WalkableOptions& options, const FloorLattice& lattice) {
  return static_cast<int>(std::ceil(options.body.height / lattice.level - 1e-6));
}

void FloorField::measure_distances() {
  rcContext context(false);
  require(rcBuildDistanceField(&context, *field_), "distances");
}

void FloorField::erode(const WalkableOptions& options) {
  // A cell's middle is one cell from what it borders, on average, before it is eroded.
  const int radius = static_cast<int>(std::lround(options.body.radius / options.cell - 1));
  rcContext context(false);
  require(rcErodeWalkableArea(&context, std::max(radius, 0), *field_), "erosion");
  require_room(options.body.radius);
}

void FloorField::require_room(double radius) const {
  if (count_walkable(*field_) == 0) {
    no_floor(fmt::format("no surface has room for a body of radius {} m", radius));
  }
}

FloorField make_field(const Mesh& mesh, const WalkableOptions& options,
                      const FloorLattice& lattice) {
  rcContext context(false);
  const Heightfield solid = rasterise(mesh, options, lattice, context);
  const int climb = climb_of(options, lattice);
  const int height = headroom_of(options, lattice);
  if (rcGetHeightFieldSpanCount(&context, *solid) == 0) {
    no_floor(fmt::format("no surface is flatter than {} degrees", options.body.slope));
  }
  rcFilterLowHangingWalkableObstacles(&context, climb, *solid);
  rcFilterLedgeSpans(&context, height, climb, *solid);
  rcFilterWalkableLowHeightSpans(&context, height, *solid);
  if (rcGetHeightFieldSpanCount(&context, *solid) >= (1 << 24)) {
    throw ArgumentError(
        fmt::format("cell: {} m makes more than {} places to stand; take larger "
                    "cells, or check the mesh's scale",
                    options.cell, 1 << 24));
  }
  CompactField field(rcAllocCompactHeightfield(), rcFreeCompactHeightfield);
  require(field && rcBuildCompactHeightfield(&context, height, climb, *solid, *field), "field");
  if (count_walkable(*field) == 0) {
    no_floor(fmt::format("no level surface with head-room of {} m is more than a ledge",
                         options.body.height));
  }
  return {std::move(field), find_covered(*solid), lattice};
}

std::vector<std::uint32_t> rank_spans(const FloorField& field, const WalkableOptions& options) {
  const Parts parts = find_parts(field);
  const std::vector<std::uint32_t> ranks = rank(parts, options);
  std::vector<std::uint32_t> of_spans(parts.of);
  for (std::uint32_t& part : of_spans) {
    if (part != kNoSpan) part = ranks[part];
  }
  return of_spans;
}

// What is in a cell, on average, begins at its middle: a thing is drawn into every cell that it
// touches.
void FloorField::erode_straight(const WalkableOptions& options) {
  const NearestWalls walls(*this);
  const double least = options.body.radius / options.cell;
  for (std::uint32_t s = 0; s < spans(); ++s) {
    if (walkable(s) && walls.cells_away(s) < least) close(s);
  }
  require_room(options.body.radius);
}

}  // namespace enfilade::mesh::detail
