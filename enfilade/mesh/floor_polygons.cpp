#include "enfilade/mesh/floor_polygons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "enfilade/core/numbers.h"
#include "enfilade/mesh/detail/floor_field.h"

namespace enfilade::mesh {

using namespace detail;

namespace {

constexpr std::size_t kCorners = FloorPolygon::kMostCorners;
constexpr double kMergedRegion = 4;  // m2: smaller pieces of floor are joined to their neighbours

using Contours = std::unique_ptr<rcContourSet, void (*)(rcContourSet*)>;
using Polygons = std::unique_ptr<rcPolyMesh, void (*)(rcPolyMesh*)>;
using Details = std::unique_ptr<rcPolyMeshDetail, void (*)(rcPolyMeshDetail*)>;

void require_step(bool done, const char* what) {
  if (!done) {
    throw ArgumentError(
        fmt::format("floor polygons: {} failed: the floor is too large for Recast's 16 bits (or "
                    "memory is short); take a larger cell or rim_error",
                    what));
  }
}

// Leaves out the parts that WalkableFloor leaves out. Gives the rank of the others by span.
std::vector<std::uint32_t> close_other_parts(FloorField& field, const WalkableOptions& options) {
  std::vector<std::uint32_t> ranks = rank_spans(field, options);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (ranks[s] == kNoSpan) field.close(s);
  }
  return ranks;
}

// The rank of a region: that of any span in it, as regions are connected.
std::vector<std::uint32_t> ranks_of_regions(FloorField& field,
                                            const std::vector<std::uint32_t>& ranks) {
  std::vector<std::uint32_t> of(std::size_t{field.recast().maxRegions} + 1, 0);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (field.walkable(s) && ranks[s] != kNoSpan) of[field.recast().spans[s].reg] = ranks[s];
  }
  return of;
}

void copy_polygons(const rcPolyMesh& from, const std::vector<std::uint32_t>& region_ranks,
                   FloorPolygons& out) {
  for (int v = 0; v < from.nverts; ++v) {
    const unsigned short* at = from.verts + 3 * v;
    out.corners.push_back({at[0], at[2], at[1]});
  }
  for (int p = 0; p < from.npolys; ++p) {
    const unsigned short* at = from.polys + 2 * kCorners * static_cast<std::size_t>(p);
    FloorPolygon& polygon = out.polygons.emplace_back();
    std::copy_n(at, kCorners, polygon.corners.begin());
    std::copy_n(at + kCorners, kCorners, polygon.beyond.begin());
    // Recast marks sides without a neighbour with bits that say on which border of a tile they are.
    for (std::uint16_t& beyond : polygon.beyond) {
      if ((beyond & 0x8000) != 0) beyond = FloorPolygon::kNone;
    }
    polygon.area = region_ranks.at(from.regs[p]);
  }
}

// The surface that a point of the floor stands on: the first one below a point that the step lies
// above it. Recast gives a cell the height of the highest surface in it.
void set_exact_points(const RayTracer& tracer, double step, FloorPolygons& out) {
  std::vector<Ray> rays(out.points.size());
  std::vector<Hit> hits(out.points.size());
  const auto reach = static_cast<float>(step + 2 * out.level);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i] = {.origin = out.points[i] + Vec3f{0, 0, static_cast<float>(out.level)},
               .direction = {0, 0, -1},
               .near = 0,
               .far = reach};
  }
  tracer.trace(rays, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Vec3f& point = out.points[i];
    // A crack between triangles: half a level is the mean error.
    point.z =
        hits[i] ? rays[i].origin.z - hits[i].distance : point.z - static_cast<float>(out.level / 2);
  }
}

void copy_heights(const rcPolyMeshDetail& from, FloorPolygons& out) {
  for (int m = 0; m < from.nmeshes; ++m) {
    const unsigned int* at = from.meshes + 4 * static_cast<std::size_t>(m);
    out.heights.push_back(
        {.first_point = at[0], .points = at[1], .first_triangle = at[2], .triangles = at[3]});
  }
  for (int v = 0; v < from.nverts; ++v) {
    const float* at = from.verts + 3 * static_cast<std::size_t>(v);
    out.points.push_back({at[0], at[2], at[1]});
  }
  for (int t = 0; t < from.ntris; ++t) {
    const unsigned char* at = from.tris + 4 * static_cast<std::size_t>(t);
    out.triangles.push_back({at[0], at[1], at[2], at[3]});
  }
}

void check_polygon_options(const PolygonOptions& o) {
  check_range("rim_error", o.rim_error, 0, 1);
  check_range("height_every", o.height_every, 0.05, 10);
  check_range("height_error", o.height_error, 0.005, 1);
}

}  // namespace

FloorPolygons make_floor_polygons(const RayTracer& tracer, const PolygonOptions& asked) {
  check_polygon_options(asked);
  check_walkable_input(tracer.mesh(), asked.floor);
  PolygonOptions options = asked;
  const double cell = options.floor.cell = fitting_cell(tracer.mesh(), asked.floor);
  options.rim_error *= cell / asked.floor.cell;
  const FloorLattice lattice = make_lattice(tracer.mesh(), options.floor);
  FloorField field = make_field(tracer.mesh(), options.floor, lattice);
  field.erode_straight(options.floor);
  const std::vector<std::uint32_t> ranks = close_other_parts(field, options.floor);
  rcContext context(false);
  field.measure_distances();
  require_step(rcBuildRegions(&context, field.recast(), 0, 0,
                              static_cast<int>(kMergedRegion / (cell * cell))),
               "regions");
  const Contours contours(rcAllocContourSet(), rcFreeContourSet);
  require_step(
      contours && rcBuildContours(&context, field.recast(),
                                  static_cast<float>(options.rim_error / cell), 0, *contours, 0),
      "contours");
  const Polygons polygons(rcAllocPolyMesh(), rcFreePolyMesh);
  require_step(polygons && rcBuildPolyMesh(&context, *contours, kCorners, *polygons), "polygons");
  const Details details(rcAllocPolyMeshDetail(), rcFreePolyMeshDetail);
  require_step(details && rcBuildPolyMeshDetail(&context, *polygons, field.recast(),
                                                static_cast<float>(options.height_every),
                                                static_cast<float>(options.height_error), *details),
               "heights");

  FloorPolygons out;
  out.body = options.floor.body;
  out.cell = cell;
  out.level = lattice.level;
  out.low = lattice.box.low;
  out.high = lattice.box.high;
  copy_polygons(*polygons, ranks_of_regions(field, ranks), out);
  copy_heights(*details, out);
  set_exact_points(tracer, options.floor.body.step, out);
  return out;
}

}  // namespace enfilade::mesh
