#include "enfilade/image/jpeg_rows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>

#include "enfilade/core/check.h"
#include "enfilade/image/detail/baseline_jpeg.h"
#include "enfilade/image/detail/block_kernels.h"
#include "enfilade/image/detail/huffman_lanes.h"

namespace enfilade::image {
namespace {

using namespace detail;

// Rows of MCUs that are kept, so that pixels are still in the first caches when they are written:
// two that lanes are at, and those before them that wait for the chroma below.
constexpr std::size_t kKept = 4;

// The rows of a component that are kept.
struct Plane {
  std::vector<std::uint8_t> bytes;
  std::size_t pitch = 0, rows = 0;

  void resize(std::size_t width, std::size_t height) {
    pitch = width + BlockKernels::kRowSlack;
    rows = height;
    if (bytes.size() < pitch * rows) bytes.resize(pitch * rows);
  }
  std::uint8_t* row(std::size_t y) { return bytes.data() + y % rows * pitch; }
};

// A first coefficient is eight times the mean of a block, less 128: -1024 to 1016. Four times this
// still fits into 16 bits; transforms differ in what they make of larger ones.
constexpr std::int64_t kLargestFirst = 8191;

// A block of an MCU.
struct Piece {
  std::size_t component = 0;
  std::size_t across = 0, down = 0;  // place in the MCU, in blocks
};

// Fills 8 rows of 8 pixels with what the transform gives if only the first coefficient is not 0.
void fill_flat(std::int16_t first, std::uint8_t* out, std::size_t pitch) {
  const int scaled = std::clamp(4 * first, -32768, 32767);
  const int value = std::clamp((scaled + 16) >> 5, -128, 127) + 128;
  for (std::size_t y = 0; y < 8; ++y) std::memset(out + y * pitch, value, 8);
}

bool takes(const BaselineJpeg& jpeg) {
  const auto& [y, cb, cr] = jpeg.component;
  const auto single = [](const JpegComponent& c) { return c.across == 1 && c.down == 1; };
  // Narrower pictures are upsampled in another way.
  constexpr std::uint32_t kLeastSize = 5;
  return jpeg.components == 3 && jpeg.luma_and_chroma && jpeg.width == jpeg.height &&
         jpeg.width >= kLeastSize && y.across == y.down && y.across <= 2 && single(cb) &&
         single(cr) && jpeg.restarts_by_row();
}

// The decoder of a thread: its tables stay, for files that have the same ones follow each other.
class RowDecoder {
 public:
  bool decode(Bytes jpeg, RowRange rows, const ColourCells& face) {
    const auto parsed = parse_baseline(jpeg);
    if (!parsed || !takes(*parsed) || parsed->width != face.size) return false;
    jpeg_ = *parsed;
    if (!split_intervals(jpeg.subspan(jpeg_.entropy), intervals_) ||
        intervals_.count() != jpeg_.mcu_rows()) {
      return false;
    }
    choose_rows(rows);
    prepare(face.size);
    return read_rows(face);
  }

 private:
  // A row of MCUs that a lane reads.
  struct Row {
    std::size_t number = 0;
    std::vector<std::int16_t> blocks;
    std::vector<std::uint8_t> ends;
  };

  bool halved() const { return jpeg_.component[0].across == 2; }

  void choose_rows(RowRange rows) {
    EN_CHECK(rows.begin < rows.end && rows.end <= jpeg_.height);
    const std::size_t begin = rows.begin, end = rows.end, side = jpeg_.mcu_height();
    written_ = begin;
    end_pixel_row_ = end;
    // A row of chroma of half the resolution is smoothed with the next one, above or below.
    const bool above = halved() && begin % 2 == 0 && begin > 0;
    const bool below = halved() && end % 2 == 0 && end < jpeg_.height;
    const std::size_t first = above ? begin - 1 : begin, last = below ? end : end - 1;
    complete_ = next_row_ = first / side;
    end_row_ = last / side + 1;
    done_.fill(false);
  }

