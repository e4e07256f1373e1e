#include "enfilade/image/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <random>

#include "enfilade/core/errors.h"

namespace enfilade::image {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

template <class T>
Image<T> numbered(std::uint32_t width, std::uint32_t height, std::uint32_t channels) {
  Image<T> picture(width, height, channels);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    picture.pixels[i] = static_cast<T>(i * 7 + i / 251);
  }
  return picture;
}

template <class T>
class Strips : public ::testing::Test {};
using Texels = ::testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Strips, Texels);

TYPED_TEST(Strips, AreCutIntoFacesAndJoinedAgain) {
  const Image<TypeParam> strip = numbered<TypeParam>(30, 5, 2);
  const CubeMap<TypeParam> faces = split_strip(strip);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    ASSERT_EQ(faces[k].width, 5U);
    ASSERT_EQ(faces[k].channels, 2U);
    EXPECT_EQ(*faces[k].at(1, 4), *strip.at(5 * k + 1, 4)) << k;
  }
  EXPECT_EQ(join_strip(faces), strip);
}

TEST(SplitStrip, RefusesWhatIsNoStrip) {
  EXPECT_THAT([] { split_strip(Image8(12, 3, 3)); },
              ThrowsMessage<ArgumentError>(HasSubstr("12 x 3 pixels, not six squares")));
  EXPECT_THROW(split_strip(Image8()), ArgumentError);
}

TEST(JoinStrip, RefusesFacesThatDiffer) {
  CubeMap<std::uint8_t> faces;
  EXPECT_THROW(join_strip(faces), ArgumentError);
  for (Image8& face : faces) face = Image8(4, 4, 3);
  faces[3] = Image8(4, 5, 3);
  EXPECT_THAT([&] { join_strip(faces); }, ThrowsMessage<ArgumentError>(HasSubstr("4 x 5 pixels")));
  faces[3] = Image8(4, 4, 1);
  EXPECT_THROW(join_strip(faces), ArgumentError);
}

TEST(Shrink, TakesTheMeanOfWholeBlocks) {
  Image8 picture(4, 2, 1);
  picture.pixels = {0,  10, 100, 101,  //
                    20, 30, 102, 104};
  // (0 + 10 + 20 + 30) / 4 = 15; (100 + 101 + 102 + 104) / 4 = 101.75, so 102
  EXPECT_THAT(shrink(picture, 2, 1).pixels, ElementsAre(15, 102));
}

TEST(Shrink, WeighsPixelsByTheAreaThatIsCovered) {
  Image8 picture(3, 1, 1);
  picture.pixels = {30, 60, 240};
  // Each of two covers one and a half: (30 + 60 / 2) / 1.5 = 40, (60 / 2 + 240) / 1.5 = 180
  EXPECT_THAT(shrink(picture, 2, 1).pixels, ElementsAre(40, 180));
  // Up to 5 : 3 along both: the slow twin with reals agrees but where it lies at x.5 but for its
  // own rounding, which the values here don't.
  const Image8 large = numbered<std::uint8_t>(25, 35, 3);
  const Image8 small = shrink(large, 15, 7);
  for (std::size_t y = 0; y < 7; ++y) {
    for (std::size_t x = 0; x < 15; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (std::size_t v = 0; v < 35; ++v) {
          for (std::size_t u = 0; u < 25; ++u) {
            const auto overlap = [](std::size_t at, std::size_t out, double ratio) {
              const auto a = static_cast<double>(at), o = static_cast<double>(out);
              return std::max(0.0, std::min(a + 1, (o + 1) * ratio) - std::max(a, o * ratio));
            };
            sum += overlap(u, x, 25.0 / 15) * overlap(v, y, 5) * large.at(u, v)[c];
          }
        }
        EXPECT_NEAR(small.at(x, y)[c], sum / (25.0 / 15 * 5), 0.5 + 1e-9);
      }
    }
  }
}

TEST(CopyFaces, LooksOnlyAtThoseThatAreWanted) {
  CubeMap<std::uint16_t> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    faces[k] = Image16(2, 2, 1);
    std::ranges::fill(faces[k].pixels, static_cast<std::uint16_t>(1000 * k + 1));
  }
  std::array<std::uint16_t, 4> second{}, fifth{};
  std::array<std::uint16_t*, kCubeFaces> to{};  // the others have no place
  to[2] = second.data();
  to[5] = fifth.data();
  copy_faces(faces, 1U << 2 | 1U << 5, to);
  EXPECT_EQ(second, (std::array<std::uint16_t, 4>{2001, 2001, 2001, 2001}));
  EXPECT_EQ(fifth, (std::array<std::uint16_t, 4>{5001, 5001, 5001, 5001}));
}

TEST(Shrink, KeepsAConstantAndTheSameSize) {
  Image8 flat(37, 23, 3);
  std::ranges::fill(flat.pixels, std::uint8_t{255});
  for (const std::uint8_t value : shrink(flat, 10, 22).pixels) EXPECT_EQ(value, 255);
  const Image8 picture = numbered<std::uint8_t>(6, 4, 3);
  EXPECT_EQ(shrink(picture, 6, 4), picture);
}

TEST(Shrink, RefusesToEnlarge) {
  const Image8 picture(4, 4, 1);
  EXPECT_THROW(shrink(picture, 5, 4), ArgumentError);
  EXPECT_THROW(shrink(picture, 4, 0), ArgumentError);
}

TEST(Rows, CutOneOfManyViews) {
  Image8 picture(1, 4, 1);
  picture.pixels = {1, 2, 3, 4};
  EXPECT_EQ(rows(picture, 2, 2).pixels, (std::vector<std::uint8_t>{3, 4}));
}

TEST(HalfTurn, SwapsCorners) {
  Image8 picture(2, 2, 1);
  picture.pixels = {1, 2, 3, 4};
  EXPECT_EQ(half_turn(picture).pixels, (std::vector<std::uint8_t>{4, 3, 2, 1}));
}

TEST(JoinCross, HangsTopAndBottomOnTheFront) {
  CubeMap<std::uint16_t> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    faces[k] = Image16(2, 2, 1);
    for (std::size_t i = 0; i < 4; ++i) {
      faces[k].pixels[i] = static_cast<std::uint16_t>(10 * (k + 1) + i);
    }
  }
  const Image16 cross = join_cross(faces);
  EXPECT_EQ(cross.width, 8U);
  EXPECT_EQ(cross.height, 6U);
  const auto first = [&](CubeFace face) { return 10 * (index(face) + 1); };
  EXPECT_EQ(*cross.at(2, 2), first(CubeFace::kFront));
  EXPECT_EQ(*cross.at(0, 2), first(CubeFace::kLeft));
  EXPECT_EQ(*cross.at(7, 3), first(CubeFace::kBack) + 3);
  EXPECT_EQ(*cross.at(2, 0), first(CubeFace::kUp) + 3);  // turned
  EXPECT_EQ(*cross.at(3, 5), first(CubeFace::kDown));
  EXPECT_EQ(*cross.at(0, 0), 0);
}

TEST(DepthUnits, AreRoundedAndNeverZero) {
  EXPECT_EQ(depth_units(1), 4000);
  EXPECT_EQ(depth_units(0.00001), 1);
  EXPECT_EQ(depth_units(1000), 65535);
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
