#include "enfilade/image/jpeg_rows.h"

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "enfilade/image/detail/baseline_jpeg.h"
#include "enfilade/image/detail/block_kernels.h"

namespace enfilade::image {
namespace EN_UNIT {

using Jpeg = std::vector<std::uint8_t>;

// Smooth colours with noise, so that blocks end early and late, and codes are short and long.
Image8 picture_of(std::uint32_t width, std::uint32_t height, int noise) {
  std::minstd_rand random(width * 7919 + height);
  Image8 picture(width, height, 3);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double u = static_cast<double>(x) / (9 + 4 * static_cast<double>(c)),
                     v = static_cast<double>(y) / (17 - 3 * static_cast<double>(c));
        // Quiet at the left, where blocks are flat.
        const double grain = x < width / 3 ? 0 : static_cast<double>(random() % 256) - 128;
        const double value = 128 + 110 * std::sin(u + v) + noise * grain / 128;
        picture.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
      }
    }
  }
  return picture;
}

Jpeg compress(const Image8& picture, int subsampling, int quality, int flags = 0) {
  const tjhandle handle = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type
  EXPECT_EQ(tjCompress2(handle, picture.pixels.data(), static_cast<int>(picture.width), 0,
                        static_cast<int>(picture.height), TJPF_RGB, &data, &size, subsampling,
                        quality, flags),
            0);
  Jpeg jpeg(data, data + size);
  tjFree(data);
  tjDestroy(handle);
  return jpeg;
}

class Face {
 public:
  explicit Face(std::uint32_t size) : bytes_(ColourCells::bytes(size), 0xA5), size_(size) {}
  ColourCells cells() { return {bytes_.data(), size_}; }
  Image8 rgb() const {
    Image8 picture(size_, size_, 3);
    plain_rgb(bytes_.data(), size_, picture.pixels);
    return picture;
  }
  // Rows begin .. end - 1.
  static std::vector<std::uint8_t> rows(const Image8& picture, std::size_t begin, std::size_t end) {
    const std::size_t row = std::size_t{3} * picture.width;
    return {picture.pixels.begin() + static_cast<std::ptrdiff_t>(begin * row),
            picture.pixels.begin() + static_cast<std::ptrdiff_t>(end * row)};
  }

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint32_t size_;
};

TEST(MarkRows, KeepsThePictureOfAnyFile) {
  struct Kind {
    int subsampling, flags;
  };
  for (const Kind kind :
       {Kind{TJSAMP_420, 0}, Kind{TJSAMP_422, 0}, Kind{TJSAMP_444, 0}, Kind{TJSAMP_440, 0},
        Kind{TJSAMP_GRAY, 0}, Kind{TJSAMP_420, TJFLAG_PROGRESSIVE}}) {
    const Jpeg jpeg = compress(picture_of(83, 61, 90), kind.subsampling, 85, kind.flags);
    const auto marked = mark_rows(jpeg, "f");
    ASSERT_TRUE(marked) << kind.subsampling;
    EXPECT_EQ(decode_jpeg(*marked, "f"), decode_jpeg(jpeg, "f")) << kind.subsampling;
    const auto parsed = detail::parse_baseline(*marked);
    ASSERT_TRUE(parsed);
    EXPECT_TRUE(parsed->restarts_by_row());
    detail::Intervals intervals;
    ASSERT_TRUE(detail::split_intervals(Bytes(*marked).subspan(parsed->entropy), intervals));
    EXPECT_EQ(intervals.count(), parsed->mcu_rows());
    EXPECT_EQ(mark_rows(*marked, "f"), marked);  // as it is
  }
}

TEST(MarkRows, AddsHardlyAnything) {
  const Jpeg jpeg = compress(picture_of(512, 512, 20), TJSAMP_420, 85);
  const auto marked = mark_rows(jpeg, "f");
  ASSERT_TRUE(marked);
  // 31 markers of two bytes, 6 bytes for the interval; a row's padding and its first coefficients,
  // which are no longer differences, take some 5 bytes more.
  EXPECT_LT(marked->size(), jpeg.size() + 6 + std::size_t{31} * 10);
}

TEST(MarkRows, RefusesABrokenFile) {
  const Jpeg jpeg = compress(picture_of(64, 64, 90), TJSAMP_420, 85);
  EXPECT_THROW(mark_rows(Bytes(jpeg).first(jpeg.size() / 2), "f"), InvalidInput);
  EXPECT_THROW(mark_rows({}, "f"), InvalidInput);
}

