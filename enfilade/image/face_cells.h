/// \file  Decoded faces in the layout for rendering: cells of 64 bytes, a cache line, that hold a
/// few neighbouring texels of one row. Cells of the same columns lie one below the other, in a
/// strip. So no load crosses a cache line, and a view turned by any angle reads runs of lines. Why,
/// and why these numbers: docs/design/kernels.md. Borders, one texel all around, are taken from the
/// neighbouring faces: with them linear filtering has no seams and needs no test for edges.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/image/image.h"

namespace enfilade::image {

/// Bytes of a cell.
inline constexpr std::size_t kCellBytes = 64;
/// The longest edge of a face, in texels, above any panorama's. Offsets in a face fit into 31 bits.
/// A hostile index of a store cannot request all memory.
inline constexpr std::uint32_t kLargestCellFace = 16384;

/// A colour face with a border of one texel all around, in the caller's memory. A cell has the
/// columns 18 k .. 18 k + 18, counted from the border's; the last is also the next strip's first,
/// so that any two neighbours lie in one cell. A texel is R G B, each less 128 (exclusive or with
/// 0x80).
struct ColourCells {
  std::uint8_t* cells = nullptr;  ///< bytes(size), aligned to kCellBytes
  std::uint32_t size = 0;         ///< texels along an edge, border not counted

  static constexpr std::uint32_t kColumns = 18;
  static constexpr std::size_t kTexelBytes = 3;

  /// How many strips a face has.
  static constexpr std::size_t strips(std::uint32_t size) { return size / kColumns + 1; }
  /// Bytes from a strip to the next.
  static constexpr std::size_t pitch(std::uint32_t size) {
    return kCellBytes * (std::size_t{size} + 2);
  }
  /// Bytes of a face, a multiple of kCellBytes.
  static constexpr std::size_t bytes(std::uint32_t size) { return strips(size) * pitch(size); }
  /// Where the texel at column x and row y begins, both counted from the border's.
  static constexpr std::size_t offset(std::uint32_t size, std::size_t x, std::size_t y) {
    const std::size_t strip = x / kColumns;
    return strip * pitch(size) + y * kCellBytes + (x - strip * kColumns) * kTexelBytes;
  }

  /// \pre -1 <= x, y <= size, 0 being the face's first texel (here and below)
  void write(std::ptrdiff_t x, std::ptrdiff_t y, const std::uint8_t* rgb) const;
  /// Texels 0 .. size - 1 of a row, RGB.
  void write_row(std::size_t y, const std::uint8_t* rgb) const;
};

/// The rows -1 .. size of a face in cells as RGBA, border included, A = 255. \pre rgba has
/// 4 (size + 2)^2 bytes
void bordered_rgba(const std::uint8_t* cells, std::uint32_t size, std::span<std::uint8_t> rgba);
/// Its rows 0 .. size - 1 as RGB, without the border. \pre rgb has 3 size^2 bytes
void plain_rgb(const std::uint8_t* cells, std::uint32_t size, std::span<std::uint8_t> rgb);

/// A face of 16- or 32-bit values: cells of 32 or 16 texels, no border.
template <class T>
struct ValueCells {
  static constexpr std::uint32_t kColumns = kCellBytes / sizeof(T);

  /// Bytes from a strip to the next.
  static constexpr std::size_t pitch(std::uint32_t size) { return kCellBytes * std::size_t{size}; }
  /// Bytes of a face, a multiple of kCellBytes.
  static constexpr std::size_t bytes(std::uint32_t size) {
    return (size + kColumns - 1) / kColumns * pitch(size);
  }
  /// Where the texel at column x and row y begins. \pre x, y < size
  static constexpr std::size_t offset(std::uint32_t size, std::size_t x, std::size_t y) {
    const std::size_t strip = x / kColumns;
    return strip * pitch(size) + y * kCellBytes + (x - strip * kColumns) * sizeof(T);
  }
  /// Writes a face from size x size values in rows. \pre cells are aligned to kCellBytes
  static void from_rows(const T* rows, std::uint32_t size, std::uint8_t* cells);
  /// \pre rows has room for size x size values
  static void to_rows(const std::uint8_t* cells, std::uint32_t size, T* rows);
};
extern template struct ValueCells<std::uint16_t>;
extern template struct ValueCells<std::uint32_t>;

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
