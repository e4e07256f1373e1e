#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"

namespace enfilade::image {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

ImageF read(const std::string& text) { return decode_hdr(bytes_of(text), "a.hdr"); }
std::string file(const std::string& resolution, const std::string& pixels,
                 const std::string& fields = "FORMAT=32-bit_rle_rgbe\n") {
  return "#?RADIANCE\n# a comment\n" + fields + "\n" + resolution + "\n" + pixels;
}
// A pixel whose red is `red` + 1/2 (exponent 136 makes units of one), green and blue of 10.5.
std::string pixel(char red) { return {red, 10, 10, static_cast<char>(136)}; }
std::vector<int> reds(const ImageF& picture) {
  std::vector<int> values;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
    values.push_back(static_cast<int>(picture.pixels[i] - 0.5F));
  }
  return values;
}

TEST(Hdr, HasTheValuesThatRadianceDefines) {
  using namespace std::string_literals;
  const ImageF picture = read(file("-Y 1 +X 3",
                                   "\x80\x40\x00\x81"s     // exponent 129
                                   "\x05\x06\x07\x00"s     // exponent 0: black
                                   "\xff\xff\xff\xff"s));  // the largest
  ASSERT_EQ(picture.width, 3U);
  ASSERT_EQ(picture.channels, 3U);
  // (m + 1/2) 2^(129 - 136)
  EXPECT_THAT(picture.pixels,
              ElementsAre(128.5F / 128, 64.5F / 128, 0.5F / 128, 0, 0, 0, std::ldexp(255.5F, 119),
                          std::ldexp(255.5F, 119), std::ldexp(255.5F, 119)));
}

TEST(Hdr, TakesBackTheExposure) {
  const ImageF picture =
      read(file("-Y 1 +X 1", pixel(7), "EXPOSURE=2\nFORMAT=32-bit_rle_rgbe\nEXPOSURE= 0.25\n"));
  EXPECT_FLOAT_EQ(picture.pixels[0], 7.5F / 0.5F);
}

