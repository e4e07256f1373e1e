#include "enfilade/mesh/walkable.h"

#include <Recast.h>
#include <fmt/format.h>
#include <functional>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/mesh/detail/exact_heights.h"

namespace enfilade::mesh {

using namespace detail;

namespace {

// Recast counts spans in 24 bits, heights in 13.
constexpr double kMostColumns = (1 << 24) - 1;
constexpr double kMostLevels = RC_SPAN_MAX_HEIGHT - 2;
// Heights are looked up exactly later; the levels only have to tell steps apart.
constexpr double kLevel = 0.02, kCoarsestLevel = 0.05;
constexpr int kMargin = 2;            // columns around the mesh, so that its rim is a ledge
constexpr double kIndoors = 8;        // m2 below a ceiling that make a mesh a building
constexpr double kAboveFloor = 0.05;  // points this far below the floor are still on it

void check_options(const WalkableOptions& o) {
  check_range("cell", o.cell, 0.005, 1);
  check_range("least_area", o.least_area, 0, 1e6);
  check_range("body.radius", o.body.radius, 0, 5);
  check_range("body.height", o.body.height, 0.1, 10);
  check_range("body.step", o.body.step, 0.02, 2);
  check_range("body.slope", o.body.slope, 0, 85);
  check_range("body.radius / cell", o.body.radius / o.cell, 0, 120);  // eroded in 8-bit half cells
}

Lattice make_lattice(const Mesh& mesh, double cell) {
  Lattice lattice;
  lattice.cell = cell;
  lattice.box = bounds(mesh);
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

using Heightfield = std::unique_ptr<rcHeightfield, void (*)(rcHeightfield*)>;
using CompactField = std::unique_ptr<rcCompactHeightfield, void (*)(rcCompactHeightfield*)>;

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

int climb_of(const WalkableOptions& options, const Lattice& lattice) {
  return static_cast<int>(std::floor(options.body.step / lattice.level + 1e-6));
}

Heightfield rasterise(const Mesh& mesh, const WalkableOptions& options, const Lattice& lattice,
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

[[noreturn]] void no_floor(const std::string& why) {
  refuse("<mesh>", "", "no-floor", "nowhere to stand: " + why);
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

constexpr std::uint32_t kNoSpan = std::numeric_limits<std::uint32_t>::max();

// Spans with their columns, and the steps between them. Walkable are those where the body's centre
// may be.
class Field {
 public:
  /// \param covered which spans have something above them
  Field(CompactField spans, std::vector<bool> covered, const Lattice& lattice)
      : field_(std::move(spans)), covered_(std::move(covered)), lattice_(lattice) {
    column_.resize(static_cast<std::size_t>(field_->spanCount));
    for (int c = 0; c < field_->width * field_->height; ++c) {
      const std::uint32_t first = field_->cells[c].index, count = field_->cells[c].count;
      std::fill_n(column_.begin() + first, count, c);
    }
  }

  std::uint32_t spans() const { return static_cast<std::uint32_t>(field_->spanCount); }
  bool walkable(std::uint32_t span) const { return field_->areas[span] != RC_NULL_AREA; }
  int column(std::uint32_t span) const { return column_[span]; }
  bool covered(std::uint32_t span) const { return covered_[span]; }

  // The span that one step in a direction leads to, if the body may be there.
  std::uint32_t step(std::uint32_t span, int direction) const {
    const int layer = rcGetCon(field_->spans[span], direction);
    if (layer == RC_NOT_CONNECTED) return kNoSpan;
    const int column =
        column_[span] + rcGetDirOffsetX(direction) + rcGetDirOffsetY(direction) * field_->width;
    const std::uint32_t next = field_->cells[column].index + static_cast<std::uint32_t>(layer);
    return walkable(next) ? next : kNoSpan;
  }

  // Visits up to 8: straight ones, and diagonal ones that two straight ones lead to in any order.
  template <class Visit>
  void each_neighbour(std::uint32_t span, const Visit& visit) const {
    for (int d = 0; d < 4; ++d) {
      const std::uint32_t straight = step(span, d);
      if (straight == kNoSpan) continue;
      visit(straight);
      const std::uint32_t corner = step(straight, (d + 1) & 3);
      const std::uint32_t other = step(span, (d + 1) & 3);
      if (corner != kNoSpan && other != kNoSpan && step(other, d) == corner) visit(corner);
    }
  }

  FloorCell cell(std::uint32_t span) const {
    const int x = column_[span] % field_->width, y = column_[span] / field_->width;
    const auto middle = [this](float low, int place) {
      return static_cast<float>(low + (place + 0.5) * lattice_.cell);
    };
    FloorCell cell;
    cell.position = {
        middle(lattice_.box.low.x, x), middle(lattice_.box.low.y, y),
        static_cast<float>(lattice_.box.low.z + field_->spans[span].y * lattice_.level)};
    // Recast's distances are in half cells from the rim's middle, which is half a cell inside.
    cell.covered = covered_[span];
    cell.clearance = static_cast<float>(0.5 * (field_->dist[span] + 1) * lattice_.cell);
    return cell;
  }

 private:
  CompactField field_;
  std::vector<bool> covered_;
  const Lattice& lattice_;
  std::vector<int> column_;
};

Field make_field(const Mesh& mesh, const WalkableOptions& options, const Lattice& lattice) {
  rcContext context(false);
  const Heightfield solid = rasterise(mesh, options, lattice, context);
  const int climb = climb_of(options, lattice);
  const int height = static_cast<int>(std::ceil(options.body.height / lattice.level - 1e-6));
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
  // A cell's middle is one cell from what it borders, on average, before it is eroded.
  const int radius = static_cast<int>(std::lround(options.body.radius / options.cell - 1));
  require(rcErodeWalkableArea(&context, std::max(radius, 0), *field), "erosion");
  if (count_walkable(*field) == 0) {
    no_floor(fmt::format("no surface has room for a body of radius {} m", options.body.radius));
  }
  require(rcBuildDistanceField(&context, *field), "distances");
  return {std::move(field), find_covered(*solid), lattice};
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

void fill_part(const Field& field, std::uint32_t first, Parts& parts) {
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

Parts find_parts(const Field& field) {
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

Cells gather(const Field& field, const Lattice& lattice, const WalkableOptions& options) {
  const Parts parts = find_parts(field);
  const std::vector<std::uint32_t> ranks = rank(parts, options);
  Cells out;
  out.first_in_column.assign(static_cast<std::size_t>(lattice.width * lattice.depth) + 1, 0);
  std::vector<std::uint32_t> place(field.spans(), kNoSpan);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (parts.of[s] == kNoSpan || ranks[parts.of[s]] == kNoSpan) continue;
    place[s] = static_cast<std::uint32_t>(out.cells.size());
    out.cells.push_back(field.cell(s));
    out.cells.back().area = ranks[parts.of[s]];
    ++out.first_in_column[static_cast<std::size_t>(field.column(s)) + 1];
  }
  std::partial_sum(out.first_in_column.begin(), out.first_in_column.end(),
                   out.first_in_column.begin());
  out.first_link.push_back(0);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (place[s] == kNoSpan) continue;
    field.each_neighbour(s, [&](std::uint32_t next) { out.links.push_back(place[next]); });
    out.first_link.push_back(static_cast<std::uint32_t>(out.links.size()));
  }
  return out;
}

}  // namespace

struct WalkableFloor::Impl {
  WalkableOptions options;
  Lattice lattice;
  Cells floor;
  std::size_t areas = 0;
};

WalkableFloor::WalkableFloor(const Mesh& mesh, const WalkableOptions& options)
    : impl_(std::make_unique<Impl>()) {
  check_options(options);
  std::vector<Diagnostic> faults = check(mesh, "<mesh>");
  if (count(faults, Severity::kError) > 0) throw InvalidInput(std::move(faults));
  impl_->options = options;
  impl_->lattice = make_lattice(mesh, options.cell);
  const Lattice& lattice = impl_->lattice;
  impl_->floor = gather(make_field(mesh, options, lattice), lattice, options);
  set_exact_heights(mesh, lattice, options.body.step, impl_->floor);
  for (const FloorCell& cell : impl_->floor.cells) {
    impl_->areas = std::max<std::size_t>(impl_->areas, cell.area + 1);
  }
}

WalkableFloor::~WalkableFloor() = default;
WalkableFloor::WalkableFloor(WalkableFloor&&) noexcept = default;
WalkableFloor& WalkableFloor::operator=(WalkableFloor&&) noexcept = default;

const WalkableOptions& WalkableFloor::options() const noexcept { return impl_->options; }
std::span<const FloorCell> WalkableFloor::cells() const noexcept { return impl_->floor.cells; }
std::size_t WalkableFloor::areas() const noexcept { return impl_->areas; }

std::span<const std::uint32_t> WalkableFloor::neighbours(std::size_t cell) const noexcept {
  const Cells& floor = impl_->floor;
  return std::span(floor.links)
      .subspan(floor.first_link[cell], floor.first_link[cell + 1] - floor.first_link[cell]);
}

double WalkableFloor::area_m2() const noexcept {
  return static_cast<double>(cells().size()) * impl_->options.cell * impl_->options.cell;
}

std::optional<std::size_t> WalkableFloor::below(Vec3f point, double drop) const {
  const Lattice& lattice = impl_->lattice;
  const double x = std::floor((point.x - lattice.box.low.x) / lattice.cell);
  const double y = std::floor((point.y - lattice.box.low.y) / lattice.cell);
  if (!(x >= 0 && x < lattice.width && y >= 0 && y < lattice.depth)) return std::nullopt;
  const auto column = static_cast<std::size_t>(y * lattice.width + x);
  const Cells& floor = impl_->floor;
  for (std::size_t c = floor.first_in_column[column + 1]; c > floor.first_in_column[column]; --c) {
    const double down = static_cast<double>(point.z) - floor.cells[c - 1].position.z;
    if (down >= -kAboveFloor) return down <= drop ? std::optional(c - 1) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace enfilade::mesh
