#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "enfilade/core/errors.h"
#include "enfilade/scan/depth_skybox.h"

namespace enfilade::scan {
namespace EN_UNIT {

using ::testing::HasSubstr;
using Depth = image::CubeMap<std::uint16_t>;
using Colour = image::CubeMap<std::uint8_t>;

constexpr auto kFront = index(CubeFace::kFront);
constexpr auto kRight = index(CubeFace::kRight);

Depth depth_of(std::uint32_t size, std::uint16_t value) {
  Depth depth;
  for (auto& face : depth) {
    face = image::Image16(size, size, 1);
    face.pixels.assign(face.pixels.size(), value);
  }
  return depth;
}

Colour grey(std::uint32_t size, std::uint8_t value) {
  Colour colour;
  for (auto& face : colour) {
    face = image::Image8(size, size, 3);
    face.pixels.assign(face.pixels.size(), value);
  }
  return colour;
}

/// Readings with holes of all sizes, and a picture of noise.
std::pair<Depth, Colour> random_panorama(std::uint32_t size) {
  std::mt19937 random(7);
  Depth depth = depth_of(size, 0);
  Colour colour = grey(size, 0);
  for (auto& face : depth) {
    for (auto& d : face.pixels) {
      d = static_cast<std::uint16_t>(random() % 3 == 0 ? 0 : 1 + random() % 65535);
    }
    for (std::size_t i = 0; i < face.pixels.size() / 2; ++i) face.pixels[i] = 0;
  }
  for (auto& face : colour) {
    for (auto& c : face.pixels) c = static_cast<std::uint8_t>(random());
  }
  return {depth, colour};
}

TEST(FillHoles, LeavesReadingsAsTheyAre) {
  const auto [depth, colour] = random_panorama(24);
  const Depth filled = fill_holes(depth, colour);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    for (std::size_t i = 0; i < depth[k].pixels.size(); ++i) {
      if (depth[k].pixels[i] == 0) continue;
      ASSERT_EQ(filled[k].pixels[i], depth[k].pixels[i]);
    }
  }
}

TEST(FillHoles, TakesTheDepthOfItsOwnColoursSide) {
  // A door frame at 2 m before a wall at 4 m; the camera lost a band across the edge.
  const std::uint32_t n = 96;
  Depth depth = depth_of(n, 8000);
  Colour colour = grey(n, 200);
  for (std::size_t y = 0; y < n; ++y) {
    for (std::size_t x = 0; x < n; ++x) {
      if (x < n / 2) {
        *depth[kFront].at(x, y) = 16000;
        for (std::size_t c = 0; c < 3; ++c) colour[kFront].at(x, y)[c] = 90;
      }
      if (x > n / 2 - 10 && x < n / 2 + 8 && y > 30 && y < 60) *depth[kFront].at(x, y) = 0;
    }
  }
  const Depth filled = fill_holes(depth, colour);
  for (std::size_t y = 31; y < 60; ++y) {
    for (std::size_t x = n / 2 - 9; x < n / 2 + 8; ++x) {
      // The passes in which the colours count are the last two; in the first, a contrast of 110/255
      // leaves the other side a tenth of the weight, of which little is left in the end.
      const double own = x < n / 2 ? 16000 : 8000;
      ASSERT_NEAR(*filled[kFront].at(x, y), own, .005 * own) << x << ", " << y;
    }
  }
}

TEST(FillHoles, FillsFromAnotherColourWhereThereIsNoLikeOne) {
  // A black screen of which no depth came back, in a white wall.
  Depth depth = depth_of(64, 9000);
  Colour colour = grey(64, 255);
  for (std::size_t y = 20; y < 40; ++y) {
    for (std::size_t x = 20; x < 50; ++x) {
      *depth[kFront].at(x, y) = 0;
      for (std::size_t c = 0; c < 3; ++c) colour[kFront].at(x, y)[c] = 0;
    }
  }
  EXPECT_EQ(fill_holes(depth, colour), depth_of(64, 9000));
}

TEST(FillHoles, WorksOverFaceEdges) {
  const std::uint32_t n = 96;
  Depth depth = depth_of(n, 0);
  depth[kRight].pixels.assign(depth[kRight].pixels.size(), 5000);
  const Depth filled = fill_holes(depth, grey(n, 100));
  // What lies at the edge to the right face takes its value, what lies far from it nothing: windows
  // reach 24, 10 and 16 texels, and once more as far as seen on the neighbour's plane.
  for (const std::size_t y : {5U, 48U, 90U}) {
    EXPECT_EQ(*filled[kFront].at(n - 1, y), 5000);
    EXPECT_EQ(*filled[kFront].at(n - 20, y), 5000);
    EXPECT_EQ(*filled[kFront].at(10, y), 0);
  }
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_EQ(*filled[index(CubeFace::kUp)].at(0, i), 5000);  // its left edge meets the right face
    EXPECT_EQ(*filled[index(CubeFace::kDown)].at(0, i), 5000);  // likewise
    EXPECT_EQ(*filled[index(CubeFace::kBack)].at(0, i), 5000);  // right and back meet there
    EXPECT_EQ(*filled[index(CubeFace::kLeft)].at(i, 48), 0);
  }
}

TEST(FillHoles, ContinuesASlantedWall) {
  const std::uint32_t n = 96;
  Depth depth = depth_of(n, 8000);
  for (std::size_t y = 0; y < n; ++y) {
    for (std::size_t x = 0; x < n; ++x) {
      const bool hole = x > 40 && x < 52 && y > 40 && y < 52;
      *depth[kFront].at(x, y) = static_cast<std::uint16_t>(hole ? 0 : 8000 + 20 * x);
    }
  }
  const Depth filled = fill_holes(depth, grey(n, 100));
  for (std::size_t y = 41; y < 52; ++y) {
    for (std::size_t x = 41; x < 52; ++x) {
      // Means flatten the slope within a hole: by less than half its width.
      ASSERT_NEAR(*filled[kFront].at(x, y), 8000 + 20 * static_cast<double>(x), 20 * 6);
    }
  }
}

TEST(FillHoles, ChangesNothingWhereAllOrNothingIsKnown) {
  EXPECT_EQ(fill_holes(depth_of(8, 0), grey(8, 3)), depth_of(8, 0));
  EXPECT_EQ(fill_holes(depth_of(8, 77), grey(8, 3)), depth_of(8, 77));
}

TEST(FillHoles, IsTheSameAtAnyNumberOfThreads) {
  const auto [depth, colour] = random_panorama(40);
  EXPECT_EQ(fill_holes(depth, colour, 1), fill_holes(depth, colour, 2));
}

TEST(FillHoles, RefusesOtherSizes) {
  try {
    fill_holes(depth_of(8, 1), grey(9, 1));
    FAIL() << "accepted";
  } catch (const ArgumentError& error) {
    EXPECT_THAT(std::string(error.what()),
                HasSubstr("depth 8 x 8 x 1, colour 9 x 9 x 3; allowed: 8 x 8 x 1 and 8 x 8 x 3"));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
