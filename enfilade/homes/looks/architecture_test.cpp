#include "enfilade/homes/looks/architecture.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "enfilade/core/rng.h"
#include "enfilade/homes/home.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::homes::looks {
namespace EN_UNIT {

/// A home without furniture.
Home bare_home(const PlanOptions& options) {
  Home home;
  home.plan = make_plan(options);
  mesh::MeshBuilder builder(home.mesh);
  const auto styles = make_styles(home.plan, builder);
  build_architecture(home.plan, styles, {builder, home.obstacles, home.things, home.lights.lamps},
                     home.lights.portals);
  return home;
}

PlanOptions some_options(std::uint64_t seed) {
  switch (seed % 4) {
    case 0:
      return {seed, HomeKind::kHouse, 2, 200};
    case 1:
      return {seed, HomeKind::kFlat, {}, 90};
    case 2:
      return {seed, HomeKind::kOffice, 3, 450};
    default:
      return {seed, {}, {}, 0};
  }
}

Vec3d middle_of(const Home& home, std::size_t room, double above) {
  const Rect& f = home.plan.rooms[room].floor;
  return {(f.x0 + f.x1) / 2, (f.y0 + f.y1) / 2,
          home.plan.storeys[home.plan.rooms[room].storey].floor + above};
}

TEST(Architecture, MeshIsWhole) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Home home = bare_home(some_options(seed));
    EXPECT_TRUE(mesh::check(home.mesh, "home").empty());
    for (const mesh::Object& o : home.mesh.objects) {
      EXPECT_GE(o.region, -1);
      EXPECT_LT(o.region, static_cast<int>(home.plan.rooms.size()));
    }
  }
}

// Rays from rooms meet something of the building, unless they leave through a window; and what
// they meet faces them: nobody looks at the back of a face.
TEST(Architecture, RoomsAreClosedAndFacesLookInward) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Home home = bare_home(some_options(seed));
    const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(home.mesh));
    Rng rng(seed);
    std::size_t backs = 0, rays = 0;
    for (std::size_t r = 0; r < home.plan.rooms.size(); ++r) {
      const Vec3d eye = middle_of(home, r, 1.73);
      for (int i = 0; i < 400; ++i) {
        const double z = 2 * rng.uniform() - 1, a = 2 * std::numbers::pi * rng.uniform();
        const double s = std::sqrt(1 - z * z);
        const Vec3d way{s * std::cos(a), s * std::sin(a), z};
        const mesh::Hit hit = tracer.trace({to_float(eye), to_float(way)});
        ++rays;
        const Rect& out = home.plan.outline;
        const double reach = hit ? double(hit.distance) : 1e3;
        const Vec3d end{eye.x + reach * way.x, eye.y + reach * way.y, eye.z + reach * way.z};
        if (hit && end.x > out.x0 && end.x < out.x1 && end.y > out.y0 && end.y < out.y1) {
          const Vec3f n = home.mesh.normals[hit.triangle][0];
          // Round bars have round normals: at their rims those look away.
          const auto object = home.mesh.triangle_object[hit.triangle];
          const bool round = home.mesh.objects[object].category == mesh::Mpcat40::kRailing;
          if (!round && double(n.x) * way.x + double(n.y) * way.y + double(n.z) * way.z > 0)
            ++backs;
          continue;
        }
        // It left: where it crosses the outline's edge must be a window.
        double t = 1e9;
        if (way.x > 0) t = std::min(t, (out.x1 - eye.x) / way.x);
        if (way.x < 0) t = std::min(t, (out.x0 - eye.x) / way.x);
        if (way.y > 0) t = std::min(t, (out.y1 - eye.y) / way.y);
        if (way.y < 0) t = std::min(t, (out.y0 - eye.y) / way.y);
        const Vec3d at{eye.x + t * way.x, eye.y + t * way.y, eye.z + t * way.z};
        const bool window = std::any_of(
            home.plan.openings.begin(), home.plan.openings.end(), [&](const Opening& o) {
              if (o.kind != OpeningKind::kWindow) return false;
              const double floor = home.plan.storeys[home.plan.rooms[o.room0].storey].floor;
              const double u = o.along_x ? at.x : at.y, n = o.along_x ? at.y : at.x;
              return std::abs(n - o.wall) < 0.2 && u > o.from && u < o.to &&
                     at.z > floor + o.sill && at.z < floor + o.head;
            });
        EXPECT_TRUE(window) << "seed " << seed << " room " << r << " leaves at " << at.x << " "
                            << at.y << " " << at.z;
      }
    }
    EXPECT_EQ(backs, 0U) << "of " << rays << ", seed " << seed;
  }
}