// A fuzzer's: its coefficients have 13 bits, which no encoder writes, and a block follows the last
// one. Written again by libjpeg-turbo it is another picture.
TEST(MarkRows, LeavesAFileAloneWhosePictureWouldChange) {
  static constexpr std::array<std::uint8_t, 371> kFile{
      0xFF, 0xD8, 0xFF, 0xE0, 0x00, 0x10, 0x4A, 0x46, 0x49, 0x46, 0x00, 0x01, 0x01, 0x00, 0x00,
      0x01, 0x00, 0x01, 0x00, 0x00, 0xFF, 0xDB, 0x00, 0x43, 0x00, 0x0D, 0x09, 0x0A, 0x0B, 0x0A,
      0x08, 0x0D, 0x0B, 0x0A, 0x0B, 0x0E, 0x0E, 0x0D, 0x0F, 0x13, 0x20, 0x15, 0x13, 0x12, 0x12,
      0x13, 0x27, 0x1C, 0x1E, 0x17, 0x20, 0x2E, 0x29, 0x31, 0x30, 0x2E, 0x29, 0x2D, 0x2C, 0x33,
      0x3A, 0x4A, 0x3E, 0x33, 0x36, 0x46, 0x37, 0x2C, 0x2D, 0x40, 0x57, 0x41, 0x46, 0x4C, 0x4E,
      0x52, 0x53, 0x52, 0x32, 0x3E, 0x5A, 0x61, 0x5A, 0x50, 0x60, 0x4A, 0x51, 0x52, 0x4F, 0xFF,
      0xC0, 0x00, 0x0B, 0x08, 0x00, 0x09, 0x00, 0x11, 0x01, 0x01, 0x11, 0x00, 0xFF, 0xC4, 0x00,
      0x1F, 0x00, 0x00, 0x01, 0x05, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00,
      0x00, 0x00, 0x00, 0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0A, 0x0B,
      0xFF, 0xC4, 0x00, 0xB5, 0x10, 0x00, 0x02, 0x01, 0x03, 0x03, 0x02, 0x04, 0x03, 0x05, 0x05,
      0x04, 0x04, 0x00, 0x00, 0x01, 0x7D, 0x01, 0x02, 0x03, 0x00, 0x04, 0x3D, 0x05, 0x12, 0x21,
      0x31, 0x41, 0x06, 0x13, 0x51, 0x61, 0x07, 0x22, 0x71, 0x14, 0x32, 0x81, 0x91, 0xA1, 0x08,
      0x23, 0x42, 0xB1, 0xC1, 0x15, 0x52, 0xD1, 0xF0, 0x24, 0x33, 0x62, 0x72, 0x82, 0x09, 0x0A,
      0x16, 0x17, 0x18, 0x19, 0x1A, 0x25, 0x26, 0x27, 0x28, 0x29, 0x2A, 0x34, 0x35, 0x36, 0x37,
      0x38, 0x39, 0x3A, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4A, 0x53, 0x54, 0x55, 0x56,
      0x57, 0x58, 0x59, 0x5A, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6A, 0x73, 0x74, 0x75,
      0x76, 0x77, 0x78, 0x79, 0x7A, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8A, 0x92, 0x93,
      0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9A, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7, 0xA8, 0xA9,
      0xAA, 0xB2, 0xB3, 0xB4, 0xB5, 0xB6, 0xB7, 0xB8, 0xB9, 0xBA, 0xC2, 0xC3, 0xC4, 0xC5, 0xC6,
      0xC7, 0xC8, 0xC9, 0xCA, 0xD2, 0xD3, 0xD4, 0xD5, 0xD6, 0xD7, 0xD8, 0xD9, 0xDA, 0xE1, 0xE2,
      0xE3, 0xE4, 0xE5, 0xE6, 0xE7, 0xE8, 0xE9, 0xEA, 0xF1, 0xF2, 0xF3, 0xF4, 0xF5, 0xF6, 0xF7,
      0xF8, 0xF9, 0xFA, 0xFF, 0xDA, 0x00, 0x08, 0x01, 0x01, 0x00, 0x00, 0x3F, 0x00, 0xD0, 0x9F,
      0xC4, 0x70, 0x5A, 0xA1, 0x4B, 0x2B, 0x71, 0x91, 0xD3, 0x02, 0xB1, 0x2E, 0xF5, 0x4D, 0x67,
      0xB4, 0xB5, 0xB6, 0xB7, 0xB8, 0xB9, 0xBA, 0xC2, 0xEC, 0xDD, 0x5F, 0xFE, 0x7E, 0x1B, 0xF3,
      0xA9, 0xA3, 0xFB, 0xD5, 0xAD, 0x69, 0xD0, 0x55, 0xCA, 0xFF, 0xD9};
  EXPECT_NE(decode_jpeg(kFile, "f").pixels.size(), 0U);
  EXPECT_FALSE(mark_rows(kFile, "f"));
}

