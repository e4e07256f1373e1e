#include "enfilade/mesh/capture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/support/assembly.h"

namespace enfilade::mesh {

using tests::Assembly;

namespace EN_UNIT {

// Heading about the vertical; the panorama's y is down.
Mat3d upright(double heading) {
  const double c = std::cos(heading), s = std::sin(heading);
  return {{c, 0, s, -s, 0, c, 0, -1, 0}};
}

constexpr Vec3f kLow{-2.5F, -1.5F, 0}, kHigh{3.5F, 2.5F, 2.75F};

// A box whose six sides glow, each in its own colour, and are objects of their own.
Assembly coloured_room() {
  Assembly assembly;
  const float w = kHigh.x - kLow.x, d = kHigh.y - kLow.y, h = kHigh.z - kLow.z;
  const auto side = [&](std::uint16_t category, Vec3f colour, Vec3f corner, Vec3f u, Vec3f v) {
    assembly.object("side", category);
    assembly.quad(assembly.material({0, 0, 0}, colour), corner, u, v);
  };
  side(2, {1, 0, 0}, kLow, {w, 0, 0}, {0, d, 0});
  side(17, {0, 1, 0}, kHigh, {0, -d, 0}, {-w, 0, 0});
  side(1, {0, 0, 1}, kLow, {0, d, 0}, {0, 0, h});
  side(3, {1, 1, 0}, kLow, {0, 0, h}, {w, 0, 0});
  side(4, {0, 1, 1}, kHigh, {0, 0, -h}, {0, -d, 0});
  side(5, {1, 0, 1}, kHigh, {-w, 0, 0}, {0, 0, -h});
  return assembly;
}

Lights dark() {
  Lights lights;
  lights.sky = {{}, {}, {}};
  return lights;
}

LitMesh lit(const Assembly& assembly, const Lights& lights = dark()) {
  BakeOptions options;
  options.rays = 16;
  return LitMesh(std::make_shared<const RayTracer>(std::make_shared<const Mesh>(assembly.mesh)),
                 lights, options);
}

// Where a ray from inside of the room meets a side: its number (as above) and how far away.
struct Side {
  std::size_t number = 0;
  double distance = 1e9;
};
Side side_met(Vec3d eye, Vec3d way) {
  Side nearest;
  const auto meet = [&](std::size_t number, double at, double from, double along) {
    const double t = (at - from) / along;
    if (t > 0 && t < nearest.distance) nearest = {number, t};
  };
  meet(0, kLow.z, eye.z, way.z);
  meet(1, kHigh.z, eye.z, way.z);
  meet(2, kLow.x, eye.x, way.x);
  meet(3, kLow.y, eye.y, way.y);
  meet(4, kHigh.x, eye.x, way.x);
  meet(5, kHigh.y, eye.y, way.y);
  return nearest;
}

Vec3d unit(Vec3d v) {
  const double size = length(v);
  return {v.x / size, v.y / size, v.z / size};
}

TEST(CaptureCube, DepthAndLabelsAreThoseOfEachPixelsMiddle) {
  const LitMesh mesh = lit(coloured_room());
  const Mat3d pose = upright(0.7);
  const Vec3d eye{0.3, 0.4, 1.55};
  constexpr std::uint32_t kSize = 61;  // not a multiple of the tile
  const CubeCapture capture = capture_cube(mesh, pose, eye, kSize);
  const std::array<std::uint16_t, 6> categories{2, 17, 1, 3, 4, 5};
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    for (std::uint32_t i = 0; i < kSize; ++i) {
      for (std::uint32_t j = 0; j < kSize; ++j) {
        const Vec3d way =
            unit(pose * cube_direction(cube_face(k), (j + 0.5) / kSize, (i + 0.5) / kSize));
        const Side side = side_met(eye, way);
        // Rounded to a quarter of a millimetre, and 1e-6 of it by floats: never one step off.
        ASSERT_NEAR(*capture.depth[k].at(j, i), 4000 * side.distance, 0.6) << k << i << ' ' << j;
        ASSERT_EQ(*capture.classes[k].at(j, i), categories[side.number]);
        ASSERT_EQ(*capture.instances[k].at(j, i), side.number + 1);
      }
    }
  }
}

TEST(CaptureCube, ColoursLieWhereTheConventionsSay) {
  const LitMesh mesh = lit(coloured_room());
  const Mat3d pose = upright(-2.1);
  const Vec3d eye{0.3, 0.4, 1.55};
  constexpr std::uint32_t kSize = 40;
  for (const std::uint32_t samples : {1U, 4U, 9U, 16U}) {
    CaptureOptions options;
    options.samples = samples;
    const CubeCapture capture = capture_cube(mesh, pose, eye, kSize, options);
    std::size_t other = 0;
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      for (std::uint32_t i = 0; i < kSize; ++i) {
        for (std::uint32_t j = 0; j < kSize; ++j) {
          const Vec3d way =
              pose * cube_direction(cube_face(k), (j + 0.5) / kSize, (i + 0.5) / kSize);
          const Vec3f glow = mesh.mesh().materials[side_met(eye, way).number].emission;
          const std::uint8_t* seen = capture.colour[k].at(j, i);
          const bool same = (seen[0] > 0) == (glow.x > 0) && (seen[1] > 0) == (glow.y > 0) &&
                            (seen[2] > 0) == (glow.z > 0);
          other += same ? 0 : 1;
        }
      }
    }
    // Pixels on edges see two sides or three; none do with one ray.
    const std::size_t edges = samples == 1 ? 0 : 900;
    EXPECT_LE(other, edges) << samples;
    EXPECT_EQ(other == 0, samples == 1);
  }
}

