/// \file  Reads single texels of colour faces, to compare them.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "enfilade/image/face_cells.h"

namespace enfilade::image {

/// The texel of a face in cells. \pre -1 <= x, y <= size
inline std::array<std::uint8_t, 3> colour_texel(const std::uint8_t* cells, std::uint32_t size,
                                                std::ptrdiff_t x, std::ptrdiff_t y) {
  auto column = static_cast<std::size_t>(x + 1);
  std::size_t last = 0;  // 1 for the last column of a face whose last strip it does not begin
  if (column / ColourCells::kColumns == ColourCells::strips(size)) last = 1;
  column -= last;
  const std::uint8_t* texel = cells +
                              ColourCells::offset(size, column, static_cast<std::size_t>(y + 1)) +
                              last * ColourCells::kTexelBytes;
  constexpr std::uint8_t kFlip = 0x80;
  std::array<std::uint8_t, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c) rgb[c] = texel[c] ^ kFlip;
  return rgb;
}

}  // namespace enfilade::image
