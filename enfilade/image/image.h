/// \file  Pictures in memory.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::image {

/// A picture that owns its pixels: shape (height, width, channels), row 0 on top, no padding.
/// A plain value. Colours are RGB.
template <class T>
struct Image {
  std::uint32_t width = 0, height = 0, channels = 1;
  std::vector<T> pixels;

  Image() = default;
  /// A picture of zeros: width, height, channels.
  Image(std::uint32_t w, std::uint32_t h, std::uint32_t c)
      : width(w), height(h), channels(c), pixels(std::size_t{w} * h * c) {}
  /// The channels of the pixel in column x of row y. \pre x < width, y < height
  T* at(std::size_t x, std::size_t y) { return pixels.data() + (y * width + x) * channels; }
  const T* at(std::size_t x, std::size_t y) const {
    return pixels.data() + (y * width + x) * channels;
  }
  friend bool operator==(const Image&, const Image&) = default;
};
/// Pictures by the type of their values.
using Image8 = Image<std::uint8_t>;
using Image16 = Image<std::uint16_t>;
using Image32 = Image<std::uint32_t>;
using ImageF = Image<float>;

/// Units of a picture of depth (Image16) in a metre: a unit is a quarter millimetre; 0 is no
/// reading.
inline constexpr double kDepthUnitsPerMetre = 4000;
/// A distance in these units: rounded, and 1 .. 65535 (16.38 m), as 0 has another meaning.
std::uint16_t depth_units(double metres);

/// Six square pictures of one size and channel count, by index(CubeFace).
template <class T>
using CubeMap = std::array<Image<T>, kCubeFaces>;

/// Copies the pixels of the faces in `wanted` (bits 1 << index(CubeFace)) to buffers of their size;
/// other buffers are not touched.
template <class T>
void copy_faces(const CubeMap<T>& faces, std::uint8_t wanted,
                const std::array<T*, kCubeFaces>& to) {
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if ((wanted >> k & 1) != 0) std::ranges::copy(faces[k].pixels, to[k]);
  }
}

/// Splits a strip of six faces side by side. \throws ArgumentError unless width == 6 * height > 0
template <class T>
CubeMap<T> split_strip(const Image<T>& strip);
/// Its inverse. \throws ArgumentError unless the faces are square and alike
template <class T>
Image<T> join_strip(const CubeMap<T>& faces);

/// The unfolded cube: a cross of 4 x 3 faces around the front one. Its top and bottom faces hang on
/// the front one (a strip's on the back one). The corners are 0.
/// \throws ArgumentError unless the faces are square and alike
/// \throws as join_strip()
template <class T>
Image<T> join_cross(const CubeMap<T>& faces);

/// The cube map of an equirectangular picture (width 2 : height 1 within a pixel; the middle column
/// is the panorama frame's +z, the top row is up). A texel is the area average of the pixels it
/// covers where the picture is finer than the face, else a bicubic interpolation.
/// \param size edge of a face, texels; 0: the picture's width / 4, its resolution at the horizon
/// \param heading of the middle column, clockwise, relative to the panorama frame's forward
/// \param panorama_from_picture a rotation that levels a tilted picture; `heading` is 0 then
/// \throws ArgumentError for another shape
CubeMap<std::uint8_t> cube_from_equirectangular(const Image8& picture, std::uint32_t size = 0,
                                                Radians heading = Radians(0), int threads = 0,
                                                const Mat3d& panorama_from_picture = {});

/// The picture turned by 180 degrees.
template <class T>
Image<T> half_turn(const Image<T>& picture);
/// Rows `first` to `first` + `count` of a picture. \pre it has them
template <class T>
Image<T> rows(const Image<T>& picture, std::size_t first, std::size_t count);

/// Area average, as Matterport3DSimulator's preprocessing shrinks sky-boxes. Any ratio >= 1 in each
/// direction. A pixel is the exact mean of the area it covers, rounded to nearest.
/// \throws ArgumentError for a size of 0 or above the picture's
Image8 shrink(const Image8& picture, std::uint32_t width, std::uint32_t height);

}  // namespace enfilade::image
