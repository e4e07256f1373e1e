#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <turbojpeg.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "enfilade/image/codecs.h"
#include "enfilade/image/jpeg_rows.h"

namespace enfilade::image {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::Le;
using ::testing::ThrowsMessage;

// Waves of colour: smooth, as JPEG likes it, and different everywhere.
Image8 waves(std::uint32_t width, std::uint32_t height) {
  Image8 picture(width, height, 3);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const auto u = static_cast<double>(x), v = static_cast<double>(y);
      std::uint8_t* rgb = picture.at(x, y);
      rgb[0] = static_cast<std::uint8_t>(128 + 100 * std::sin(u / 11 + v / 23));
      rgb[1] = static_cast<std::uint8_t>(128 + 100 * std::sin(u / 17 - v / 13));
      rgb[2] = static_cast<std::uint8_t>(128 + 100 * std::sin(v / 9));
    }
  }
  return picture;
}

std::vector<std::uint8_t> compress(const std::vector<std::uint8_t>& pixels, int width, int height,
                                   int format, int subsampling, int flags) {
  const tjhandle handle = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type
  EXPECT_EQ(tjCompress2(handle, pixels.data(), width, 0, height, format, &data, &size, subsampling,
                        90, flags),
            0);
  std::vector<std::uint8_t> jpeg(data, data + size);
  tjFree(data);
  tjDestroy(handle);
  return jpeg;
}

// Where the marker of the scan begins.
std::size_t scan_of(const std::vector<std::uint8_t>& jpeg) {
  constexpr std::array<std::uint8_t, 2> kScan{0xFF, 0xDA};
  return static_cast<std::size_t>(std::ranges::search(jpeg, kScan).begin() - jpeg.begin());
}

double mean_difference(const Image8& a, const Image8& b) {
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(a.pixels[i] - b.pixels[i]);
  return sum / static_cast<double>(a.pixels.size());
}

TEST(Jpeg, ComesBackAlmostAsItWas) {
  const Image8 picture = waves(75, 50);
  for (const bool full_chroma : {false, true}) {
    const auto jpeg = encode_jpeg(picture, 95, full_chroma);
    EXPECT_EQ(jpeg_shape(jpeg, "f"), (Shape{75, 50, 3, 8}));
    // Quantization at quality 95 in steps of 2 to 10 levels; halved chroma adds to it.
    EXPECT_LT(mean_difference(decode_jpeg(jpeg, "f"), picture), full_chroma ? 1 : 2);
  }
}

TEST(Jpeg, IsTheSamePictureInTheCallersMemory) {
  const auto jpeg = encode_jpeg(waves(48, 32), 90);
  const Image8 rgb = decode_jpeg(jpeg, "f");
  std::vector<std::uint8_t> pixels(std::size_t{3} * 48 * 32);
  decode_jpeg(jpeg, 48, 32, pixels, "f");
  EXPECT_EQ(pixels, rgb.pixels);
  EXPECT_THAT([&] { decode_jpeg(jpeg, 32, 48, pixels, "a.jpg"); },
              ThrowsMessage<ArgumentError>(HasSubstr("a.jpg: 48 x 32 pixels, not the 32 x 48")));
}

TEST(Jpeg, GreyscaleComesOutAsThreeEqualChannels) {
  Image8 grey(16, 16, 1);
  for (std::size_t i = 0; i < 256; ++i) grey.pixels[i] = static_cast<std::uint8_t>(i);
  const auto jpeg = encode_jpeg(grey, 100);
  EXPECT_EQ(jpeg_shape(jpeg, "f").channels, 1U);
  const Image8 rgb = decode_jpeg(jpeg, "f");
  ASSERT_EQ(rgb.channels, 3U);
  for (std::size_t i = 0; i < 256; ++i) {
    // At quality 100 the steps are 1: rounding there and back, one level each.
    EXPECT_NEAR(rgb.pixels[3 * i], grey.pixels[i], 2);
    EXPECT_EQ(rgb.pixels[3 * i], rgb.pixels[3 * i + 1]);
    EXPECT_EQ(rgb.pixels[3 * i], rgb.pixels[3 * i + 2]);
  }
}

