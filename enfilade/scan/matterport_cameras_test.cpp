#include "enfilade/scan/matterport_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/scan/depth_skybox.h"

namespace enfilade::scan {
namespace EN_UNIT {

using ::testing::HasSubstr;

/// Looks along +x, the eye 1.5 m above the origin.
PanoramaPose eye_to_the_east() {
  return {"east", world_from_camera(degrees(90), degrees(0)), {0, 0, 1.5}, true};
}

/// As real ones are: not level.
PanoramaPose crooked_eye() {
  return {
      "crooked", world_from_camera(degrees(203), degrees(1.5)), {-5.48891, 1.4484, 1.53509}, true};
}

Vec3d ahead(const RigCamera& c) { return c.world_from_camera * Vec3d{0, 0, 1}; }
double elevation_of(const RigCamera& c) { return std::asin(ahead(c).z) * 57.29577951308232; }

TEST(RigCameras, TurnClockwiseFromBehindLookingUpLevelAndDown) {
  const auto cameras = rig_cameras(eye_to_the_east());
  for (std::size_t k = 0; k < kRigImages; ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(cameras[k].camera, k / 6);
    EXPECT_EQ(cameras[k].yaw, k % 6);
    constexpr std::array<double, 3> kElevation{41, 0, -42};
    EXPECT_NEAR(elevation_of(cameras[k]), kElevation[k / 6], 1e-9);
    // The panorama looks to heading 90; turn 2 is its forward, 60 degrees more each turn.
    const double heading = 90 + 60 * (static_cast<double>(k % 6) - 2);
    const Vec3d d = ahead(cameras[k]);
    EXPECT_NEAR(std::remainder(std::atan2(d.x, d.y) * 57.29577951308232 - heading, 360), 0, 1e-9);
    // Pictures are upright: their columns go down, their rows are level.
    EXPECT_NEAR((cameras[k].world_from_camera * Vec3d{1, 0, 0}).z, 0, 1e-12);
    EXPECT_LT((cameras[k].world_from_camera * Vec3d{0, 1, 0}).z, -.7);
  }
}

TEST(RigCameras, LookAlongTheFacesThatTheFormatNames) {
  const PanoramaPose eye = crooked_eye();
  const auto cameras = rig_cameras(eye);
  const auto face = [&](CubeFace f) {
    return eye.world_from_panorama * kFaceAxes[index(f)].forward;
  };
  EXPECT_LT(length(ahead(cameras[6 + 2]) - face(CubeFace::kFront)), 1e-12);  // i1_2: face 3
  EXPECT_LT(length(ahead(cameras[6 + 5]) - face(CubeFace::kBack)), 1e-12);   // i1_5: face 1
  // The rig turns to the right: turn 3 lies between front (2) and back (5), on the right's side.
  const Vec3d right = face(CubeFace::kRight), d = ahead(cameras[6 + 3]);
  EXPECT_NEAR(dot(right, d), std::sqrt(.75), 1e-12);
}

TEST(RigCameras, StandCentimetresBesideTheEyeAndHaveTheirOwnIntrinsics) {
  const PanoramaPose eye = crooked_eye();
  const auto cameras = rig_cameras(eye);
  for (const RigCamera& c : cameras) {
    const double beside = length(c.position - eye.position);
    EXPECT_GT(beside, .02);
    EXPECT_LT(beside, .035);
    EXPECT_EQ(c.width, 1280U);
    EXPECT_EQ(c.height, 1024U);
    EXPECT_NEAR(c.fx, 1075, 5);
    EXPECT_NEAR(c.fy, 1075, 5);
    EXPECT_NE(c.cx, 639.5);
    EXPECT_NEAR(c.cx, 639.5, 15);
    EXPECT_NEAR(c.cy, 511.5, 15);
    // Shared by the turns, as the files' names have it.
    EXPECT_EQ(c.fx, cameras[6 * c.camera].fx);
    EXPECT_EQ(c.cy, cameras[6 * c.camera].cy);
  }
  // They turn about one axis: opposite places have the axis in their middle, all at one height.
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d sum = cameras[6 + k].position + cameras[6 + k + 3].position;
    EXPECT_LT(length(sum - eye.position - eye.position), 1e-12);
  }
}

TEST(RigCameras, LeaveNothingBetweenThemButZenithAndNadir) {
  const auto cameras = rig_cameras(eye_to_the_east());
  const auto is_seen = [&](Vec3d p) {
    return std::ranges::any_of(cameras, [&](const RigCamera& c) {
      const Vec3d q = transpose(c.world_from_camera) * (p - c.position);
      if (q.z <= 0) return false;
      const double x = c.cx + c.fx * q.x / q.z, y = c.cy + c.fy * q.y / q.z;
      return x >= 0 && y >= 0 && x <= c.width - 1. && y <= c.height - 1.;
    });
  };
  for (double heading = 0; heading < 360; heading += 7.5) {
    const double h = heading / 57.29577951308232;
    const auto at = [&](double elevation) {
      const double e = elevation / 57.29577951308232;
      return Vec3d{3 * std::cos(e) * std::sin(h), 3 * std::cos(e) * std::cos(h),
                   1.5 + 3 * std::sin(e)};
    };
    for (double e = -62; e <= 62; e += 2) EXPECT_TRUE(is_seen(at(e))) << heading << " " << e;
    EXPECT_FALSE(is_seen(at(75)));
    EXPECT_FALSE(is_seen(at(-75)));
  }
}

TEST(RigCameras, ScaleWithTheWidth) {
  const auto large = rig_cameras(crooked_eye()), small = rig_cameras(crooked_eye(), 320);
  EXPECT_EQ(small[0].height, 256U);
  EXPECT_DOUBLE_EQ(small[0].fx, large[0].fx / 4);
  // The same direction is seen at the same share of the picture, counted from its edge.
  EXPECT_DOUBLE_EQ((small[7].cx + .5) / 320, (large[7].cx + .5) / 1280);
  EXPECT_THROW(rig_cameras(crooked_eye(), 9), ArgumentError);
}

TEST(MatterportWriter, WritesConfLinesWorkedOutByHand) {
  RigCamera c;
  c.viewpoint = "a";
  c.camera = 1, c.yaw = 2;
  c.width = 1280, c.height = 1024;
  c.fx = 1075.5, c.fy = 1076, c.cx = 640.25, c.cy = 500;  // rows from the bottom: 1023 - 500
  // Looks along +x from (1, 2, 3): right is -y, down is -z. In the file y is up and z behind.
  c.world_from_camera = {{0, 0, 1, -1, 0, 0, 0, -1, 0}};
  c.position = {1, 2, 3};
  EXPECT_EQ(undistorted_cameras_text({&c, 1}),
            "dataset matterport\nn_images 1\ndepth_directory undistorted_depth_images\n"
            "color_directory undistorted_color_images\n"
            "\nintrinsics_matrix 1075.5 0 640.25 0 1076 523 0 0 1\n"
            "scan a_d1_2.png a_i1_2.jpg 0 0 -1 1 -1 0 0 2 0 1 0 3 0 0 0 1\n");
  EXPECT_EQ(camera_pose_text(c), "0 0 1 1\n-1 0 0 2\n0 -1 0 3\n0 0 0 1\n");
  EXPECT_EQ(camera_intrinsics_text(c), "1280 1024 1075.5 1076 640.25 500 0 0 0 0 0\n");
}

TEST(MatterportWriter, WritesWhatTheReaderReadsBack) {
  std::vector<RigCamera> cameras;
  for (const PanoramaPose& eye : {crooked_eye(), eye_to_the_east()}) {
    const auto rig = rig_cameras(eye);
    cameras.insert(cameras.end(), rig.begin(), rig.end());
  }
  const std::string text = undistorted_cameras_text(cameras);
  std::size_t intrinsics = 0;
  for (std::size_t at = text.find("intrinsics"); at != std::string::npos; ++intrinsics) {
    at = text.find("intrinsics", at + 1);
  }
  EXPECT_EQ(intrinsics, 6U) << "one for the six turns of each camera";
  const auto read = parse_undistorted_cameras(text, "s.conf");
  ASSERT_EQ(read.size(), 36U);
  for (std::size_t k = 0; k < read.size(); ++k) {
    const RigCamera& c = cameras[k];
    SCOPED_TRACE(read[k].depth_file);
    EXPECT_EQ(read[k].viewpoint(), c.viewpoint);
    // One world point, projected by the writer's and by the reader's definition; 1e-10 in the
    // file's numbers is 1e-7 pixels.
    const Vec3d p = c.position + c.world_from_camera * Vec3d{.3, -.2, 2};
    const Vec3d q = transpose(read[k].world_from_camera) * (p - read[k].position);
    EXPECT_NEAR(read[k].cx - read[k].fx * q.x / q.z, c.cx + c.fx * .15, 1e-6);
    const double row_from_bottom = read[k].cy - read[k].fy * q.y / q.z;
    EXPECT_NEAR(c.height - 1 - row_from_bottom, c.cy - c.fy * .1, 1e-6);
  }
}

TEST(MatterportWriter, PosesAreRowMajorMatricesToTheWorld) {
  const RigCamera c = rig_cameras(crooked_eye())[9];
  std::istringstream text(camera_pose_text(c));
  std::array<double, 16> pose{};
  for (double& value : pose) text >> value;
  ASSERT_TRUE(text);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_NEAR(pose[4 * i + j], c.world_from_camera.m[3 * i + j], 1e-10);
    }
  }
  EXPECT_NEAR(pose[3], c.position.x, 1e-10);
  EXPECT_NEAR(pose[11], c.position.z, 1e-10);
}

