#include <algorithm>
#include <bit>
#include <cstdlib>

#include "enfilade/image/detail/baseline_jpeg.h"
#include "enfilade/image/detail/huffman_lanes.h"
#include "enfilade/image/detail/to_baseline.h"
#include "enfilade/image/jpeg_rows.h"

namespace enfilade::image {
namespace {

using namespace detail;

// Bits as files have them: whole bytes, a 0 after each 255.
class BitWriter {
 public:
  explicit BitWriter(std::vector<std::uint8_t>& to) : to_(to) {}

  // The lower `length` bits. \pre length <= 32
  void put(std::uint64_t bits, std::uint32_t length) {
    held_ = held_ << length | bits;
    for (count_ += length; count_ >= 8; count_ -= 8) {
      const auto byte = static_cast<std::uint8_t>(held_ >> (count_ - 8));
      to_.push_back(byte);
      if (byte == 0xFF) to_.push_back(0);
    }
    held_ &= (std::uint64_t{1} << count_) - 1;
  }
  // Fills the last byte with ones, as markers begin at whole bytes.
  void finish() {
    if (count_ > 0) put(0xFFU >> count_, 8 - count_);
  }
  void marker(std::uint8_t which) {
    to_.push_back(0xFF);
    to_.push_back(which);
  }

 private:
  std::vector<std::uint8_t>& to_;
  std::uint64_t held_ = 0;
  std::uint32_t count_ = 0;  // of bits in held_
};

// The codes of symbols: the table that decoders turn round.
class Codes {
 public:
  explicit Codes(const HuffmanSpec& spec) {
    std::uint32_t code = 0;
    std::size_t next = 0;
    for (std::uint8_t length = 1; length <= 16; ++length, code <<= 1U) {
      for (std::size_t k = 0; k < spec.counts[length - 1U]; ++k, ++code, ++next) {
        codes_[spec.symbols[next]] = {code, length};
      }
    }
  }
  // Writes how many bits a difference has, and the bits. False if the table has no such code.
  bool put(std::int32_t difference, BitWriter& to) const {
    const auto size = static_cast<std::uint32_t>(
        std::bit_width(static_cast<std::uint32_t>(std::abs(difference))));
    if (size > 15 || codes_[size].length == 0) return false;
    to.put(codes_[size].bits, codes_[size].length);
    const std::int32_t bits = difference < 0 ? difference + (1 << size) - 1 : difference;
    to.put(static_cast<std::uint64_t>(bits), size);
    return true;
  }

 private:
  struct Code {
    std::uint32_t bits = 0;
    std::uint8_t length = 0;  // 0: none
  };
  std::array<Code, 256> codes_;
};

// Goes through the codes of a file without restart markers and writes them again with some. Only
// the first coefficient of a block changes, when it is no longer told from the last block's.
class Marker {
 public:
  Marker(const BaselineJpeg& jpeg, const Intervals& intervals, std::vector<std::uint8_t>& to)
      : jpeg_(jpeg),
        writer_(to),
        codes_{Codes(jpeg.dc[0]), Codes(jpeg.dc[1])},
        dc_{HuffmanTable(HuffmanTable::Kind::kDc), HuffmanTable(HuffmanTable::Kind::kDc)},
        ac_{HuffmanTable(HuffmanTable::Kind::kAc), HuffmanTable(HuffmanTable::Kind::kAc)} {
    for (std::size_t k = 0; k < 2; ++k) {
      dc_[k].set(jpeg.dc[k]);
      ac_[k].set(jpeg.ac[k]);
    }
    reader_.begin(intervals.bytes.data(), intervals.bytes.data() + intervals.begin[1]);
  }

  bool write() {
    const std::uint32_t rows = jpeg_.mcu_rows();
    for (std::uint32_t row = 0; row < rows; ++row) {
      if (row > 0) writer_.marker(static_cast<std::uint8_t>(0xD0 + (row - 1) % 8));
      written_ = {};
      for (std::uint32_t column = 0; column < jpeg_.mcu_columns(); ++column) {
        if (!write_mcu()) return false;
      }
      writer_.finish();
    }
    writer_.marker(0xD9);
    return reader_.is_at_end();
  }

 private:
  bool write_mcu() {
    for (std::size_t c = 0; c < jpeg_.components; ++c) {
      const JpegComponent& component = jpeg_.component[c];
      for (int k = 0; k < component.across * component.down; ++k) {
        if (!write_block(c)) return false;
      }
    }
    return true;
  }

  bool write_block(std::size_t c) {
    const JpegComponent& component = jpeg_.component[c];
    const Meaning first = dc_[component.dc].at(reader_.ahead());
    if (length_of(first) == 0) return false;
    reader_.skip(length_of(first));
    read_[c] += value_of(first);
    if (!codes_[component.dc].put(read_[c] - written_[c], writer_)) return false;
    written_[c] = read_[c];
    std::uint32_t k = 1;
    for (; k < kBlock; ++k) {
      const std::uint64_t ahead = reader_.ahead();
      const Meaning m = ac_[component.ac].at(ahead);
      if (length_of(m) == 0) return false;
      writer_.put(ahead >> (64 - length_of(m)), length_of(m));
      reader_.skip(length_of(m));
      k += skip_of(m);
    }
    return is_sound_end(k) && reader_.is_inside();
  }

  const BaselineJpeg& jpeg_;
  BitWriter writer_;
  std::array<Codes, 2> codes_;
  std::array<HuffmanTable, 2> dc_, ac_;
  BitReader reader_;
  std::array<std::int32_t, 3> read_{}, written_{};  // the last first coefficients
};

std::optional<std::vector<std::uint8_t>> marked(Bytes bytes) {
  const auto jpeg = parse_baseline(bytes);
  if (!jpeg) return std::nullopt;
  if (jpeg->restarts_by_row()) return std::vector<std::uint8_t>(bytes.begin(), bytes.end());
  Intervals intervals;
  constexpr std::uint32_t kLongestInterval = 65535;
  if (jpeg->restart_interval != 0 || jpeg->mcu_columns() > kLongestInterval ||
      !split_intervals(bytes.subspan(jpeg->entropy), intervals) || intervals.count() != 1) {
    return std::nullopt;
  }
  std::vector<std::uint8_t> result;
  result.reserve(bytes.size() + bytes.size() / 64);
  result.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(jpeg->scan));
  const std::uint32_t interval = jpeg->mcu_columns();
  result.insert(result.end(), {0xFF, 0xDD, 0, 4, static_cast<std::uint8_t>(interval >> 8U),
                               static_cast<std::uint8_t>(interval)});
  const Bytes scan = bytes.subspan(jpeg->scan, jpeg->entropy - jpeg->scan);
  result.insert(result.end(), scan.begin(), scan.end());
  if (!Marker(*jpeg, intervals, result).write()) return std::nullopt;
  return result;
}

}  // namespace

std::optional<std::vector<std::uint8_t>> mark_rows(Bytes jpeg, const std::string& file) {
  auto result = marked(jpeg);
  if (result) return result;
  // Written again by libjpeg-turbo, a file is baseline and has tables with all codes. But it cuts
  // off coefficients that no encoder writes, and what follows the last block.
  result = marked(to_baseline(jpeg, file));
  if (result && decode_jpeg(*result, file).pixels != decode_jpeg(jpeg, file).pixels) return {};
  return result;
}

}  // namespace enfilade::image
