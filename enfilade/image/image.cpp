#include "enfilade/image/image.h"

#include <fmt/format.h>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/image/detail/row_shrinker.h"

namespace enfilade::image {
namespace {

// The faces' width. \throws ArgumentError unless they are square and alike
template <class T>
std::uint32_t checked_size(const CubeMap<T>& faces) {
  const std::uint32_t size = faces[0].width;
  for (const Image<T>& face : faces) {
    if (size == 0 || face.width != size || face.height != size ||
        face.channels != faces[0].channels) {
      throw ArgumentError(
          fmt::format("faces: one of {} x {} pixels, {} channels; they have to be square and alike",
                      face.width, face.height, face.channels));
    }
  }
  return size;
}

// Copies a face to a place counted in faces.
template <class T>
void paste(const Image<T>& face, std::size_t column, std::size_t row, Image<T>& onto) {
  for (std::size_t y = 0; y < face.height; ++y) {
    std::copy_n(face.at(0, y), std::size_t{face.width} * face.channels,
                onto.at(column * face.width, row * face.height + y));
  }
}

}  // namespace

std::uint16_t depth_units(double metres) {
  return static_cast<std::uint16_t>(
      std::clamp(std::round(metres * kDepthUnitsPerMetre), 1.0, 65535.0));
}

template <class T>
CubeMap<T> split_strip(const Image<T>& strip) {
  if (strip.height == 0 || strip.width != 6 * std::uint64_t{strip.height}) {
    throw ArgumentError(fmt::format("strip: {} x {} pixels, not six squares side by side",
                                    strip.width, strip.height));
  }
  CubeMap<T> faces;
  const std::size_t row = std::size_t{strip.height} * strip.channels;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    faces[k] = Image<T>(strip.height, strip.height, strip.channels);
    for (std::size_t y = 0; y < strip.height; ++y) {
      std::copy_n(strip.at(k * strip.height, y), row, faces[k].at(0, y));
    }
  }
  return faces;
}

template <class T>
Image<T> join_strip(const CubeMap<T>& faces) {
  Image<T> strip(6 * checked_size(faces), faces[0].width, faces[0].channels);
  for (std::size_t k = 0; k < kCubeFaces; ++k) paste(faces[k], k, 0, strip);
  return strip;
}

template <class T>
Image<T> join_cross(const CubeMap<T>& faces) {
  const std::uint32_t size = checked_size(faces);
  Image<T> cross(4 * size, 3 * size, faces[0].channels);
  const auto put = [&](CubeFace face, std::size_t column) {
    paste(faces[index(face)], column, 1, cross);
  };
  put(CubeFace::kLeft, 0);
  put(CubeFace::kFront, 1);
  put(CubeFace::kRight, 2);
  put(CubeFace::kBack, 3);
  paste(half_turn(faces[index(CubeFace::kUp)]), 1, 0, cross);
  paste(half_turn(faces[index(CubeFace::kDown)]), 1, 2, cross);
  return cross;
}

template <class T>
Image<T> half_turn(const Image<T>& picture) {
  Image<T> turned = picture;
  for (std::size_t y = 0; y < picture.height; ++y) {
    for (std::size_t x = 0; x < picture.width; ++x) {
      std::copy_n(picture.at(x, y), picture.channels,
                  turned.at(picture.width - 1 - x, picture.height - 1 - y));
    }
  }
  return turned;
}

template <class T>
Image<T> rows(const Image<T>& picture, std::size_t first, std::size_t count) {
  Image<T> part(picture.width, static_cast<std::uint32_t>(count), picture.channels);
  std::copy_n(picture.at(0, first), part.pixels.size(), part.pixels.begin());
  return part;
}

template CubeMap<std::uint8_t> split_strip(const Image8&);
template CubeMap<std::uint16_t> split_strip(const Image16&);
template CubeMap<std::uint32_t> split_strip(const Image32&);
template Image8 join_strip(const CubeMap<std::uint8_t>&);
template Image16 join_strip(const CubeMap<std::uint16_t>&);
template Image32 join_strip(const CubeMap<std::uint32_t>&);
template Image8 join_cross(const CubeMap<std::uint8_t>&);
template Image16 join_cross(const CubeMap<std::uint16_t>&);
template Image32 join_cross(const CubeMap<std::uint32_t>&);
template Image8 half_turn(const Image8&);
template Image8 rows(const Image8&, std::size_t, std::size_t);

Image8 shrink(const Image8& picture, std::uint32_t width, std::uint32_t height) {
  if (width == 0 || height == 0 || width > picture.width || height > picture.height) {
    throw ArgumentError(
        fmt::format("shrink: to {} x {} pixels; from 1 x 1 to the picture's {} x {} are allowed",
                    width, height, picture.width, picture.height));
  }
  if (width == picture.width && height == picture.height) return picture;
  Image8 small(width, height, picture.channels);
  detail::RowShrinker rows({picture.width, picture.height}, {width, height}, picture.channels,
                           small.pixels.data());
  for (std::size_t y = 0; y < picture.height; ++y) rows.add(picture.at(0, y));
  return small;
}

}  // namespace enfilade::image
