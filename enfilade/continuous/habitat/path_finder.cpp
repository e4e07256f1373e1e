#include "enfilade/continuous/habitat/path_finder.h"

#include <DetourCommon.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <unordered_map>

#include "enfilade/continuous/habitat/floor_query.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"

namespace enfilade::continuous::habitat {
namespace {

constexpr int kMostPathPolygons = 256;
constexpr float kAside = 0.01F;          // metres from the floor that count as on it
constexpr double kMostPixels = 1 << 28;  // of a map
constexpr std::size_t kRowsATask = 8;    // of a map
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr Vec3f kNowhere{kNaN, kNaN, kNaN};

float uniform() { return static_cast<float>(std::rand()) / static_cast<float>(RAND_MAX); }

// Triangles of the heights of one polygon: visit(corner, corner, corner).
template <class Visit>
void for_each_height_triangle(const PolygonPlace& place, const Visit& visit) {
  const auto number = place.polygon - place.tile->polys;
  const dtPolyDetail& detail = place.tile->detailMeshes[number];
  const auto corner = [&](unsigned char k) {
    return k < place.size()
               ? place.corner(k)
               : place.tile->detailVerts + std::size_t{3} * (detail.vertBase + (k - place.size()));
  };
  for (std::size_t t = 0; t < detail.triCount; ++t) {
    const unsigned char* at = place.tile->detailTris + std::size_t{4} * (detail.triBase + t);
    visit(corner(at[0]), corner(at[1]), corner(at[2]));
  }
}

float area_of(const PolygonPlace& place) {
  float sum = 0;
  for_each_height_triangle(place, [&](const float* a, const float* b, const float* c) {
    sum += 0.5F * length(cross(point_of(c) - point_of(b), point_of(a) - point_of(b)));
  });
  return sum;
}

}  // namespace

struct PathFinder::Impl {
  NavMesh mesh;
  Navigation navigation;
  FloorQuery floor;
  std::vector<float> areas;  // by island
  float area = 0;
  std::vector<dtPolyRef> corridor = std::vector<dtPolyRef>(kMostPathPolygons);
  std::vector<float> corners = std::vector<float>(std::size_t{3} * kMostPathPolygons);

  Impl(NavMesh made, Navigation which)
      : mesh(std::move(made)), navigation(which), floor(mesh), areas(floor.islands(), 0) {
    floor.for_each([&](dtPolyRef ref, const PolygonPlace& place) {
      const int island = floor.island_of(ref);
      if (island >= 0) areas[static_cast<std::size_t>(island)] += area_of(place);
    });
    area = summed_as_habitat();
  }

  // A sum in float32 depends on its order, which is that of a hash table of the islands in Habitat.
  float summed_as_habitat() const {
    std::unordered_map<std::uint32_t, float> table;
    for (std::size_t k = 0; k < areas.size(); ++k) {
      table.emplace(static_cast<std::uint32_t>(k), areas[k]);
    }
    std::vector<float> order;
    for (const auto& [island, value] : table) order.push_back(value);
    float sum = 0;
    for (std::size_t k = order.size(); k-- > 0;) sum += order[k];
    return sum;
  }

  bool same_island(const OnFloor& a, const OnFloor& b) const {
    return floor.island_of(a.polygon) == floor.island_of(b.polygon);
  }

  // Between points as asked, which are on the floor at `from` and `to`.
  Path path(Vec3f start, const OnFloor& from, Vec3f end, const OnFloor& to) {
    if (from.point == to.point) return {.points = {start, end}, .length = 0};
    if (!same_island(from, to)) return {};
    const auto a = array_of(start), b = array_of(end);
    int polygons = 0, count = 0;
    const dtStatus searched =
        floor.query().findPath(from.polygon, to.polygon, a.data(), b.data(), &floor.filter(),
                               corridor.data(), &polygons, kMostPathPolygons);
    if (dtStatusFailed(searched) || polygons == 0) return {};
    const dtStatus pulled =
        floor.query().findStraightPath(a.data(), b.data(), corridor.data(), polygons,
                                       corners.data(), nullptr, nullptr, &count, kMostPathPolygons);
    if (dtStatusFailed(pulled) || count == 0) return {};
    Path out{.points = {}, .length = 0};
    for (int k = 0; k < count; ++k) {
      out.points.push_back(point_of(&corners[std::size_t{3} * static_cast<std::size_t>(k)]));
      if (k > 0)
        out.length += enfilade::length(out.points.back() - out.points[out.points.size() - 2]);
    }
    if (count == 1) out.points.push_back(out.points.front());
    return out;
  }