bool inside(const Obstacle& o, Vec3d p, double slack) {
  const double c = std::cos(o.turned), s = std::sin(o.turned);
  const double x = c * (p.x - o.x) + s * (p.y - o.y), y = -s * (p.x - o.x) + c * (p.y - o.y);
  return std::abs(x) <= o.half_x + slack && std::abs(y) <= o.half_y + slack &&
         p.z >= o.z0 - slack && p.z <= o.z1 + slack;
}

// Whatever a ray meets at the height of a body is an obstacle.
TEST(Architecture, EverythingSolidIsAnObstacle) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Home home = bare_home(some_options(seed));
    const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(home.mesh));
    Rng rng(seed);
    for (std::size_t r = 0; r < home.plan.rooms.size(); ++r) {
      for (int i = 0; i < 300; ++i) {
        const Vec3d eye = middle_of(home, r, 0.05 + 2.1 * rng.uniform());
        if (std::any_of(home.obstacles.begin(), home.obstacles.end(),
                        [&](const Obstacle& o) { return inside(o, eye, 0.01); })) {
          continue;
        }
        const double a = 2 * std::numbers::pi * rng.uniform();
        const Vec3d way{std::cos(a), std::sin(a), 0};
        const mesh::Hit hit = tracer.trace({to_float(eye), to_float(way)});
        if (!hit) continue;
        const double d = double(hit.distance);
        const Vec3d at{eye.x + d * way.x, eye.y + d * way.y, eye.z};
        const auto object = home.mesh.triangle_object[hit.triangle];
        if (home.mesh.objects[object].region < 0) continue;
        // Handles' bars and balusters are round; their obstacles are boxes around them.
        EXPECT_TRUE(std::any_of(home.obstacles.begin(), home.obstacles.end(),
                                [&](const Obstacle& o) { return inside(o, at, 0.03); }))
            << home.mesh.objects[object].name << " at " << at.x << " " << at.y << " " << at.z
            << ", seed " << seed;
      }
    }
  }
}

TEST(Architecture, ThingsAreOfTheirObjects) {
  const Home home = bare_home({3, HomeKind::kHouse, 2, 220});
  bool door = false, stairs = false, window = false;
  for (const HomeThing& t : home.things) {
    ASSERT_LT(t.object, home.mesh.objects.size());
    EXPECT_LE(t.low.x, t.high.x);
    EXPECT_LE(t.low.y, t.high.y);
    EXPECT_LT(t.low.z, t.high.z);
    door = door || t.noun == "door";
    stairs = stairs || t.noun == "stairs";
    window = window || t.noun == "window";
  }
  EXPECT_TRUE(door && stairs && window);
}

TEST(Architecture, RoomSpacesKnowHolesAndLeaves) {
  const Plan plan = make_plan({3, HomeKind::kHouse, 2, 220});
  const auto spaces = room_spaces(plan);
  ASSERT_EQ(spaces.size(), plan.rooms.size());
  std::size_t holes = 0, expected = 0;
  for (const RoomSpace& s : spaces) {
    holes += s.holes.size();
    for (const auto& h : s.holes) {
      const auto [from, to] = s.floor.range(runs_along_x(h.wall));
      EXPECT_GE(h.from, from);
      EXPECT_LE(h.to, to);
      EXPECT_LT(h.head, s.ceiling_z - s.floor_z);
    }
  }
  for (const Opening& o : plan.openings) expected += o.room1 ? 2U : 1U;
  EXPECT_EQ(holes, expected);
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::looks
