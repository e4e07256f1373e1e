/// \file  The 18 cameras of a panorama in Matterport3D, and writers and a reader of the text files
/// of their poses.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/geometry/vec.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan {

/// Cameras of Matterport's rig, its turns in a panorama, and pictures of both.
inline constexpr std::size_t kRigCameras = 3;
inline constexpr std::size_t kRigYaws = 6;
inline constexpr std::size_t kRigImages = kRigCameras * kRigYaws;

/// The camera of one undistorted image. Camera frame: x right, y down, z forward. The point (x, y,
/// z) is at column cx + fx x / z and row cy + fy y / z, counted from the top. Integers are pixel
/// centres.
struct RigCamera {
  std::string viewpoint;
  std::size_t camera = 0;  ///< 0 is pitched up, 1 level, 2 down
  std::size_t yaw = 0;     ///< turn, clockwise seen from above
  std::uint32_t width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  Mat3d world_from_camera;
  Vec3d position;  ///< metres, world
};

/// The 18 cameras of a panorama, by camera, then turn. Three cameras at elevations of 41, 0 and -42
/// degrees turn about the panorama's vertical in six steps of 60 degrees. Camera 1 faces along face
/// 3 at turn 2 and along face 1 at turn 5. Each is 3 cm off the eye. It has its own focal lengths,
/// about 1075 pixels, and principal point, some pixels off the centre; values are of the size of
/// Matterport's. No camera covers the zenith or nadir.
/// \param width of images, pixels; heights are 4/5 of it, and intrinsics scale with it
/// \throws ArgumentError for a width below 10
std::array<RigCamera, kRigImages> rig_cameras(const PanoramaPose& eye, std::uint32_t width = 1280);

/// Rotation to the camera frame of `.conf` and `.house` files: x right, y up, looking along -z.
Mat3d with_y_up(const Mat3d& world_from_camera);

/// `undistorted_camera_parameters/<scan>.conf`, the input of parse_undistorted_cameras(). The
/// file's cameras look along -z with y up, and rows are counted from the bottom. Numbers are
/// rounded to 1e-10. An intrinsics line holds for the cameras that follow.
std::string undistorted_cameras_text(std::span<const RigCamera> cameras);

/// `matterport_camera_poses/...`: 4 x 4, camera to world, the camera's frame as in RigCamera.
std::string camera_pose_text(const RigCamera& camera);
/// `matterport_camera_intrinsics/...`: `width height fx fy cx cy k1 k2 p1 p2 k3`, rows from the
/// top; no distortion.
std::string camera_intrinsics_text(const RigCamera& camera);

/// The camera of one undistorted image, as read. Camera frame of the file: x right, y up, looking
/// along -z. The point (x, y, z) is at column cx - fx x / z and row cy - fy y / z, counted from the
/// bottom. Integers are pixel centres: stated not by the file, but by OpenCV, whose names the raw
/// intrinsics use.
struct UndistortedCamera {
  std::string depth_file, colour_file;    ///< `<viewpoint>_d<cam>_<yaw>.png`, `_i<cam>_<yaw>.jpg`
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels; the file counts rows from the bottom (cy too)
  Mat3d world_from_camera;
  Vec3d position;  ///< metres, world frame

  std::string_view viewpoint() const;  ///< the part of depth_file before "_d"
};

/// Reads the cameras of `undistorted_camera_parameters/<scan>.conf`, in the file's order. Commands:
/// `dataset`, `n_images`, `depth_directory`, `color_directory`, `intrinsics_matrix`, and `scan` or
/// `image` (synonyms). The reference reader also accepts `rectangle`, `mesh` and
/// `texture_directory`; they are ignored, as are empty lines and those that begin with '#'.
/// \param file its name in messages
/// \throws InvalidInput naming the line of each fault:
/// - an unknown command, a wrong number of fields or an invalid number
/// - a camera before its intrinsics, or after `intrinsics <file>`, which is not read
/// - a depth file's name of another form
/// - a pose that is not a rotation
/// - another number of `scan` lines than `n_images`
std::vector<UndistortedCamera> parse_undistorted_cameras(std::string_view text,
                                                         const std::string& file);

}  // namespace enfilade::scan
