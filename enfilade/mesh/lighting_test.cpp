#include "enfilade/mesh/lighting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>

#include "enfilade/mesh/light/scene.h"
#include "tests/support/assembly.h"

namespace enfilade::mesh {

using tests::Assembly;

namespace EN_UNIT {

constexpr float kPi = std::numbers::pi_v<float>;

Lights darkness() {
  Lights lights;
  lights.sky = {{}, {}, {}};
  return lights;
}
Lights even_sky(float radiance) {
  Lights lights = darkness();
  const Vec3f all{radiance, radiance, radiance};
  lights.sky = {all, all, all};
  return lights;
}

LitMesh lit(const Assembly& assembly, const Lights& lights, const BakeOptions& options = {}) {
  const auto mesh = std::make_shared<const Mesh>(assembly.mesh);
  return LitMesh(std::make_shared<const RayTracer>(mesh), lights, options);
}

Vec3f look(const LitMesh& mesh, Vec3f from, Vec3f towards) {
  const Ray ray{from, towards};
  Vec3f radiance;
  mesh.look({&ray, 1}, {&radiance, 1});
  return radiance;
}
Vec3f look_down(const LitMesh& mesh, float x, float y, float z = 1) {
  return look(mesh, {x, y, z}, {0, 0, -1});
}

TEST(Lighting, FurnaceIsAsBrightAsItsSumOfReflections) {
  Assembly assembly;
  assembly.hollow(assembly.material({0.5F, 0.5F, 0.5F}, {1, 1, 1}), {0, 0, 0}, {3, 4, 2.5F});
  for (const std::uint32_t bounces : {0U, 1U, 4U}) {
    BakeOptions options;
    options.bounces = bounces;
    const LitMesh mesh = lit(assembly, darkness(), options);
    // 1 + 1/2 + ... + (1/2)^(bounces + 1)
    const double expected = 2 - std::pow(0.5, bounces + 1);
    for (const Vec3f way : {Vec3f{1, 0.2F, 0.1F}, Vec3f{-1, 1, 1}, Vec3f{0, 0, -1}}) {
      EXPECT_NEAR(look(mesh, {1.5F, 2, 1.2F}, way).y, expected, 1e-4);  // sums of floats
    }
    EXPECT_NEAR(mesh.key(), expected - 1, 1e-4);  // the surface's own glow is not light on it
  }
}

TEST(Lighting, LampOverAFloorFallsOffAsItShould) {
  Assembly assembly;
  assembly.quad(assembly.material({0.6F, 0.6F, 0.6F}), {-6, -6, 0}, {12, 0, 0}, {0, 12, 0});
  Lights lights = darkness();
  lights.lamps.push_back({{0.2F, 0.1F, 2}, {3, 2, 1}, 0.1F});
  const LitMesh mesh = lit(assembly, lights);
  for (const float x : {0.2F, 0.7F, 1.33F, 2.9F, 4.7F}) {
    const double square = 4 + (x - 0.2) * (x - 0.2);
    const double irradiance = 3 * 2 / (square * std::sqrt(square));
    const Vec3f seen = look_down(mesh, x, 0.1F);
    // Straight lines between points 0.3 m apart under a lamp at 2 m: 0.3^2 / 8 of the curvature,
    // about 1 %.
    EXPECT_NEAR(seen.x, 0.6 / kPi * irradiance, 0.012 * 0.6 / kPi * irradiance) << x;
    EXPECT_NEAR(seen.y / seen.x, 2.0 / 3, 1e-4);
  }
  EXPECT_EQ(look(mesh, {0, 0, -1}, {0, 0, 1}), Vec3f{}) << "the floor's other side is dark";
}

// Below the edge of a sheet 1 m above the floor, the share of the sun's disc that is seen.
TEST(Lighting, ASunWithSizeHasSoftShadows) {
  Assembly assembly;
  assembly.quad(assembly.material({0.5F, 0.5F, 0.5F}), {-4, -4, 0}, {8, 0, 0}, {0, 8, 0});
  assembly.quad(assembly.material({0, 0, 0}), {0, -4, 1}, {3, 0, 0}, {0, 8, 0});
  Lights lights = darkness();
  lights.sun = {{0, 0, 1}, {2, 2, 2}, 0.1F};
  const LitMesh mesh = lit(assembly, lights, {.bounces = 0});
  const float sunny = 0.5F * 2 / kPi;
  const auto seen = [&](float x) {
    std::array<Ray, kSunParts> rays;
    std::array<Vec3f, kSunParts> radiance;
    rays.fill({{x, 0.3F, 0.5F}, {0, 0, -1}});
    mesh.look(rays, radiance);
    return radiance;
  };
  const double edge = std::tan(0.1);  // metres from the middle of the edge to its end
  for (const double into : {-1.05, -0.9, -0.5, -0.2, 0.0, 0.2, 0.5, 0.9, 1.05}) {
    const auto radiance = seen(static_cast<float>(into * edge));
    const double t = std::clamp(into, -1.0, 1.0);
    const double share = (std::acos(t) - t * std::sqrt(1 - t * t)) / kPi;  // of a disc
    double sum = 0;
    for (std::size_t four = 0; four < kSunParts; four += 4) {
      double part = 0;
      for (std::size_t k = four; k < four + 4; ++k) part += radiance[k].x / sunny;
      EXPECT_NEAR(part / 4, share, 0.4) << into << ": a pixel's four rays";
      sum += part;
    }
    // For edges in any direction, the count of parts is at most 2.3 off, and that of four 1.6.
    EXPECT_NEAR(sum / kSunParts, share, 2.3 / kSunParts) << into;
    if (std::abs(into) > 1) {
      EXPECT_NEAR(sum / kSunParts, into < 0 ? 1 : 0, 1e-5) << "outside of the edge nothing changes";
    }
  }
  lights.sun.radius = 0;
  const LitMesh sharp = lit(assembly, lights, {.bounces = 0});
  EXPECT_NEAR(look_down(sharp, -0.01F, 0.3F, 0.5F).x, sunny, 1e-5);
  EXPECT_EQ(look_down(sharp, 0.01F, 0.3F, 0.5F).x, 0);
  lights.sun.radius = -0.1F;
  EXPECT_THROW(lit(assembly, lights), ArgumentError);
}

TEST(Lighting, OpenFloorUnderAnEvenSkyGetsPiTimesItsRadiance) {
  Assembly assembly;
  assembly.quad(assembly.material({0.6F, 0.3F, 0.1F}), {-6, -6, 0}, {12, 0, 0}, {0, 12, 0});
  const LitMesh mesh = lit(assembly, even_sky(2));
  const Vec3f seen = look_down(mesh, 1, 2);
  EXPECT_NEAR(seen.x, 1.2, 1e-4);
  EXPECT_NEAR(seen.z, 0.2, 1e-4);
  EXPECT_NEAR(look(mesh, {0, 0, 1}, {0, 3, 4}).x, 2, 1e-6);
}

TEST(Lighting, SunShinesWhereNothingIsInItsWay) {
  Assembly assembly;
  const std::uint32_t grey = assembly.material({0.5F, 0.5F, 0.5F});
  assembly.quad(grey, {-6, -6, 0}, {12, 0, 0}, {0, 12, 0});
  assembly.box(grey, {-0.5F, -0.5F, 1}, {0.5F, 0.5F, 1.2F});
  Lights lights = darkness();
  lights.sun = {{0, 3, 4}, {10, 10, 10}};
  BakeOptions options;
  options.bounces = 0;
  const LitMesh mesh = lit(assembly, lights, options);
  // The cosine is 4/5. The box's shadow begins 0.75 m for each metre of height away from the sun.
  EXPECT_NEAR(look_down(mesh, 3, 0).x, 0.5 / kPi * 8, 1e-4);
  EXPECT_EQ(look_down(mesh, 0, -0.9F, 0.5F).x, 0);
  EXPECT_NEAR(look_down(mesh, 0, 0, 0.5F).x, 0.5 / kPi * 8, 1e-4);
}

// A room of 4 x 4 x 2.5 m with a window of 1.2 x 1 m.
Assembly room_with_window() {
  Assembly assembly;
  const std::uint32_t grey = assembly.material({0.6F, 0.6F, 0.6F});
  const float w = 4, h = 2.5F;
  assembly.quad(grey, {0, 0, 0}, {w, 0, 0}, {0, w, 0});
  assembly.quad(grey, {0, 0, h}, {0, w, 0}, {w, 0, 0});
  assembly.quad(grey, {0, 0, 0}, {0, w, 0}, {0, 0, h});
  assembly.quad(grey, {w, 0, 0}, {0, 0, h}, {0, w, 0});
  assembly.quad(grey, {0, w, 0}, {w, 0, 0}, {0, 0, h});
  assembly.quad(grey, {0, 0, 0}, {0, 0, h}, {1.4F, 0, 0});
  assembly.quad(grey, {2.6F, 0, 0}, {0, 0, h}, {1.4F, 0, 0});
  assembly.quad(grey, {1.4F, 0, 0}, {0, 0, 1}, {1.2F, 0, 0});
  assembly.quad(grey, {1.4F, 0, 2}, {0, 0, 0.5F}, {1.2F, 0, 0});
  return assembly;
}

TEST(Lighting, PortalsChangeTheNoiseAndNotTheLight) {
  const Assembly assembly = room_with_window();
  Lights lights = even_sky(5);
  BakeOptions many;
  many.rays = 2048;
  const LitMesh without = lit(assembly, lights, many);
  lights.portals.push_back({{1.4F, 0, 1}, {1.2F, 0, 0}, {0, 0, 1}});
  const LitMesh with = lit(assembly, lights);
  double sum0 = 0, sum1 = 0;
  for (float x = 0.25F; x < 4; x += 0.5F) {
    for (float y = 0.25F; y < 4; y += 0.5F) {
      const float a = look_down(without, x, y).x, b = look_down(with, x, y).x;
      // What 2,048 rays that find 1 to 5 % sky leave, smoothed, and 18 points for a window.
      EXPECT_NEAR(b, a, 0.12 * a + 0.01) << x << ' ' << y;
      sum0 += a;
      sum1 += b;
    }
  }
  EXPECT_NEAR(sum1, sum0, 0.04 * sum0);
}

TEST(Lighting, RoomsAreDarkerAwayFromTheWindow) {
  Lights lights = even_sky(5);
  lights.portals.push_back({{1.4F, 0, 1}, {1.2F, 0, 0}, {0, 0, 1}});
  const LitMesh mesh = lit(room_with_window(), lights);
  EXPECT_GT(look_down(mesh, 2, 1).x, 2 * look_down(mesh, 2, 3.8F).x);
  EXPECT_GT(look_down(mesh, 2, 2).x, 1.1 * look_down(mesh, 0.03F, 0.03F).x);
}

TEST(Lighting, NothingLeaksThroughAWall) {
  // One floor and one ceiling for two rooms, and a thin wall on them.
  Assembly assembly;
  const std::uint32_t grey = assembly.material({0.7F, 0.7F, 0.7F});
  assembly.hollow(grey, {0, 0, 0}, {8, 4, 2.5F});
  assembly.box(grey, {3.95F, 0, 0}, {4.05F, 4, 2.5F});
  Lights lights = darkness();
  lights.lamps.push_back({{2, 2, 2}, {3, 3, 3}, 0.1F});
  const LitMesh mesh = lit(assembly, lights);
  EXPECT_GT(look_down(mesh, 3.9F, 2).x, 0.05);
  for (float y = 0.05F; y < 4; y += 0.1F) {
    EXPECT_EQ(look(mesh, {6, y, 1}, {-1, 0, 0}), Vec3f{});
    // Points of floor and ceiling lie up to 5 cm apart where light ends; the wall is 5 cm away.
    for (const float x : {4.1F, 4.2F, 4.5F, 6.0F, 7.9F}) {
      EXPECT_EQ(look_down(mesh, x, y), Vec3f{}) << x << ' ' << y;
      EXPECT_EQ(look(mesh, {x, y, 1}, {0, 0, 1}), Vec3f{}) << x << ' ' << y;
    }
  }
}

TEST(Lighting, FloorsKeepTheirLightUpToWhatStandsOnThem) {
  Assembly assembly;
  const std::uint32_t grey = assembly.material({0.5F, 0.5F, 0.5F});
  assembly.hollow(grey, {0, 0, 0}, {5, 4, 2.5F});
  assembly.box(grey, {2, 1.5F, 0}, {3, 2.5F, 0.5F});
  Lights lights = darkness();
  lights.lamps.push_back({{1, 2, 2.2F}, {3, 3, 3}, 0.1F});
  const LitMesh mesh = lit(assembly, lights);
  // On the lamp's side there is no shadow: a little darker for the box, but not black.
  EXPECT_GT(look_down(mesh, 1.98F, 2).x, 0.7 * look_down(mesh, 1.6F, 2).x);
  // Behind it there is one.
  EXPECT_LT(look_down(mesh, 3.05F, 2).x, 0.6 * look_down(mesh, 1.98F, 2).x);
}

TEST(Lighting, MirrorsShowWhatTheyReflect) {
  Assembly assembly;
  assembly.quad(assembly.material({1, 1, 1}, {}, 0.75F), {0, -2, 0}, {0, 4, 0}, {0, 0, 3});
  assembly.quad(assembly.material({0, 0, 0}, {0.2F, 0.4F, 0.8F}), {1, 2, 0}, {0.5F, 0, 0},
                {0, 0, 3});
  BakeOptions options;
  options.bounces = 0;
  const LitMesh mesh = lit(assembly, darkness(), options);
  // From (1.25, -0.5) to (0, 0.75) and by the mirror to (1.25, 2): the glowing panel. It lights the
  // mirror's other quarter, which is white, a little.
  const Vec3f seen = look(mesh, {1.25F, -0.5F, 1.5F}, {-1, 1, 0});
  EXPECT_GT(seen.x, 0.75 * 0.2);
  EXPECT_LT(seen.x, 0.75 * 0.2 + 0.25 * 0.2);
  EXPECT_NEAR(seen.z / seen.x, 4, 1e-3);
  // Past the panel, to the dark.
  EXPECT_LT(look(mesh, {1.25F, -1.5F, 1.5F}, {-1, 1, 0}).x, 0.25 * 0.2);
}

TEST(Lighting, ShadesDoNotHoldBackTheirLampsLight) {
  Assembly assembly;
  const std::uint32_t grey = assembly.material({0.5F, 0.5F, 0.5F});
  const std::uint32_t glow = assembly.material({0.5F, 0.5F, 0.5F}, {1e-3F, 1e-3F, 1e-3F});
  assembly.quad(grey, {-3, -3, 0}, {6, 0, 0}, {0, 6, 0});
  assembly.box(glow, {-0.2F, -0.2F, 1.8F}, {0.2F, 0.2F, 2.2F});
  Lights lights = darkness();
  lights.lamps.push_back({{0, 0, 2}, {3, 3, 3}, 0.1F});
  const LitMesh mesh = lit(assembly, lights);
  EXPECT_NEAR(look_down(mesh, 0, 0).x, 0.5 / kPi * 3 / 4, 0.01);
}

TEST(Lighting, AirGlowsInClosedRoomsButLessInCorners) {
  Assembly assembly;
  assembly.hollow(assembly.material({0.5F, 0.5F, 0.5F}), {0, 0, 0}, {5, 4, 2.5F});
  const LitMesh mesh = lit(assembly, studio_lights(assembly.mesh));
  EXPECT_GT(look_down(mesh, 2.5F, 2).x, 1.2 * look_down(mesh, 0.02F, 0.02F).x);
  EXPECT_GT(look_down(mesh, 0.02F, 0.02F).x, 0.02);
}

TEST(Lighting, IsTheSameOnAnyNumberOfThreads) {
  Lights lights = even_sky(3);
  lights.sun = {{0.3F, -0.8F, 0.5F}, {9, 8, 7}};
  lights.portals.push_back({{1.4F, 0, 1}, {1.2F, 0, 0}, {0, 0, 1}});
  lights.lamps.push_back({{1, 2, 2.2F}, {1, 1, 1}, 0.1F});
  const Assembly assembly = room_with_window();
  BakeOptions one, two;
  one.threads = 1;
  two.threads = 2;
  const LitMesh a = lit(assembly, lights, one), b = lit(assembly, lights, two);
  EXPECT_EQ(a.key(), b.key());
  for (float x = 0.01F; x < 4; x += 0.13F) {
    EXPECT_EQ(look_down(a, x, 4 - x), look_down(b, x, 4 - x));
  }
  one.seed = 2;
  EXPECT_NE(lit(assembly, lights, one).key(), a.key());
}

// Programs write them where a polygon's first corners are on one edge. Refinement had no end there.
TEST(Lighting, TrianglesWithoutAreaStayWhole) {
  Mesh mesh;
  mesh.positions = {{0, 0, -6}, {0, 0, -4}, {0, 0, 0}, {5, 0, 0}};
  for (const float k : {1.0F, 3.0F, 7.0F}) mesh.positions.push_back({0.1F * k, 0.2F * k, 0.3F * k});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}};
  light::LightMesh cut(mesh);
  cut.cut([&](light::LightPoint a, light::LightPoint b) {
    return length(cut.position(a) - cut.position(b)) > 0.5F;
  });
  std::array<std::size_t, 3> pieces{};
  for (const auto& piece : cut.pieces()) ++pieces[piece.triangle];
  EXPECT_EQ(pieces[0], 1U);
  EXPECT_GT(pieces[1], 100U) << "beside it, all edges are cut";
  EXPECT_EQ(pieces[2], 1U) << "on a line up to rounding";
}

