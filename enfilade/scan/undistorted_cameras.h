/// \file  Reader of `undistorted_camera_parameters/<scan>.conf`.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/geometry/mat.h"

namespace enfilade::scan {

/// The camera of one undistorted image. Camera frame of the file: x right, y up, looking along -z.
/// The point (x, y, z) is at column cx - fx x / z and row cy - fy y / z, counted from the bottom.
/// Integers are pixel centres: stated not by the file, but by OpenCV, whose names the raw
/// intrinsics use.
struct UndistortedCamera {
  std::string depth_file, colour_file;    ///< `<viewpoint>_d<cam>_<yaw>.png`, `_i<cam>_<yaw>.jpg`
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels; the file counts rows from the bottom (cy too)
  Mat3d world_from_camera;
  Vec3d position;  ///< metres, world frame

  std::string_view viewpoint() const;  ///< the part of depth_file before "_d"
};

/// The content of a scan's .conf file.
struct UndistortedCameras {
  std::string depth_directory, colour_directory;  ///< as named in the file
  std::vector<UndistortedCamera> cameras;         ///< in the file's order
};

/// Commands: `dataset`, `n_images`, `depth_directory`, `color_directory`, `intrinsics_matrix`, and
/// `scan` or `image` (synonyms). The reference reader also accepts `rectangle`, `mesh` and
/// `texture_directory`; they are ignored, as are empty lines and those that begin with '#'.
/// \param file its name in messages
/// \throws InvalidInput naming the line of each fault:
/// - an unknown command, a wrong number of fields or an invalid number
/// - a camera before its intrinsics, or after `intrinsics <file>`, which is not read
/// - a depth file's name of another form
/// - a pose that is not a rotation
/// - another number of `scan` lines than `n_images`
UndistortedCameras parse_undistorted_cameras(std::string_view text, const std::string& file);

}  // namespace enfilade::scan
