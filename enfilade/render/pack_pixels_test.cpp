#include "enfilade/render/renderer.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>
#include <vector>

namespace enfilade::render {
namespace EN_UNIT {

constexpr std::uint32_t kWidth = 5, kHeight = 3;
constexpr std::size_t kPixels = kWidth * kHeight, kViews = 2;

std::uint32_t pixel(std::size_t k) {
  const auto n = static_cast<std::uint32_t>(k);
  return n | (n + 100) << 8 | (n + 200) << 16 | 255U << 24;
}

// Packs all views row by row.
std::vector<std::byte> packed(ColourFormat format, const Normalisation& normalisation = {}) {
  std::vector<std::byte> bytes(kViews * kPixels * pixel_bytes(format));
  const ColourOutput output{format, normalisation, bytes};
  for (std::size_t view = 0; view < kViews; ++view) {
    for (std::size_t row = 0; row < kHeight; ++row) {
      std::array<std::uint32_t, kWidth> rgba;
      for (std::size_t j = 0; j < kWidth; ++j) {
        rgba[j] = pixel(view * kPixels + row * kWidth + j);
      }
      pack_colours(output, {view, row * kWidth, kPixels}, rgba);
    }
  }
  return bytes;
}

TEST(PackPixels, Interleaved) {
  for (const ColourFormat format :
       {ColourFormat::kRgb8, ColourFormat::kBgr8, ColourFormat::kRgba8}) {
    const std::vector<std::byte> bytes = packed(format);
    const std::size_t size = pixel_bytes(format);
    for (std::size_t k = 0; k < kViews * kPixels; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t from = format == ColourFormat::kBgr8 ? 2 - c : c;
        EXPECT_EQ(std::to_integer<std::uint32_t>(bytes[k * size + c]), pixel(k) >> 8 * from & 255)
            << k << ' ' << c;
      }
    }
  }
}

TEST(PackPixels, Planes) {
  const Normalisation normalisation{{0.5F, 0.25F, 0}, {0.5F, 1, 2}};
  const std::vector<std::byte> bytes = packed(ColourFormat::kPlanarFloat32, normalisation);
  for (std::size_t view = 0; view < kViews; ++view) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < kPixels; ++k) {
        float value = 0;
        std::memcpy(&value, bytes.data() + 4 * ((3 * view + c) * kPixels + k), 4);
        const auto byte = static_cast<float>(pixel(view * kPixels + k) >> 8 * c & 255);
        EXPECT_NEAR(value, (byte / 255 - normalisation.mean[c]) / normalisation.deviation[c], 1e-6);
      }
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::render
