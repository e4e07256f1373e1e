/// \file  The frame of texels around a face, taken from its neighbours, with which linear filtering
/// has no seams and needs no test for edges.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/image/image.h"

namespace enfilade::image {

/// One face, RGBA, in memory of the caller: `texel(0, 0)` is its first texel; texels -1 and `size`
/// in both directions are its border, which is addressable too.
struct BorderedFace {
  std::uint8_t* origin = nullptr;  ///< texel (0, 0)
  std::size_t stride = 0;          ///< bytes from a row to the next; >= 4 * (size + 2)
  std::uint32_t size = 0;
  std::uint8_t* texel(std::ptrdiff_t x, std::ptrdiff_t y) const {
    return origin + y * static_cast<std::ptrdiff_t>(stride) + x * 4;
  }
};

/// RGB triples of the texels around a face of size n: row -1 from x = -1 to n, then row n likewise,
/// column -1 from y = 0 to n - 1, column n likewise.
constexpr std::size_t border_texels(std::uint32_t size) { return 4 * std::size_t{size} + 4; }

/// The border of a face: beyond an edge lies the neighbour's row of texels along that edge; at a
/// corner, where three faces meet, the mean of their three corner texels (OpenGL 4.6, 8.14.2.1).
/// \pre faces are square, alike and of 3 channels
std::vector<std::uint8_t> border_of(const CubeMap<std::uint8_t>& faces, CubeFace face);

/// Writes such a border around a face, alpha 255. \pre border.size() == 3 * border_texels(size)
void write_border(const BorderedFace& face, std::span<const std::uint8_t> border);

/// Copies a face (3 channels) to its place, alpha 255, without the border.
void write_face(const BorderedFace& face, const Image8& picture);

/// Both, for the faces in `wanted` (bits 1 << index(CubeFace)); the other places are not looked at.
/// \pre faces are square, alike and of 3 channels; each place has their size
void write_faces(const CubeMap<std::uint8_t>& faces, std::uint8_t wanted,
                 const std::array<BorderedFace, kCubeFaces>& to);

}  // namespace enfilade::image
