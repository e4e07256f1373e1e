#include "enfilade/draw/colour_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::draw {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

template <class T>
image::Image<T> picture_of(std::uint32_t width, std::vector<T> values) {
  image::Image<T> picture(width, static_cast<std::uint32_t>(values.size() / width), 1);
  picture.pixels = std::move(values);
  return picture;
}

Rgb pixel(const image::Image8& picture, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* p = picture.at(x, y);
  return {p[0], p[1], p[2]};
}

// How different eyes find two colours, roughly: the largest difference of a channel.
int distance(Rgb a, Rgb b) {
  int largest = 0;
  for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a[c] - b[c]));
  return largest;
}

// Rec. 709.
double luminance(Rgb colour) {
  const auto linear = [](double level) { return std::pow(level / 255, 2.2); };
  return 0.2126 * linear(colour[0]) + 0.7152 * linear(colour[1]) + 0.0722 * linear(colour[2]);
}

bool shows(const image::Image8& picture, Rgb colour, std::uint32_t from_row) {
  for (std::uint32_t y = from_row; y < picture.height; ++y) {
    for (std::uint32_t x = 0; x < picture.width; ++x) {
      if (pixel(picture, x, y) == colour) return true;
    }
  }
  return false;
}

TEST(DepthColour, GetsDarkerAllTheWayFromNearToFar) {
  for (int i = 1; i <= 100; ++i) {
    EXPECT_LT(luminance(depth_colour(i / 100.0)), luminance(depth_colour((i - 1) / 100.0))) << i;
  }
  EXPECT_EQ(depth_colour(-3), depth_colour(0));
  EXPECT_EQ(depth_colour(7), depth_colour(1));
}

TEST(DepthColour, NoReadingIsUnlikeAnyDepth) {
  for (int i = 0; i <= 1000; ++i) {
    // 40 levels in one channel at least: grey among colours is seen at a glance.
    EXPECT_GT(distance(depth_colour(i / 1000.0), kNothing), 40) << i;
  }
}

TEST(ColourDepth, SpreadsReadingsUpToTheFarthest) {
  const auto depth = picture_of<std::uint16_t>(4, {0, 4000, 10000, 20000});
  EXPECT_EQ(farthest_depth(depth), 5);
  const image::Image8 picture = colour_depth(depth, 5);
  ASSERT_EQ(picture.channels, 3U);
  EXPECT_EQ(pixel(picture, 0, 0), kNothing);
  EXPECT_EQ(pixel(picture, 1, 0), depth_colour(0.2));
  EXPECT_EQ(pixel(picture, 2, 0), depth_colour(0.5));
  EXPECT_EQ(pixel(picture, 3, 0), depth_colour(1));
  EXPECT_EQ(pixel(colour_depth(depth, 2.5), 3, 0), depth_colour(1));
}

TEST(ColourDepth, FarthestIsAWholeMetreAndNeverNone) {
  EXPECT_EQ(farthest_depth(picture_of<std::uint16_t>(2, {4001, 100})), 2);
  EXPECT_EQ(farthest_depth(picture_of<std::uint16_t>(2, {0, 0})), 1);
  EXPECT_EQ(farthest_depth(picture_of<std::uint16_t>(1, {65535})), 17);
}

TEST(DepthRange, IsThatOfMostReadings) {
  // Nearly all readings lie evenly from 1 to 3 m; the rest is the frame of a door and a window.
  std::vector<std::uint16_t> units;
  for (int i = 0; i < 180; ++i) units.push_back(static_cast<std::uint16_t>(4000 + i * 8000 / 179));
  for (int i = 0; i < 8; ++i) units.push_back(400);
  for (int i = 0; i < 8; ++i) units.push_back(60000);
  for (int i = 0; i < 50; ++i) units.push_back(0);  // no reading counts for nothing
  const auto range = depth_range(std::array{picture_of<std::uint16_t>(41, std::move(units))});
  EXPECT_NEAR(range.nearest, 1, 1e-9);
  EXPECT_NEAR(range.farthest, 3, 1e-9);
}

