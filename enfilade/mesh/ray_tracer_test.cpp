#include "enfilade/mesh/ray_tracer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "enfilade/core/rng.h"
#include "tests/support/assembly.h"

namespace enfilade::mesh {

using tests::Assembly;

namespace EN_UNIT {

// Distances are compared with EXPECT_FLOAT_EQ, which allows 4 units in the last place. Embree
// multiplies by a reciprocal that it refines from the processor's estimate, and estimates differ
// between processors of Intel and AMD.

constexpr float kInfinity = std::numeric_limits<float>::infinity();

RayTracer tracer_of(const Assembly& assembly) {
  return RayTracer(std::make_shared<const Mesh>(assembly.mesh));
}

float uniform(Rng& rng, double low, double high) {
  return static_cast<float>(low + (high - low) * rng.uniform());
}
Vec3f any_point(Rng& rng, double reach) {
  return {uniform(rng, -reach, reach), uniform(rng, -reach, reach), uniform(rng, -reach, reach)};
}

TEST(RayTracer, MeetsTheNearSideOfABox) {
  Assembly assembly;
  assembly.box(assembly.material({1, 1, 1}), {1, -1, -1}, {3, 1, 1});
  const RayTracer tracer = tracer_of(assembly);
  // Distances are in units of the direction's length.
  EXPECT_FLOAT_EQ(tracer.trace({{0, 0, 0}, {1, 0, 0}}).distance, 1);
  EXPECT_FLOAT_EQ(tracer.trace({{0, 0, 0}, {0.5F, 0, 0}}).distance, 2);
  EXPECT_FLOAT_EQ(tracer.trace({{5, 0.5F, 0.25F}, {-1, 0, 0}}).distance, 2);
  EXPECT_FLOAT_EQ(tracer.trace({{2, 0.5F, 0.25F}, {0, 0, 1}}).distance, 0.75F);  // from within
  EXPECT_FALSE(tracer.trace({{0, 0, 0}, {-1, 0, 0}}));
  EXPECT_FALSE(tracer.trace({{0, 1.01F, 0}, {1, 0, 0}}));
}

TEST(RayTracer, LooksBetweenNearAndFarOnly) {
  Assembly assembly;
  assembly.box(assembly.material({1, 1, 1}), {1, -1, -1}, {3, 1, 1});
  const RayTracer tracer = tracer_of(assembly);
  EXPECT_FLOAT_EQ(tracer.trace({{0, 0, 0}, {1, 0, 0}, 1.5F}).distance, 3);
  EXPECT_FALSE(tracer.trace({{0, 0, 0}, {1, 0, 0}, 0, 0.99F}));
  EXPECT_FALSE(tracer.blocked({{0, 0, 0}, {1, 0, 0}, 0, 0.99F}));
  EXPECT_FALSE(tracer.blocked({{0, 0, 0}, {1, 0, 0}, 1.1F, 2.9F}));
  EXPECT_TRUE(tracer.blocked({{0, 0, 0}, {1, 0, 0}, 1.1F, 3.1F}));
}

TEST(RayTracer, SaysWhereOnATiltedTriangle) {
  Assembly assembly;
  const Vec3f a{1, 0, 0}, b{0, 2, 0}, c{0, 0, 3};
  assembly.triangle(assembly.material({1, 1, 1}), {5, 5, 5}, {6, 5, 5}, {5, 6, 5});
  assembly.triangle(0, a, b, c);
  const RayTracer tracer = tracer_of(assembly);
  const Vec3f target = 0.5F * a + 0.3F * b + 0.2F * c;
  const Hit hit = tracer.trace({target + Vec3f{2, 1, 4}, {-1, -0.5F, -2}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit.triangle, 1U);
  // Coordinates of size 10 in floats, a few operations: 1e-5.
  EXPECT_NEAR(hit.distance, 2, 1e-5);
  EXPECT_NEAR(hit.u, 0.3, 1e-5);
  EXPECT_NEAR(hit.v, 0.2, 1e-5);
}

TEST(RayTracer, LetsRaysThroughCutOuts) {
  Assembly assembly;
  const std::uint32_t leaf = assembly.material({1, 1, 1}), wall = assembly.material({1, 1, 1});
  Material& material = assembly.mesh.materials[leaf];
  material.texture = image::Image8(2, 1, 4);  // left half nothing, right half leaf
  material.texture.pixels = {0, 0, 0, 0, 255, 255, 255, 255};
  material.cutout = 0.5F;
  assembly.quad(leaf, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  // The texture once over the quad.
  for (auto& corners : assembly.mesh.texture_points) {
    for (TexturePoint& point : corners) point = {point.u / 2, point.v / 2};
  }
  assembly.quad(wall, {-1, -1, -1}, {2, 0, 0}, {0, 2, 0});
  const RayTracer tracer = tracer_of(assembly);
  const std::vector<Ray> rays{{{-0.5F, 0.1F, 3}, {0, 0, -1}}, {{0.5F, 0.1F, 3}, {0, 0, -1}}};
  std::vector<Hit> hits(2);
  tracer.trace(rays, hits);
  EXPECT_FLOAT_EQ(hits[0].distance, 4);
  EXPECT_FLOAT_EQ(hits[1].distance, 3);
  EXPECT_FLOAT_EQ(tracer.trace(rays[0]).distance, 4);
  EXPECT_FALSE(tracer.sees({0.5F, 0.1F, 0.5F}, {0.5F, 0.1F, -0.5F}));
  EXPECT_TRUE(tracer.sees({-0.5F, 0.1F, 0.5F}, {-0.5F, 0.1F, -0.5F}));
}

TEST(RayTracer, GlowingSurfacesBlockUnlessTheyAreNotAskedFor) {
  Assembly assembly;
  assembly.quad(assembly.material({1, 1, 1}, {2, 2, 2}), {-1, -1, 1}, {2, 0, 0}, {0, 2, 0});
  assembly.quad(assembly.material({1, 1, 1}), {-1, -1, 2}, {2, 0, 0}, {0, 2, 0});
  const RayTracer tracer = tracer_of(assembly);
  const std::vector<Ray> rays{{{0, 0, 0}, {0, 0, 1}, 0, 1.5F}, {{0, 0, 0}, {0, 0, 1}}};
  std::vector<std::uint8_t> all(2), others(2);
  tracer.blocked(rays, all);
  tracer.blocked(rays, others, Blockers::kNotGlowing);
  EXPECT_EQ(all, (std::vector<std::uint8_t>{1, 1}));
  EXPECT_EQ(others, (std::vector<std::uint8_t>{0, 1}));
}

TEST(RayTracer, SeesUpToSurfacesWithinTheSlack) {
  Assembly assembly;
  assembly.quad(assembly.material({1, 1, 1}), {-1, -1, 1}, {2, 0, 0}, {0, 2, 0});
  const RayTracer tracer = tracer_of(assembly);
  EXPECT_FALSE(tracer.sees({0, 0, 0}, {0, 0, 2}));
  EXPECT_TRUE(tracer.sees({0, 0, 0}, {0, 0, 1}));
  EXPECT_FALSE(tracer.sees({0, 0, 0}, {0, 0, 1.1F}));
  EXPECT_TRUE(tracer.sees({0, 0, 0}, {0, 0, 1.1F}, 0.2F));
  EXPECT_TRUE(tracer.sees({0, 0, 1}, {0, 0, 1}));
}

// Moeller and Trumbore in double precision over all triangles.
std::optional<double> slow_distance(const Mesh& mesh, const Ray& ray) {
  const Vec3d direction = to_double(ray.direction);
  std::optional<double> nearest;
  for (const auto& corners : mesh.triangles) {
    const Vec3d a = to_double(mesh.positions[corners[0]]);
    const Vec3d u = to_double(mesh.positions[corners[1]]) - a,
                v = to_double(mesh.positions[corners[2]]) - a;
    const Vec3d p = cross(direction, v);
    const double determinant = dot(u, p);
    const Vec3d from = to_double(ray.origin) - a, q = cross(from, u);
    const double s = dot(from, p) / determinant, r = dot(direction, q) / determinant;
    const double t = dot(v, q) / determinant;
    if (s < 0 || r < 0 || s + r > 1 || t < 0) continue;
    if (!nearest || t < *nearest) nearest = t;
  }
  return nearest;
}

TEST(RayTracer, AgreesWithASlowOneOnRandomRays) {
  Rng rng(7);
  Assembly assembly;
  const std::uint32_t grey = assembly.material({0.5F, 0.5F, 0.5F});
  for (int i = 0; i < 300; ++i) {
    const Vec3f at = any_point(rng, 3);
    assembly.triangle(grey, at, at + any_point(rng, 1), at + any_point(rng, 1));
  }
  const RayTracer tracer = tracer_of(assembly);
  constexpr std::size_t kRays = 20'000;
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < kRays; ++i) rays.push_back({any_point(rng, 4), any_point(rng, 1)});
  std::vector<Hit> hits(kRays);
  std::vector<std::uint8_t> blocked(kRays);
  tracer.trace(rays, hits);
  tracer.blocked(rays, blocked);
  std::size_t met = 0, other = 0;
  for (std::size_t i = 0; i < kRays; ++i) {
    const std::optional<double> slow = slow_distance(assembly.mesh, rays[i]);
    const Hit single = tracer.trace(rays[i]);
    met += slow ? 1 : 0;
    // Floats of size 4: 1e-6 of it; grazing hits are worse by the slant.
    const bool same = slow ? std::abs(hits[i].distance - *slow) < 1e-3 * (1 + *slow) : !hits[i];
    const bool alike =
        hits[i] ? std::abs(single.distance - hits[i].distance) <= 1e-3F * (1 + single.distance)
                : !single;
    if (!same || !alike || (blocked[i] != 0) != slow.has_value()) ++other;
  }
  EXPECT_GT(met, kRays / 4);
  // Rays through an edge within a float's resolution may fall to either side of it.
  EXPECT_LE(other, 4U);
}

TEST(RayTracer, NoRayEscapesAClosedBox) {
  Rng rng(3);
  Assembly assembly;
  assembly.hollow(assembly.material({1, 1, 1}), {-2.1F, -1.7F, 0.1F}, {3.3F, 2.9F, 2.7F});
  const RayTracer tracer = tracer_of(assembly);
  std::vector<Ray> rays;
  for (int i = 0; i < 100'000; ++i) {
    const Vec3f from{uniform(rng, -2, 3), uniform(rng, -1.6, 2.8), uniform(rng, 0.2, 2.6)};
    // Every other ray at a point of an edge, where two sides meet.
    Vec3f to{uniform(rng, -2.1, 3.3), 2.9F, 2.7F};
    if (i % 2 == 0) to = from + any_point(rng, 1);
    rays.push_back({from, to - from});
  }
  std::vector<Hit> hits(rays.size());
  tracer.trace(rays, hits);
  for (const Hit& hit : hits) ASSERT_LT(hit.distance, kInfinity);
}

TEST(RayTracer, TakesAnyNumberOfRays) {
  Assembly assembly;
  assembly.quad(assembly.material({1, 1, 1}), {-9, -9, 1}, {18, 0, 0}, {0, 18, 0});
  const RayTracer tracer = tracer_of(assembly);
  for (const std::size_t n : {0U, 1U, 15U, 16U, 17U, 100U}) {
    const std::vector<Ray> rays(n, Ray{{0, 0.5F, 0}, {0, 0, 1}});
    std::vector<Hit> hits(n);
    tracer.trace(rays, hits);
    for (const Hit& hit : hits) EXPECT_FLOAT_EQ(hit.distance, 1);
  }
}

TEST(RayTracer, RefusesAMeshThatMeansNothing) {
  EXPECT_THROW(RayTracer(std::make_shared<const Mesh>()), InvalidInput);
  Assembly assembly;
  assembly.quad(assembly.material({1, 1, 1}), {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  assembly.mesh.triangles[1][2] = 99;
  EXPECT_THROW(tracer_of(assembly), InvalidInput);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
