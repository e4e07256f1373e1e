#include "enfilade/geometry/cube_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "enfilade/core/rng.h"

namespace enfilade {
namespace EN_UNIT {

// What a few operations on numbers of size 1 may lose.
constexpr double kRounding = 1e-14;

Vec3d random_direction(Rng& rng) {
  return {rng.uniform() - 0.5, rng.uniform() - 0.5, rng.uniform() - 0.5};
}

TEST(CubeMap, MiddlesOfFacesAreTheAxesOfThePanoramaFrame) {
  EXPECT_EQ(cube_direction(CubeFace::kFront, 0.5, 0.5), (Vec3d{0, 0, 1}));
  EXPECT_EQ(cube_direction(CubeFace::kRight, 0.5, 0.5), (Vec3d{1, 0, 0}));
  EXPECT_EQ(cube_direction(CubeFace::kBack, 0.5, 0.5), (Vec3d{0, 0, -1}));
  EXPECT_EQ(cube_direction(CubeFace::kLeft, 0.5, 0.5), (Vec3d{-1, 0, 0}));
  EXPECT_EQ(cube_direction(CubeFace::kUp, 0.5, 0.5), (Vec3d{0, -1, 0}));
  EXPECT_EQ(cube_direction(CubeFace::kDown, 0.5, 0.5), (Vec3d{0, 1, 0}));
}

TEST(CubeMap, FacesJoinAsInAStripOfMatterport3D) {
  // Face 2 lies to the right of 1, 3 of 2, 4 of 3; the lower edge of 0 and the upper of 5 meet 1.
  for (const double t : {0.1, 0.7}) {
    for (std::size_t k = 1; k < 4; ++k) {
      EXPECT_EQ(cube_direction(cube_face(k), 1, t), cube_direction(cube_face(k + 1), 0, t));
    }
    EXPECT_EQ(cube_direction(CubeFace::kUp, t, 1), cube_direction(CubeFace::kBack, t, 0));
    EXPECT_EQ(cube_direction(CubeFace::kDown, t, 0), cube_direction(CubeFace::kBack, t, 1));
  }
}

TEST(CubeMap, ProjectionUndoesDirection) {
  Rng rng(1, 0);
  for (int k = 0; k < 10'000; ++k) {
    const FacePoint point{cube_face(rng.below(6)), rng.uniform(), rng.uniform()};
    const FacePoint found = project_to_cube(cube_direction(point.face, point.s, point.t));
    ASSERT_EQ(found.face, point.face);
    ASSERT_NEAR(found.s, point.s, kRounding);
    ASSERT_NEAR(found.t, point.t, kRounding);
  }
}

TEST(CubeMap, CameraLooksWhereItIsTold) {
  const Mat3d north = world_from_camera(Radians(0), Radians(0));
  EXPECT_NEAR((north * Vec3d{0, 0, 1}).y, 1, kRounding);   // heading 0 is +y
  EXPECT_NEAR((north * Vec3d{1, 0, 0}).x, 1, kRounding);   // its right is +x
  EXPECT_NEAR((north * Vec3d{0, 1, 0}).z, -1, kRounding);  // its down is -z
  EXPECT_NEAR((world_from_camera(degrees(90), Radians(0)) * Vec3d{0, 0, 1}).x, 1, kRounding);
  EXPECT_NEAR((world_from_camera(degrees(40), degrees(90)) * Vec3d{0, 0, 1}).z, 1, kRounding);
}

TEST(CubeMap, PixelRaysSpanTheFieldsOfView) {
  const Camera camera;  // 640 x 480, 60 degrees
  const PixelRays rays = pixel_rays(camera, Mat3d{});
  // Half a pixel beyond the middles of the outer pixels.
  EXPECT_NEAR(rays.at(-0.5, 319.5).y, -std::tan(degrees(30).value), kRounding);
  EXPECT_NEAR(rays.at(239.5, 639.5).x, std::tan(horizontal_field_of_view(camera).value / 2),
              kRounding);
  EXPECT_NEAR(rays.at(239.5, 319.5).x, 0, kRounding);
  EXPECT_EQ(rays.at(3, 4).z, 1);
}

TEST(CubeMap, FacesInViewHoldsAllThatIsSeenAndLittleMore) {
  Rng rng(2, 0);
  std::size_t promised = 0, seen = 0;
  for (int k = 0; k < 500; ++k) {
    const Camera camera{20 + static_cast<std::uint32_t>(rng.below(60)),
                        20 + static_cast<std::uint32_t>(rng.below(60)),
                        degrees(2 + 176 * rng.uniform())};
    const Mat3d rotation =
        world_from_camera(Radians(rng.uniform() * 7), Radians((rng.uniform() - 0.5) * kPi));
    const std::uint8_t mask = faces_in_view(camera, rotation);
    const PixelRays rays = pixel_rays(camera, rotation);
    std::uint8_t found = 0;
    for (std::uint32_t i = 0; i < camera.height; ++i) {
      for (std::uint32_t j = 0; j < camera.width; ++j) {
        found = static_cast<std::uint8_t>(found | 1U << index(project_to_cube(rays.at(i, j)).face));
      }
    }
    ASSERT_EQ(found & ~mask, 0) << "view " << k;
    promised += static_cast<std::size_t>(__builtin_popcount(mask));
    seen += static_cast<std::size_t>(__builtin_popcount(found));
  }
  // A face of which only a sliver between two pixels' middles is in the picture counts too.
  EXPECT_LT(static_cast<double>(promised), 1.05 * static_cast<double>(seen));
}

TEST(CubeMap, TransposeUndoesARotation) {
  Rng rng(3, 0);
  const Mat3d rotation = world_from_camera(Radians(1.2), Radians(-0.4));
  const Vec3d v = random_direction(rng);
  EXPECT_NEAR(length((transpose(rotation) * rotation) * v - v), 0, kRounding);
}

}  // namespace EN_UNIT
}  // namespace enfilade
