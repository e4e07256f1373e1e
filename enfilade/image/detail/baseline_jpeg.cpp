#include "enfilade/image/detail/baseline_jpeg.h"

#include <algorithm>
#include <cstring>

namespace enfilade::image::detail {
namespace {

constexpr std::uint8_t kStartOfImage = 0xD8, kEndOfImage = 0xD9, kBaseline = 0xC0, kTables = 0xC4,
                       kScan = 0xDA, kQuantizers = 0xDB, kInterval = 0xDD, kApp0 = 0xE0,
                       kAdobe = 0xEE, kApp15 = 0xEF, kComment = 0xFE, kFirstRestart = 0xD0,
                       kLastRestart = 0xD7;

std::uint32_t two_bytes(Bytes bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 8U | bytes[at + 1];
}

bool read_quantizers(Bytes body, BaselineJpeg& jpeg) {
  constexpr std::size_t kBytes = 1 + kBlock;  // of a table of 8-bit numbers: all that baseline has
  for (; !body.empty(); body = body.subspan(kBytes)) {
    if (body[0] > 3 || body.size() < kBytes) return false;
    std::ranges::copy(body.subspan(1, kBlock), jpeg.quant[body[0]].begin());
    jpeg.quant_defined[body[0]] = true;
  }
  return true;
}

bool read_tables(Bytes body, BaselineJpeg& jpeg) {
  while (!body.empty()) {
    const std::uint8_t which = body[0];
    if ((which & 0xEEU) != 0 || body.size() < 17) return false;
    HuffmanSpec spec;
    std::ranges::copy(body.subspan(1, 16), spec.counts.begin());
    std::size_t symbols = 0;
    std::uint32_t codes = 0;  // of the codes of 16 bits, how many are taken
    for (std::size_t bits = 1; bits <= 16; ++bits) {
      symbols += spec.counts[bits - 1];
      codes += std::uint32_t{spec.counts[bits - 1]} << (16 - bits);
    }
    if (symbols > spec.symbols.size() || body.size() < 17 + symbols || codes > 0x10000) {
      return false;
    }
    std::ranges::copy(body.subspan(17, symbols), spec.symbols.begin());
    spec.defined = true;
    ((which & 0x10U) != 0 ? jpeg.ac : jpeg.dc)[which & 1U] = spec;
    body = body.subspan(17 + symbols);
  }
  return true;
}

bool read_frame(Bytes body, BaselineJpeg& jpeg) {
  if (jpeg.components != 0 || body.size() < 6 || body[0] != 8) return false;
  jpeg.height = two_bytes(body, 1);
  jpeg.width = two_bytes(body, 3);
  jpeg.components = body[5];
  if (jpeg.components != 1 && jpeg.components != 3) return false;
  if (body.size() != 6 + 3 * jpeg.components || jpeg.width == 0 || jpeg.height == 0) return false;
  for (std::size_t k = 0; k < jpeg.components; ++k) {
    const Bytes entry = body.subspan(6 + 3 * k, 3);
    JpegComponent& component = jpeg.component[k];
    component.id = entry[0];
    component.across = entry[1] >> 4U;
    component.down = entry[1] & 15U;
    component.quant = entry[2];
    const auto fits = [](std::uint8_t factor) { return factor >= 1 && factor <= 4; };
    if (!fits(component.across) || !fits(component.down) || component.quant > 3) return false;
  }
  // A single component's blocks follow each other in rows, whatever its factors.
  if (jpeg.components == 1) jpeg.component[0].across = jpeg.component[0].down = 1;
  return true;
}

bool read_scan(Bytes body, BaselineJpeg& jpeg) {
  const std::size_t n = jpeg.components;
  if (n == 0 || body.size() != 4 + 2 * n || body[0] != n) return false;
  for (std::size_t k = 0; k < n; ++k) {
    JpegComponent& component = jpeg.component[k];
    if (body[1 + 2 * k] != component.id) return false;
    component.dc = body[2 + 2 * k] >> 4U;
    component.ac = body[2 + 2 * k] & 15U;
    if (component.dc > 1 || component.ac > 1 || !jpeg.dc[component.dc].defined ||
        !jpeg.ac[component.ac].defined || !jpeg.quant_defined[component.quant]) {
      return false;
    }
  }
  return body[1 + 2 * n] == 0 && body[2 + 2 * n] == 63 && body[3 + 2 * n] == 0;
}

bool read_segment(std::uint8_t marker, Bytes body, BaselineJpeg& jpeg) {
  constexpr std::size_t kTransform = 11;  // of Adobe's segment, the byte that names the colours
  switch (marker) {
    case kQuantizers:
      return read_quantizers(body, jpeg);
    case kTables:
      return read_tables(body, jpeg);
    case kBaseline:
      return read_frame(body, jpeg);
    case kScan:
      return read_scan(body, jpeg);
    case kInterval:
      if (body.size() != 2) return false;
      jpeg.restart_interval = two_bytes(body, 0);
      return true;
    case kAdobe:
      if (body.size() > kTransform && std::memcmp(body.data(), "Adobe", 5) == 0) {
        jpeg.luma_and_chroma = jpeg.luma_and_chroma && body[kTransform] == 1;
      }
      return true;
    default:
      return (marker >= kApp0 && marker <= kApp15) || marker == kComment;
  }
}

}  // namespace

std::uint32_t BaselineJpeg::mcu_width() const {
  std::uint32_t most = 1;
  for (const JpegComponent& one : component) most = std::max<std::uint32_t>(most, one.across);
  return 8 * most;
}

std::uint32_t BaselineJpeg::mcu_height() const {
  std::uint32_t most = 1;
  for (const JpegComponent& one : component) most = std::max<std::uint32_t>(most, one.down);
  return 8 * most;
}

std::optional<BaselineJpeg> parse_baseline(Bytes bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xFF || bytes[1] != kStartOfImage) return std::nullopt;
  BaselineJpeg jpeg;
  std::size_t at = 2;
  while (at + 4 <= bytes.size()) {
    const std::size_t size = two_bytes(bytes, at + 2);
    if (bytes[at] != 0xFF || size < 2 || at + 2 + size > bytes.size()) return std::nullopt;
    const std::uint8_t marker = bytes[at + 1];
    if (!read_segment(marker, bytes.subspan(at + 4, size - 2), jpeg)) return std::nullopt;
    if (marker == kScan) {
      jpeg.scan = at;
      jpeg.entropy = at + 2 + size;
      if (jpeg.components == 3) {  // without a word from Adobe, the ids tell the colours
        for (std::uint8_t k = 0; k < 3; ++k) {
          jpeg.luma_and_chroma = jpeg.luma_and_chroma && jpeg.component[k].id == k + 1;
        }
      }
      return jpeg;
    }
    at += 2 + size;
  }
  return std::nullopt;
}

