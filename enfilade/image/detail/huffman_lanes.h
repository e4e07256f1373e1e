/// \file  Huffman codes of a baseline JPEG, of several intervals at once. Internal.
///
/// The next code of an interval begins where the last one ended. So a decoder mostly waits for a
/// table to give the length of a code. Intervals do not depend on each other. A lane decodes one
/// interval, and the lanes take turns.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/image/detail/baseline_jpeg.h"

namespace enfilade::image::detail {

/// The meaning of the next bits, packed into 32 bits. It has the length of code and extra bits (0:
/// not known, or damaged), the number of coefficients to skip, and the value of the next.
using Meaning = std::uint32_t;
constexpr Meaning meaning(std::uint32_t length, std::uint32_t skip, std::int32_t value) {
  return length | skip << 8U | static_cast<std::uint32_t>(value) << 16U;
}
constexpr std::uint32_t length_of(Meaning m) { return m & 0xFFU; }
constexpr std::uint32_t skip_of(Meaning m) { return m >> 8U & 0xFFU; }
constexpr std::int32_t value_of(Meaning m) { return static_cast<std::int32_t>(m) >> 16; }
/// The number that an end of block skips. It completes the block from any coefficient.
inline constexpr std::uint32_t kEndOfBlock = 128;

/// A table of codes.
class HuffmanTable {
 public:
  enum class Coefficient : std::uint8_t { kDc, kAc };
  explicit HuffmanTable(Coefficient kind) : kind_(kind) {}

  /// Does nothing if it has the same codes already.
  void set(const HuffmanSpec& spec);
  /// The meaning of the code that begins with the upper bit of `bits`, of which at least 32 are the
  /// file's.
  Meaning at(std::uint64_t bits) const {
    const Meaning quick = quick_[bits >> (64 - kQuickBits)];
    return length_of(quick) != 0 ? quick : search(bits);
  }

 private:
  static constexpr unsigned kQuickBits = 11;  // 4 KiB a table: four stay in the first-level cache

  Meaning search(std::uint64_t bits) const;

  Coefficient kind_;
  HuffmanSpec spec_;
  std::array<Meaning, std::size_t{1} << kQuickBits> quick_{};
  std::array<std::uint32_t, 17> limit_{};  // by bits - 1: above the last code, as 16 bits
  std::array<std::int32_t, 17> first_{};   // by bits - 1: number of the first symbol - its code
};

/// Multipliers of coefficients in the file's order, and their places in the block. Those beyond a
/// block's end (in damaged files, and after an end of block) are 0 and go to the place behind it.
struct Coefficients {
  static constexpr std::size_t kMost = 256;
  std::array<std::int16_t, kMost> quant{};
  static const std::array<std::uint8_t, kMost> kPlace;
};

/// The tables that a block is read with.
struct BlockTables {
  const HuffmanTable* dc = nullptr;
  const HuffmanTable* ac = nullptr;
  const Coefficients* coefficients = nullptr;
};

/// Bits of an interval.
struct BitReader {
  // The upper `count` ones of `bits` have been taken from memory up to `next`.
  const std::uint8_t* next = nullptr;
  const std::uint8_t* end = nullptr;  ///< of the interval
  std::uint64_t bits = 0;
  std::uint32_t count = 0;

  void begin(const std::uint8_t* from, const std::uint8_t* to) {
    next = from;
    end = to;
    bits = count = 0;
  }
  /// The bits ahead from the upper one on, at least 56 (behind the interval: what follows it).
  std::uint64_t ahead();
  /// \pre length <= 56 and ahead() was called
  void skip(std::uint32_t length);
  /// Whether less than a byte of the interval is left.
  bool is_at_end() const;
  /// Whether it has not gone far beyond the interval. `next` may be ahead of the used bits.
  bool is_inside() const { return next <= end + sizeof(bits); }
};

/// Whether a block that ended before the k-th coefficient is sound, and has more than the first.
constexpr bool is_sound_end(std::uint32_t k) { return k == kBlock || k > kEndOfBlock; }
constexpr bool is_flat_end(std::uint32_t k) { return k == 1 + kEndOfBlock + 1; }

/// An interval that is being read: its blocks one after the other.
struct Lane {
  BitReader reader;
  std::span<const BlockTables> tables;  ///< of the blocks of an MCU
  std::size_t piece = 0;                ///< of `tables`, the one of the block that is being read
  std::size_t left = 0;                 ///< blocks that are not complete
  std::uint32_t k = 0;                  ///< next coefficient of the block
  /// The block that is being read, in rows, dequantized. Its first coefficient is the difference to
  /// the component's last block, as in the file.
  /// \pre all 0 before; kBlock more values behind the last block may be written
  std::int16_t* block = nullptr;
  std::uint8_t* ends = nullptr;  ///< where k goes when the block is complete: is_sound_end()
};

/// Reads on in all lanes, in turns, until one has no block left. False if damaged. \pre all have
/// some left; Intervals::kPadding bytes follow the last interval
bool read_lanes(Lane& a, Lane& b);
bool read_lanes(Lane& a);

}  // namespace enfilade::image::detail
