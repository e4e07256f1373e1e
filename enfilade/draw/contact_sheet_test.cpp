#include "enfilade/draw/contact_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::draw {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

image::Image8 plain(std::uint32_t width, std::uint32_t height, std::uint8_t red) {
  image::Image8 picture(width, height, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) picture.pixels[i] = red;
  return picture;
}

struct Box {
  std::size_t left = 1000000, top = 1000000, right = 0, bottom = 0, pixels = 0;
};
// Where plain(.., red) lies on a sheet.
Box find(const image::Image8& sheet, std::uint8_t red) {
  Box box;
  for (std::size_t y = 0; y < sheet.height; ++y) {
    for (std::size_t x = 0; x < sheet.width; ++x) {
      const std::uint8_t* p = sheet.at(x, y);
      if (p[0] != red || p[1] != 0 || p[2] != 0) continue;
      box = {std::min(box.left, x), std::min(box.top, y), std::max(box.right, x),
             std::max(box.bottom, y), box.pixels + 1};
    }
  }
  return box;
}

std::vector<SheetPicture> five() {
  std::vector<SheetPicture> pictures;
  for (std::uint8_t i = 0; i < 5; ++i) {
    pictures.push_back({plain(40, 30, static_cast<std::uint8_t>(100 + i)), "one\ntwo"});
  }
  return pictures;
}

TEST(ContactSheet, PutsPicturesInRowsUncut) {
  const std::vector<SheetPicture> pictures = five();
  const image::Image8 sheet = contact_sheet(pictures, {.columns = 3, .title = "A house"});
  std::array<Box, 5> boxes;
  for (std::uint8_t i = 0; i < 5; ++i) {
    boxes[i] = find(sheet, static_cast<std::uint8_t>(100 + i));
    EXPECT_EQ(boxes[i].pixels, 1200U) << int{i};
    EXPECT_EQ(boxes[i].right - boxes[i].left, 39U);
  }
  EXPECT_EQ(boxes[0].top, boxes[2].top);
  EXPECT_LT(boxes[0].right, boxes[1].left);
  EXPECT_LT(boxes[1].right, boxes[2].left);
  EXPECT_EQ(boxes[0].left, boxes[3].left);
  EXPECT_LT(boxes[0].bottom + 20, boxes[3].top);  // two lines of caption between
  EXPECT_EQ(boxes[3].top, boxes[4].top);
  EXPECT_LT(boxes[3].bottom + 20, sheet.height);
}

TEST(ContactSheet, IsAboutAsWideAsAScreenUnlessAsked) {
  const std::vector<SheetPicture> hundred(100, {plain(40, 30, 1), ""});
  const image::Image8 sheet = contact_sheet(hundred);
  const double ratio = static_cast<double>(sheet.width) / sheet.height;
  EXPECT_GT(ratio, 1.0);
  EXPECT_LT(ratio, 1.7);
  EXPECT_EQ(contact_sheet(five(), {.columns = 99, .title = ""}).width, 5 * 46U + 6);
}

TEST(ContactSheet, CellsHaveTheSizeOfTheLargest) {
  const std::vector<SheetPicture> pictures{{plain(10, 50, 1), ""}, {plain(60, 5, 2), ""}};
  const image::Image8 sheet = contact_sheet(pictures, {.columns = 2, .title = ""});
  EXPECT_EQ(sheet.width, 2 * 66U + 6);
  EXPECT_EQ(sheet.height, 56U + 6);
  EXPECT_EQ(find(sheet, 1).pixels, 500U);
  EXPECT_EQ(find(sheet, 2).pixels, 300U);
}

TEST(ContactSheet, CaptionsStayBelowTheirPicture) {
  std::vector<SheetPicture> pictures(2, {plain(40, 30, 9), ""});
  const image::Image8 bare = contact_sheet(pictures, {.columns = 2, .title = ""});
  pictures[0].caption = std::string(100, 'W');
  const image::Image8 sheet = contact_sheet(pictures, {.columns = 2, .title = ""});
  EXPECT_EQ(find(sheet, 9).pixels, 2 * 1200U);
  EXPECT_GT(sheet.height, bare.height);
  for (std::size_t y = 0; y < sheet.height; ++y) {
    const std::uint8_t paper = *sheet.at(0, 0);
    for (std::size_t x = 46; x < 52; ++x) EXPECT_EQ(*sheet.at(x, y), paper) << x << " " << y;
  }
}

TEST(ContactSheet, LongTitlesTakeMoreLines) {
  const std::vector<SheetPicture> pictures = five();
  const auto top = [&](const std::string& title) {
    return find(contact_sheet(pictures, {.columns = 5, .title = title}), 100).top;
  };
  EXPECT_EQ(top(""), 6U);
  EXPECT_LT(top(""), top("A house"));
  EXPECT_LT(top("A house"), top("Walk down the hall. Turn left at the table. Go on to the couch. "
                                "Stop there, and wait until somebody comes for you."));
}

TEST(ContactSheet, RefusesWhatItCannotDraw) {
  EXPECT_THAT([] { (void)contact_sheet({}); }, ThrowsMessage<ArgumentError>(HasSubstr("none")));
  std::vector<SheetPicture> pictures = five();
  pictures[3].picture = image::Image8(4, 4, 4);
  EXPECT_THAT([&] { (void)contact_sheet(pictures); },
              ThrowsMessage<ArgumentError>(HasSubstr("pictures[3]: 4 x 4 with 4 channels")));
  pictures.assign(1, {plain(65501, 1, 0), ""});
  EXPECT_THAT([&] { (void)contact_sheet(pictures); },
              ThrowsMessage<ArgumentError>(HasSubstr("at most 65500 along an edge")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