TEST(DepthRange, IsNeverNothing) {
  const auto range_of = [](std::vector<std::uint16_t> units) {
    return depth_range(std::array{picture_of<std::uint16_t>(2, std::move(units))});
  };
  EXPECT_EQ(range_of({0, 0}).nearest, 0);
  EXPECT_EQ(range_of({0, 0}).farthest, 1);
  EXPECT_NEAR(range_of({8000, 8000}).nearest, 2, 1e-9);
  EXPECT_NEAR(range_of({8000, 8000}).farthest, 2.5, 1e-9);
  EXPECT_EQ(depth_range({}).farthest, 1);
}

TEST(ColourDepth, SpreadsReadingsOverARange) {
  const auto depth = picture_of<std::uint16_t>(5, {0, 4000, 8000, 12000, 40000});
  const image::Image8 picture = colour_depth(depth, DepthRange{2, 4});
  EXPECT_EQ(pixel(picture, 0, 0), kNothing);
  EXPECT_EQ(pixel(picture, 1, 0), depth_colour(0));
  EXPECT_EQ(pixel(picture, 2, 0), depth_colour(0));
  EXPECT_EQ(pixel(picture, 3, 0), depth_colour(0.5));
  EXPECT_EQ(pixel(picture, 4, 0), depth_colour(1));
  for (const DepthRange wrong : {DepthRange{2, 2}, DepthRange{3, 2}, DepthRange{0, std::nan("")}}) {
    EXPECT_THAT([&] { (void)colour_depth(depth, wrong); },
                ThrowsMessage<ArgumentError>(HasSubstr("nearest < farthest")));
  }
}

TEST(ColourDepth, RefusesWhatIsNoDepth) {
  const image::Image16 two(1, 1, 2);
  EXPECT_THAT([&] { (void)colour_depth(two, 1); },
              ThrowsMessage<ArgumentError>(HasSubstr("2 channels")));
  const image::Image16 one(1, 1, 1);
  for (const double wrong : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW((void)colour_depth(one, wrong), ArgumentError) << wrong;
  }
}

