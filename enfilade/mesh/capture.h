/// \file  Rendering of a mesh: cube maps and pinhole images, with depth and labels.
#pragma once
#include <cstdint>

#include "enfilade/geometry/cube_map.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/image/image.h"
#include "enfilade/mesh/lighting.h"

namespace enfilade::mesh {

/// Layers of a camera's capture, and their sampling.
struct CaptureOptions {
  std::uint32_t samples = 4;  ///< colour rays per pixel: 1, 4, 9 or 16
  float exposure = 0;         ///< stops, added to the mesh's own (LitMesh::key())
  bool colour = true, depth = true, labels = true;
  int threads = 0;  ///< 0: all cores; does not change the pictures
};

/// Depth: quarter millimetres as image::depth_units(), 0 where the ray hits nothing. Class: index
/// in mpcat40. Instance: index of the object plus 1. Both are 0 where the ray hits nothing or an
/// unlabelled surface. Depth and labels are those of the ray through the pixel's centre. Layers
/// that were not requested are empty.
struct CubeCapture {
  image::CubeMap<std::uint8_t> colour;  ///< sRGB
  image::CubeMap<std::uint16_t> depth;  ///< along the ray
  image::CubeMap<std::uint16_t> classes;
  image::CubeMap<std::uint32_t> instances;
};
/// The cube map at `eye`, with faces as in geometry/cube_map.h. \throws ArgumentError for size 0 or
/// above 8192, samples not allowed, an eye that is not finite
CubeCapture capture_cube(const LitMesh& mesh, const Mat3d& world_from_panorama, Vec3d eye,
                         std::uint32_t size, const CaptureOptions& options = {});

/// Camera frame: x right, y down, z forward. The centre of pixel (row i, column j) is in direction
/// ((j - cx) / fx, (i - cy) / fy, 1): integers are pixel centres, as in OpenCV.
struct Pinhole {
  std::uint32_t width = 1280, height = 1024;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Mat3d world_from_camera;
  Vec3d position;
};
/// The capture of a pinhole camera; layers that were not requested are empty.
struct PinholeCapture {
  image::Image8 colour;
  image::Image16 depth;  ///< z-distance
  image::Image16 classes;
  image::Image32 instances;
};
PinholeCapture capture_pinhole(const LitMesh& mesh, const Pinhole& camera,
                               const CaptureOptions& options = {});

}  // namespace enfilade::mesh
