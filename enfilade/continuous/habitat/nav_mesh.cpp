#include "enfilade/continuous/habitat/nav_mesh.h"

#include <DetourNavMeshBuilder.h>
#include <Recast.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "enfilade/continuous/habitat/detour.h"
#include "enfilade/continuous/habitat/settings_table.h"
#include "enfilade/core/errors.h"
#include "enfilade/geometry/habitat_frame.h"

namespace enfilade::continuous::habitat {
namespace {

constexpr double kMostCells = 1 << 27;  // seen from above: 1 GB of them

using Heightfield = std::unique_ptr<rcHeightfield, void (*)(rcHeightfield*)>;
using Compact = std::unique_ptr<rcCompactHeightfield, void (*)(rcCompactHeightfield*)>;
using Contours = std::unique_ptr<rcContourSet, void (*)(rcContourSet*)>;
using Polygons = std::unique_ptr<rcPolyMesh, void (*)(rcPolyMesh*)>;
using Details = std::unique_ptr<rcPolyMeshDetail, void (*)(rcPolyMeshDetail*)>;

[[noreturn]] void refuse_mesh(std::string why) {
  throw InvalidInput({{Severity::kError, "", "", "no-floor", std::move(why)}});
}

void require_recast(bool done, const char* what) {
  if (!done) {
    throw ArgumentError(fmt::format(
        "navmesh settings: {} failed: the floor is too large for Recast's 16 bits (or memory is "
        "short); take a larger cell_size or region_min_size",
        what));
  }
}

void check_settings(const NavMeshSettings& settings) {
  for (const auto& [name, value, least, most] : kNumberSettings) {
    check_range(name, settings.*value, least, most);
  }
}

// Whole cells, for Recast.
struct Cells {
  int height, climb, radius, edge, least_region, merged_region, corners;
  float sample_distance, sample_error;

  explicit Cells(const NavMeshSettings& s)
      : height(static_cast<int>(std::ceil(s.agent_height / s.cell_height))),
        climb(static_cast<int>(std::floor(s.agent_max_climb / s.cell_height))),
        radius(static_cast<int>(std::ceil(s.agent_radius / s.cell_size))),
        edge(static_cast<int>(s.edge_max_len / s.cell_size)),
        least_region(static_cast<int>(s.region_min_size * s.region_min_size)),
        merged_region(static_cast<int>(s.region_merge_size * s.region_merge_size)),
        corners(static_cast<int>(s.verts_per_poly)),
        sample_distance(s.detail_sample_dist < 0.9F ? 0 : s.cell_size * s.detail_sample_dist),
        sample_error(s.cell_height * s.detail_sample_max_error) {}
};

// Recast 1.6 keeps spans exactly as high as the body, where versions before remove them. It is the
// only difference between the two that changes a navigation mesh.
bool keeps_exact_heights() {
  static const bool keeps = [] {
    rcContext context(false);
    const Heightfield field(rcAllocHeightfield(), rcFreeHeightField);
    const std::array<float, 3> low{0, 0, 0}, high{1, 20, 1};
    require_recast(field &&
                       rcCreateHeightfield(&context, *field, 1, 1, low.data(), high.data(), 1, 1) &&
                       rcAddSpan(&context, *field, 0, 0, 0, 1, RC_WALKABLE_AREA, 1) &&
                       rcAddSpan(&context, *field, 0, 0, 6, 7, RC_WALKABLE_AREA, 1),
                   "a test of Recast");
    rcFilterWalkableLowHeightSpans(&context, 5, *field);
    return field->spans[0]->area != RC_NULL_AREA;
  }();
  return keeps;
}

Compact make_field(rcContext& context, const Triangles& mesh, const std::vector<float>& corners,
                   const NavMeshSettings& settings, const Cells& cells, Navigation navigation,
                   const NavMesh& box) {
  const auto low = array_of(box.low), high = array_of(box.high);
  int width = 0, depth = 0;
  const double along_x = (double{high[0]} - low[0]) / settings.cell_size;
  const double along_z = (double{high[2]} - low[2]) / settings.cell_size;
  if (!(along_x * along_z <= kMostCells)) {
    throw ArgumentError(fmt::format("cell_size: {}, too small for a mesh of {:.1f} x {:.1f} m",
                                    settings.cell_size, high[0] - low[0], high[2] - low[2]));
  }
  rcCalcGridSize(low.data(), high.data(), settings.cell_size, &width, &depth);
  if (width < 1 || depth < 1) refuse_mesh("it is thinner than half a cell");
  const Heightfield solid(rcAllocHeightfield(), rcFreeHeightField);
  require_recast(
      solid && rcCreateHeightfield(&context, *solid, width, depth, low.data(), high.data(),
                                   settings.cell_size, settings.cell_height),
      "the height field");
  const auto points = static_cast<int>(mesh.corners.size());
  const auto count = static_cast<int>(mesh.triangles.size());
  const int* triangles = mesh.triangles.front().data();
  std::vector<unsigned char> areas(mesh.triangles.size(), RC_NULL_AREA);
  rcMarkWalkableTriangles(&context, settings.agent_max_slope, corners.data(), points, triangles,
                          count, areas.data());
  require_recast(rcRasterizeTriangles(&context, corners.data(), points, triangles, areas.data(),
                                      count, *solid, cells.climb),
                 "filling the height field");
  if (settings.filter_low_hanging_obstacles) {
    rcFilterLowHangingWalkableObstacles(&context, cells.climb, *solid);
  }
  if (settings.filter_ledge_spans) {
    rcFilterLedgeSpans(&context, cells.height, cells.climb, *solid);
  }
  if (settings.filter_walkable_low_height_spans) {
    const int wanted = navigation == Navigation::kLatest ? 1 : 0;
    const int found = keeps_exact_heights() ? 1 : 0;
    rcFilterWalkableLowHeightSpans(&context, cells.height + found - wanted, *solid);
  }
  Compact field(rcAllocCompactHeightfield(), rcFreeCompactHeightfield);
  require_recast(
      field && rcBuildCompactHeightfield(&context, cells.height, cells.climb, *solid, *field),
      "the compact height field");
  require_recast(rcErodeWalkableArea(&context, cells.radius, *field), "the body's radius");
  require_recast(rcBuildDistanceField(&context, *field), "distances");
  require_recast(rcBuildRegions(&context, *field, 0, cells.least_region, cells.merged_region),
                 "regions");
  return field;
}

dtNavMeshCreateParams tile_of(rcPolyMesh& polygons, const rcPolyMeshDetail& details,
                              const NavMeshSettings& settings) {
  for (int p = 0; p < polygons.npolys; ++p) {
    if (polygons.areas[p] == RC_WALKABLE_AREA) polygons.areas[p] = 0;
    polygons.flags[p] = polygons.areas[p] == 0 ? kWalkable : 0;
  }
  dtNavMeshCreateParams out{};
  out.verts = polygons.verts;
  out.vertCount = polygons.nverts;
  out.polys = polygons.polys;
  out.polyFlags = polygons.flags;
  out.polyAreas = polygons.areas;
  out.polyCount = polygons.npolys;
  out.nvp = polygons.nvp;
  out.detailMeshes = details.meshes;
  out.detailVerts = details.verts;
  out.detailVertsCount = details.nverts;
  out.detailTris = details.tris;
  out.detailTriCount = details.ntris;
  std::ranges::copy(polygons.bmin, out.bmin);
  std::ranges::copy(polygons.bmax, out.bmax);
  out.walkableHeight = settings.agent_height;
  out.walkableRadius = settings.agent_radius;
  out.walkableClimb = settings.agent_max_climb;
  out.cs = settings.cell_size;
  out.ch = settings.cell_height;
  out.buildBvTree = true;
  return out;
}

}  // namespace

bool operator==(const NavMeshSettings& a, const NavMeshSettings& b) noexcept {
  constexpr float kSame = 1e-5F;
  return std::ranges::all_of(kNumberSettings,
                             [&](const NumberSetting& number) {
                               return std::abs(a.*number.value - b.*number.value) < kSame;
                             }) &&
         std::ranges::all_of(kSwitchSettings, [&](const SwitchSetting& one) {
           return a.*one.value == b.*one.value;
         });
}

Triangles triangles_of(const mesh::Mesh& mesh, Upright up) {
  // Rows of the matrix that Habitat makes of a quarter turn in float32. Their error of 2^-23 shows
  // in the bounds, and in which cells are filled.
  constexpr float kError = 0x1p-23F;
  Triangles out;
  out.corners.reserve(mesh.positions.size());
  for (const Vec3f p : mesh.positions) {
    if (up == Upright::kY) {
      out.corners.push_back(to_habitat(p));
    } else {
      out.corners.push_back(
          {p.x, -kError * p.y + (1 + kError) * p.z, -(1 + kError) * p.y + -kError * p.z});
    }
  }
  out.triangles.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    out.triangles.push_back(
        {static_cast<std::int32_t>(a), static_cast<std::int32_t>(b), static_cast<std::int32_t>(c)});
  }
  return out;
}

