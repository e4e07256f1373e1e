#include "enfilade/scan/matterport_writer.h"

#include <fmt/format.h>
#include <cmath>
#include <numbers>

#include "enfilade/core/errors.h"
#include "enfilade/scan/matterport_names.h"

namespace enfilade::scan {
namespace {

/// One of the three cameras, for pictures of kKindWidth.
struct RigCameraKind {
  double elevation;       ///< degrees above the horizon
  Vec3d beside;           ///< of the eye, metres: to the right, down, ahead of the turned rig
  double fx, fy, cx, cy;  ///< pixels
};
constexpr double kKindWidth = 1280;
/// Invented values, close to those of calibrated rigs: all cameras differ, and no principal point
/// is in the middle (639.5, 511.5). In Matterport3D's files, the camera of the first picture is at
/// most 3.5 cm from the eye.
constexpr std::array<RigCameraKind, kRigCameras> kKinds{{
    {41, {.010, -.020, .025}, 1076.45, 1077.19, 629.48, 505.46},
    {0, {.010, 0, .027}, 1074.28, 1075.36, 640.21, 517.02},
    {-42, {.011, .018, .025}, 1077.93, 1078.41, 646.87, 499.87},
}};

/// Rotated to the right about the panorama's vertical axis, then up about the camera's x axis.
Mat3d panorama_from_camera(double heading, double elevation) {
  const double sh = std::sin(heading), ch = std::cos(heading);
  const double se = std::sin(elevation), ce = std::cos(elevation);
  // Columns: right, down, ahead. Down is +y of the panorama.
  return {{ch, se * sh, ce * sh, 0, ce, -se, -sh, se * ch, ce * ch}};
}

/// Rotation matrices of common angles contain values such as 6e-17 instead of 0.
double rounded(double value) { return std::round(value * 1e10) / 1e10 + 0.; }

std::string row(const Mat3d& m, std::size_t i, double place) {
  return fmt::format("{} {} {} {}", rounded(m.m[3 * i]), rounded(m.m[3 * i + 1]),
                     rounded(m.m[3 * i + 2]), rounded(place));
}

std::string rows_of(const Mat3d& m, Vec3d position, const char* between) {
  return row(m, 0, position.x) + between + row(m, 1, position.y) + between + row(m, 2, position.z) +
         between + "0 0 0 1";
}

}  // namespace

std::array<RigCamera, kRigImages> rig_cameras(const PanoramaPose& eye, std::uint32_t width) {
  if (width < 10) throw ArgumentError(fmt::format("width: {}, not at least 10 pixels", width));
  constexpr double kDegree = std::numbers::pi / 180;
  const double scale = width / kKindWidth;
  std::array<RigCamera, kRigImages> cameras;
  for (std::size_t k = 0; k < kRigImages; ++k) {
    RigCamera& c = cameras[k];
    const RigCameraKind& kind = kKinds[k / kRigYaws];
    c.viewpoint = eye.viewpoint;
    c.camera = k / kRigYaws;
    c.yaw = k % kRigYaws;
    c.width = width;
    c.height = width * 4 / 5;
    c.fx = kind.fx * scale;
    c.fy = kind.fy * scale;
    // Scaled about the picture's edge, which is half a pixel outside the first pixels' centres.
    c.cx = (kind.cx + .5) * scale - .5;
    c.cy = (kind.cy + .5) * scale - .5;
    const double heading = 60 * (static_cast<double>(c.yaw) - 2) * kDegree;
    c.world_from_camera =
        eye.world_from_panorama * panorama_from_camera(heading, kind.elevation * kDegree);
    c.position =
        eye.position + eye.world_from_panorama * (panorama_from_camera(heading, 0) * kind.beside);
  }
  return cameras;
}

Mat3d with_y_up(const Mat3d& world_from_camera) {
  const auto& m = world_from_camera.m;
  return {{m[0], -m[1], -m[2], m[3], -m[4], -m[5], m[6], -m[7], -m[8]}};
}

std::string undistorted_cameras_text(std::span<const RigCamera> cameras) {
  std::string text = fmt::format(
      "dataset matterport\nn_images {}\ndepth_directory undistorted_depth_images\n"
      "color_directory undistorted_color_images\n",
      cameras.size());
  std::string last;
  for (const RigCamera& c : cameras) {
    const std::string intrinsics =
        fmt::format("\nintrinsics_matrix {} 0 {} 0 {} {} 0 0 1\n", rounded(c.fx), rounded(c.cx),
                    rounded(c.fy), rounded(c.height - 1 - c.cy));
    if (intrinsics != last) text += intrinsics;
    last = intrinsics;
    text += fmt::format("scan {} {} {}\n", depth_image_name(c.viewpoint, c.camera, c.yaw),
                        colour_image_name(c.viewpoint, c.camera, c.yaw),
                        rows_of(with_y_up(c.world_from_camera), c.position, " "));
  }
  return text;
}

std::string camera_pose_text(const RigCamera& camera) {
  return rows_of(camera.world_from_camera, camera.position, "\n") + "\n";
}

std::string camera_intrinsics_text(const RigCamera& camera) {
  return fmt::format("{} {} {} {} {} {} 0 0 0 0 0\n", camera.width, camera.height,
                     rounded(camera.fx), rounded(camera.fy), rounded(camera.cx),
                     rounded(camera.cy));
}

}  // namespace enfilade::scan
