/// \file  Pictures of a mesh: cube maps and pinhole cameras, with true depth and labels.
#pragma once
#include <cstdint>
#include <optional>

#include "enfilade/geometry/cube_map.h"
#include "enfilade/geometry/mat.h"
#include "enfilade/image/image.h"
#include "enfilade/mesh/lighting.h"

namespace enfilade::mesh {

struct CaptureOptions {
  std::uint32_t samples = 4;  ///< colour rays a pixel: 1, 4, 9 or 16
  float exposure = 0;         ///< stops on top of the mesh's own (LitMesh::key())
  bool colour = true, depth = true, labels = true;
  int threads = 0;  ///< 0: all cores; the pictures are the same for any
};

/// Depth in quarter millimetres, rounded, at most 65535 (16.38 m); 0 where nothing is met. Class:
/// of mpcat40. Instance: place of the object plus 1. Both 0 where nothing is met or nothing is
/// known. Depth and labels are those of the ray through the pixel's middle, exactly. What is not
/// asked for is empty.
struct CubeCapture {
  image::CubeMap<std::uint8_t> colour;  ///< sRGB
  image::CubeMap<std::uint16_t> depth;  ///< along the ray
  image::CubeMap<std::uint16_t> classes;
  image::CubeMap<std::uint32_t> instances;
};
/// Seen from `eye`, faces as geometry/cube_map.h has them. \throws ArgumentError for size 0 or
/// above 8192, samples not allowed, an eye that is not finite
CubeCapture capture_cube(const LitMesh& mesh, const Mat3d& world_from_panorama, Vec3d eye,
                         std::uint32_t size, const CaptureOptions& options = {});

/// Camera frame: x right, y down, z ahead. Pixel (i, j)'s middle is seen along ((j - cx) / fx,
/// (i - cy) / fy, 1): whole numbers are middles, as OpenCV has it.
struct Pinhole {
  std::uint32_t width = 1280, height = 1024;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Mat3d world_from_camera;
  Vec3d position;
};
struct PinholeCapture {
  image::Image8 colour;
  image::Image16 depth;  ///< z-distance
  image::Image16 classes;
  image::Image32 instances;
};
PinholeCapture capture_pinhole(const LitMesh& mesh, const Pinhole& camera,
                               const CaptureOptions& options = {});

}  // namespace enfilade::mesh
