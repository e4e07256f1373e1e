#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::image {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class LoadPicture : public ::testing::Test {
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

  const tests::TemporaryFolder folder_{"load_picture"};
};

TEST_F(LoadPicture, TellsFormatsByTheirFirstBytes) {
  Image8 red(8, 4, 3);
  for (std::size_t i = 0; i < red.pixels.size(); i += 3) red.pixels[i] = 254;
  EXPECT_EQ(load_picture(write(encode_png(red))), red);
  // Quality 100 has quantization steps of 1: rounding alone.
  const Image8 jpeg = load_picture(write(encode_jpeg(red, 100, true)));
  EXPECT_NEAR(jpeg.pixels[0], 254, 2);
  EXPECT_NEAR(jpeg.pixels[1], 0, 2);
  const std::string hdr =
      "#?RGBE\n\n-Y 1 +X 2\n"
      "\x40\x40\x40\x80"
      "\x40\x40\x40\x80";
  EXPECT_THAT(load_picture(write(hdr)).pixels, ::testing::Each(118));
  // 64.5 / 256 of exponent 0, two stops down: 0.063, in sRGB 0.2782.
  EXPECT_THAT(load_picture(write(hdr), -2).pixels, ::testing::Each(71));
}

TEST_F(LoadPicture, GivesThreeChannelsWhateverTheFileHas) {
  Image8 grey(2, 1, 1), grey_alpha(2, 1, 2), rgba(2, 1, 4);
  grey.pixels = {5, 6};
  grey_alpha.pixels = {5, 255, 6, 0};
  rgba.pixels = {1, 2, 3, 255, 4, 5, 6, 0};
  EXPECT_THAT(load_picture(write(encode_png(grey))).pixels, ElementsAre(5, 5, 5, 6, 6, 6));
  EXPECT_THAT(load_picture(write(encode_png(grey_alpha))).pixels, ElementsAre(5, 5, 5, 6, 6, 6));
  EXPECT_THAT(load_picture(write(encode_png(rgba))).pixels, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST_F(LoadPicture, ReadsWhatSaveWrote) {
  Image8 picture(3, 2, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    picture.pixels[i] = static_cast<std::uint8_t>(10 * i);
  }
  const std::string png = (folder_.path() / "saved.png").string();
  const std::string jpg = (folder_.path() / "saved.jpg").string();
  save(png, picture);
  EXPECT_EQ(load_picture(png), picture);
  save(jpg, Image8(8, 8, 3), 95);
  EXPECT_EQ(load_picture(jpg), Image8(8, 8, 3));
  EXPECT_THAT([&] { save("picture.gif", picture); },
              ThrowsMessage<ArgumentError>(HasSubstr(".png, .jpg or .jpeg")));
}

TEST_F(LoadPicture, RefusesOtherFiles) {
  EXPECT_THAT([&] { load_picture(write("GIF89a")); },
              ThrowsMessage<InvalidInput>(HasSubstr("neither JPEG, nor PNG, nor Radiance HDR")));
  EXPECT_THAT([&] { load_picture(write("")); },
              ThrowsMessage<InvalidInput>(HasSubstr("the file is empty")));
  EXPECT_THROW(load_picture("/nowhere/at/all.jpg"), FileError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