TEST(CapturePinhole, SeesWhatTheCubeSees) {
  const LitMesh mesh = lit(coloured_room());
  const Mat3d pose = upright(0.3);
  const Vec3d eye{-0.4, 0.2, 1.4};
  constexpr std::uint32_t kSize = 48;
  const CubeCapture cube = capture_cube(mesh, pose, eye, kSize);
  // The front face as a camera: 90 degrees, the middle between the middle pixels.
  Pinhole camera;
  camera.width = camera.height = kSize;
  camera.fx = camera.fy = kSize / 2.0;
  camera.cx = camera.cy = kSize / 2.0 - 0.5;
  camera.world_from_camera = pose;
  camera.position = eye;
  const PinholeCapture picture = capture_pinhole(mesh, camera);
  const std::size_t front = index(CubeFace::kFront);
  EXPECT_EQ(picture.classes, cube.classes[front]);
  EXPECT_EQ(picture.instances, cube.instances[front]);
  for (std::uint32_t i = 0; i < kSize; ++i) {
    for (std::uint32_t j = 0; j < kSize; ++j) {
      const double along =
          length(cube_direction(CubeFace::kFront, (j + 0.5) / kSize, (i + 0.5) / kSize));
      // z-distance against distance: each is rounded once.
      ASSERT_NEAR(*picture.depth.at(j, i) * along, *cube.depth[front].at(j, i), 0.5 * along + 0.6);
    }
  }
  std::size_t other = 0;
  for (std::size_t i = 0; i < picture.colour.pixels.size(); ++i) {
    other += picture.colour.pixels[i] != cube.colour[front].pixels[i] ? 1 : 0;
  }
  EXPECT_LT(other, 20U);  // rays that floats put on the other side of an edge
}

TEST(CapturePinhole, WholeNumbersArePixelsMiddles) {
  const LitMesh mesh = lit(coloured_room());
  Pinhole camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = 50;
  camera.fy = 40;
  camera.cx = 20;
  camera.cy = 30;
  camera.world_from_camera = upright(0);
  camera.position = {0.5, 0, 1};
  const PinholeCapture picture = capture_pinhole(mesh, camera);
  // Pixel (30, 20) looks straight ahead, along +y.
  EXPECT_EQ(*picture.depth.at(20, 30), 10000);
  EXPECT_EQ(*picture.classes.at(20, 30), 5);
  // The floor, 1 m below, is met where (i - 30) / 40 z = 1.
  EXPECT_NEAR(*picture.depth.at(20, 47), 4000 * 40.0 / 17, 1);
  EXPECT_EQ(*picture.classes.at(20, 47), 2);
}