  template <class Draw>
  Vec3f draw_until(int most_tries, const Draw& fits) const {
    for (int k = 0; k < most_tries; ++k) {
      dtPolyRef polygon = 0;
      std::array<float, 3> at{};
      const dtStatus status =
          floor.query().findRandomPoint(&floor.filter(), uniform, &polygon, at.data());
      if (dtStatusSucceed(status) && fits(at.data())) return point_of(at.data());
    }
    return kNowhere;
  }

  bool on_island(dtPolyRef ref, int island) const {
    return island == kAnyIsland || floor.island_of(ref) == island;
  }

  template <class T, class Value>
  FloorMap<T> map(float metres_per_pixel, Value value) const {
    if (!(metres_per_pixel > 0)) {
      throw ArgumentError(fmt::format("meters_per_pixel: {}, not above 0", metres_per_pixel));
    }
    const float across = (mesh.high.x - mesh.low.x) / metres_per_pixel;
    const float along = (mesh.high.z - mesh.low.z) / metres_per_pixel;
    if (!(double{across} * double{along} <= kMostPixels)) {
      throw ArgumentError(fmt::format("meters_per_pixel: {}, a map of {:.0f} x {:.0f} pixels",
                                      metres_per_pixel, across, along));
    }
    FloorMap<T> out{static_cast<std::size_t>(along), static_cast<std::size_t>(across), {}};
    out.values.resize(out.rows * out.columns);
    // Summed up, as in Habitat: not low + k * metres_per_pixel, to the last bits.
    const auto places = [&](float first, std::size_t count) {
      std::vector<float> at;
      for (std::size_t k = 0; k < count; ++k, first += metres_per_pixel) at.push_back(first);
      return at;
    };
    const std::vector<float> xs = places(mesh.low.x, out.columns);
    const std::vector<float> zs = places(mesh.low.z, out.rows);
    parallel_for(out.rows, kRowsATask, 0, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row) {
        for (std::size_t column = 0; column < out.columns; ++column) {
          out.values[row * out.columns + column] = value(xs[column], zs[row]);
        }
      }
    });
    return out;
  }
};

PathFinder::PathFinder(NavMesh mesh, Navigation navigation)
    : impl_(std::make_unique<Impl>(std::move(mesh), navigation)) {}
PathFinder::~PathFinder() = default;
PathFinder::PathFinder(PathFinder&&) noexcept = default;
PathFinder& PathFinder::operator=(PathFinder&&) noexcept = default;

const NavMesh& PathFinder::mesh() const noexcept { return impl_->mesh; }
Navigation PathFinder::navigation() const noexcept { return impl_->navigation; }
std::size_t PathFinder::islands() const noexcept { return impl_->floor.islands(); }

int PathFinder::island(Vec3f point) const {
  const auto at = impl_->floor.project(point);
  return at ? impl_->floor.island_of(at->polygon) : -1;
}

float PathFinder::island_radius(Vec3f point) const {
  const int at = island(point);
  return at < 0 ? 0 : impl_->floor.radius(static_cast<std::size_t>(at));
}

float PathFinder::island_radius(std::size_t island) const {
  EN_CHECK(island < islands());
  return impl_->floor.radius(island);
}

float PathFinder::island_area(std::size_t island) const {
  EN_CHECK(island < islands());
  return impl_->areas[island];
}

float PathFinder::area() const noexcept { return impl_->area; }

Vec3f PathFinder::snap(Vec3f point, int island) const {
  const auto at = impl_->floor.project(point, island);
  return at ? at->point : kNowhere;
}

bool PathFinder::is_navigable(Vec3f point, float most_dy) const {
  const auto at = impl_->floor.project(point);
  if (!at) return false;
  const float dx = at->point.x - point.x, dz = at->point.z - point.z;
  return std::abs(at->point.y - point.y) <= most_dy && std::sqrt(dx * dx + dz * dz) <= kAside;
}