bool split_intervals(Bytes entropy, Intervals& intervals) {
  auto& [bytes, begin] = intervals;
  if (bytes.size() < entropy.size() + Intervals::kPadding) {
    bytes.resize(entropy.size() + Intervals::kPadding);
  }
  begin.assign(1, 0);
  std::uint8_t* to = bytes.data();
  const std::uint8_t* from = entropy.data();
  const std::uint8_t* const end = from + entropy.size();
  for (;;) {
    const void* found = std::memchr(from, 0xFF, static_cast<std::size_t>(end - from));
    if (found == nullptr) return false;
    const auto* marker = static_cast<const std::uint8_t*>(found);
    if (end - marker < 2) return false;
    const bool stuffed = marker[1] == 0;
    const auto count = static_cast<std::size_t>(marker - from) + (stuffed ? 1 : 0);
    std::memcpy(to, from, count);
    to += count;
    from = marker + 2;
    if (stuffed) continue;
    const auto place = static_cast<std::size_t>(to - bytes.data());
    if (marker[1] >= kFirstRestart && marker[1] <= kLastRestart) {
      if ((marker[1] & 7U) != (begin.size() - 1) % 8) return false;
      begin.push_back(place);
      continue;
    }
    if (marker[1] != kEndOfImage) return false;
    begin.push_back(place);
    std::memset(to, 0, Intervals::kPadding);
    return true;
  }
}

}  // namespace enfilade::image::detail