  void prepare(std::size_t size) {
    pieces_ = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const JpegComponent& component = jpeg_.component[c];
      planes_[c].resize(std::size_t{8} * component.across * jpeg_.mcu_columns(),
                        8 * component.down * kKept);
      for (std::size_t y = 0; y < component.down; ++y) {
        for (std::size_t x = 0; x < component.across; ++x, ++pieces_) {
          piece_[pieces_] = {c, x, y};
          tables_[pieces_] = {&dc_[component.dc], &ac_[component.ac], &coefficients_[c]};
        }
      }
      std::ranges::copy(jpeg_.quant[component.quant], coefficients_[c].quant.begin());
      dc_[component.dc].set(jpeg_.dc[component.dc]);
      ac_[component.ac].set(jpeg_.ac[component.ac]);
    }
    unused_.resize(8 * planes_[0].pitch);
    for (Row& row : rows_) {
      const std::size_t blocks = pieces_ * jpeg_.mcu_columns();
      row.blocks.assign(kBlock * (blocks + 1), 0);
      row.ends.resize(blocks);
    }
    const std::size_t room = size + 2 * BlockKernels::kRowSlack;
    if (sums_.size() >= room) return;
    rgb_.resize(3 * room);
    for (auto& row : upsampled_) row.resize(room);
    sums_.resize(room);
  }

  bool read_rows(const ColourCells& face) {
    std::array<bool, 2> busy{};
    while (complete_ < end_row_) {
      for (std::size_t i = 0; i < 2; ++i) {
        // The row whose memory it takes must have been written: a lane may be far ahead.
        if (busy[i] || next_row_ == end_row_ || next_row_ >= complete_ + kKept - 1) continue;
        start_row(i);
        busy[i] = true;
      }
      const bool sound = busy[0] && busy[1] ? read_lanes(lanes_[0], lanes_[1])
                                            : read_lanes(lanes_[busy[0] ? 0 : 1]);
      if (!sound) return false;
      for (std::size_t i = 0; i < 2; ++i) {
        if (!busy[i] || lanes_[i].left > 0) continue;
        if (!lanes_[i].reader.is_at_end() || !transform_row(rows_[i])) return false;
        complete_row(rows_[i].number, face);
        busy[i] = false;
      }
    }
    return true;
  }

  void complete_row(std::size_t row, const ColourCells& face) {
    done_[row % kKept] = true;
    while (complete_ < end_row_ && done_[complete_ % kKept]) {
      done_[complete_ % kKept] = false;
      ++complete_;
    }
    // The last row of pixels of a row of MCUs needs the chroma below, if there is any.
    std::size_t end = complete_ * jpeg_.mcu_height();
    if (halved() && complete_ < jpeg_.mcu_rows()) end -= std::min<std::size_t>(end, 1);
    write_rows(std::min(end, end_pixel_row_), face);
  }

  void start_row(std::size_t i) {
    Row& row = rows_[i];
    row.number = next_row_++;
    const std::uint8_t* bytes = intervals_.bytes.data();
    Lane& lane = lanes_[i];
    lane.reader.begin(bytes + intervals_.begin[row.number],
                      bytes + intervals_.begin[row.number + 1]);
    lane.tables = std::span(tables_).first(pieces_);
    lane.piece = 0;
    lane.left = row.ends.size();
    lane.k = 0;
    lane.block = row.blocks.data();
    lane.ends = row.ends.data();
  }

  // From coefficients, which become 0 again, to the planes. False if a block is damaged.
  bool transform_row(Row& row) {
    std::array<std::int32_t, 3> first{};  // the last first coefficients, by component
    std::int16_t* block = row.blocks.data();
    const std::uint8_t* end = row.ends.data();
    std::array<std::uint8_t*, 6> places{};  // of the blocks of the row's first MCU, by piece
    for (std::size_t p = 0; p < pieces_; ++p) {
      const Piece& piece = piece_[p];
      const std::size_t y = row.number * jpeg_.component[piece.component].down + piece.down;
      places[p] = planes_[piece.component].row(8 * y) + 8 * piece.across;
    }
    std::array<std::uint8_t*, 2> out{};
    std::size_t next = 0;  // piece
    for (std::size_t done = 0; done < row.ends.size(); done += 2, block += 2 * kBlock, end += 2) {
      bool flat = true;
      std::size_t pitch = 0;
      // Both blocks have planes alike: luma, or chroma, or at 4:4:4 any. An odd one is alone.
      const std::size_t count = std::min<std::size_t>(row.ends.size() - done, 2);
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t c = piece_[next].component;
        pitch = planes_[c].pitch;
        out[k] = places[next];
        places[next] += std::size_t{8} * jpeg_.component[c].across;
        next = next + 1 == pieces_ ? 0 : next + 1;
        std::int16_t& own = block[k * kBlock];
        first[c] += own;
        const std::int64_t scaled = std::int64_t{first[c]} * coefficients_[c].quant[0];
        if (!is_sound_end(end[k]) || scaled < -kLargestFirst || scaled > kLargestFirst)
          return false;
        own = static_cast<std::int16_t>(scaled);
        flat = flat && is_flat_end(end[k]);
      }
      if (count == 1) out[1] = unused_.data();
      if (flat) {
        for (std::size_t k = 0; k < count; ++k) fill_flat(block[k * kBlock], out[k], pitch);
      } else {
        kernels_.transform(block, out[0], out[1], pitch);
        std::memset(block, 0, 2 * kBlock * sizeof(*block));
      }
    }
    return true;
  }

