#include "enfilade/render/cpu/row_plan.h"

#include <gtest/gtest.h>

#include "enfilade/core/rng.h"

namespace enfilade::render::cpu {
namespace {

// Pixels that the plan puts on another face than project_to_cube() does.
std::size_t differing_pixels(const Camera& camera, const Mat3d& rotation) {
  const PixelRays rays = pixel_rays(camera, rotation);
  std::size_t differing = 0;
  for (std::uint32_t row = 0; row < camera.height; ++row) {
    const RowPlan plan(rays, row, camera.width);
    std::uint32_t column = 0;
    for (const Stretch& stretch : plan.stretches()) {
      EXPECT_EQ(stretch.begin, column);  // they cover the row, from left to right
      for (; column < stretch.end; ++column) {
        differing += project_to_cube(rays.at(row, column)).face != stretch.face ? 1 : 0;
      }
    }
    EXPECT_EQ(column, camera.width);
  }
  return differing;
}

TEST(RowPlan, AgreesWithAskingEachPixel) {
  Rng rng(7, 0);
  for (int k = 0; k < 300; ++k) {
    const Camera camera{1 + static_cast<std::uint32_t>(rng.below(200)),
                        1 + static_cast<std::uint32_t>(rng.below(100)),
                        degrees(1 + 178 * rng.uniform())};
    ASSERT_EQ(differing_pixels(camera, world_from_camera(Radians(rng.uniform() * 7),
                                                         Radians((rng.uniform() - .5) * kPi))),
              0U)
        << "view " << k;
  }
}

TEST(RowPlan, HoldsWhereEdgesRunAlongRowsAndThroughCorners) {
  for (const double heading : {0., 45., 90., 135.}) {
    for (const double elevation : {-90., -45., 0., 45., 90.}) {
      const Camera camera{90, 90, degrees(90)};
      // A row that runs along an edge may be put on either side of it, pixel by pixel.
      EXPECT_LE(differing_pixels(camera, world_from_camera(degrees(heading), degrees(elevation))),
                2U * 90U);
    }
  }
}

TEST(RowPlan, LinesMeetThePlaneOfTheirFace) {
  const Camera camera{64, 48, degrees(70)};
  const PixelRays rays = pixel_rays(camera, world_from_camera(Radians(0.4), Radians(0.2)));
  for (std::uint32_t row = 0; row < camera.height; ++row) {
    const FaceLines lines = face_lines(rays, row);
    const RowPlan plan(rays, row, camera.width);
    for (const Stretch& stretch : plan.stretches()) {
      const FaceLine& line = lines[index(stretch.face)];
      const float j = static_cast<float>(stretch.begin), ahead = line.d0 + j * line.d1;
      const FacePoint point = project_to_cube(rays.at(row, stretch.begin));
      // Single precision.
      EXPECT_NEAR((line.s0 + j * line.s1) / ahead, 2 * point.s - 1, 1e-6);
      EXPECT_NEAR((line.t0 + j * line.t1) / ahead, 2 * point.t - 1, 1e-6);
    }
  }
}

}  // namespace
}  // namespace enfilade::render::cpu