TEST(Jpeg, ProgressiveFilesAreTheSamePicture) {
  const Image8 picture = waves(64, 64);
  const auto plain = compress(picture.pixels, 64, 64, TJPF_RGB, TJSAMP_420, 0);
  const auto progressive =
      compress(picture.pixels, 64, 64, TJPF_RGB, TJSAMP_420, TJFLAG_PROGRESSIVE);
  ASSERT_NE(plain, progressive);
  EXPECT_EQ(decode_jpeg(plain, "f"), decode_jpeg(progressive, "f"));
}

TEST(Jpeg, RefusesAFileCutOffAnywhere) {
  const Image8 picture = waves(48, 48);
  for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
    const auto jpeg = compress(picture.pixels, 48, 48, TJPF_RGB, TJSAMP_420, flags);
    std::vector<std::uint8_t> pixels(std::size_t{3} * 48 * 48);
    for (std::size_t n = 0; n < jpeg.size(); ++n) {
      const Bytes part = Bytes(jpeg).first(n);
      EXPECT_THROW(decode_jpeg(part, "f"), InvalidInput) << n << " of " << jpeg.size();
      EXPECT_THROW(decode_jpeg(part, 48, 48, pixels, "f"), InvalidInput) << n;
    }
  }
}

TEST(Jpeg, AFileThatFailsLeavesTheNextOneAlone) {
  const auto jpeg = encode_jpeg(waves(48, 48), 90);
  const Image8 before = decode_jpeg(jpeg, "f");
  EXPECT_THROW(decode_jpeg(Bytes(jpeg).first(jpeg.size() / 2), "f"), InvalidInput);
  EXPECT_EQ(decode_jpeg(jpeg, "f"), before);
}

TEST(Jpeg, SaysWhatIsWrong) {
  const auto jpeg = encode_jpeg(waves(192, 192), 90);
  EXPECT_THAT([&] { decode_jpeg(Bytes(jpeg).first(jpeg.size() / 2), "a.jpg"); },
              ThrowsMessage<InvalidInput>(
                  HasSubstr("a.jpg: the JPEG is damaged: Premature end of JPEG file")));
  EXPECT_THAT(
      [] { jpeg_shape(bytes_of("GIF89a"), "a.jpg"); },
      ThrowsMessage<InvalidInput>(HasSubstr("a.jpg: no JPEG that can be read: Not a JPEG")));
  EXPECT_THROW(jpeg_shape({}, "f"), InvalidInput);
}

// A row: an edit of a good file, and what libjpeg calls it.
struct Oddity {
  const char* name;
  std::function<void(std::vector<std::uint8_t>&)> edit;
  const char* says;
};

std::vector<Oddity> harmless() {
  return {
      {"two zeros before the end marker, as Samsung's panoramas have them",
       [](std::vector<std::uint8_t>& jpeg) { jpeg.insert(jpeg.end() - 2, 2, 0); },
       "extraneous bytes before marker 0xd9"},
      {"a scan that ends with coefficient 0",
       [](std::vector<std::uint8_t>& jpeg) { jpeg[scan_of(jpeg) + 12] = 0; },
       "Invalid SOS parameters for sequential JPEG"},
      {"JFIF 3.0", [](std::vector<std::uint8_t>& jpeg) { jpeg[11] = 3; },
       "unknown JFIF revision number 3"},
  };
}

TEST(Jpeg, HarmlessOdditiesAreWarnings) {
  const auto jpeg = encode_jpeg(waves(64, 32), 90);
  const Image8 picture = decode_jpeg(jpeg, "f");
  for (const Oddity& odd : harmless()) {
    SCOPED_TRACE(odd.name);
    auto edited = jpeg;
    odd.edit(edited);
    std::vector<Diagnostic> findings;
    EXPECT_EQ(decode_jpeg(edited, "a.jpg", &findings), picture);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].severity, Severity::kWarning);
    EXPECT_EQ(findings[0].code, "odd-jpeg");
    EXPECT_EQ(findings[0].file, "a.jpg");
    EXPECT_THAT(findings[0].message, HasSubstr(odd.says));
    EXPECT_EQ(jpeg_shape(edited, "f"), (Shape{64, 32, 3, 8}));
    std::vector<std::uint8_t> pixels(picture.pixels.size());
    decode_jpeg(edited, 64, 32, pixels, "f");
    EXPECT_EQ(pixels, picture.pixels);
    // The fast decoder's file is the same picture.
    const auto marked = mark_rows(edited, "f");
    ASSERT_TRUE(marked);
    EXPECT_EQ(decode_jpeg(*marked, "f"), picture);
  }
}