TEST(Capture, ShowsTheKeyAsMiddleGrey) {
  Assembly assembly;
  assembly.quad(assembly.material({0.5F, 0.5F, 0.5F}), {-6, -6, 0}, {12, 0, 0}, {0, 12, 0});
  Lights lights = dark();
  lights.sky = {{7, 7, 7}, {7, 7, 7}, {}};
  const LitMesh mesh = lit(assembly, lights);
  EXPECT_NEAR(mesh.key(), 3.5, 1e-3);
  CaptureOptions options;
  const auto down = [&] {
    return *capture_cube(mesh, upright(0), {0, 0, 1}, 8, options)
                .colour[index(CubeFace::kDown)]
                .at(4, 4);
  };
  EXPECT_EQ(down(), 118);  // sRGB of 18 %
  options.exposure = -1;
  EXPECT_EQ(down(), 85);  // sRGB of 9 %: 0.3325
}

TEST(Capture, NothingMetIsZero) {
  Assembly assembly;
  assembly.quad(assembly.material({0.5F, 0.5F, 0.5F}), {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  const CubeCapture capture = capture_cube(lit(assembly, Lights{}), upright(0), {0, 0, 1}, 8);
  const auto up = index(CubeFace::kUp), down = index(CubeFace::kDown);
  EXPECT_EQ(*std::ranges::max_element(capture.depth[up].pixels), 0);
  EXPECT_EQ(*std::ranges::max_element(capture.instances[up].pixels), 0U);
  EXPECT_GT(*std::ranges::min_element(capture.colour[up].pixels), 0) << "but the sky is seen";
  EXPECT_GT(*std::ranges::min_element(capture.depth[down].pixels), 0);
  EXPECT_EQ(*std::ranges::max_element(capture.instances[down].pixels), 0U) << "no object";
}

TEST(Capture, IsTheSameOnAnyNumberOfThreads) {
  const LitMesh mesh = lit(coloured_room());
  CaptureOptions one, two;
  one.threads = 1;
  two.threads = 2;
  const CubeCapture a = capture_cube(mesh, upright(1), {0, 0, 1}, 70, one);
  const CubeCapture b = capture_cube(mesh, upright(1), {0, 0, 1}, 70, two);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.instances, b.instances);
}

TEST(Capture, MakesOnlyWhatIsAskedFor) {
  const LitMesh mesh = lit(coloured_room());
  CaptureOptions options;
  options.colour = false;
  options.labels = false;
  const CubeCapture depth = capture_cube(mesh, upright(0), {0, 0, 1}, 16, options);
  EXPECT_TRUE(depth.colour[0].pixels.empty());
  EXPECT_TRUE(depth.classes[0].pixels.empty());
  EXPECT_EQ(depth.depth, capture_cube(mesh, upright(0), {0, 0, 1}, 16).depth);
}

TEST(Capture, RefusesWhatMeansNothing) {
  const LitMesh mesh = lit(coloured_room());
  CaptureOptions options;
  EXPECT_THROW(capture_cube(mesh, {}, {}, 0, options), ArgumentError);
  EXPECT_THROW(capture_cube(mesh, {}, {}, 8193, options), ArgumentError);
  EXPECT_THROW(capture_cube(mesh, {}, {0, std::nan(""), 0}, 8, options), ArgumentError);
  options.samples = 3;
  EXPECT_THROW(capture_cube(mesh, {}, {}, 8, options), ArgumentError);
  EXPECT_THROW(capture_pinhole(mesh, {}), ArgumentError);  // no focal length
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