/// Distance along a ray of length 1 inside a box room with the origin in it.
double wall(Vec3d from, Vec3d d) {
  const auto axis = [](double at, double step, double low, double high) {
    return step > 0 ? (high - at) / step : step < 0 ? (low - at) / step : 1e30;
  };
  return std::min(
      {axis(from.x, d.x, -3, 2), axis(from.y, d.y, -4, 2.5), axis(from.z, d.z, 0, 2.7)});
}

TEST(MatterportWriter, AgreesWithTheBuilderOfDepthSkyboxes) {
  // Pictures taken by RigCamera's definition, cameras by the file's: depth_skybox.h turns rows over
  // and mirrors axes as it needs to, and finds the walls where they are.
  const PanoramaPose eye = crooked_eye();
  PanoramaPose here = eye;
  here.position = {0, 0, 1.5};
  const auto rig = rig_cameras(here, 320);
  const auto read = parse_undistorted_cameras(undistorted_cameras_text(rig), "s.conf");
  std::vector<DepthImage> images;
  for (std::size_t k = 0; k < rig.size(); ++k) {
    const RigCamera& c = rig[k];
    image::Image16 depth(c.width, c.height, 1);
    for (std::uint32_t y = 0; y < c.height; ++y) {
      for (std::uint32_t x = 0; x < c.width; ++x) {
        const Vec3d d = c.world_from_camera * Vec3d{(x - c.cx) / c.fx, (y - c.cy) / c.fy, 1};
        *depth.at(x, y) = static_cast<std::uint16_t>(std::lround(4000 * wall(c.position, d)));
      }
    }
    images.push_back({read[k], std::move(depth)});
  }
  const auto map = depth_skybox(images, here, 64);
  std::vector<double> errors;
  for (std::size_t face = 0; face < kCubeFaces; ++face) {
    for (std::size_t i = 0; i < 64 * 64; ++i) {
      if (map[face].pixels[i] == 0) continue;
      const Vec3d d = cube_direction(cube_face(face), (static_cast<double>(i % 64) + .5) / 64,
                                     (static_cast<double>(i / 64) + .5) / 64);
      const Vec3d w = here.world_from_panorama * d;
      const double truth = wall(here.position, w) * length(d);
      errors.push_back(std::abs(map[face].pixels[i] / kDepthUnitsPerMetre - truth));
    }
  }
  EXPECT_GT(errors.size(), 6U * 64 * 64 * 9 / 10);
  std::ranges::sort(errors);
  // Rounding to 0.25 mm, twice; in the room's corners the interpolated surface cuts the corner by
  // less than a pixel's width, 1/269 of up to 5 m.
  EXPECT_LT(errors[errors.size() / 2], .00025);
  EXPECT_LT(errors.back(), .02);
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
