/// \file  Equirectangular panoramas (2 : 1 pictures of all directions) to cube maps.
#pragma once
#include "enfilade/geometry/angle.h"
#include "enfilade/image/image.h"

namespace enfilade::image {

/// The cube map of an equirectangular picture (width 2 : height 1 within a pixel; the middle column
/// is the panorama frame's +z, the top row is up). A texel is the area average of the pixels it
/// covers where the picture is finer than the face, else a bicubic interpolation.
/// \param size edge of a face, texels; 0: the picture's width / 4, its resolution at the horizon
/// \param heading of the middle column, clockwise, relative to the panorama frame's forward
/// \throws ArgumentError for another shape
CubeMap<std::uint8_t> cube_from_equirectangular(const Image8& picture, std::uint32_t size = 0,
                                                Radians heading = Radians(0), int threads = 0);

}  // namespace enfilade::image