TEST(DecodeRows, AreTheBytesOfTheWholePicture) {
  for (const std::uint32_t size : {5U, 15U, 16U, 17U, 33U, 90U, 128U, 250U}) {
    for (const int subsampling : {TJSAMP_420, TJSAMP_444}) {
      for (const int quality : {30, 85, 100}) {
        const Jpeg jpeg = compress(picture_of(size, size, 127), subsampling, quality);
        const auto marked = mark_rows(jpeg, "f");
        ASSERT_TRUE(marked);
        EXPECT_TRUE(has_marked_rows(*marked));
        Face face(size);
        ASSERT_TRUE(decode_rows(*marked, {0, size}, face.cells()));
        EXPECT_EQ(face.rgb(), decode_jpeg(jpeg, "f")) << size << ", " << quality;
      }
    }
  }
}

TEST(DecodeRows, AnyRangeIsThatOfTheWholePicture) {
  constexpr std::uint32_t kSize = 53;
  for (const int subsampling : {TJSAMP_420, TJSAMP_444}) {
    const Jpeg jpeg = compress(picture_of(kSize, kSize, 60), subsampling, 85);
    const auto marked = mark_rows(jpeg, "f");
    ASSERT_TRUE(marked);
    const Image8 whole = decode_jpeg(jpeg, "f");
    const Image8 untouched = Face(kSize).rgb();
    for (std::uint32_t begin = 0; begin < kSize; ++begin) {
      for (std::uint32_t end = begin + 1; end <= kSize; ++end) {
        Face face(kSize);
        ASSERT_TRUE(decode_rows(*marked, {begin, end}, face.cells()));
        const Image8 got = face.rgb();
        ASSERT_EQ(Face::rows(got, begin, end), Face::rows(whole, begin, end))
            << begin << " " << end;
        ASSERT_EQ(Face::rows(got, 0, begin), Face::rows(untouched, 0, begin));
        ASSERT_EQ(Face::rows(got, end, kSize), Face::rows(untouched, end, kSize));
      }
    }
  }
}

TEST(DecodeRows, LeavesOthersToTheOrdinaryDecoder) {
  const Image8 picture = picture_of(64, 64, 60);
  Face face(64);
  const auto takes = [&](const Jpeg& jpeg) { return decode_rows(jpeg, {0, 64}, face.cells()); };
  EXPECT_FALSE(takes(compress(picture, TJSAMP_420, 85)));  // no markers
  EXPECT_FALSE(takes(compress(picture, TJSAMP_420, 85, TJFLAG_PROGRESSIVE)));
  for (const int subsampling : {TJSAMP_422, TJSAMP_440, TJSAMP_411, TJSAMP_GRAY}) {
    const auto marked = mark_rows(compress(picture, subsampling, 85), "f");
    ASSERT_TRUE(marked);
    EXPECT_FALSE(takes(*marked)) << subsampling;
    EXPECT_FALSE(has_marked_rows(*marked));
  }
  const auto other_size = mark_rows(compress(picture_of(48, 48, 60), TJSAMP_420, 85), "f");
  EXPECT_FALSE(takes(*other_size));
}

TEST(DecodeRows, NoFileThatIsCutOffIsAPicture) {
  const auto marked = mark_rows(compress(picture_of(40, 40, 90), TJSAMP_420, 85), "f");
  ASSERT_TRUE(marked);
  Face face(40);
  for (std::size_t n = 0; n < marked->size(); ++n) {
    EXPECT_FALSE(decode_rows(Bytes(*marked).first(n), {0, 40}, face.cells())) << n;
  }
}

// The largest sum of a column's coefficients, each without its sign.
struct LargestColumn {
  explicit LargestColumn(const Jpeg& jpeg) : parsed(*detail::parse_baseline(jpeg)) {
    tjtransform transform{};
    transform.op = TJXOP_NONE;
    transform.options = TJXOPT_NOOUTPUT;
    transform.data = this;
    transform.customFilter = look;
    const tjhandle handle = tjInitTransform();
    unsigned char* none = nullptr;
    unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type
    EXPECT_EQ(tjTransform(handle, jpeg.data(), jpeg.size(), 1, &none, &size, &transform, 0), 0);
    tjFree(none);
    tjDestroy(handle);
  }
  static int look(short* coefficients, tjregion region, tjregion /*plane*/, int component,
                  int /*transform*/, tjtransform* transform) {
    auto& self = *static_cast<LargestColumn*>(transform->data);
    const auto c = static_cast<std::size_t>(component);
    const auto& quant = self.parsed.quant[self.parsed.component[c].quant];
    const auto count = static_cast<std::size_t>(region.w) * static_cast<std::size_t>(region.h);
    for (std::size_t first = 0; first < count; first += detail::kBlock) {
      std::array<int, 8> sums{};
      for (std::size_t k = 0; k < detail::kBlock; ++k) {
        const std::size_t place = detail::kRowOrder[k];
        sums[place % 8] += std::abs(coefficients[first + place] * quant[k]);
      }
      self.sum = std::max(self.sum, *std::ranges::max_element(sums));
    }
    return 0;
  }

