#include "enfilade/image/detail/huffman_lanes.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace enfilade::image::detail {
namespace {

std::uint64_t load_big_endian(const std::uint8_t* from) {
  std::uint64_t word = 0;
  std::memcpy(&word, from, sizeof(word));
  if constexpr (std::endian::native == std::endian::little) word = __builtin_bswap64(word);
  return word;
}

// Takes whole bytes until there are 56 bits or more. Further ones may follow them in `bits`, which
// the next call reads again.
inline void refill(std::uint64_t& bits, std::uint32_t& count, const std::uint8_t*& next) {
  bits |= load_big_endian(next) >> count;
  next += (63 - count) >> 3U;
  count |= 56U;
}

// The number that `size` bits stand for: the lower half of what they can say is negative.
std::int32_t extended(std::uint32_t bits, std::uint32_t size) {
  if (size == 0) return 0;
  const auto value = static_cast<std::int32_t>(bits);
  return value < 1 << (size - 1) ? value - (1 << size) + 1 : value;
}

constexpr std::array<std::uint8_t, Coefficients::kMost> places() {
  std::array<std::uint8_t, Coefficients::kMost> all{};
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k] = k < kBlock ? kRowOrder[k] : std::uint8_t{kBlock};
  }
  return all;
}

// A lane in registers.
struct Turn {
  explicit Turn(const Lane& lane)
      : bits(lane.reader.bits),
        next(lane.reader.next),
        count(lane.reader.count),
        k(lane.k),
        block(lane.block),
        tables(lane.tables[lane.piece]) {}

  void save(Lane& lane) const {
    lane.reader.bits = bits;
    lane.reader.next = next;
    lane.reader.count = count;
    lane.k = k;
    lane.block = block;
  }

  [[gnu::always_inline]] void fill() { refill(bits, count, next); }
  // The next code, read. 0: damaged. \pre there are as many bits as it may have: 16 for a code, 15
  // behind it
  [[gnu::always_inline]] Meaning take(const HuffmanTable& table) {
    const Meaning m = table.at(bits);
    bits <<= length_of(m);
    count -= length_of(m);
    return m;
  }

  std::uint64_t bits;
  const std::uint8_t* next;
  std::uint32_t count, k;
  std::int16_t* block;
  BlockTables tables;
};

enum class After : std::uint8_t { kMore, kEnd, kDamage };

// Reads a block's first coefficient.
[[gnu::always_inline]] inline After begin_block(Turn& turn) {
  turn.fill();
  const Meaning m = turn.take(*turn.tables.dc);
  turn.block[0] = static_cast<std::int16_t>(value_of(m));
  turn.k = 1;
  return length_of(m) == 0 ? After::kDamage : After::kMore;
}

// To the next block, if there is one.
[[gnu::always_inline]] inline After end_block(Turn& turn, Lane& lane) {
  *lane.ends++ = static_cast<std::uint8_t>(turn.k);
  turn.block += kBlock;
  turn.k = 0;
  if (turn.next > lane.reader.end + sizeof(turn.bits)) return After::kDamage;
  lane.piece = lane.piece + 1 == lane.tables.size() ? 0 : lane.piece + 1;
  if (--lane.left == 0) return After::kEnd;
  turn.tables = lane.tables[lane.piece];
  return begin_block(turn);
}

// A coefficient. False if it is damaged.
[[gnu::always_inline]] inline bool read_code(Turn& turn) {
  const Meaning m = turn.take(*turn.tables.ac);
  turn.k += skip_of(m);
  turn.block[Coefficients::kPlace[turn.k]] =
      static_cast<std::int16_t>(value_of(m) * turn.tables.coefficients->quant[turn.k]);
  ++turn.k;
  return length_of(m) != 0;
}

// Two coefficients, or the last one of a block: what 56 bits are enough for.
[[gnu::always_inline]] inline After read_codes(Turn& turn, Lane& lane) {
  turn.fill();
  for (int i = 0; i < 2; ++i) {
    if (!read_code(turn)) [[unlikely]] {
      return After::kDamage;
    }
    if (turn.k >= kBlock) return end_block(turn, lane);
  }
  return After::kMore;
}

