#include "enfilade/draw/outlines.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace enfilade::draw {
namespace EN_UNIT {

image::Image8 grey() {
  image::Image8 picture(200, 100, 3);
  std::ranges::fill(picture.pixels, std::uint8_t{128});
  return picture;
}

/// The rectangle of pixels that are not grey: first and last column, first and last row.
std::array<std::size_t, 4> changed(const image::Image8& picture) {
  std::array<std::size_t, 4> box{picture.width, 0, picture.height, 0};
  for (std::size_t y = 0; y < picture.height; ++y) {
    for (std::size_t x = 0; x < picture.width; ++x) {
      if (*picture.at(x, y) == 128) continue;
      box = {std::min(box[0], x), std::max(box[1], x), std::min(box[2], y), std::max(box[3], y)};
    }
  }
  return box;
}

TEST(Marks, AreAroundTheirMiddle) {
  image::Image8 picture = grey();
  draw_marks(picture, std::vector<Mark>{{100, 50, "B"}});
  const auto [left, right, top, bottom] = changed(picture);
  EXPECT_NEAR(static_cast<double>(left + right) / 2, 100, 1);
  EXPECT_NEAR(static_cast<double>(top + bottom) / 2, 50, 1);
  EXPECT_EQ(*picture.at(left, top), 255);         // the rim
  EXPECT_EQ(*picture.at(left + 1, top + 1), 24);  // the plate
}

TEST(Marks, StayInThePicture) {
  image::Image8 picture = grey();
  draw_marks(picture, std::vector<Mark>{{0, 0, "AA"}, {199.5, 99.5, "C"}});
  const auto [left, right, top, bottom] = changed(picture);
  EXPECT_EQ(left, 0U);
  EXPECT_EQ(right, 199U);
  EXPECT_EQ(top, 0U);
  EXPECT_EQ(bottom, 99U);
}

TEST(Marks, OutsideAreLeftOut) {
  image::Image8 picture = grey();
  draw_marks(picture, std::vector<Mark>{{-1, 50, "A"}, {200, 50, "B"}, {50, 100, "C"}});
  EXPECT_EQ(picture, grey());
  image::Image8 tiny(4, 4, 3);  // no room for a plate
  draw_marks(tiny, std::vector<Mark>{{1, 1, "A"}});
  EXPECT_EQ(tiny, image::Image8(4, 4, 3));
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
