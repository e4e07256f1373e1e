#include "enfilade/continuous/navigation_mesh.h"

#include <DetourNavMesh.h>
#include <DetourNavMeshBuilder.h>
#include <DetourNavMeshQuery.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "enfilade/core/check.h"

namespace enfilade::continuous {

using mesh::FloorPolygon;
using mesh::FloorPolygons;

namespace {

constexpr std::size_t kCorners = FloorPolygon::kMostCorners;
constexpr unsigned short kWalkable = 1;  // the only flag of polygons, which every query asks for
// Farther than a step, so that it never ends for want of memory: Detour takes 16 here.
constexpr int kMostCrossed = 48;
// A wall touched within this distance is not reported: single precision.
constexpr float kTouch = 1e-5F;

using Point = std::array<float, 3>;  // Detour's: y up, and z is our y

Point to_detour(Vec3f p) { return {p.x, p.z, p.y}; }
Vec3f from_detour(const float* p) { return {p[0], p[2], p[1]}; }

void require(bool done, const char* what) {
  if (!done) throw Error(fmt::format("navigation mesh: {}: out of memory", what));
}

dtQueryFilter make_filter() {
  dtQueryFilter filter;
  filter.setIncludeFlags(kWalkable);
  return filter;
}

// Recast's arrays, as dtCreateNavMeshData() takes them.
struct RecastArrays {
  std::vector<unsigned short> corners, polygons, flags;
  std::vector<unsigned char> areas;
  std::vector<unsigned int> heights;
  std::vector<float> points;
  std::vector<unsigned char> triangles;

  explicit RecastArrays(const FloorPolygons& floor) {
    for (const auto& [x, y, z] : floor.corners) corners.insert(corners.end(), {x, z, y});
    for (const FloorPolygon& p : floor.polygons) {
      polygons.insert(polygons.end(), p.corners.begin(), p.corners.end());
      polygons.insert(polygons.end(), p.beyond.begin(), p.beyond.end());
    }
    flags.assign(floor.polygons.size(), kWalkable);
    areas.assign(floor.polygons.size(), 0);
    for (const mesh::PolygonHeights& h : floor.heights) {
      heights.insert(heights.end(), {h.first_point, h.points, h.first_triangle, h.triangles});
    }
    for (const Vec3f p : floor.points) points.insert(points.end(), {p.x, p.z, p.y});
    for (const auto& t : floor.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  }
};

// One tile with everything.
std::pair<unsigned char*, int> make_tile(const FloorPolygons& floor) {
  const RecastArrays arrays(floor);
  dtNavMeshCreateParams p{};
  p.verts = arrays.corners.data();
  p.vertCount = static_cast<int>(floor.corners.size());
  p.polys = arrays.polygons.data();
  p.polyFlags = arrays.flags.data();
  p.polyAreas = arrays.areas.data();
  p.polyCount = static_cast<int>(floor.polygons.size());
  p.nvp = static_cast<int>(kCorners);
  p.detailMeshes = arrays.heights.data();
  p.detailVerts = arrays.points.data();
  p.detailVertsCount = static_cast<int>(floor.points.size());
  p.detailTris = arrays.triangles.data();
  p.detailTriCount = static_cast<int>(floor.triangles.size());
  std::ranges::copy(to_detour(floor.low), p.bmin);
  std::ranges::copy(to_detour(floor.high), p.bmax);
  p.walkableHeight = static_cast<float>(floor.body.height);
  p.walkableRadius = static_cast<float>(floor.body.radius);
  p.walkableClimb = static_cast<float>(floor.body.step);
  p.cs = static_cast<float>(floor.cell);
  p.ch = static_cast<float>(floor.level);
  p.buildBvTree = true;
  unsigned char* data = nullptr;
  int size = 0;
  require(dtCreateNavMeshData(&p, &data, &size), "tile");
  return {data, size};
}

// Seen from above.
float apart(Vec3f a, Vec3f b) { return std::hypot(a.x - b.x, a.y - b.y); }

}  // namespace

struct Walker::Impl {
  dtNavMeshQuery query;
  const dtNavMesh* mesh = nullptr;  // that query is for
};

Walker::Walker() : impl_(std::make_unique<Impl>()) {}
Walker::~Walker() = default;
Walker::Walker(Walker&&) noexcept = default;
Walker& Walker::operator=(Walker&&) noexcept = default;

struct NavigationMesh::Impl {
  FloorPolygons floor;
  dtNavMesh mesh;
  dtNavMeshQuery query;  // for calls that need no memory of its own, so any thread's
  dtQueryFilter filter = make_filter();
  dtPolyRef first = 0;                // the reference of polygon 0; others follow
  std::vector<double> areas;          // m2, of each connected part
  std::vector<double> up_to;          // m2 of all polygons before, in `order`
  std::vector<std::uint32_t> order;   // polygons by part
  std::vector<std::size_t> first_in;  // of each part in `order`

