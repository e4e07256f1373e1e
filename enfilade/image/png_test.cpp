#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>

#include "enfilade/image/codecs.h"

namespace enfilade::image {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

template <class T>
Image<T> noise(std::uint32_t width, std::uint32_t height, std::uint32_t channels) {
  Image<T> picture(width, height, channels);
  std::uint32_t state = 1;
  for (T& value : picture.pixels)
    value = static_cast<T>((state = state * 1664525 + 1013904223) >> 9);
  return picture;
}

std::string unhex(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
  }
  return bytes;
}

TEST(Png, KeepsEightBitPicturesExactly) {
  for (std::uint32_t channels = 1; channels <= 4; ++channels) {
    const Image8 picture = noise<std::uint8_t>(33, 17, channels);
    const auto png = encode_png(picture);
    EXPECT_EQ(png_shape(png, "f"), (Shape{33, 17, channels, 8}));
    EXPECT_EQ(decode_png8(png, "f"), picture);
  }
}

TEST(Png, KeepsSixteenBitGreyExactly) {
  const Image16 picture = noise<std::uint16_t>(40, 9, 1);
  const auto png = encode_png(picture);
  EXPECT_EQ(png_shape(png, "f"), (Shape{40, 9, 1, 16}));
  EXPECT_EQ(decode_png16(png, "f"), picture);
}

TEST(Png, ReadsEightBitGreyAsNumbersToo) {
  const Image8 picture = noise<std::uint8_t>(5, 5, 1);
  const Image16 numbers = decode_png16(encode_png(picture), "f");
  EXPECT_TRUE(std::ranges::equal(numbers.pixels, picture.pixels));
}

TEST(Png, RefusesTheWrongKind) {
  EXPECT_THAT([] { decode_png16(encode_png(Image8(2, 2, 3)), "a.png"); },
              ThrowsMessage<InvalidInput>(HasSubstr("a.png: a PNG in colours")));
  EXPECT_THROW(encode_png(Image8(2, 2, 5)), ArgumentError);
  EXPECT_THROW(encode_png(Image16(2, 2, 3)), ArgumentError);
  EXPECT_THROW(encode_png(Image8(0, 2, 3)), ArgumentError);
}

// Made with Python's zlib by the definition of PNG: (0, 128, 255) and (65535, 65407, 256).
TEST(Png, RoundsSixteenBitsToEight) {
  const std::string png = unhex(
      "89504e470d0a1a0a0000000d49484452000000020000000110020000002bd0349e000000134944415478da6360"
      "60606860f80f04f58c0c001bf604fdf95ed55f0000000049454e44ae426082");
  EXPECT_EQ(png_shape(bytes_of(png), "f"), (Shape{2, 1, 3, 16}));
  EXPECT_THAT(decode_png8(bytes_of(png), "f").pixels, ElementsAre(0, 0, 1, 255, 255, 1));
  EXPECT_THROW(decode_png16(bytes_of(png), "f"), InvalidInput);
  Image16 grey(2, 1, 1);
  grey.pixels = {0x1234, 0xFFFF};
  EXPECT_THAT(decode_png8(encode_png(grey), "f").pixels, ElementsAre(0x12, 255));
}

TEST(Png, RefusesAFileCutOffAnywhere) {
  const auto png = encode_png(noise<std::uint8_t>(16, 16, 3));
  // The last 4 bytes are the checksum of the end's own name.
  for (std::size_t n = 0; n < png.size() - 4; ++n) {
    EXPECT_THROW(decode_png8(Bytes(png).first(n), "f"), InvalidInput) << n << " of " << png.size();
  }
}

TEST(Png, RefusesAFlippedBit) {
  const auto png = encode_png(noise<std::uint8_t>(16, 16, 3));
  for (std::size_t n = 0; n < png.size(); ++n) {
    auto flipped = png;
    flipped[n] ^= 4;
    EXPECT_THROW(decode_png8(flipped, "f"), InvalidInput) << n << " of " << png.size();
  }
}

// Made with Python's zlib by the definition of PNG (W3C, third edition).
TEST(Png, ReadsPalettes) {
  const std::string opaque = unhex(
      "89504e470d0a1a0a0000000d49484452000000040000000102030000008452e75e0000000c504c5445ff000000"
      "ff000000ff090807a2d262c00000000a4944415478da63900600001d001c237c8fac0000000049454e44ae4260"
      "82");
  EXPECT_EQ(png_shape(bytes_of(opaque), "f"), (Shape{4, 1, 3, 8}));
  EXPECT_THAT(decode_png8(bytes_of(opaque), "f").pixels,
              ElementsAre(255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 8, 7));
  const std::string transparent = unhex(
      "89504e470d0a1a0a0000000d49484452000000040000000102030000008452e75e0000000c504c5445ff000000"
      "ff000000ff090807a2d262c00000000374524e53ff80007f6d68780000000a4944415478da63900600001d001c"
      "237c8fac0000000049454e44ae426082");
  EXPECT_EQ(png_shape(bytes_of(transparent), "f"), (Shape{4, 1, 4, 8}));
  EXPECT_THAT(decode_png8(bytes_of(transparent), "f").pixels,
              ElementsAre(255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 0, 9, 8, 7, 255));
}

TEST(Png, ReadsGreyOfFourBitsAsColoursAndAsNumbers) {
  const std::string png = unhex(
      "89504e470d0a1a0a0000000d4948445200000003000000010400000000fb7ba6690000000b4944415478da6390"
      "2f000000b1009027f3d5f20000000049454e44ae426082");
  EXPECT_THAT(decode_png8(bytes_of(png), "f").pixels, ElementsAre(17, 255, 7 * 17));
  EXPECT_THAT(decode_png16(bytes_of(png), "f").pixels, ElementsAre(1, 15, 7));
}

TEST(Png, RefusesAHeaderThatClaimsTooMuch) {
  // 60,000 x 8,000 pixels of RGBA, and no more than 5 bytes of them.
  const std::string png = unhex(
      "89504e470d0a1a0a0000000d494844520000ea6000001f400806000000b138650a0000000b4944415478da6360"
      "00020000050001e9fadcd80000000049454e44ae426082");
  EXPECT_THAT([&] { png_shape(bytes_of(png), "f"); },
              ThrowsMessage<InvalidInput>(HasSubstr("ends too early")));
}

TEST(Ids, TakeSixteenBitsOrFourBytes) {
  Image32 ids(2, 1, 1);
  ids.pixels = {7, 65535};
  EXPECT_EQ(decode_png16(encode_ids(ids), "ids").pixels, (std::vector<std::uint16_t>{7, 65535}));
  EXPECT_EQ(decode_ids(encode_ids(ids), "ids"), ids);
  ids.pixels = {7, 0x04030201};
  EXPECT_EQ(decode_png8(encode_ids(ids), "ids").pixels,
            (std::vector<std::uint8_t>{7, 0, 0, 0, 1, 2, 3, 4}));
  EXPECT_EQ(decode_ids(encode_ids(ids), "ids"), ids);
}

TEST(Ids, AreNoColours) {
  EXPECT_THROW(decode_ids(encode_png(Image8(1, 1, 3)), "ids"), InvalidInput);
  EXPECT_THROW(decode_ids(encode_png(Image8(1, 1, 2)), "ids"), InvalidInput);
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
