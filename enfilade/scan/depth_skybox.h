/// \file  Depth cube maps from the 18 undistorted depth images of a panorama.
#pragma once
#include <cstdint>
#include <span>

#include "enfilade/image/image.h"
#include "enfilade/scan/matterport_cameras.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan {

/// A camera and its depth image: z-distance in quarter millimetres, 0: unknown.
struct DepthImage {
  UndistortedCamera camera;
  image::Image16 depth;
};

/// Distance along the ray of each texel, from the panorama's eye, in quarter millimetres. The
/// cameras lie some centimetres off the eye: on each ray, the point is searched whose depth equals
/// the depth in the image there. Readings of several images are blended, weighted by the distance
/// to the edge of the image. Readings more than 2 cm or 2 % apart are of different surfaces (only
/// one camera sees past an edge) and are not blended. The nearest surface that has at least half
/// the weight of each one behind it is taken. Distances above 16.38375 m become that; texels
/// without a reading 0.
/// \param size edge of a face, texels
/// \param threads 0: all cores; does not change the result
image::CubeMap<std::uint16_t> depth_skybox(std::span<const DepthImage> images,
                                           const PanoramaPose& eye, std::uint32_t size,
                                           int threads = 0);

/// Fills texels that are 0 from the readings around them. A cross-bilateral filter guided by the
/// RGB picture, in passes from coarse to fine, across the edges of faces. Other readings do not
/// change. Texels too far from any reading stay 0.
/// \pre depth and colour have one size
image::CubeMap<std::uint16_t> fill_holes(const image::CubeMap<std::uint16_t>& depth,
                                         const image::CubeMap<std::uint8_t>& colour,
                                         int threads = 0);

}  // namespace enfilade::scan