  dtPolyRef reference(std::uint32_t polygon) const { return first + polygon; }
  std::uint32_t polygon(dtPolyRef reference) const {
    return static_cast<std::uint32_t>(reference - first);
  }
  const dtMeshTile& tile() const {
    const dtNavMesh& shared = mesh;
    return *shared.getTile(0);
  }
  Vec3f corner(std::size_t c) const { return from_detour(tile().verts + 3 * c); }
  double polygon_m2(std::uint32_t polygon) const;
  void set_exact_corners();
  void sort_by_area();
  void set_height(FloorPoint& at) const;
};

// dtCreateNavMeshData() takes the corners' heights from the lattice.
void NavigationMesh::Impl::set_exact_corners() {
  const dtMeshTile& tile = this->tile();
  for (std::size_t p = 0; p < floor.polygons.size(); ++p) {
    for (std::size_t k = 0; k < floor.polygons[p].size(); ++k) {
      const Vec3f exact = floor.points[floor.heights[p].first_point + k];
      tile.verts[3 * floor.polygons[p].corners[k] + 1] = exact.z;
    }
  }
}

double NavigationMesh::Impl::polygon_m2(std::uint32_t p) const {
  const FloorPolygon& polygon = floor.polygons[p];
  const Vec3f a = corner(polygon.corners[0]);
  double twice = 0;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const Vec3f b = corner(polygon.corners[k - 1]) - a, c = corner(polygon.corners[k]) - a;
    twice += static_cast<double>(b.x) * c.y - static_cast<double>(b.y) * c.x;
  }
  return std::abs(twice) / 2;
}

void NavigationMesh::Impl::sort_by_area() {
  std::uint32_t parts = 0;
  for (const FloorPolygon& p : floor.polygons) parts = std::max(parts, p.area + 1);
  areas.assign(parts, 0);
  for (std::uint32_t p = 0; p < floor.polygons.size(); ++p) {
    areas[floor.polygons[p].area] += polygon_m2(p);
    order.push_back(p);
  }
  std::ranges::stable_sort(order, {}, [this](std::uint32_t p) { return floor.polygons[p].area; });
  double sum = 0;
  for (const std::uint32_t p : order) {
    while (first_in.size() <= floor.polygons[p].area) first_in.push_back(up_to.size());
    up_to.push_back(sum);
    sum += polygon_m2(p);
  }
  first_in.push_back(order.size());
  up_to.push_back(sum);
}

NavigationMesh::NavigationMesh(FloorPolygons floor) : impl_(std::make_unique<Impl>()) {
  std::vector<Diagnostic> faults = check_polygons(floor, "<floor polygons>");
  if (count(faults, Severity::kError) > 0) throw InvalidInput(std::move(faults));
  impl_->floor = std::move(floor);
  const auto [data, size] = make_tile(impl_->floor);
  require(dtStatusSucceed(impl_->mesh.init(data, size, DT_TILE_FREE_DATA)), "mesh");
  require(dtStatusSucceed(impl_->query.init(&impl_->mesh, 16)), "query");
  impl_->first = impl_->mesh.getPolyRefBase(&impl_->tile());
  impl_->set_exact_corners();
  impl_->sort_by_area();
}

NavigationMesh::~NavigationMesh() = default;

const FloorPolygons& NavigationMesh::floor() const noexcept { return impl_->floor; }
std::size_t NavigationMesh::areas() const noexcept { return impl_->areas.size(); }

double NavigationMesh::area_m2(std::size_t area) const {
  EN_CHECK_LT(area, impl_->areas.size());
  return impl_->areas[area];
}

Vec3f NavigationMesh::corner(std::size_t corner) const {
  EN_CHECK_LT(corner, impl_->floor.corners.size());
  return impl_->corner(corner);
}

void NavigationMesh::Impl::set_height(FloorPoint& at) const {
  const Point point = to_detour(at.point);
  float height = at.point.z;
  if (dtStatusSucceed(query.getPolyHeight(reference(at.polygon), point.data(), &height))) {
    at.point.z = height;
    return;
  }
  // Rounding can put a point of the rim outside of its polygon.
  Point nearest{};
  if (dtStatusSucceed(
          query.closestPointOnPoly(reference(at.polygon), point.data(), nearest.data(), nullptr))) {
    at.point.z = nearest[1];
  }
}

float NavigationMesh::height(const FloorPoint& at) const {
  EN_CHECK_LT(at.polygon, impl_->floor.polygons.size());
  FloorPoint copy = at;
  impl_->set_height(copy);
  return copy.point.z;
}

std::optional<FloorPoint> NavigationMesh::nearest(Vec3f point, Reach reach) const {
  if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) return {};
  const Point centre = to_detour(point);
  const Point extent{reach.aside, reach.above_below, reach.aside};
  dtPolyRef found = 0;
  Point at{};
  const dtStatus status =
      impl_->query.findNearestPoly(centre.data(), extent.data(), &impl_->filter, &found, at.data());
  if (dtStatusFailed(status) || found == 0) return {};
  const FloorPoint result{from_detour(at.data()), impl_->polygon(found), point};
  // Detour looks for polygons whose box is in reach.
  const Vec3f off = result.point - point;
  if (std::hypot(off.x, off.y) > reach.aside || std::abs(off.z) > reach.above_below) return {};
  return result;
}

