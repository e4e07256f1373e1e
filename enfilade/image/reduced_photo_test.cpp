// Pictures that are reduced while they are read.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spng.h>
#include <sys/resource.h>
#include <turbojpeg.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "enfilade/image/photo.h"
#include "tests/support/photo_files.h"

namespace enfilade::image {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

Image8 noise(std::uint32_t width, std::uint32_t height, std::uint32_t channels) {
  Image8 picture(width, height, channels);
  std::uint32_t state = 1;
  for (std::uint8_t& value : picture.pixels) {
    value = static_cast<std::uint8_t>((state = state * 1664525 + 1013904223) >> 24U);
  }
  return picture;
}

TEST(ReducedPhoto, OfAPngIsTheMean) {
  for (std::uint32_t channels = 1; channels <= 4; ++channels) {
    const Image8 picture = noise(101, 50, channels);
    const auto png = encode_png(picture);
    EXPECT_EQ(decode_photo(png, "f", 5050).picture, picture);
    const Photo half = decode_photo(png, "f", 5049);
    EXPECT_EQ(half.picture, shrink(picture, 51, 25));
    EXPECT_EQ(half.stored_width, 101U);
    EXPECT_EQ(half.stored_height, 50U);
    ASSERT_EQ(half.findings.size(), 1U);
    EXPECT_EQ(half.findings[0].code, "reduced-picture");
    EXPECT_EQ(half.findings[0].message, "101 x 50 pixels, reduced to 51 x 25 while they are read");
    EXPECT_EQ(decode_photo(png, "f", 1).picture, shrink(picture, 1, 1));
  }
  const Image8 wide = decode_photo(bytes_of(tests::colour_of_sixteen_bits()), "f", 40).picture;
  EXPECT_EQ(wide.width, 8U);
  EXPECT_THAT(std::vector(wide.at(7, 3), wide.at(7, 3) + 3), ElementsAre(0, 255, 128));
}

// Grey, 8 x 8 pixels: pixel k is 4 k.
std::string interlaced_png() {
  const std::string hex =
      "89504e470d0a1a0a0000000d49484452000000080000000808000000019663d1c10000005a4944415478da01"
      "4f00b0ff00000010008090000818008898004048505800c0c8d0d800040c141c00444c545c00848c949c00c4"
      "ccd4dc002024282c3034383c006064686c7074787c00a0a4a8acb0b4b8bc00e0e4e8ecf0f4f8fcb8cc1f8151"
      "7685960000000049454e44ae426082";
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return bytes;
}

TEST(ReducedPhoto, IsNoneOfAnInterlacedPng) {
  const std::string png = interlaced_png();
  const Image8 picture = decode_photo(bytes_of(png), "f", 64).picture;
  for (std::size_t k = 0; k < 64; ++k) EXPECT_EQ(picture.pixels[k], 4 * k);
  EXPECT_THAT([&] { decode_photo(bytes_of(png), "a.png", 63); },
              ThrowsMessage<InvalidInput>(
                  HasSubstr("a.png: an interlaced PNG of 8 x 8 pixels; at most 63 are allowed")));
}

std::vector<std::uint8_t> jpeg_of(const Image8& picture, int flags) {
  const tjhandle handle = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type
  EXPECT_EQ(
      tjCompress2(handle, picture.pixels.data(), static_cast<int>(picture.width), 0,
                  static_cast<int>(picture.height), TJPF_RGB, &data, &size, TJSAMP_444, 95, flags),
      0);
  std::vector<std::uint8_t> jpeg(data, data + size);
  tjFree(data);
  tjDestroy(handle);
  return jpeg;
}

TEST(ReducedPhoto, OfAJpegIsTheMeanAlmost) {
  Image8 waves(208, 96, 3);
  for (std::size_t y = 0; y < 96; ++y) {
    for (std::size_t x = 0; x < 208; ++x) {
      const double u = static_cast<double>(x), v = static_cast<double>(y);
      std::fill_n(waves.at(x, y), 3,
                  static_cast<std::uint8_t>(128 + 100 * std::sin(u / 31 + v / 23)));
    }
  }
  const auto jpeg = jpeg_of(waves, 0);
  EXPECT_EQ(decode_photo(jpeg, "f", 208 * 96).picture, decode_jpeg(jpeg, "f"));
  for (const unsigned halvings : {1U, 2U, 3U, 4U}) {  // the last one by libjpeg and by means
    const std::uint32_t width = halved(208, halvings), height = halved(96, halvings);
    const Image8 small = decode_photo(jpeg, "f", width * height).picture;
    ASSERT_EQ(small.width, width);
    ASSERT_EQ(small.height, height);
    const Image8 wanted = shrink(waves, width, height);
    for (std::size_t k = 0; k < wanted.pixels.size(); ++k) {
      ASSERT_NEAR(small.pixels[k], wanted.pixels[k], 6) << k << " " << halvings;
    }
  }
  const Image8 odd = decode_photo(jpeg_of(Image8(33, 17, 3), 0), "f", 50).picture;
  EXPECT_EQ(odd.width, 9U);
  EXPECT_EQ(odd.height, 5U);
  EXPECT_THROW(decode_photo(Bytes(jpeg).first(jpeg.size() / 2), "f", 100), InvalidInput);
  const auto progressive = jpeg_of(waves, TJFLAG_PROGRESSIVE);
  EXPECT_EQ(decode_photo(progressive, "f", 208 * 96).picture, decode_jpeg(jpeg, "f"));
  EXPECT_THAT([&] { decode_photo(progressive, "a.jpg", 208 * 96 - 1); },
              ThrowsMessage<InvalidInput>(HasSubstr("a progressive JPEG of 208 x 96 pixels")));
}

TEST(ReducedPhoto, OfAnHdrIsTheMeanOfLight) {
  std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 3\n";
  for (const char value : std::string("\2\3\4\5\6\7")) {
    hdr += {value, value, value, '\x88'};  // + 1/2
  }
  Shape stored;
  const ImageF small = decode_hdr(bytes_of(hdr), "f", 2, &stored);
  ASSERT_EQ(small.width, 2U);
  ASSERT_EQ(small.height, 1U);
  EXPECT_FLOAT_EQ(small.pixels[0], (2 + 3 + 5 + 6) / 4.F + 0.5F);
  EXPECT_FLOAT_EQ(small.pixels[3], (4 + 7) / 2.F + 0.5F) << "a cell of two pixels";
  EXPECT_EQ(stored, (Shape{3, 2, 3, 8}));
}

std::string png_of_zeros(std::uint32_t width, std::uint32_t height) {
  spng_ctx* const context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_ihdr header{width, height, 8, SPNG_COLOR_TYPE_GRAYSCALE, 0, 0, SPNG_INTERLACE_NONE};
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  spng_set_ihdr(context, &header);
  EXPECT_EQ(spng_encode_image(context, nullptr, 0, SPNG_FMT_PNG,
                              SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE),
            0);
  const std::vector<std::uint8_t> row(width);
  int result = 0;
  while (result == 0) result = spng_encode_row(context, row.data(), row.size());
  EXPECT_EQ(result, SPNG_EOI);
  std::size_t size = 0;
  void* const data = spng_get_png_buffer(context, &size, &result);
  std::string png(static_cast<const char*>(data), size);
  std::free(data);
  spng_ctx_free(context);
  return png;
}

// A texture of 1.3 MB took 450 MB here, and more than 4 GB in all.
TEST(ReducedPhoto, TakesLittleMemoryForManyPixels) {
  const std::string png = png_of_zeros(30'000, 15'000);
  EXPECT_LT(png.size(), 2'000'000U);
  EXPECT_EXIT(
      {
        const Photo photo = decode_photo(bytes_of(png), "f");
        rusage used{};
        getrusage(RUSAGE_SELF, &used);
        std::exit(photo.picture.width == 7'500 && used.ru_maxrss < 250'000 ? 0 : 1);  // kilobytes
      },
      ::testing::ExitedWithCode(0), "");
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