  detail::BaselineJpeg parsed;
  int sum = 0;
};

// Whether libjpeg-turbo makes the same of these coefficients on every processor. The transform's
// first pass multiplies by up to 4 sqrt(2) cos(pi / 16) = 5.55, and keeps 16 bits: of what has
// more, the nearest number that has 16 on x86, and in our kernels; its lower bits on ARM. No
// picture comes near it: its coefficients are at most 1024, and those of a column are large one at
// a time.
bool is_plain(const Jpeg& jpeg) {
#if defined(__x86_64__)
  static_cast<void>(jpeg);
  return true;
#else
  return LargestColumn(jpeg).sum < 32767 / 5.55;
#endif
}

// Where it takes damaged codes (JPEG has no checksums), libjpeg-turbo takes them too, and sees the
// same picture. Headers are not damaged here: libjpeg-turbo warns of numbers that mean nothing.
TEST(DecodeRows, AgreesAboutDamagedFiles) {
  const auto marked = mark_rows(compress(picture_of(40, 40, 90), TJSAMP_420, 85), "f");
  ASSERT_TRUE(marked);
  const std::size_t codes = detail::parse_baseline(*marked)->entropy;
  std::minstd_rand random(1);
  int taken = 0;
  for (int k = 0; k < 4000; ++k) {
    Jpeg damaged = *marked;
    for (int bits = 0; bits < 1 + k % 3; ++bits) {
      const std::size_t at = codes + random() % (damaged.size() - codes);
      damaged[at] ^= static_cast<std::uint8_t>(1U << random() % 8);
    }
    Face face(40);
    if (!decode_rows(damaged, {0, 40}, face.cells()) || !is_plain(damaged)) continue;
    ++taken;
    ASSERT_EQ(face.rgb(), decode_jpeg(damaged, "f")) << k;
  }
  EXPECT_GT(taken, 100);  // most flipped bits within a block change it alone
}

TEST(BlockKernels, AreTheirPlainTwins) {
  const detail::BlockKernels &quick = detail::block_kernels(),
                             &plain = detail::scalar_block_kernels();
  constexpr std::size_t kPitch = 24;
  std::minstd_rand random(2);
  for (int round = 0; round < 2000; ++round) {
    std::array<std::int16_t, 128> blocks{};
    const std::uint32_t range = 1U << (round % 16 + 1);  // up to what no picture has
    for (std::int16_t& value : blocks) {
      value = static_cast<std::int16_t>(random() % range - range / 2);
    }
    std::array<std::array<std::uint8_t, 16 * kPitch>, 2> out{};
    quick.transform(blocks.data(), out[0].data(), out[0].data() + 8 * kPitch, kPitch);
    plain.transform(blocks.data(), out[1].data(), out[1].data() + 8 * kPitch, kPitch);
    ASSERT_EQ(out[0], out[1]) << "range " << range;
  }
  constexpr std::size_t kSlack = detail::BlockKernels::kRowSlack;
  for (std::size_t width = 1; width < 70; ++width) {
    std::array<std::vector<std::uint8_t>, 3> rows;
    for (auto& row : rows) {
      row.resize(2 * width + 2 * kSlack);
      for (std::uint8_t& value : row) value = static_cast<std::uint8_t>(random());
    }
    std::array<std::vector<std::uint8_t>, 2> wide, rgb;
    std::vector<std::uint16_t> sums(width + 2 + kSlack);
    for (const bool simd : {false, true}) {
      const detail::BlockKernels& kernels = simd ? quick : plain;
      wide[simd].resize(2 * width + kSlack);
      kernels.upsample({rows[0].data(), rows[1].data()}, width, sums.data(), wide[simd].data());
      wide[simd].resize(2 * width);
      rgb[simd].resize(3 * width + kSlack);
      kernels.to_rgb(rows[0].data(), rows[1].data(), rows[2].data(), width, rgb[simd].data());
      rgb[simd].resize(3 * width);
    }
    ASSERT_EQ(wide[0], wide[1]) << width;
    ASSERT_EQ(rgb[0], rgb[1]) << width;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
