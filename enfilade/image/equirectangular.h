/// \file  Panoramas as people's cameras and the web have them: 2 : 1 pictures of all directions.
#pragma once
#include "enfilade/geometry/angle.h"
#include "enfilade/image/image.h"

namespace enfilade::image {

/// Cuts a cube map out of an equirectangular picture (width 2 : height 1 within a pixel; its middle
/// column looks along the panorama frame's +z, its top row up). Each texel is the area average of
/// what it covers where the picture is the finer one, else a bicubic interpolation.
/// \param size of a face, pixels; 0: the picture's width / 4, its resolution at the horizon
/// \param heading of the middle column, clockwise, relative to the panorama frame's forward
/// \throws ArgumentError for another shape
CubeMap<std::uint8_t> cube_from_equirectangular(const Image8& picture, std::uint32_t size = 0,
                                                Radians heading = Radians(0), int threads = 0);

}  // namespace enfilade::image
