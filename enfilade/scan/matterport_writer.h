/// \file  The 18 cameras of a panorama, and the text files that tell where they stand.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "enfilade/geometry/mat.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan {

inline constexpr std::size_t kRigCameras = 3, kRigYaws = 6;
inline constexpr std::size_t kRigImages = kRigCameras * kRigYaws;

/// One picture of the rig, undistorted. Camera frame: x right, y down, z ahead; a point (x, y, z)
/// of it is seen at column cx + fx x / z and row cy + fy y / z, counted from the top; whole numbers
/// are the middles of pixels.
struct RigCamera {
  std::string viewpoint;
  std::size_t camera = 0;  ///< 0 looks up, 1 level, 2 down
  std::size_t yaw = 0;     ///< turn, clockwise seen from above
  std::uint32_t width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  Mat3d world_from_camera;
  Vec3d position;  ///< metres, world
};

/// How pictures are taken at a panorama's eye: three cameras turn about the tripod's axis, which is
/// the panorama's vertical, in six steps of 60 degrees. They are 41 degrees up, level and 42 down;
/// camera 1 at turn 2 looks along face 3, at turn 5 along face 1. Each stands 3 cm beside the eye,
/// and each has its own focal lengths, about 1075 pixels, and its own principal point some pixels
/// from the middle: numbers of the size that Matterport's have. Zenith and nadir are not seen by
/// any. By camera, then turn. \param width of pictures, pixels; heights are 4/5 of it, and
/// intrinsics scale with it \throws ArgumentError for a width below 10
std::array<RigCamera, kRigImages> rig_cameras(const PanoramaPose& eye, std::uint32_t width = 1280);

/// The same camera in the frame of `.conf` and `.house` files: x right, y up, looking along -z.
Mat3d with_y_up(const Mat3d& world_from_camera);

/// `undistorted_camera_parameters/<scan>.conf`: what parse_undistorted_cameras() reads. The file's
/// cameras look along -z with y up, and rows are counted from the bottom; angles and places are
/// written to 1e-10. One intrinsics line for the cameras that follow with the same ones.
std::string undistorted_cameras_text(std::span<const RigCamera> cameras);

/// `matterport_camera_poses/...`: 4 x 4, camera to world, the camera's frame as in RigCamera.
std::string camera_pose_text(const RigCamera& camera);
/// `matterport_camera_intrinsics/...`: `width height fx fy cx cy k1 k2 p1 p2 k3`, rows from the
/// top; no distortion.
std::string camera_intrinsics_text(const RigCamera& camera);

}  // namespace enfilade::scan