[[gnu::always_inline]] inline bool read_two(Lane& a, Lane& b) {
  Turn at_a(a), at_b(b);
  if (at_a.k == 0 && begin_block(at_a) == After::kDamage) return false;
  if (at_b.k == 0 && begin_block(at_b) == After::kDamage) return false;
  After after_a = After::kMore, after_b = After::kMore;
  while (after_a == After::kMore && after_b == After::kMore) {
    after_a = read_codes(at_a, a);
    after_b = read_codes(at_b, b);
  }
  at_a.save(a);
  at_b.save(b);
  return after_a != After::kDamage && after_b != After::kDamage;
}

#if defined(__x86_64__)
// The same with shifts by any register: without them all go through one.
[[gnu::target("bmi2")]] bool read_two_bmi2(Lane& a, Lane& b) { return read_two(a, b); }
#endif

}  // namespace

const std::array<std::uint8_t, Coefficients::kMost> Coefficients::kPlace = places();

void HuffmanTable::set(const HuffmanSpec& spec) {
  if (spec == spec_) return;
  spec_ = spec;
  std::uint32_t code = 0;  // as 16 bits
  std::int32_t symbols = 0;
  for (std::uint32_t bits = 1; bits <= 16; ++bits) {
    const std::uint32_t step = 1U << (16 - bits), count = spec.counts[bits - 1];
    first_[bits - 1] = symbols - static_cast<std::int32_t>(code / step);
    code += count * step;
    symbols += static_cast<std::int32_t>(count);
    limit_[bits - 1] = code;
  }
  for (std::uint64_t k = 0; k < quick_.size(); ++k) {
    // What code and bits behind it say is known if they end within the bits looked up.
    const Meaning m = search(k << (64 - kQuickBits));
    quick_[k] = length_of(m) <= kQuickBits ? m : 0;
  }
}

Meaning HuffmanTable::search(std::uint64_t bits) const {
  const auto code = static_cast<std::uint32_t>(bits >> 48U);
  std::uint32_t length = 1;
  while (length <= 16 && code >= limit_[length - 1]) ++length;
  if (length > 16) return 0;
  const std::int32_t number = first_[length - 1] + static_cast<std::int32_t>(code >> (16 - length));
  const std::uint32_t symbol = spec_.symbols[static_cast<std::size_t>(number)];
  const std::uint32_t skip = symbol >> 4U, size = symbol & 15U;
  if (kind_ == Coefficient::kDc && skip != 0) return 0;
  if (kind_ == Coefficient::kAc && size == 0) {
    if (skip == 0) return meaning(length, kEndOfBlock, 0);
    return skip == 15 ? meaning(length, skip, 0) : 0;
  }
  const std::uint64_t behind = bits << length;
  const auto extra = size == 0 ? 0U : static_cast<std::uint32_t>(behind >> (64 - size));
  return meaning(length + size, skip, extended(extra, size));
}

std::uint64_t BitReader::ahead() {
  refill(bits, count, next);
  return bits;
}

void BitReader::skip(std::uint32_t length) {
  bits <<= length;
  count -= length;
}

bool BitReader::is_at_end() const {
  const std::ptrdiff_t left = 8 * (end - next) + static_cast<std::ptrdiff_t>(count);
  return left >= 0 && left < 8;
}

bool read_lanes(Lane& a, Lane& b) {
#if defined(__x86_64__)
  static const bool kBmi2 = __builtin_cpu_supports("bmi2") != 0;
  if (kBmi2) return read_two_bmi2(a, b);
#endif
  return read_two(a, b);
}

bool read_lanes(Lane& a) {
  Turn at_a(a);
  if (at_a.k == 0 && begin_block(at_a) == After::kDamage) return false;
  After after = After::kMore;
  while (after == After::kMore) after = read_codes(at_a, a);
  at_a.save(a);
  return after != After::kDamage;
}

}  // namespace enfilade::image::detail
