/// \file  Depth sky-boxes out of the 18 undistorted depth images of a panorama.
#pragma once
#include <cstdint>
#include <span>

#include "enfilade/image/image.h"
#include "enfilade/scan/panorama_source.h"
#include "enfilade/scan/undistorted_cameras.h"

namespace enfilade::scan {

/// A camera and its picture: z-distance, 4000 units a metre, 0 unknown.
struct DepthImage {
  UndistortedCamera camera;
  image::Image16 depth;
};

/// For each texel, the distance along its ray from the panorama's eye. Cameras stand centimetres
/// beside the eye; that is taken into account, by looking for the point of the ray at which a
/// picture's depth agrees with the point's. What the pictures say is blended, each weighted by how
/// far inside its frame it sees the point, but never across a step in depth: readings more than 2
/// cm or 2 % apart are of different surfaces (one camera sees past an edge and another does not),
/// of which the nearest wins that has half the weight of any behind it. Distances above 16.38375 m
/// are given as that. 0 where nobody has a reading. \param size of a face, texels  \param threads
/// 0: all cores; the result is the same for any
image::CubeMap<std::uint16_t> depth_skybox(std::span<const DepthImage> images,
                                           const PanoramaPose& eye, std::uint32_t size,
                                           int threads = 0);

struct HoleFilling {
  std::array<double, 3> space_sigma{12, 5, 8};      ///< texels, pass by pass
  std::array<double, 3> range_sigma{.2, .08, .02};  ///< of luminance in [0, 1]
};

/// Fills the texels that are 0 from readings around them, those of like colour first:
/// cross-bilateral filtering guided by the RGB picture, in passes from coarse to fine, over face
/// edges as if the sphere had none. Readings that exist are left as they are. What no reading
/// reaches stays 0. \pre depth and colour have one size
image::CubeMap<std::uint16_t> fill_holes(const image::CubeMap<std::uint16_t>& depth,
                                         const image::CubeMap<std::uint8_t>& colour,
                                         const HoleFilling& options = {}, int threads = 0);

}  // namespace enfilade::scan
