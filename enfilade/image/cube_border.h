/// \file  Borders of cube map faces: one texel all around, taken from the neighbouring faces, so
/// that linear filtering has no seams and needs no test for edges.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/image/image.h"

namespace enfilade::image {

/// One face, RGBA, in the caller's memory. texel(0, 0) is the first texel of the face; texels -1
/// and `size` in both directions are its border.
struct BorderedFace {
  std::uint8_t* origin = nullptr;  ///< texel (0, 0)
  std::size_t stride = 0;          ///< bytes from a row to the next; >= 4 * (size + 2)
  std::uint32_t size = 0;
  /// The four bytes of a texel. \pre -1 <= x, y <= size
  std::uint8_t* texel(std::ptrdiff_t x, std::ptrdiff_t y) const {
    return origin + y * static_cast<std::ptrdiff_t>(stride) + x * 4;
  }
};

/// Number of texels around a face of size n. Their order: row -1 from x = -1 to n, row n likewise,
/// column -1 from y = 0 to n - 1, column n likewise.
constexpr std::size_t border_texels(std::uint32_t size) { return 4 * std::size_t{size} + 4; }

/// The border of a face as RGB triples. Beyond an edge: the neighbour's texels along that edge. At
/// a corner, where three faces meet: the mean of their corner texels (OpenGL 4.6, 8.14.2.1). \pre
/// faces are square, alike and of 3 channels
std::vector<std::uint8_t> border_of(const CubeMap<std::uint8_t>& faces, CubeFace face);

/// Writes a border of border_of() around a face, with alpha 255. \pre border.size() == 3 *
/// border_texels(size)
void write_border(const BorderedFace& face, std::span<const std::uint8_t> border);

/// Copies a face's pixels, RGB in rows, with alpha 255, without a border. \pre of the face's size
void write_face(const BorderedFace& face, const std::uint8_t* rgb);
void write_face(const BorderedFace& face, const Image8& picture);

/// Writes the faces in `wanted` (bits 1 << index(CubeFace)) with their borders; other buffers are
/// not touched. \pre faces are square, alike and of 3 channels; each buffer has their size
void write_faces(const CubeMap<std::uint8_t>& faces, std::uint8_t wanted,
                 const std::array<BorderedFace, kCubeFaces>& to);

}  // namespace enfilade::image
