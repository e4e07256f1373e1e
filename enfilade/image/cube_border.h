/// \file  Borders of cube map faces: one texel all around, taken from the neighbouring faces. With
/// it linear filtering has no seams and needs no test for edges.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/image/face_cells.h"
#include "enfilade/image/image.h"

namespace enfilade::image {

/// Number of texels around a face of size n. Their order: row -1 from x = -1 to n, row n likewise,
/// column -1 from y = 0 to n - 1, column n likewise.
constexpr std::size_t border_texels(std::uint32_t size) { return 4 * std::size_t{size} + 4; }

/// The border of a face as RGB triples. Beyond an edge: the neighbour's texels along that edge. At
/// a corner, where three faces meet: the mean of their corner texels (OpenGL 4.6, 8.14.2.1). \pre
/// faces are square, alike and of 3 channels
std::vector<std::uint8_t> border_of(const CubeMap<std::uint8_t>& faces, CubeFace face);

/// Writes a border of border_of() around a face. \pre border.size() == 3 * border_texels(size)
void write_border(const ColourCells& face, std::span<const std::uint8_t> border);
/// The same for rows begin .. end - 1 only: the texels beside them. Also the row above the face if
/// they begin with its first, and the row below it if they end with its last.
void write_border_rows(const ColourCells& face, std::span<const std::uint8_t> border,
                       std::uint32_t begin, std::uint32_t end);

/// Copies a face's pixels, RGB in rows, without a border. \pre of the face's size
void write_face(const ColourCells& face, const std::uint8_t* rgb);
void write_face(const ColourCells& face, const Image8& picture);

/// Writes the faces in `wanted` (bits 1 << index(CubeFace)) with their borders. Other buffers are
/// not touched.
/// \pre faces are square, alike and of 3 channels; each buffer has their size
void write_faces(const CubeMap<std::uint8_t>& faces, std::uint8_t wanted,
                 const std::array<ColourCells, kCubeFaces>& to);

}  // namespace enfilade::image
