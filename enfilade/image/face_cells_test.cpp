#include "enfilade/image/face_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "tests/support/colour_texel.h"

namespace enfilade::image {
namespace EN_UNIT {

// A texel that says where it is.
std::array<std::uint8_t, 3> label(std::ptrdiff_t x, std::ptrdiff_t y) {
  return {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
          static_cast<std::uint8_t>(7 * x + 3 * y)};
}

// Around the sizes at which a border's column begins a strip of its own.
constexpr std::array<std::uint32_t, 8> kSizes{1, 2, 16, 17, 18, 19, 35, 70};

std::vector<std::uint8_t> labelled(std::uint32_t size) {
  std::vector<std::uint8_t> memory(ColourCells::bytes(size), 0xEE);
  const ColourCells face{memory.data(), size};
  const auto n = static_cast<std::ptrdiff_t>(size);
  std::vector<std::uint8_t> row(3 * std::size_t{size});
  for (std::ptrdiff_t y = 0; y < n; ++y) {
    for (std::ptrdiff_t x = 0; x < n; ++x) {
      std::ranges::copy(label(x, y), row.begin() + 3 * x);
    }
    face.write_row(static_cast<std::size_t>(y), row.data());
  }
  for (std::ptrdiff_t k = -1; k <= n; ++k) {
    for (const auto& [x, y] :
         {std::pair{k, std::ptrdiff_t{-1}}, {k, n}, {std::ptrdiff_t{-1}, k}, {n, k}}) {
      face.write(x, y, label(x, y).data());
    }
  }
  return memory;
}

TEST(ColourCells, GiveBackWhatWasWritten) {
  for (const std::uint32_t size : kSizes) {
    const auto memory = labelled(size);
    const auto n = static_cast<std::ptrdiff_t>(size);
    for (std::ptrdiff_t y = -1; y <= n; ++y) {
      for (std::ptrdiff_t x = -1; x <= n; ++x) {
        EXPECT_EQ(colour_texel(memory.data(), size, x, y), label(x, y))
            << "size " << size << " at " << x << ", " << y;
      }
    }
  }
}

TEST(ColourCells, HaveEachTexelAndItsRightNeighbourInOneCell) {
  for (const std::uint32_t size : kSizes) {
    const auto memory = labelled(size);
    for (std::uint32_t y = 0; y < size + 2; ++y) {
      for (std::uint32_t x = 0; x <= size; ++x) {
        const std::size_t at = ColourCells::offset(size, x, y);
        ASSERT_LE(at + 8, memory.size());                   // what a load of a pair reads
        ASSERT_EQ(at / kCellBytes, (at + 7) / kCellBytes);  // within one line
        const auto right = label(std::ptrdiff_t{x}, std::ptrdiff_t{y} - 1);
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_EQ(memory[at + 3 + c] ^ 0x80, right[c]) << "size " << size << " at " << x;
        }
      }
    }
  }
}

TEST(ColourCells, BecomePlainRows) {
  for (const std::uint32_t size : kSizes) {
    const auto memory = labelled(size);
    std::vector<std::uint8_t> rgb(3 * std::size_t{size} * size);
    plain_rgb(memory.data(), size, rgb);
    const std::uint8_t* pixel = rgb.data();
    for (std::ptrdiff_t y = 0; y < std::ptrdiff_t{size}; ++y) {
      for (std::ptrdiff_t x = 0; x < std::ptrdiff_t{size}; ++x, pixel += 3) {
        ASSERT_TRUE(std::ranges::equal(label(x, y), std::span(pixel, 3))) << size;
      }
    }
  }
}

TEST(ColourCells, BecomeRowsWithTheirBorder) {
  const auto memory = labelled(19);
  std::vector<std::uint8_t> rgba(4 * 21 * 21);
  bordered_rgba(memory.data(), 19, rgba);
  for (std::ptrdiff_t y = -1; y <= 19; ++y) {
    for (std::ptrdiff_t x = -1; x <= 19; ++x) {
      const std::uint8_t* texel = rgba.data() + 4 * ((y + 1) * 21 + x + 1);
      EXPECT_TRUE(std::ranges::equal(label(x, y), std::span(texel, 3)));
      EXPECT_EQ(texel[3], 255);
    }
  }
}

template <class T>
void check_values() {
  for (const std::uint32_t size : kSizes) {
    std::vector<T> rows(std::size_t{size} * size), back(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<T>(k * 2654435761U);
    std::vector<std::uint8_t> cells(ValueCells<T>::bytes(size));
    ValueCells<T>::from_rows(rows.data(), size, cells.data());
    ValueCells<T>::to_rows(cells.data(), size, back.data());
    EXPECT_EQ(back, rows) << size;
    for (std::uint32_t y = 0; y < size; ++y) {
      for (std::uint32_t x = 0; x < size; ++x) {
        T value = 0;
        std::memcpy(&value, cells.data() + ValueCells<T>::offset(size, x, y), sizeof(T));
        ASSERT_EQ(value, rows[std::size_t{y} * size + x]);
      }
    }
  }
}

TEST(ValueCells, GiveBackWhatWasWritten) {
  check_values<std::uint16_t>();
  check_values<std::uint32_t>();
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
