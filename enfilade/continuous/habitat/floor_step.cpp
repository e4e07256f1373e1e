// Steps of bodies: Habitat's try_step and try_step_no_sliding.
#include <DetourCommon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "enfilade/continuous/habitat/floor_query.h"

namespace enfilade::continuous::habitat {
namespace {

constexpr std::size_t kMostVisited = 64;  // polygons a step
constexpr float kNudge = 1e-4F;           // metres

/// Where a step comes to, and the polygon whose height counts.
struct Landing {
  Vec3f point;
  dtPolyRef polygon = 0;
};

bool within(float share) { return share >= 0 && share <= 1; }

// The crossing of a polygon's rim that is nearest to the asked end.
struct Crossing {
  std::array<float, 3> point{};
  float distance = std::numeric_limits<float>::max();  // squared, seen from above
  void offer(const std::array<float, 3>& at, const float* end) {
    const float d = dtVdist2DSqr(at.data(), end);
    if (d < distance) {
      point = at;
      distance = d;
    }
  }
};

// Polygons that a sliding step crossed.
struct Visited {
  std::array<dtPolyRef, kMostVisited> polygons{};
  int count = 0;
  std::span<const dtPolyRef> all() const {
    return std::span(polygons).first(static_cast<std::size_t>(count));
  }
};

std::optional<Landing> slide(const FloorQuery& floor, const OnFloor& from, Vec3f to,
                             Visited& visited) {
  std::array<float, 3> end{};
  const dtStatus status = floor.query().moveAlongSurface(
      from.polygon, array_of(from.point).data(), array_of(to).data(), &floor.filter(), end.data(),
      visited.polygons.data(), &visited.count, static_cast<int>(kMostVisited));
  if (dtStatusFailed(status) || visited.count == 0) return std::nullopt;
  return Landing{point_of(end.data()), visited.all().back()};
}

// Since v0.3.4: the sliding step, and then the walls of all polygons that it visited.
std::optional<Landing> stop_at_walls_of_slide(const FloorQuery& floor, const OnFloor& from,
                                              Vec3f to) {
  Visited visited;
  std::optional<Landing> landing = slide(floor, from, to, visited);
  if (!landing) return landing;
  const auto start = array_of(from.point), end = array_of(to);
  Crossing nearest;
  for (const dtPolyRef polygon : visited.all()) {
    const PolygonPlace place = floor.place(polygon);
    for (std::size_t k = 0; k < place.size(); ++k) {
      if (floor.beyond(polygon, k) != 0) continue;
      const float* u = place.corner(k);
      const float* v = place.corner((k + 1) % place.size());
      float s = 0, t = 0;
      if (!dtIntersectSegSeg2D(start.data(), end.data(), u, v, s, t)) continue;
      if (!within(s) || !within(t)) continue;
      std::array<float, 3> hit{};
      dtVlerp(hit.data(), u, v, t);
      nearest.offer(hit, end.data());
    }
  }
  if (nearest.distance < std::numeric_limits<float>::max()) {
    landing->point = point_of(nearest.point.data());
  }
  return landing;
}

// Up to v0.3.3: Detour's search along the surface, but through crossed edges alone.
std::optional<Landing> stop_at_first_wall(const FloorQuery& floor, const OnFloor& from, Vec3f to) {
  const auto start = array_of(from.point), end = array_of(to);
  std::array<float, 3> middle{};
  dtVlerp(middle.data(), start.data(), end.data(), 0.5F);
  const float reach = dtVdist(start.data(), end.data()) / 2 + 0.001F;
  std::array<dtPolyRef, kMostVisited> open{};
  std::size_t seen = 0;
  open[seen++] = from.polygon;
  Crossing nearest;
  dtPolyRef best = 0;
  for (std::size_t at = 0; at < seen; ++at) {
    const PolygonPlace place = floor.place(open[at]);
    std::array<float, 3 * DT_VERTS_PER_POLYGON> corners{};
    for (std::size_t k = 0; k < place.size(); ++k) dtVcopy(&corners[3 * k], place.corner(k));
    if (dtPointInPolygon(end.data(), corners.data(), static_cast<int>(place.size()))) {
      return Landing{to, open[at]};
    }
    for (std::size_t k = 0, j = place.size() - 1; k < place.size(); j = k++) {
      const float* u = &corners[3 * j];
      const float* v = &corners[3 * k];
      float s = 0, t = 0;
      if (!dtIntersectSegSeg2D(u, v, start.data(), end.data(), s, t)) continue;
      if (!within(s) || !within(t)) continue;
      const dtPolyRef next = floor.beyond(open[at], j);
      if (next == 0) {
        std::array<float, 3> hit{};
        dtVlerp(hit.data(), u, v, s);
        const float before = nearest.distance;
        nearest.offer(hit, end.data());
        if (nearest.distance < before) best = open[at];
        continue;
      }
      if (std::find(open.begin(), open.begin() + static_cast<std::ptrdiff_t>(seen), next) !=
          open.begin() + static_cast<std::ptrdiff_t>(seen)) {
        continue;
      }
      float along = 0;
      if (dtDistancePtSegSqr2D(middle.data(), u, v, along) > reach * reach) continue;
      if (seen < open.size()) open[seen++] = next;
    }
  }
  if (best == 0) return std::nullopt;
  return Landing{point_of(nearest.point.data()), best};
}

// A point on an edge between two islands, as at walls without thickness, is on either.
Vec3f nudged_inside(const PolygonPlace& place, Vec3f point) {
  Vec3f middle;
  for (std::size_t k = 0; k < place.size(); ++k) middle += point_of(place.corner(k));
  const auto count = static_cast<float>(place.size());
  const Vec3f aside = Vec3f{middle.x / count, middle.y / count, middle.z / count} - point;
  const float far = length(aside);
  return point + kNudge * Vec3f{aside.x / far, aside.y / far, aside.z / far};
}

}  // namespace

Vec3f floor_step(const FloorQuery& floor, Navigation navigation, Vec3f from, Vec3f to,
                 Moves moves) {
  const auto start = floor.project(from), end = floor.project(to);
  if (!start || !end) return from;
  const int island = floor.island_of(start->polygon);
  if (floor.island_of(end->polygon) != island) return from;
  Visited visited;
  std::optional<Landing> landing = moves == Moves::kSlide ? slide(floor, *start, to, visited)
                                   : navigation == Navigation::kLatest
                                       ? stop_at_walls_of_slide(floor, *start, to)
                                       : stop_at_first_wall(floor, *start, to);
  if (!landing) return from;
  float height = 0;
  if (dtStatusSucceed(floor.query().getPolyHeight(landing->polygon, array_of(landing->point).data(),
                                                  &height))) {
    landing->point.y = height;
  }
  const auto there = floor.project(landing->point);
  if (!there || floor.island_of(there->polygon) != island) {
    return nudged_inside(floor.place(landing->polygon), landing->point);
  }
  return landing->point;
}

}  // namespace enfilade::continuous::habitat
