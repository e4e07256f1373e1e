#include "enfilade/draw/detail/bitmap_text.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

namespace enfilade::draw::detail {
namespace EN_UNIT {

constexpr Rgb kBlack{0, 0, 0};
constexpr Rgb kWhite{255, 255, 255};

Rgb pixel(const image::Image8& picture, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* p = picture.at(x, y);
  return {p[0], p[1], p[2]};
}

std::vector<std::string> drawn(char letter) {
  image::Image8 picture = filled(kLetterAdvance, kLetterHeight, kWhite);
  draw_text(picture, 0, 0, std::string(1, letter), kBlack, 1);
  std::vector<std::string> rows;
  for (std::uint32_t y = 0; y < picture.height; ++y) {
    rows.emplace_back();
    for (std::uint32_t x = 0; x < picture.width; ++x) {
      rows.back() += pixel(picture, x, y) == kBlack ? '#' : '.';
    }
  }
  return rows;
}

TEST(BitmapText, DrawsTheDotsOfALetter) {
  const std::vector<std::string> expected{"#.....", "#.....", "#.....", "#.....", "#.....",
                                          "#.....", "#####.", "......", "......"};
  EXPECT_EQ(drawn('L'), expected);
}

TEST(BitmapText, NoTwoLettersLookAlikeAndNoneTouchesTheNext) {
  std::set<std::vector<std::string>> seen;
  for (char letter = ' '; letter <= '~'; ++letter) {
    const std::vector<std::string> rows = drawn(letter);
    EXPECT_TRUE(seen.insert(rows).second) << letter;
    for (const std::string& row : rows) EXPECT_EQ(row.back(), '.') << letter;
  }
  EXPECT_EQ(drawn('\xc3'), drawn('?'));
}

TEST(BitmapText, ScalesDotsToSquares) {
  image::Image8 picture = filled(3 * kLetterAdvance, 3 * kLetterHeight, kWhite);
  draw_text(picture, 0, 0, "L", kBlack, 3);
  const auto black = [&](std::uint32_t x, std::uint32_t y) {
    return pixel(picture, x, y) == kBlack;
  };
  EXPECT_TRUE(black(0, 0) && black(2, 2) && black(14, 20));
  EXPECT_FALSE(black(3, 0) || black(15, 20) || black(0, 21));
}

TEST(BitmapText, CutsOffWhatLiesBeyondThePicture) {
  image::Image8 picture = filled(8, 5, kWhite);
  draw_text(picture, 6, 3, "WWW", kBlack, 2);
  draw_text(picture, 100, 100, "W", kBlack, 1);
  EXPECT_EQ(pixel(picture, 7, 4), kBlack);
  EXPECT_EQ(pixel(picture, 5, 4), kWhite);
}

TEST(BitmapText, ShortensLongTexts) {
  EXPECT_EQ(cut_text("corridor", 48, 1), "corridor");  // eight letters of six pixels
  EXPECT_EQ(cut_text("corridor", 47, 1), "corri..");
  EXPECT_EQ(cut_text("corridor", 12, 1), "co");
  EXPECT_EQ(cut_text("corridor", 5, 1), "");
}

TEST(BitmapText, WrapsAtBlanks) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(wrap_text("Go left at  the\ntable. ", 42, 1), (Lines{"Go left", "at the", "table."}));
  EXPECT_EQ(wrap_text("a corridor b", 42, 1), (Lines{"a", "corri..", "b"}));
  EXPECT_TRUE(wrap_text(" ", 42, 1).empty());
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw::detail