  void write_rows(std::size_t end, const ColourCells& face) {
    for (; written_ < end; ++written_) {
      std::array<const std::uint8_t*, 2> chroma{};
      for (std::size_t c = 0; c < 2; ++c) {
        chroma[c] = halved() ? upsampled_row(c, written_) : planes_[c + 1].row(written_);
      }
      kernels_.to_rgb(planes_[0].row(written_), chroma[0], chroma[1], face.size, rgb_.data());
      face.write_row(written_, rgb_.data());
    }
  }

  const std::uint8_t* upsampled_row(std::size_t c, std::size_t y) {
    Plane& plane = planes_[c + 1];
    const std::size_t near = y / 2, rows = (std::size_t{jpeg_.height} + 1) / 2;
    const std::size_t far =
        y % 2 == 1 ? std::min(near + 1, rows - 1) : near - std::min<std::size_t>(near, 1);
    kernels_.upsample({plane.row(near), plane.row(far)}, (std::size_t{jpeg_.width} + 1) / 2,
                      sums_.data(), upsampled_[c].data());
    return upsampled_[c].data();
  }

  const BlockKernels& kernels_ = block_kernels();
  BaselineJpeg jpeg_;
  Intervals intervals_;
  std::array<Piece, 6> piece_;         // of an MCU: the first `pieces_`
  std::array<BlockTables, 6> tables_;  // likewise
  std::size_t pieces_ = 0;
  // Rows of MCUs: all before it are read; for the next free lane; the end.
  std::size_t complete_ = 0, next_row_ = 0, end_row_ = 0;
  std::array<bool, kKept> done_{};               // rows from complete_ on that are read
  std::size_t written_ = 0, end_pixel_row_ = 0;  // rows of pixels: next one to write; the end
  std::array<Coefficients, 3> coefficients_;     // by component
  std::array<HuffmanTable, 2> dc_{HuffmanTable(HuffmanTable::Coefficient::kDc),
                                  HuffmanTable(HuffmanTable::Coefficient::kDc)};
  std::array<HuffmanTable, 2> ac_{HuffmanTable(HuffmanTable::Coefficient::kAc),
                                  HuffmanTable(HuffmanTable::Coefficient::kAc)};
  std::array<Plane, 3> planes_;  // by component
  std::array<Lane, 2> lanes_;
  std::vector<std::uint8_t> unused_;  // target of blocks that do not exist
  std::array<Row, 2> rows_;           // of the lanes
  std::array<std::vector<std::uint8_t>, 2> upsampled_;
  std::vector<std::uint16_t> sums_;
  std::vector<std::uint8_t> rgb_;
};

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
        dc_{HuffmanTable(HuffmanTable::Coefficient::kDc),
            HuffmanTable(HuffmanTable::Coefficient::kDc)},
        ac_{HuffmanTable(HuffmanTable::Coefficient::kAc),
            HuffmanTable(HuffmanTable::Coefficient::kAc)} {
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

bool has_marked_rows(Bytes jpeg) {
  const auto parsed = parse_baseline(jpeg);
  return parsed && takes(*parsed);
}

bool decode_rows(Bytes jpeg, RowRange rows, const ColourCells& face) {
  thread_local RowDecoder decoder;
  return decoder.decode(jpeg, rows, face);
}

std::optional<std::vector<std::uint8_t>> mark_rows(Bytes jpeg, const std::string& file) {
  auto result = marked(jpeg);
  if (result) return result;
  // Written again by libjpeg-turbo, a file is baseline and has tables with all codes. But it cuts
  // off coefficients that no encoder writes, and what follows the last block.
  const auto baseline = to_baseline(jpeg, file);
  if (!baseline) return std::nullopt;
  result = marked(*baseline);
  if (result && decode_jpeg(*result, file).pixels != decode_jpeg(jpeg, file).pixels) return {};
  return result;
}

}  // namespace enfilade::image