NavMesh make_nav_mesh(const Triangles& triangles, const NavMeshSettings& settings,
                      Navigation navigation) {
  check_settings(settings);
  if (triangles.triangles.empty()) refuse_mesh("a mesh without triangles");
  std::vector<float> corners;
  corners.reserve(3 * triangles.corners.size());
  for (const Vec3f p : triangles.corners) corners.insert(corners.end(), {p.x, p.y, p.z});
  NavMesh out;
  out.settings = settings;
  std::array<float, 3> low{}, high{};
  rcCalcBounds(corners.data(), static_cast<int>(triangles.corners.size()), low.data(), high.data());
  out.low = point_of(low.data());
  out.high = point_of(high.data());

  const Cells cells(settings);
  rcContext context(false);
  const Compact field = make_field(context, triangles, corners, settings, cells, navigation, out);
  const Contours contours(rcAllocContourSet(), rcFreeContourSet);
  require_recast(
      contours && rcBuildContours(&context, *field, settings.edge_max_error, cells.edge, *contours),
      "contours");
  const Polygons polygons(rcAllocPolyMesh(), rcFreePolyMesh);
  require_recast(polygons && rcBuildPolyMesh(&context, *contours, cells.corners, *polygons),
                 "polygons");
  if (polygons->npolys == 0) refuse_mesh("nowhere is room for a body to stand");
  const Details details(rcAllocPolyMeshDetail(), rcFreePolyMeshDetail);
  require_recast(
      details && rcBuildPolyMeshDetail(&context, *polygons, *field, cells.sample_distance,
                                       cells.sample_error, *details),
      "heights");
  dtNavMeshCreateParams tile = tile_of(*polygons, *details, settings);
  unsigned char* data = nullptr;
  int size = 0;
  require_recast(dtCreateNavMeshData(&tile, &data, &size), "the tile");
  dtNavMesh mesh;
  if (dtStatusFailed(mesh.init(data, size, DT_TILE_FREE_DATA))) {
    dtFree(data);
    require_recast(false, "opening the tile");
  }
  take_from_detour(mesh, out);
  return out;
}

}  // namespace enfilade::continuous::habitat