// CIELAB of an sRGB colour (white D65), from the definitions of IEC 61966-2-1 and CIE 15.
std::array<double, 3> lab(Rgb colour) {
  const auto linear = [](double level) {
    return level <= 10.31475 ? level / 255 / 12.92 : std::pow((level / 255 + 0.055) / 1.055, 2.4);
  };
  const double r = linear(colour[0]), g = linear(colour[1]), b = linear(colour[2]);
  const auto root = [](double t) {
    return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
  };
  const double x = root((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
  const double y = root(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
  const double z = root((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

// CIE76.
double lab_distance(Rgb a, Rgb b) {
  const auto p = lab(a), q = lab(b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

TEST(IdColour, CategoriesAreTellableApartAndFromNothing) {
  EXPECT_NEAR(lab_distance({255, 255, 255}, {0, 0, 0}), 100, 0.01);
  for (std::uint32_t a = 1; a <= kChosenColours; ++a) {
    EXPECT_GE(lab_distance(id_colour(a), kNothing), 25) << a;
    for (std::uint32_t b = a + 1; b <= kChosenColours; ++b) {
      EXPECT_GE(lab_distance(id_colour(a), id_colour(b)), 25) << a << " and " << b;
    }
  }
  constexpr std::uint32_t kPicture = 6, kWindow = 9;  // both hang on walls
  EXPECT_GE(lab_distance(id_colour(kPicture), id_colour(kWindow)), 60);
}

TEST(IdColour, IdsThatFollowEachOtherDifferPlainly) {
  for (std::uint32_t id = 1; id <= 500; ++id) {
    EXPECT_GT(distance(id_colour(id), id_colour(id + 1)), 50) << id;
  }
}

TEST(IdColour, IsOfTheIdAlone) {
  const auto small = picture_of<std::uint16_t>(3, {7, 0, 7});
  const auto large = picture_of<std::uint32_t>(3, {7, 0, 4'000'000'000});
  const image::Image8 a = colour_ids(small);
  const image::Image8 b = colour_ids(large);
  EXPECT_EQ(pixel(a, 0, 0), id_colour(7));
  EXPECT_EQ(pixel(a, 1, 0), kNothing);
  EXPECT_EQ(pixel(a, 2, 0), id_colour(7));
  EXPECT_EQ(pixel(b, 0, 0), id_colour(7));
  EXPECT_EQ(pixel(b, 2, 0), id_colour(4'000'000'000));
}

TEST(CountIds, LargestFirstWithoutNothing) {
  const auto ids = picture_of<std::uint32_t>(4, {5, 9, 9, 0, 2, 5, 9, 0});
  EXPECT_THAT(count_ids(ids), ElementsAre(IdArea{9, 3}, IdArea{5, 2}, IdArea{2, 1}));
  EXPECT_TRUE(count_ids(image::Image16()).empty());
}

TEST(Legends, StandBelowThePictureAndLeaveItAsItIs) {
  const image::Image8 picture =
      colour_depth(picture_of<std::uint16_t>(300, std::vector<std::uint16_t>(300 * 2, 8000)), 4);
  const image::Image8 sheet = with_depth_legend(picture, 4);
  EXPECT_EQ(sheet.width, 300U);
  EXPECT_GT(sheet.height, picture.height);
  EXPECT_TRUE(std::equal(picture.pixels.begin(), picture.pixels.end(), sheet.pixels.begin()));
  for (const Rgb colour : {depth_colour(0), depth_colour(1), kNothing}) {
    EXPECT_TRUE(shows(sheet, colour, picture.height));
  }
}

TEST(Legends, ShowEveryIdThatFitsAndSayHowManyDoNot) {
  std::vector<std::uint32_t> values(400);
  for (std::uint32_t i = 0; i < values.size(); ++i) values[i] = i + 1;
  const auto ids = picture_of<std::uint32_t>(400, values);
  const std::vector<IdArea> areas = count_ids(ids);
  const image::Image8 picture = colour_ids(ids);
  const image::Image8 three = with_id_legend(picture, std::span(areas).first(3), {});
  EXPECT_TRUE(shows(three, id_colour(3), 1));
  EXPECT_FALSE(shows(three, id_colour(4), 1));
  const image::Image8 all = with_id_legend(picture, areas, {});
  EXPECT_TRUE(shows(all, id_colour(12), 1));
  EXPECT_FALSE(shows(all, id_colour(400), 1));
  EXPECT_LT(all.height, 200U);
}

TEST(Legends, NamesChangeTheWords) {
  const auto ids = picture_of<std::uint16_t>(300, std::vector<std::uint16_t>(300, 3));
  const std::vector<IdArea> areas = count_ids(ids);
  const image::Image8 picture = colour_ids(ids);
  EXPECT_NE(with_id_legend(picture, areas, {{3, "chair"}}), with_id_legend(picture, areas, {}));
  EXPECT_EQ(with_id_legend(picture, areas, {{4, "door"}}), with_id_legend(picture, areas, {}));
}

TEST(Legends, WorkForPicturesOfAnySize) {
  for (const std::uint32_t width : {1U, 63U, 240U, 641U, 4096U}) {
    const auto ids = picture_of<std::uint16_t>(width, std::vector<std::uint16_t>(width, 3));
    const std::vector<IdArea> areas = count_ids(ids);
    EXPECT_GE(with_id_legend(colour_ids(ids), areas, {{3, std::string(200, 'x')}}).width, width);
    EXPECT_GE(with_id_legend(colour_ids(ids), {}, {}).width, width);
    EXPECT_GE(with_depth_legend(colour_depth(ids, 0.5), 0.5).width, width);
  }
}

TEST(ClassNames, AreReadAsEditorsSaveThem) {
  const tests::TemporaryFolder folder("labels");
  const auto file = folder.path() / "mpcat40.tsv";
  const std::string table = "mpcatcat40index\tmpcat40\r\n3\tchair\thex\r\n4\tdoor\r\n";
  std::string wide = "\xff\xfe";  // UTF-16
  for (const char c : table) (wide += c) += '\0';
  for (const std::string& saved : {table, "\xef\xbb\xbf" + table, wide}) {
    write_file_atomically(file, saved);
    EXPECT_EQ(load_class_names(file), (IdNames{{3, "chair"}, {4, "door"}}));
  }
  write_file_atomically(file, "\xef\xbb\xbfindex\tname\nchair\t3\n");
  EXPECT_THAT([&] { load_class_names(file); }, ThrowsMessage<InvalidInput>(HasSubstr("line 2")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
