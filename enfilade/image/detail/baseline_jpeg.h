/// \file  The structure of a baseline JPEG file (ITU-T T.81): headers, tables, entropy-coded part.
/// Internal. Only to_baseline() throws. A file that is damaged or not baseline gives no value;
/// libjpeg-turbo then reads it or reports its fault.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/image/codecs.h"

namespace enfilade::image::detail {

inline constexpr std::size_t kBlock = 64;  ///< coefficients of 8 x 8 pixels

/// Where the k-th coefficient of the file's order (zigzag) stands in the block's rows.
inline constexpr std::array<std::uint8_t, kBlock> kRowOrder{
    0,  1,  8,  16, 9,  2,  3,  10, 17, 24, 32, 25, 18, 11, 4,  5,  12, 19, 26, 33, 40, 48,
    41, 34, 27, 20, 13, 6,  7,  14, 21, 28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23,
    30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54, 47, 55, 62, 63};

/// A Huffman table as files have it.
struct HuffmanSpec {
  std::array<std::uint8_t, 16> counts{};    ///< of codes with 1 .. 16 bits
  std::array<std::uint8_t, 256> symbols{};  ///< by code
  bool defined = false;
  friend bool operator==(const HuffmanSpec&, const HuffmanSpec&) = default;
};

struct JpegComponent {
  std::uint8_t id = 0;
  std::uint8_t across = 1, down = 1;       ///< blocks of an MCU
  std::uint8_t quant = 0, dc = 0, ac = 0;  ///< numbers of its tables
};

/// The headers of a file. An MCU is a rectangle of pixels whose blocks follow each other: 16 x 16
/// at 4:2:0, 8 x 8 at 4:4:4.
struct BaselineJpeg {
  std::uint32_t width = 0, height = 0;
  std::uint32_t restart_interval = 0;  ///< MCUs between restart markers; 0: none
  bool luma_and_chroma = true;         ///< three components are Y, Cb, Cr
  std::size_t components = 0;          ///< 1 or 3
  std::array<JpegComponent, 3> component;
  std::array<std::array<std::uint16_t, kBlock>, 4> quant{};  ///< in the file's order
  std::array<bool, 4> quant_defined{};
  std::array<HuffmanSpec, 2> dc, ac;
  std::size_t scan = 0;     ///< offset of the marker that begins the scan
  std::size_t entropy = 0;  ///< offset of the entropy-coded part

  std::uint32_t mcu_width() const;
  std::uint32_t mcu_height() const;
  std::uint32_t mcu_columns() const { return (width + mcu_width() - 1) / mcu_width(); }
  std::uint32_t mcu_rows() const { return (height + mcu_height() - 1) / mcu_height(); }
  /// Whether each row of MCUs, and nothing else, is an interval.
  bool restarts_by_row() const { return restart_interval == mcu_columns(); }
};

/// No value unless the file has one scan of 8-bit baseline coding with all tables before it.
std::optional<BaselineJpeg> parse_baseline(Bytes jpeg);

/// The intervals between restart markers, as bits without stuffing.
struct Intervals {
  std::vector<std::uint8_t> bytes;  ///< one interval after the other, then kPadding zeros
  std::vector<std::size_t> begin;   ///< where each begins; then the end of the last

  /// Bytes that a decoder may read beyond the end before it notices: a block, at most 64 codes of
  /// 16 bits with 16 bits after them.
  static constexpr std::size_t kPadding = 512;
  std::size_t count() const { return begin.size() - 1; }
};
/// Fills `intervals` from the entropy-coded part, whose memory is used again. False unless restart
/// markers have the right numbers and an end marker follows.
bool split_intervals(Bytes entropy, Intervals& intervals);

/// Any JPEG with the same coefficients in baseline coding: with the standard's tables, one scan, no
/// restart markers, no comments. No value for CMYK and rare subsampling. \throws InvalidInput
std::optional<std::vector<std::uint8_t>> to_baseline(Bytes jpeg, const std::string& file);

}  // namespace enfilade::image::detail