TEST(Hdr, TurnsAllEightOrientationsUpright) {
  const std::string pixels = pixel(1) + pixel(2) + pixel(3) + pixel(4) + pixel(5) + pixel(6);
  EXPECT_THAT(reds(read(file("-Y 2 +X 3", pixels))), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(reds(read(file("-Y 2 -X 3", pixels))), ElementsAre(3, 2, 1, 6, 5, 4));
  EXPECT_THAT(reds(read(file("+Y 2 +X 3", pixels))), ElementsAre(4, 5, 6, 1, 2, 3));
  EXPECT_THAT(reds(read(file("+Y 2 -X 3", pixels))), ElementsAre(6, 5, 4, 3, 2, 1));
  // Scan lines are columns of two.
  EXPECT_THAT(reds(read(file("+X 3 -Y 2", pixels))), ElementsAre(1, 3, 5, 2, 4, 6));
  EXPECT_THAT(reds(read(file("-X 3 -Y 2", pixels))), ElementsAre(5, 3, 1, 6, 4, 2));
  EXPECT_THAT(reds(read(file("+X 3 +Y 2", pixels))), ElementsAre(2, 4, 6, 1, 3, 5));
  EXPECT_THAT(reds(read(file("-X 3 +Y 2", pixels))), ElementsAre(6, 4, 2, 5, 3, 1));
}

TEST(Hdr, UnpacksNewStyleRuns) {
  using namespace std::string_literals;
  const std::string line =
      "\x02\x02\x00\x09"s
      "\x85\x03\x04\x01\x02\x03\x04"s  // red: 3 five times, then 1, 2, 3, 4
      "\x89\x0a\x89\x0a\x89\x88"s;     // the others: nine times 10, exponents of 136
  const std::string two = file("-Y 2 +X 9", line + line);
  EXPECT_THAT(reds(read(two)), ElementsAre(3, 3, 3, 3, 3, 1, 2, 3, 4, 3, 3, 3, 3, 3, 1, 2, 3, 4));
}

TEST(Hdr, UnpacksOldStyleRuns) {
  using namespace std::string_literals;
  EXPECT_THAT(reds(read(file("-Y 1 +X 5", pixel(9) + "\x01\x01\x01\x03"s + pixel(8)))),
              ElementsAre(9, 9, 9, 9, 8));
  // Two run pixels: 3 + 1 * 256 times more.
  const ImageF wide = read(file("-Y 1 +X 260", pixel(9) + "\x01\x01\x01\x03\x01\x01\x01\x01"s));
  EXPECT_EQ(wide.pixels.back(), 10.5F);
  EXPECT_EQ(wide.pixels[wide.pixels.size() - 3], 9.5F);
}

TEST(Hdr, SaysWhatIsWrong) {
  using namespace std::string_literals;
  const auto says = [](const std::string& text, const char* words) {
    EXPECT_THAT([&] { read(text); }, ThrowsMessage<InvalidInput>(HasSubstr(words)));
  };
  says("", "a.hdr: header: ends too early");
  says("P6\n1 1\n255\n", "does not begin with \"#?\"");
  says(file("-Y 1 +X 1", pixel(1), "FORMAT=32-bit_rle_xyze\n"), "32-bit_rle_xyze");
  says(file("-Y 1 +X 1", pixel(1), "EXPOSURE=dark\n"), "EXPOSURE=\"dark\", not a number");
  says(file("-Y 1 +X 1", pixel(1), "EXPOSURE=0\n"), "EXPOSURE of 0");
  for (const char* resolution : {"", "1 1", "-Y 1 +Y 1", "-Y 1 +X", "-Y x +X 1", "-Y 1 +X 1 ",
                                 "-Z 1 +X 1", "-Y -1 +X 1", "-Y 1  +X 1", "-Y 99999999999 +X 1"}) {
    says(file(resolution, pixel(1)), "not like \"-Y 512 +X 1024\"");
  }
  says(file("-Y 0 +X 1", ""), "0 pixels");
  says(file("-Y 60000 +X 8000", ""), "at most 134217728 pixels");
  says(file("-Y 70000 +X 1", ""), "edges of 1 .. 65500");
  says(file("-Y 1 +X 9", "\x02\x02\x00\x08"s), "scan line 0: 8 pixels, not 9");
  says(file("-Y 1 +X 9", "\x02\x02\x00\x09\x8a\x01"s), "a run beyond the end");
  says(file("-Y 1 +X 2", "\x01\x01\x01\x01"s), "a run with no pixel before it");
  says(file("-Y 1 +X 2", pixel(1) + "\x01\x01\x01\x02"s), "a run beyond the line's end");
}

TEST(Hdr, RefusesAFileCutOffAnywhere) {
  using namespace std::string_literals;
  const std::string packed = "\x02\x02\x00\x09\x89\x03\x89\x0a\x89\x0a\x89\x88"s;
  for (const std::string& whole :
       {file("-Y 2 +X 9", packed + packed), file("-Y 1 +X 3", pixel(1) + pixel(2) + pixel(3))}) {
    read(whole);
    for (std::size_t n = 0; n < whole.size(); ++n) {
      EXPECT_THROW(read(whole.substr(0, n)), InvalidInput) << n;
    }
  }
}

TEST(Hdr, ReadsRealPanoramas) {
  const char* data = std::getenv("ENFILADE_DATA");
  if (data == nullptr) GTEST_SKIP() << "ENFILADE_DATA is not set: no real HDR panoramas";
  for (const char* name : {"st_fagans_interior_1k", "empty_warehouse_01_1k", "lebombo_1k",
                           "studio_small_03_1k", "adams_place_bridge_1k"}) {
    const auto path = std::filesystem::path(data) / "imagery" / (std::string(name) + ".hdr");
    const std::string bytes = read_file(path);
    const ImageF picture = decode_hdr(bytes_of(bytes), name);
    EXPECT_EQ(picture.width, 1024U);
    EXPECT_EQ(picture.height, 512U);
    // Light sources are many times brighter than a display's white.
    EXPECT_GT(*std::ranges::max_element(picture.pixels), 5) << name;
    EXPECT_GE(*std::ranges::min_element(picture.pixels), 0) << name;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