// The harmless warning comes first, and hides none.
TEST(Jpeg, HarmlessOdditiesHideNoDamage) {
  auto jpeg = encode_jpeg(waves(192, 192), 90);
  jpeg[scan_of(jpeg) + 12] = 0;
  EXPECT_NO_THROW(decode_jpeg(jpeg, "f"));
  for (const std::size_t left : {jpeg.size() - 2, jpeg.size() / 2}) {
    EXPECT_THAT([&] { decode_jpeg(Bytes(jpeg).first(left), "a.jpg"); },
                ThrowsMessage<InvalidInput>(
                    HasSubstr("a.jpg: the JPEG is damaged: Premature end of JPEG file")));
    EXPECT_THROW(mark_rows(Bytes(jpeg).first(left), "f"), InvalidInput);
  }
}

// A decoder of rows agrees where rows are marked.
TEST(Jpeg, OddFilesAreCutAndReadByRows) {
  auto jpeg = encode_jpeg(waves(64, 64), 90);
  const Image8 picture = decode_jpeg(jpeg, "f");
  jpeg.insert(jpeg.end() - 2, 3, 0);
  const auto marked = mark_rows(jpeg, "f");
  ASSERT_TRUE(marked);
  ASSERT_TRUE(has_marked_rows(*marked));
  std::vector<std::uint8_t> cells(ColourCells::bytes(64));
  ASSERT_TRUE(decode_rows(*marked, {0, 64}, {cells.data(), 64}));
  std::vector<std::uint8_t> rgb(picture.pixels.size());
  plain_rgb(cells.data(), 64, rgb);
  EXPECT_EQ(rgb, picture.pixels);

  auto strip = encode_jpeg(waves(6 * 32, 32), 90);
  const auto faces = cut_jpeg_strip(strip, "f");
  strip.insert(strip.end() - 2, 3, 0);
  EXPECT_EQ(cut_jpeg_strip(strip, "f"), faces);
}

TEST(Jpeg, BytesBehindTheEndMarkerAreNobodysBusiness) {
  auto jpeg = encode_jpeg(waves(16, 16), 90);
  const Image8 picture = decode_jpeg(jpeg, "f");
  jpeg.insert(jpeg.end(), 100, 0);  // as phones append theirs
  EXPECT_EQ(decode_jpeg(jpeg, "f"), picture);
}

// Adobe's files store 255 - ink: 100 of each is 155 of cyan and of black.
TEST(Jpeg, TakesInkOffWhitePaper) {
  const std::vector<std::uint8_t> cmyk(std::size_t{16} * 16 * 4, 100);
  auto jpeg = compress(cmyk, 16, 16, TJPF_CMYK, TJSAMP_444, 0);
  EXPECT_EQ(jpeg_shape(jpeg, "f"), (Shape{16, 16, 3, 8}));
  std::vector<Diagnostic> findings;
  // 100 * 100 / 255 = 39.2; two levels of compression in each factor.
  EXPECT_THAT(decode_jpeg(jpeg, "f", &findings).pixels, Each(AllOf(Ge(37), Le(41))));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].code, "printing-colours");
  EXPECT_FALSE(mark_rows(jpeg, "f"));
  EXPECT_FALSE(cut_jpeg_strip(jpeg, "f"));
  EXPECT_THROW(decode_jpeg(Bytes(jpeg).first(jpeg.size() - 2), "f"), InvalidInput);
}

