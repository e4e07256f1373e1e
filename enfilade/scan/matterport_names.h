/// \file  Names of the files of a scan in Matterport3D.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan {

/// The viewpoint's strip of six faces in `matterport_skybox_images`, as Matterport3DSimulator's
/// preprocessing names colour and depth, and Enfilade classes and instances.
std::string skybox_strip_name(std::string_view viewpoint, Layer layer);
/// One colour face there. \param face 0 .. 5
std::string skybox_face_name(std::string_view viewpoint, std::size_t face);

/// Names for camera 0 (up), 1 (level), 2 (down) at turn 0 .. 5: `<viewpoint>_i<cam>_<yaw>.jpg` in
/// `undistorted_color_images`, ...
std::string colour_image_name(std::string_view viewpoint, std::size_t camera, std::size_t yaw);
/// ... `<viewpoint>_d<cam>_<yaw>.png` in `undistorted_depth_images`, ...
std::string depth_image_name(std::string_view viewpoint, std::size_t camera, std::size_t yaw);
/// ... `<viewpoint>_pose_<cam>_<yaw>.txt` in `matterport_camera_poses`, ...
std::string camera_pose_name(std::string_view viewpoint, std::size_t camera, std::size_t yaw);
/// ... and, for all turns, `<viewpoint>_intrinsics_<cam>.txt` in `matterport_camera_intrinsics`.
std::string camera_intrinsics_name(std::string_view viewpoint, std::size_t camera);

}  // namespace enfilade::scan
