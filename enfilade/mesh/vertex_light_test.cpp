#include "enfilade/mesh/lighting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/image/tone.h"
#include "tests/support/assembly.h"

namespace enfilade::mesh {

using tests::Assembly;

namespace EN_UNIT {

/// A floor of 4 x 4 m, a part of it below a sheet that keeps the sun off; no other light.
LitMesh half_in_the_sun() {
  Assembly assembly;
  assembly.object("floor", 2);
  assembly.quad(assembly.material({0.5F, 0.5F, 0.5F}), {0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  assembly.quad(assembly.material({0, 0, 0}), {2.3F, -1, 1}, {3, 0, 0}, {0, 6, 0});
  Lights lights;
  lights.sky = {{}, {}, {}};
  lights.sun = {{0, 0, 1}, {2, 2, 2}};
  return LitMesh(std::make_shared<const RayTracer>(std::make_shared<const Mesh>(assembly.mesh)),
                 lights, {.bounces = 0, .threads = 1});
}

double area_of(const Mesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  return 0.5 * length(cross(mesh.positions[b] - mesh.positions[a],
                            mesh.positions[c] - mesh.positions[a]));
}

TEST(VertexLight, IsTheExposedLightOnTheFloor) {
  const LitMesh lit = half_in_the_sun();
  const Mesh mesh = with_vertex_light(lit, {.least_edge = 0.1, .most_edge = 1, .threads = 1});
  ASSERT_EQ(mesh.colours.size(), mesh.positions.size());
  const float sunny = 2 / std::numbers::pi_v<float> * image::kMidGrey<float> / lit.key();
  std::size_t in_sun = 0, in_shadow = 0;
  for (std::size_t k = 0; k < mesh.positions.size(); ++k) {
    const Vec3f p = mesh.positions[k];
    if (p.z != 0) continue;
    // Light is looked up 4 mm beside an edge at most, and there is no half-shadow.
    if (p.x < 2.29F) {
      EXPECT_NEAR(mesh.colours[k].x, sunny, 1e-4F * sunny) << p.x;
      ++in_sun;
    } else if (p.x > 2.31F) {
      EXPECT_EQ(mesh.colours[k].x, 0) << p.x;
      ++in_shadow;
    }
  }
  EXPECT_GT(in_sun, 10U);
  EXPECT_GT(in_shadow, 10U);
}

TEST(VertexLight, CutsWhereTheShadowEndsAndNoSurfaceIsLost) {
  const Mesh mesh = with_vertex_light(half_in_the_sun(), {.least_edge = 0.1, .threads = 1});
  double floor = 0, finest = 1e9;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangle_material[t] != 0) continue;
    floor += area_of(mesh, t);
    float low = 1e9F, high = -1e9F;
    for (const std::uint32_t corner : mesh.triangles[t]) {
      low = std::min(low, mesh.positions[corner].x);
      high = std::max(high, mesh.positions[corner].x);
    }
    if (low < 2.3F && high > 2.3F) finest = std::min<double>(finest, high - low);
    // An edge of 0.2 m is cut; of the halves none is longer than its diagonal.
    if (low < 2.29F && high > 2.31F) {
      EXPECT_LT(high - low, 0.3F);
    }
  }
  EXPECT_NEAR(floor, 16, 1e-4);  // sums of floats
  EXPECT_LT(finest, 0.3);
}

TEST(VertexLight, SharedEdgesAreCutInBothTriangles) {
  const Mesh mesh = with_vertex_light(half_in_the_sun(), {.least_edge = 0.1, .threads = 1});
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangle_material[t] != 0) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto ends = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      ++sides[{ends.first, ends.second}];
    }
  }
  for (const auto& [ends, count] : sides) {
    if (count == 2) continue;
    // An edge with one triangle lies on the floor's rim: else there would be a gap in the middle.
    const Vec3f a = mesh.positions[ends.first], b = mesh.positions[ends.second];
    const bool rim =
        (a.x == b.x && (a.x == 0 || a.x == 4)) || (a.y == b.y && (a.y == 0 || a.y == 4));
    EXPECT_TRUE(rim) << a.x << ' ' << a.y << " to " << b.x << ' ' << b.y;
  }
}

TEST(VertexLight, WhatShinesShowsItsOwnLight) {
  Assembly assembly;
  assembly.hollow(assembly.material({0.5F, 0.5F, 0.5F}), {0, 0, 0}, {2, 2, 2});
  assembly.quad(assembly.material({0.1F, 0.1F, 0.1F}, {50, 50, 50}), {0.5F, 0.5F, 1.9F}, {0, 1, 0},
                {1, 0, 0});
  Lights lights;
  lights.sky = {{}, {}, {}};
  const LitMesh lit(std::make_shared<const RayTracer>(std::make_shared<const Mesh>(assembly.mesh)),
                    lights, {.threads = 1});
  const Mesh mesh = with_vertex_light(lit, {.threads = 1});
  EXPECT_EQ(mesh.materials[1].colour, (Vec3f{1, 1, 1}));
  EXPECT_EQ(mesh.materials[1].emission, Vec3f{});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangle_material[t] != 1) continue;
    for (const std::uint32_t k : mesh.triangles[t]) EXPECT_EQ(mesh.colours[k], (Vec3f{1, 1, 1}));
  }
}

TEST(VertexLight, LightThatIsKeptSomewhereIsTakenAsItIs) {
  const LitMesh lit = half_in_the_sun();
  // Red in the north, green in the south; exposed already.
  const auto kept = [&lit](std::span<const SurfacePoint> points, std::span<Vec3f> radiance) {
    for (std::size_t k = 0; k < points.size(); ++k) {
      const auto& [a, b, c] = lit.mesh().triangles[points[k].triangle];
      const auto& p = lit.mesh().positions;
      const float y =
          (1 - points[k].u - points[k].v) * p[a].y + points[k].u * p[b].y + points[k].v * p[c].y;
      radiance[k] = y > 2 ? Vec3f{0.5F, 0, 0} : Vec3f{0, 0.25F, 0};
    }
  };
  const Mesh mesh = with_vertex_light(lit.mesh(), {kept, 1}, {.least_edge = 0.1, .threads = 2});
  std::size_t red = 0, green = 0;
  for (std::size_t k = 0; k < mesh.positions.size(); ++k) {
    const float y = mesh.positions[k].y;
    if (y > 2.01F) {
      EXPECT_EQ(mesh.colours[k], (Vec3f{0.5F, 0, 0})) << y;
      ++red;
    } else if (y < 1.99F) {
      EXPECT_EQ(mesh.colours[k], (Vec3f{0, 0.25F, 0})) << y;
      ++green;
    }
  }
  EXPECT_GT(red, 10U);
  EXPECT_GT(green, 10U);
  EXPECT_THROW(with_vertex_light(lit.mesh(), {}), ArgumentError);
}

TEST(VertexLight, ThreadsChangeNothingAndOptionsAreChecked) {
  const LitMesh lit = half_in_the_sun();
  const Mesh one = with_vertex_light(lit, {.threads = 1}),
             two = with_vertex_light(lit, {.threads = 2});
  EXPECT_EQ(one.triangles, two.triangles);
  EXPECT_EQ(one.colours, two.colours);
  EXPECT_LE(with_vertex_light(lit, {.most_triangles = 40}).triangles.size(), 40U);
  EXPECT_THROW(with_vertex_light(lit, {.least_edge = 0}), ArgumentError);
  EXPECT_THROW(with_vertex_light(lit, {.least_edge = 1, .most_edge = 0.5}), ArgumentError);
  EXPECT_THROW(with_vertex_light(lit, {.tolerance = 0}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