// TurboJPEG writes YCCK: 155, 128, 128 and 100 here. Read as CMYK, the same numbers are ink.
TEST(Jpeg, ReadsPlainCmykWithAndWithoutAdobesMarker) {
  const std::vector<std::uint8_t> cmyk(std::size_t{16} * 16 * 4, 100);
  auto jpeg = compress(cmyk, 16, 16, TJPF_CMYK, TJSAMP_444, 0);
  constexpr std::array<std::uint8_t, 2> kAdobe{0xFF, 0xEE};
  const auto adobe = std::ranges::search(jpeg, kAdobe).begin();
  ASSERT_NE(adobe, jpeg.end());
  adobe[15] = 0;                                       // the marker's transform: none
  const auto expect = [&](double red, double other) {  // compression: as above
    const Image8 picture = decode_jpeg(jpeg, "f");
    EXPECT_NEAR(picture.pixels[0], red, 2);
    EXPECT_NEAR(picture.pixels[1], other, 2);
    EXPECT_NEAR(picture.pixels[2], other, 2);
  };
  expect(155 * 100 / 255., 128 * 100 / 255.);  // inverted
  jpeg.erase(adobe, adobe + 16);
  expect(100 * 155 / 255., 127 * 155 / 255.);
}

TEST(Jpeg, EncodingRefusesWhatItCannotHold) {
  EXPECT_THROW(encode_jpeg(Image8(4, 4, 3), 0), ArgumentError);
  EXPECT_THROW(encode_jpeg(Image8(4, 4, 3), 101), ArgumentError);
  EXPECT_THROW(encode_jpeg(Image8(4, 4, 4), 90), ArgumentError);
  EXPECT_THROW(encode_jpeg(Image8(0, 4, 3), 90), ArgumentError);
  EXPECT_THROW(encode_jpeg(Image8(65501, 1, 3), 90), ArgumentError);
}

struct Cut {
  int subsampling;
  int flags;
  std::uint32_t smooth_columns;  // on each side of a cut, where chroma is smoothed across it
};

// The coefficients of a cut face are those of the strip, so its pixels are too; but a decoder
// smooths halved chroma with the next sample's (weights 3/4 and 1/4), which a face has no more:
// one column of pixels on each side of a cut. There the cut face is the better one, for the next
// face of a strip is no neighbour in the room.
TEST(CutJpegStrip, FacesDecodeToThePixelsOfTheStrip) {
  const Image8 picture = waves(6 * 64, 64);
  for (const Cut& cut : {Cut{TJSAMP_444, 0, 0}, Cut{TJSAMP_420, 0, 1}, Cut{TJSAMP_422, 0, 1},
                         Cut{TJSAMP_444, TJFLAG_PROGRESSIVE, 0}, Cut{TJSAMP_GRAY, 0, 0}}) {
    const auto jpeg = compress(picture.pixels, 6 * 64, 64, TJPF_RGB, cut.subsampling, cut.flags);
    const auto faces = cut_jpeg_strip(jpeg, "f");
    ASSERT_TRUE(faces);
    const CubeMap<std::uint8_t> wanted = split_strip(decode_jpeg(jpeg, "f"));
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      const Image8 face = decode_jpeg((*faces)[k], "f");
      ASSERT_EQ(face.width, 64U);
      const std::uint32_t left = k == 0 ? 0 : cut.smooth_columns;
      const std::uint32_t right = k == 5 ? 64 : 64 - cut.smooth_columns;
      for (std::size_t y = 0; y < 64; ++y) {
        for (std::size_t x = left; x < right; ++x) {
          for (std::size_t c = 0; c < 3; ++c) {
            ASSERT_EQ(face.at(x, y)[c], wanted[k].at(x, y)[c])
                << "face " << k << " at " << x << ", " << y;
          }
        }
      }
    }
  }
}

TEST(CutJpegStrip, GivesNothingWhereBlocksCrossACut) {
  EXPECT_TRUE(cut_jpeg_strip(encode_jpeg(waves(6 * 24, 24), 90, true), "f"));
  EXPECT_FALSE(cut_jpeg_strip(encode_jpeg(waves(6 * 24, 24), 90, false), "f"));
  EXPECT_FALSE(cut_jpeg_strip(encode_jpeg(waves(6 * 20, 20), 90, true), "f"));
  EXPECT_FALSE(cut_jpeg_strip(encode_jpeg(waves(64, 32), 90, true), "f"));
}

TEST(CutJpegStrip, RefusesADamagedStrip) {
  const auto jpeg = encode_jpeg(waves(6 * 32, 32), 90);
  EXPECT_THROW(cut_jpeg_strip(Bytes(jpeg).first(jpeg.size() / 2), "f"), InvalidInput);
  EXPECT_THROW(cut_jpeg_strip({}, "f"), InvalidInput);
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