Obstacle PathFinder::closest_obstacle(Vec3f point, float radius) const {
  const auto at = impl_->floor.project(point);
  if (!at) return {};
  Obstacle out;
  std::array<float, 3> position{}, normal{};
  impl_->floor.query().findDistanceToWall(at->polygon, array_of(at->point).data(), radius,
                                          &impl_->floor.filter(), &out.distance, position.data(),
                                          normal.data());
  out.position = point_of(position.data());
  out.normal = point_of(normal.data());
  return out;
}

Path PathFinder::path(Vec3f start, Vec3f end) const {
  const auto from = impl_->floor.project(start), to = impl_->floor.project(end);
  return from && to ? impl_->path(start, *from, end, *to) : Path{};
}

GoalPath PathFinder::path(Vec3f start, std::span<const Vec3f> goals, GoalBounds& bounds) const {
  GoalPath out;
  bounds.least.resize(goals.size(), 0);
  const auto from = impl_->floor.project(start);
  if (!from) return out;
  const float moved = path(start, bounds.start).length;
  bounds.start = start;
  struct Candidate {
    float bound;
    int goal;
    OnFloor at;
  };
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < goals.size(); ++k) {
    const auto at = impl_->floor.project(goals[k]);
    float& bound = bounds.least[k];
    bound = std::max(bound - moved, enfilade::length(start - goals[k]));
    if (at) candidates.push_back({bound, static_cast<int>(k), *at});
  }
  std::ranges::sort(candidates, {}, &Candidate::bound);
  for (const Candidate& candidate : candidates) {
    if (candidate.bound > out.path.length) continue;
    const auto goal = static_cast<std::size_t>(candidate.goal);
    Path found = impl_->path(start, *from, goals[goal], candidate.at);
    if (!(found.length < out.path.length)) continue;
    bounds.least[goal] = found.length;
    out = {std::move(found), candidate.goal};
  }
  return out;
}

void PathFinder::seed(std::uint32_t seed) noexcept { std::srand(seed); }

Vec3f PathFinder::random_point(int most_tries, int island) const {
  const auto draw = [&] {
    return impl_->draw_until(most_tries, [](const float*) { return true; });
  };
  if (island == kAnyIsland) return draw();
  return impl_->floor.with_only(
      [&](dtPolyRef ref, const PolygonPlace&) { return impl_->on_island(ref, island); }, draw);
}

Vec3f PathFinder::random_point_near(Vec3f centre, float radius, int most_tries, int island) const {
  const auto middle = array_of(centre);
  const auto touches = [&](dtPolyRef ref, const PolygonPlace& place) {
    if (!impl_->on_island(ref, island)) return false;
    for (std::size_t k = 0; k < place.size(); ++k) {
      // Habitat takes three sides of any polygon, the third of which goes back to the first corner.
      float along = 0;
      if (dtDistancePtSegSqr2D(middle.data(), place.corner(k), place.corner((k + 1) % 3), along) <
          radius * radius) {
        return true;
      }
    }
    return false;
  };
  return impl_->floor.with_only(touches, [&] {
    return impl_->draw_until(most_tries, [&](const float* at) {
      return dtVdist2DSqr(at, middle.data()) < radius * radius;
    });
  });
}

Vec3f PathFinder::step(Vec3f from, Vec3f to, Moves moves) const {
  return floor_step(impl_->floor, impl_->navigation, from, to, moves);
}

std::vector<Vec3f> PathFinder::vertices(int island) const {
  std::vector<Vec3f> out;
  impl_->floor.for_each([&](dtPolyRef ref, const PolygonPlace& place) {
    if (!impl_->on_island(ref, island)) return;
    for_each_height_triangle(place, [&](const float* a, const float* b, const float* c) {
      for (const float* corner : {a, b, c}) out.push_back(point_of(corner));
    });
  });
  return out;
}

FloorMap<std::uint8_t> PathFinder::topdown(float metres_per_pixel, float height, float eps) const {
  return impl_->map<std::uint8_t>(metres_per_pixel, [&](float x, float z) {
    return is_navigable({x, height, z}, eps) ? std::uint8_t{1} : std::uint8_t{0};
  });
}

FloorMap<std::int32_t> PathFinder::topdown_islands(float metres_per_pixel, float height,
                                                   float eps) const {
  return impl_->map<std::int32_t>(metres_per_pixel, [&](float x, float z) {
    const Vec3f at{x, height, z};
    return is_navigable(at, eps) ? std::int32_t{island(at)} : std::int32_t{-1};
  });
}

}  // namespace enfilade::continuous::habitat