TEST(Lighting, TellsHowFarItIs) {
  Assembly assembly;
  assembly.hollow(assembly.material({0.5F, 0.5F, 0.5F}, {1, 1, 1}), {0, 0, 0}, {3, 4, 2.5F});
  const auto tracer =
      std::make_shared<const RayTracer>(std::make_shared<const Mesh>(assembly.mesh));
  std::size_t last = 0, total = 0, calls = 0;
  const LitMesh mesh(tracer, darkness(), {}, [&](std::size_t done, std::size_t of) {
    EXPECT_GE(done, last);
    last = done;
    total = of;
    ++calls;
  });
  EXPECT_EQ(last, total);
  EXPECT_GT(calls, 10U);
  struct Stop {};
  EXPECT_THROW(LitMesh(tracer, darkness(), {}, [](std::size_t, std::size_t) { throw Stop(); }),
               Stop);
}

TEST(Lighting, RefusesWhatMeansNothing) {
  Assembly assembly;
  assembly.quad(assembly.material({0.5F, 0.5F, 0.5F}), {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const auto bake = [&](double spacing, std::uint32_t rays, float power) {
    Lights lights;
    lights.lamps.push_back({{}, {power, 0, 0}, 0.1F});
    BakeOptions options;
    options.spacing = spacing;
    options.rays = rays;
    return lit(assembly, lights, options).key();
  };
  EXPECT_GT(bake(0.3, 16, 1), 0);
  EXPECT_THROW(bake(0, 16, 1), ArgumentError);
  EXPECT_THROW(bake(std::nan(""), 16, 1), ArgumentError);
  EXPECT_THROW(bake(0.3, 0, 1), ArgumentError);
  EXPECT_THROW(bake(0.3, 16, -1), ArgumentError);
  EXPECT_THROW(bake(0.3, 16, std::nanf("")), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