FloorPoint NavigationMesh::random_point(Rng& rng, std::optional<std::uint32_t> area) const {
  EN_CHECK_LT(area.value_or(0), impl_->areas.size());
  const std::size_t from = area ? impl_->first_in[*area] : 0;
  const std::size_t to = area ? impl_->first_in[*area + 1] : impl_->order.size();
  const double low = impl_->up_to[from], high = impl_->up_to[to];
  const double drawn = low + rng.uniform() * (high - low);
  const auto begin = impl_->up_to.begin();
  const auto after = std::upper_bound(begin + static_cast<std::ptrdiff_t>(from) + 1,
                                      begin + static_cast<std::ptrdiff_t>(to), drawn);
  const std::uint32_t p = impl_->order[static_cast<std::size_t>(after - begin) - 1];
  // A triangle of the fan, by area, and a point of it.
  const FloorPolygon& polygon = impl_->floor.polygons[p];
  double rest = drawn - impl_->up_to[static_cast<std::size_t>(after - begin) - 1];
  const Vec3d a = to_double(impl_->corner(polygon.corners[0]));
  Vec3d u, v;
  for (std::size_t k = 2; k < polygon.size() && rest >= 0; ++k) {
    u = to_double(impl_->corner(polygon.corners[k - 1])) - a;
    v = to_double(impl_->corner(polygon.corners[k])) - a;
    rest -= std::abs(u.x * v.y - u.y * v.x) / 2;
  }
  double s = rng.uniform(), t = rng.uniform();
  if (s + t > 1) {
    s = 1 - s;
    t = 1 - t;
  }
  FloorPoint point{to_float(a + s * u + t * v), p};
  impl_->set_height(point);
  return point;
}

Walked NavigationMesh::walk(Walker& walker, const FloorPoint& from, Vec3f towards,
                            Walls walls) const {
  Walker::Impl& own = *walker.impl_;
  if (own.mesh != &impl_->mesh) {
    require(dtStatusSucceed(own.query.init(&impl_->mesh, 16)), "walker");
    own.mesh = &impl_->mesh;
  }
  const Point start = to_detour(from.point);
  Point end = to_detour({towards.x, towards.y, from.point.z});
  std::array<dtPolyRef, kMostCrossed> crossed{};
  int count = 0;
  Walked walked{.end = from};
  if (walls == Walls::kStop) {
    dtRaycastHit hit{};
    const dtStatus status = impl_->query.raycast(impl_->reference(from.polygon), start.data(),
                                                 end.data(), &impl_->filter, 0, &hit);
    if (dtStatusSucceed(status) && hit.t < 1) {
      // Short of the wall, so that the next ray starts inside.
      const float share = std::max(0.0F, hit.t - kTouch);
      for (std::size_t k = 0; k < 3; ++k) end[k] = start[k] + share * (end[k] - start[k]);
    }
  }
  Point reached{};
  const dtStatus status = own.query.moveAlongSurface(impl_->reference(from.polygon), start.data(),
                                                     end.data(), &impl_->filter, reached.data(),
                                                     crossed.data(), &count, kMostCrossed);
  if (dtStatusFailed(status) || count == 0) return {.end = from, .at_wall = true};
  walked.end = {from_detour(reached.data()),
                impl_->polygon(crossed[static_cast<std::size_t>(count) - 1])};
  impl_->set_height(walked.end);
  walked.at_wall = apart(walked.end.point, towards) > kTouch;
  return walked;
}

}  // namespace enfilade::continuous
