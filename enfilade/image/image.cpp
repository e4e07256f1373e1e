#include "enfilade/image/image.h"

#include <fmt/format.h>
#include <cmath>

#include "enfilade/core/errors.h"

namespace enfilade::image {
namespace {

// The source pixels that an output pixel covers along an axis. Units: a source pixel has `out` of
// them and an output pixel `in`, which are whole numbers, so means are exact.
struct Cover {
  std::size_t first = 0, last = 0;  // source pixels, both included
  std::uint32_t first_weight = 0, last_weight = 0;

  std::uint32_t weight(std::size_t at, std::uint32_t out) const {
    if (at == first) return first_weight;
    return at == last ? last_weight : out;
  }
};

std::vector<Cover> covers(std::uint32_t in, std::uint32_t out) {
  std::vector<Cover> all(out);
  for (std::uint64_t i = 0; i < out; ++i) {
    const std::uint64_t begin = i * in, end = begin + in;  // units
    Cover& cover = all[i];
    cover.first = begin / out;
    cover.last = (end - 1) / out;
    cover.first_weight =
        static_cast<std::uint32_t>(std::min(end, (cover.first + 1) * std::uint64_t{out}) - begin);
    cover.last_weight = static_cast<std::uint32_t>(end - cover.last * std::uint64_t{out});
  }
  return all;
}

// Adds weight * row to sums. 255 * kLongestEdge fits into 32 bits.
void add_row(const std::uint8_t* row, std::uint32_t weight, std::vector<std::uint32_t>& sums) {
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += weight * row[k];
}

// Averages columns of weighted sums down to one output row.
void reduce_row(const std::vector<std::uint32_t>& sums, const Image8& from,
                const std::vector<Cover>& columns, std::uint8_t* row) {
  const std::uint64_t area = std::uint64_t{from.width} * from.height;
  const auto out = static_cast<std::uint32_t>(columns.size());
  for (const Cover& cover : columns) {
    for (std::size_t c = 0; c < from.channels; ++c) {
      std::uint64_t sum = area / 2;
      for (std::size_t x = cover.first; x <= cover.last; ++x) {
        sum += std::uint64_t{cover.weight(x, out)} * sums[x * from.channels + c];
      }
      *row++ = static_cast<std::uint8_t>(sum / area);
    }
  }
}

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
  const std::vector<Cover> columns = covers(picture.width, width);
  const std::vector<Cover> rows = covers(picture.height, height);
  std::vector<std::uint32_t> sums(std::size_t{picture.width} * picture.channels);
  for (std::size_t y = 0; y < height; ++y) {
    std::ranges::fill(sums, 0U);
    for (std::size_t from = rows[y].first; from <= rows[y].last; ++from) {
      add_row(picture.at(0, from), rows[y].weight(from, height), sums);
    }
    reduce_row(sums, picture, columns, small.at(0, y));
  }
  return small;
}

}  // namespace enfilade::image
