/// \file  Panoramas in the files of Matterport3D's download and of Matterport3DSimulator, and the
/// names of these files.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan {

/// Reads a scan's panoramas from folders or from the `.zip` files of the download, unextracted.
///
/// For a scan S below a root folder R, these are tried as folders, then as files with `.zip` added:
/// `R/S/<kind>`, `R/v1/scans/S/<kind>`, `R/scans/S/<kind>`, `R/<kind>`.
///
/// Kinds and files:
/// - matterport_skybox_images
///   - `<viewpoint>_skybox_small.jpg` (strip of 6, RGB)
///   - `<viewpoint>_skybox<0..5>_sami.jpg` (one face each)
///   - `<viewpoint>_skybox_depth_small.png` (strip, 16 bit grey, as Layer::kDepth)
///   - `<viewpoint>_skybox_class_small.png` (strip, 8 or 16 bit grey)
///   - `<viewpoint>_skybox_instance_small.png` (strip, 16 bit grey, or 8-bit RGBA: id = R + 256 G +
///     65536 B + 2^24 A)
/// - undistorted_camera_parameters: `<scan>.conf`, and undistorted_depth_images:
///   `<viewpoint>_d<cam>_<yaw>.png`; depth without a strip, built by depth_skybox.h
///
/// A file is read from the first place that has it. Strips are preferred to faces, as
/// Matterport3DSimulator renders strips. The names of class and instance strips are Enfilade's own:
/// Matterport3D has no semantic pictures. Depth from undistorted images has the size of the colour
/// faces. It takes seconds for each panorama, in the calling thread; pack() such scans first.
/// \param root as above  \param connectivity folder of `<scan>_connectivity.json`
/// \throws LookupError if no folder or zip of sky-boxes is found, naming all that were tried;
/// FileError, InvalidInput for a broken zip or connectivity file
std::shared_ptr<const PanoramaSource> open_matterport_images(
    const std::filesystem::path& root, const std::filesystem::path& connectivity,
    const std::string& scan);

// --- names of files ---

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
