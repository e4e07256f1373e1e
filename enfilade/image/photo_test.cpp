#include "enfilade/image/photo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/file.h"
#include "tests/support/photo_files.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::image {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

std::string unhexed(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
  }
  return bytes;
}

// 1 2 3 over 4 5 6, of one channel.
Image8 six() {
  Image8 picture(3, 2, 1);
  picture.pixels = {1, 2, 3, 4, 5, 6};
  return picture;
}

// By the table of EXIF 2.3: where the stored row 0 and column 0 are in the upright picture.
TEST(Upright, FollowsTheEightOrientations) {
  EXPECT_THAT(upright(six(), 1).pixels, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(upright(six(), 2).pixels, ElementsAre(3, 2, 1, 6, 5, 4));  // top, right
  EXPECT_THAT(upright(six(), 3).pixels, ElementsAre(6, 5, 4, 3, 2, 1));  // bottom, right
  EXPECT_THAT(upright(six(), 4).pixels, ElementsAre(4, 5, 6, 1, 2, 3));  // bottom, left
  EXPECT_THAT(upright(six(), 5).pixels, ElementsAre(1, 4, 2, 5, 3, 6));  // left, top
  EXPECT_THAT(upright(six(), 6).pixels, ElementsAre(4, 1, 5, 2, 6, 3));  // right, top
  EXPECT_THAT(upright(six(), 7).pixels, ElementsAre(6, 3, 5, 2, 4, 1));  // right, bottom
  EXPECT_THAT(upright(six(), 8).pixels, ElementsAre(3, 6, 2, 5, 1, 4));  // left, bottom
  EXPECT_EQ(upright(six(), 6).width, 2U);
  EXPECT_EQ(upright(six(), 6).height, 3U);
}

TEST(DecodePhoto, TurnsAJpegByExif) {
  // White over black.
  Image8 stored(16, 16, 3);
  std::fill_n(stored.pixels.begin(), stored.pixels.size() / 2, std::uint8_t{255});
  const std::string jpeg = tests::jpeg_of(stored);
  for (const bool big_endian : {false, true}) {
    const std::string turned = tests::with_orientation(jpeg, 3, big_endian);
    const Photo photo = decode_photo(bytes_of(turned), "a.jpg");
    EXPECT_EQ(photo.orientation, 3);
    EXPECT_LT(photo.picture.at(8, 2)[0], 5);
    EXPECT_GT(photo.picture.at(8, 13)[0], 250);
    ASSERT_EQ(photo.findings.size(), 1U);
    EXPECT_EQ(photo.findings[0].severity, Severity::kNote);
    EXPECT_EQ(photo.findings[0].message, "EXIF orientation 3: turned by half");
    // Pixels as stored, for strips and stores.
    EXPECT_EQ(decode_jpeg(bytes_of(turned), "f"), decode_jpeg(bytes_of(jpeg), "f"));
  }
  EXPECT_THAT(decode_photo(bytes_of(tests::with_orientation(jpeg, 9)), "f").findings, IsEmpty())
      << "no orientation";
}

TEST(DecodePhoto, TurnsAPngByExif) {
  const Photo photo = decode_photo(bytes_of(unhexed("89504e470d0a1a0a0000000d4948445200000002000000"
                                                    "0108020000007b40e8dd0000001a6558496649492a00"
                                                    "08000000010012010300010000000300000000000000ff"
                                                    "a81f4d0000000f4944415478da636064626661650300"
                                                    "003f001698c168130000000049454e44ae426082")),
                                   "f");
  EXPECT_THAT(photo.picture.pixels, ElementsAre(4, 5, 6, 1, 2, 3));
  EXPECT_EQ(photo.orientation, 3);
}

TEST(DecodePhoto, ReadsXmpOfAPng) {
  EXPECT_EQ(decode_photo(bytes_of(unhexed("89504e470d0a1a0a0000000d49484452000000020000000108020000"
                                          "007b40e8dd0000005d69545874584d4c3a"
                                          "636f6d2e61646f62652e786d7000000000003c783a786d706d657461"
                                          "3e3c7264663a4465736372697074696f6e"
                                          "204750616e6f3a506f73655069746368446567726565733d2231322e"
                                          "35222f3e3c2f783a786d706d6574613e79"
                                          "f492150000000f4944415478da636064626661650300003f001698c1"
                                          "68130000000049454e44ae426082")),
                         "f")
                .sphere.pitch,
            12.5);
}

TEST(DecodePhoto, ReadsTheSphereFromAttributesAndElements) {
  const std::string jpeg = tests::jpeg_of(Image8(16, 8, 3));
  for (const bool elements : {false, true}) {
    const std::string xmp = tests::gpano({{"ProjectionType", "equirectangular"},
                                          {"PoseHeadingDegrees", "350.5"},
                                          {"PosePitchDegrees", "-3"},
                                          {"PoseRollDegrees", "+2.25"},
                                          {"FullPanoWidthPixels", "32"},
                                          {"FullPanoHeightPixels", "16"},
                                          {"CroppedAreaImageWidthPixels", "16"},
                                          {"CroppedAreaImageHeightPixels", "8"},
                                          {"CroppedAreaLeftPixels", "8"},
                                          {"CroppedAreaTopPixels", "4"}},
                                         elements);
    const Photo photo = decode_photo(bytes_of(tests::with_xmp(jpeg, xmp)), "f");
    EXPECT_THAT(photo.findings, IsEmpty());
    EXPECT_EQ(photo.sphere.projection, "equirectangular");
    EXPECT_EQ(photo.sphere.heading, 350.5);
    EXPECT_EQ(photo.sphere.pitch, -3);
    EXPECT_EQ(photo.sphere.roll, 2.25);
    EXPECT_FALSE(photo.sphere.is_level());
    ASSERT_TRUE(photo.sphere.crop);
    EXPECT_TRUE(photo.sphere.crop->is_part());
    EXPECT_EQ(photo.sphere.crop->full_width, 32);
    EXPECT_EQ(photo.sphere.crop->left, 8);
  }
}

TEST(DecodePhoto, ReportsFieldsOfASphereThatAreNoNumbers) {
  const std::string jpeg = tests::jpeg_of(Image8(16, 8, 3));
  for (const char* value : {"NaN", "400", "up"}) {
    const std::string xmp = tests::gpano({{"PoseRollDegrees", value}});
    const Photo photo = decode_photo(bytes_of(tests::with_xmp(jpeg, xmp)), "f");
    EXPECT_TRUE(photo.sphere.is_level()) << value;
    ASSERT_EQ(photo.findings.size(), 1U) << value;
    EXPECT_EQ(photo.findings[0].where, "GPano:PoseRollDegrees");
    EXPECT_THAT(photo.findings[0].message, HasSubstr("not a number from -180 to 180"));
  }
}

TEST(DecodePhoto, ReadsOverNotesThatAreCutOff) {
  const std::string jpeg = tests::jpeg_of(Image8(16, 8, 3));
  const std::string exif = tests::exif(6);
  for (std::size_t n = 0; n < exif.size(); ++n) {
    EXPECT_NO_THROW(decode_photo(bytes_of(tests::with_segment(jpeg, exif.substr(0, n))), "f")) << n;
  }
  const std::string xmp = tests::gpano({{"PosePitchDegrees", "5"}});
  for (std::size_t n = 0; n < xmp.size(); ++n) {
    EXPECT_NO_THROW(decode_photo(bytes_of(tests::with_xmp(jpeg, xmp.substr(0, n))), "f")) << n;
  }
}

// The middle of a picture with a pitch of 90 degrees is the zenith; a roll turns the horizon
// counterclockwise, so the sky (up, -y) is at the picture's left (-x) with a roll of 90 degrees.
TEST(LevelFromPicture, UndoesPitchAndRoll) {
  SphereNotes sphere;
  EXPECT_EQ(level_from_picture(sphere), Mat3d());
  sphere.pitch = 90;
  const Vec3d zenith = level_from_picture(sphere) * Vec3d{0, 0, 1};
  EXPECT_NEAR(zenith.y, -1, 1e-12);
  sphere.pitch = 0;
  sphere.roll = 90;
  const Vec3d up = level_from_picture(sphere) * Vec3d{-1, 0, 0};
  EXPECT_NEAR(up.y, -1, 1e-12);
}

class LoadPhoto : public ::testing::Test {
 protected:
  // Every file has the same name, which says nothing.
  std::string write(std::string_view content) const {
    const std::filesystem::path path = folder_.path() / "picture";
    write_file_atomically(path, content);
    return path.string();
  }
  std::string write(const std::vector<std::uint8_t>& content) const {
    return write(std::string_view(reinterpret_cast<const char*>(content.data()), content.size()));
  }

  const tests::TemporaryFolder folder_{"load_photo"};
};

TEST_F(LoadPhoto, TellsFormatsByTheirFirstBytes) {
  Image8 red(8, 4, 3);
  for (std::size_t i = 0; i < red.pixels.size(); i += 3) red.pixels[i] = 254;
  EXPECT_EQ(load_photo(write(encode_png(red))).picture, red);
  // Quality 100 has quantization steps of 1: rounding alone.
  const Image8 jpeg = load_photo(write(encode_jpeg(red, 100, true))).picture;
  EXPECT_NEAR(jpeg.pixels[0], 254, 2);
  EXPECT_NEAR(jpeg.pixels[1], 0, 2);
  const std::string hdr =
      "#?RGBE\n\n-Y 1 +X 2\n"
      "\x40\x40\x40\x80"
      "\x40\x40\x40\x80";
  EXPECT_THAT(load_photo(write(hdr)).picture.pixels, ::testing::Each(118));
  // 64.5 / 256 of exponent 0, two stops down: 0.063, in sRGB 0.2782.
  EXPECT_THAT(load_photo(write(hdr), -2).picture.pixels, ::testing::Each(71));
}

TEST_F(LoadPhoto, GivesThreeChannelsWhateverTheFileHas) {
  Image8 grey(2, 1, 1), grey_alpha(2, 1, 2), rgba(2, 1, 4);
  grey.pixels = {5, 6};
  grey_alpha.pixels = {5, 255, 6, 0};
  rgba.pixels = {1, 2, 3, 255, 4, 5, 6, 0};
  EXPECT_THAT(load_photo(write(encode_png(grey))).picture.pixels, ElementsAre(5, 5, 5, 6, 6, 6));
  EXPECT_THAT(load_photo(write(encode_png(grey_alpha))).picture.pixels,
              ElementsAre(5, 5, 5, 6, 6, 6));
  EXPECT_THAT(load_photo(write(encode_png(rgba))).picture.pixels, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST_F(LoadPhoto, TakesPicturesForPrintingAndOfSixteenBits) {
  Image16 grey(2, 1, 1);
  grey.pixels = {0, 65535};
  EXPECT_THAT(load_photo(write(encode_png(grey))).picture.pixels,
              ElementsAre(0, 0, 0, 255, 255, 255));
  const Image8 colour = load_photo(write(tests::colour_of_sixteen_bits())).picture;
  EXPECT_EQ(colour.width, 16U);
  EXPECT_THAT(std::vector(colour.at(9, 5), colour.at(9, 5) + 3), ElementsAre(0, 255, 128));
}

TEST_F(LoadPhoto, RefusesOtherFiles) {
  EXPECT_THAT([&] { load_photo(write("GIF89a")); },
              ThrowsMessage<InvalidInput>(HasSubstr("neither JPEG, nor PNG, nor Radiance HDR")));
  EXPECT_THAT([&] { load_photo(write("")); },
              ThrowsMessage<InvalidInput>(HasSubstr("the file is empty")));
  EXPECT_THROW(load_photo("/nowhere/at/all.jpg"), FileError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
