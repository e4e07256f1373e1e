#include "enfilade/image/face_cells.h"

#include <algorithm>
#include <cstring>

#include "enfilade/core/check.h"

namespace enfilade::image {
namespace {

constexpr std::uint8_t kFlip = 0x80;

constexpr std::uint64_t kFlips = 0x8080808080808080U;

// Sixteen bytes, which compilers make one register.
void flip16(const std::uint8_t* from, std::uint8_t* to) {
  std::array<std::uint64_t, 2> words;
  std::memcpy(words.data(), from, sizeof(words));
  words[0] ^= kFlips;
  words[1] ^= kFlips;
  std::memcpy(to, words.data(), sizeof(words));
}

// Copies texels and flips their upper bits.
void flip_copy(const std::uint8_t* from, std::size_t bytes, std::uint8_t* to) {
  std::size_t k = 0;
  for (; k + 16 <= bytes; k += 16) flip16(from + k, to + k);
  for (; k < bytes; ++k) to[k] = from[k] ^ kFlip;
}

// A whole row of a cell: the last sixteen bytes overlap those before.
void flip_copy_cell(const std::uint8_t* from, std::uint8_t* to) {
  constexpr std::size_t kLast = (ColourCells::kColumns + 1) * ColourCells::kTexelBytes - 16;
  static_assert(kLast <= 48);
  flip16(from, to);
  flip16(from + 16, to + 16);
  flip16(from + 32, to + 32);
  flip16(from + kLast, to + kLast);
}

// Columns and rows first .. end - 1 of a face, counted from its border's, as RGB or RGBA.
template <std::size_t kChannels>
void write_rows(const std::uint8_t* cells, std::uint32_t size, std::size_t first, std::size_t end,
                std::uint8_t* out) {
  const std::size_t width = end - first;
  for (std::size_t strip = 0; strip < ColourCells::strips(size); ++strip) {
    const std::size_t left = strip * ColourCells::kColumns;
    // The last strip's 19th texel may be the face's last column.
    const std::size_t from = std::max(first, left);
    const std::size_t to = std::min(end, left + ColourCells::kColumns + 1);
    for (std::size_t y = first; y < end; ++y) {
      const std::uint8_t* texel = cells + strip * ColourCells::pitch(size) + y * kCellBytes +
                                  (from - left) * ColourCells::kTexelBytes;
      std::uint8_t* pixel = out + kChannels * ((y - first) * width + from - first);
      for (std::size_t x = from; x < to; ++x, texel += 3, pixel += kChannels) {
        for (std::size_t c = 0; c < 3; ++c) pixel[c] = texel[c] ^ kFlip;
        if constexpr (kChannels == 4) pixel[3] = 255;
      }
    }
  }
}

// The columns of strip k that a value face has.
template <class T>
std::size_t columns_of(std::size_t strip, std::uint32_t size) {
  return std::min<std::size_t>(ValueCells<T>::kColumns, size - strip * ValueCells<T>::kColumns);
}

}  // namespace

void ColourCells::write(std::ptrdiff_t x, std::ptrdiff_t y, const std::uint8_t* rgb) const {
  const auto column = static_cast<std::size_t>(x + 1), row = static_cast<std::size_t>(y + 1);
  const std::size_t strip = column / kColumns, place = column % kColumns;
  std::uint8_t* cell = cells + row * kCellBytes;
  if (strip < strips(size)) {
    flip_copy(rgb, kTexelBytes, cell + strip * pitch(size) + place * kTexelBytes);
  }
  if (place == 0 && strip > 0) {
    flip_copy(rgb, kTexelBytes, cell + (strip - 1) * pitch(size) + kColumns * kTexelBytes);
  }
}

void ColourCells::write_row(std::size_t y, const std::uint8_t* rgb) const {
  std::uint8_t* cell = cells + (y + 1) * kCellBytes;
  // The first strip begins with a texel of the border.
  const std::size_t first = std::min<std::size_t>(kColumns, size);
  flip_copy(rgb, first * kTexelBytes, cell + kTexelBytes);
  for (std::size_t strip = 1; strip < strips(size); ++strip) {
    cell += pitch(size);
    const std::size_t begin = strip * kColumns - 1;  // of the face's own texels
    if (begin + kColumns + 1 <= size) {
      flip_copy_cell(rgb + begin * kTexelBytes, cell);
    } else {
      flip_copy(rgb + begin * kTexelBytes, (size - begin) * kTexelBytes, cell);
    }
  }
}

std::array<std::uint8_t, 3> colour_texel(const std::uint8_t* cells, std::uint32_t size,
                                         std::ptrdiff_t x, std::ptrdiff_t y) {
  auto column = static_cast<std::size_t>(x + 1);
  std::size_t last = 0;  // 1 for the last column of a face whose last strip it does not begin
  if (column / ColourCells::kColumns == ColourCells::strips(size)) last = 1;
  column -= last;
  const std::uint8_t* texel = cells +
                              ColourCells::offset(size, column, static_cast<std::size_t>(y + 1)) +
                              last * ColourCells::kTexelBytes;
  std::array<std::uint8_t, 3> rgb;
  flip_copy(texel, 3, rgb.data());
  return rgb;
}

void bordered_rgba(const std::uint8_t* cells, std::uint32_t size, std::span<std::uint8_t> rgba) {
  EN_CHECK_EQ(rgba.size(), 4 * (std::size_t{size} + 2) * (std::size_t{size} + 2));
  write_rows<4>(cells, size, 0, std::size_t{size} + 2, rgba.data());
}

void plain_rgb(const std::uint8_t* cells, std::uint32_t size, std::span<std::uint8_t> rgb) {
  EN_CHECK_EQ(rgb.size(), 3 * std::size_t{size} * size);
  write_rows<3>(cells, size, 1, std::size_t{size} + 1, rgb.data());
}

template <class T>
void ValueCells<T>::from_rows(const T* rows, std::uint32_t size, std::uint8_t* cells) {
  for (std::size_t strip = 0; strip * kColumns < size; ++strip) {
    const std::size_t bytes = columns_of<T>(strip, size) * sizeof(T);
    const T* from = rows + strip * kColumns;
    std::uint8_t* cell = cells + strip * pitch(size);
    for (std::uint32_t y = 0; y < size; ++y, from += size, cell += kCellBytes) {
      std::memcpy(cell, from, bytes);
    }
  }
}

template <class T>
void ValueCells<T>::to_rows(const std::uint8_t* cells, std::uint32_t size, T* rows) {
  for (std::size_t strip = 0; strip * kColumns < size; ++strip) {
    const std::size_t bytes = columns_of<T>(strip, size) * sizeof(T);
    T* to = rows + strip * kColumns;
    const std::uint8_t* cell = cells + strip * pitch(size);
    for (std::uint32_t y = 0; y < size; ++y, to += size, cell += kCellBytes) {
      std::memcpy(to, cell, bytes);
    }
  }
}

template struct ValueCells<std::uint16_t>;
template struct ValueCells<std::uint32_t>;

}  // namespace enfilade::image
