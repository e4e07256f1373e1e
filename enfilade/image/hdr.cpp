// Radiance pictures, after Radiance's own reader (src/common: header.c, resolu.c, color.c).

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/detail/check_size.h"
#include "enfilade/image/detail/row_shrinker.h"
#include "enfilade/image/tone.h"

namespace enfilade::image {

using namespace detail;

namespace {

using Rgbe = std::array<std::uint8_t, 4>;

// Header lines are short; a longer one is not a header.
constexpr std::size_t kLongestLine = 4096;

// Each takes 12 bytes in memory.
constexpr std::uint64_t kMostHdrPixels = std::uint64_t{1} << 27;

struct Resolution {
  std::uint32_t width = 0, height = 0;
  bool columns = false;     // scan lines are columns, not rows
  bool from_right = false;  // X decreases
  bool from_below = false;  // Y increases (it points up)
  std::uint32_t lines() const { return columns ? width : height; }
  std::uint32_t length() const { return columns ? height : width; }
};

class HdrReader {
 public:
  HdrReader(Bytes bytes, const std::string& file, std::uint64_t most)
      : rest_(bytes), file_(file), most_(most) {}

  ImageF read(Shape* stored) {
    read_header();
    const Resolution resolution = parse_resolution(line());
    if (stored != nullptr) *stored = {resolution.width, resolution.height, 3};
    if (rest_.size() / 4 < resolution.lines()) fail("truncated-hdr", "the file ends too early");
    halvings_ = halvings_to(resolution.width, resolution.height, most_);
    ImageF picture(halved(resolution.width, halvings_), halved(resolution.height, halvings_), 3);
    std::vector<Rgbe> scan_line(resolution.length());
    for (line_ = 0; line_ < resolution.lines(); ++line_) {
      read_line(scan_line);
      store(scan_line, resolution, picture);
    }
    return picture;
  }

 private:
  [[noreturn]] void fail(std::string code, std::string message) const {
    refuse(file_, line_ == kInHeader ? "header" : fmt::format("scan line {}", line_),
           std::move(code), std::move(message));
  }

  std::string_view line() {
    const std::string_view text(reinterpret_cast<const char*>(rest_.data()), rest_.size());
    const std::size_t end = text.substr(0, kLongestLine).find('\n');
    if (end == std::string_view::npos) fail("bad-hdr", "ends too early, or is no text");
    rest_ = rest_.subspan(end + 1);
    return text.substr(0, end);
  }

  // EXPOSURE may occur several times: pixels were multiplied by the product.
  void read_header() {
    if (!line().starts_with("#?")) fail("bad-hdr", "does not begin with \"#?\"");
    double exposure = 1;
    for (std::string_view one = line(); !one.empty(); one = line()) {
      if (one.starts_with("FORMAT=") && one != "FORMAT=32-bit_rle_rgbe") {
        fail("bad-format", fmt::format("{:?}, not \"FORMAT=32-bit_rle_rgbe\"", one.substr(0, 40)));
      }
      if (one.starts_with("EXPOSURE=")) exposure *= number(one.substr(9));
    }
    if (!(exposure > 1e-30 && exposure < 1e30)) {
      fail("bad-exposure",
           fmt::format("EXPOSURE of {} in all; 1e-30 .. 1e30 is allowed", exposure));
    }
    scale_ = 1 / exposure;
  }

  double number(std::string_view text) const {
    text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
    double value = 0;
    if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc()) {
      fail("bad-exposure", fmt::format("EXPOSURE={:?}, not a number", text.substr(0, 40)));
    }
    return value;
  }

  // "-Y 512 +X 1024": the axis from line to line, then the axis along a line.
  Resolution parse_resolution(std::string_view text) const {
    Resolution resolution;
    const char first_axis = text.size() > 1 ? text[1] : ' ';
    std::string_view rest = text;
    const std::uint32_t first = axis(rest, resolution, text);
    if (!rest.starts_with(' ') || rest.size() < 3 || rest[2] == first_axis) bad_resolution(text);
    rest.remove_prefix(1);
    const std::uint32_t second = axis(rest, resolution, text);
    if (!rest.empty()) bad_resolution(text);
    resolution.columns = first_axis == 'X';
    resolution.width = resolution.columns ? first : second;
    resolution.height = resolution.columns ? second : first;
    check_size(resolution.width, resolution.height, file_);
    if (std::uint64_t{resolution.width} * resolution.height > kMostHdrPixels) {
      fail("bad-size", fmt::format("{} x {} pixels; at most {} pixels are allowed",
                                   resolution.width, resolution.height, kMostHdrPixels));
    }
    return resolution;
  }

  [[noreturn]] void bad_resolution(std::string_view text) const {
    fail("bad-resolution",
         fmt::format("resolution {:?}, not like \"-Y 512 +X 1024\"", text.substr(0, 40)));
  }

  std::uint32_t axis(std::string_view& rest, Resolution& resolution, std::string_view all) const {
    const bool y = rest.size() > 1 && rest[1] == 'Y', x = rest.size() > 1 && rest[1] == 'X';
    const bool plus = rest.starts_with('+'), minus = rest.starts_with('-');
    if ((!x && !y) || (!plus && !minus) || rest.size() < 4 || rest[2] != ' ') bad_resolution(all);
    if (y) resolution.from_below = plus;
    if (x) resolution.from_right = minus;
    rest.remove_prefix(3);
    std::uint32_t value = 0;
    const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (code != std::errc()) bad_resolution(all);
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    return value;
  }

  std::uint8_t byte() {
    if (rest_.empty()) fail("truncated-hdr", "the file ends too early");
    const std::uint8_t value = rest_.front();
    rest_ = rest_.subspan(1);
    return value;
  }

  void read_line(std::vector<Rgbe>& pixels) {
    constexpr std::size_t kShortest = 8, kLongest = 0x7fff;  // of a new-style line
    const bool may_be_new = pixels.size() >= kShortest && pixels.size() <= kLongest;
    if (!may_be_new || rest_.size() < 4 || rest_[0] != 2 || rest_[1] != 2 || rest_[2] > 127) {
      read_old_line(pixels);
      return;
    }
    const std::size_t length = std::size_t{rest_[2]} << 8U | rest_[3];
    if (length != pixels.size()) {
      fail("bad-line", fmt::format("{} pixels, not {} as the header says", length, pixels.size()));
    }
    rest_ = rest_.subspan(4);
    for (std::size_t channel = 0; channel < 4; ++channel) read_channel(pixels, channel);
  }

  // New style: one channel after the other, each in runs (a code above 128) and literal values.
  void read_channel(std::vector<Rgbe>& pixels, std::size_t channel) {
    for (std::size_t x = 0; x < pixels.size();) {
      const std::uint8_t code = byte();
      const std::size_t count = code > 128 ? code & 127U : code;
      if (count > pixels.size() - x) fail("bad-run", "a run beyond the end of the line");
      const std::uint8_t value = code > 128 ? byte() : std::uint8_t{0};
      for (std::size_t end = x + count; x < end; ++x) {
        pixels[x][channel] = code > 128 ? value : byte();
      }
    }
  }

  // Old style: pixel by pixel; (1, 1, 1, n) repeats the last pixel n times, and several such pixels
  // in a row give the bytes of n, lowest first. Flat files have no such pixel.
  void read_old_line(std::vector<Rgbe>& pixels) {
    unsigned shift = 0;
    for (std::size_t x = 0; x < pixels.size();) {
      Rgbe pixel{};
      for (std::uint8_t& value : pixel) value = byte();
      if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
        pixels[x++] = pixel;
        shift = 0;
        continue;
      }
      const std::size_t count = shift > 16 ? pixels.size() + 1 : std::size_t{pixel[3]} << shift;
      if (x == 0 || count > pixels.size() - x) {
        fail("bad-run", x == 0 ? "a run with no pixel before it" : "a run beyond the line's end");
      }
      const Rgbe last = pixels[x - 1];
      for (std::size_t end = x + count; x < end; ++x) pixels[x] = last;
      shift += 8;
    }
  }

  // Of a pixel in a mean: 1 over how many there are. The last cell of an edge may have fewer.
  double share(std::size_t cell, std::uint32_t edge) const {
    const std::size_t begin = cell << halvings_;
    return 1.0 / static_cast<double>(std::min((cell + 1) << halvings_, std::size_t{edge}) - begin);
  }

  // color.c adds half a step to each mantissa: the middle of the values that are rounded down to
  // it.
  void store(const std::vector<Rgbe>& pixels, const Resolution& r, ImageF& picture) const {
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      const Rgbe& pixel = pixels[k];
      if (pixel[3] == 0) continue;  // black, whatever the mantissas say
      const std::size_t along_x = r.columns ? line_ : k, along_y = r.columns ? k : line_;
      const std::size_t x = (r.from_right ? r.width - 1 - along_x : along_x) >> halvings_;
      const std::size_t y = (r.from_below ? r.height - 1 - along_y : along_y) >> halvings_;
      float* rgb = picture.at(x, y);
      const double unit =
          std::ldexp(scale_, pixel[3] - (128 + 8)) * share(x, r.width) * share(y, r.height);
      for (std::size_t c = 0; c < 3; ++c) rgb[c] += static_cast<float>((pixel[c] + 0.5) * unit);
    }
  }

  static constexpr std::size_t kInHeader = ~std::size_t{0};
  Bytes rest_;
  const std::string& file_;
  std::uint64_t most_;
  unsigned halvings_ = 0;
  double scale_ = 1;
  std::size_t line_ = kInHeader;
};

// The factor by which the median becomes mid-grey. Black pixels are left out (a studio's panorama
// may be mostly black).
double metered_scale(const ImageF& linear) {
  std::vector<float> values;
  values.reserve(linear.pixels.size() / 3);
  for (std::size_t i = 0; i < linear.pixels.size(); i += 3) {
    const float* rgb = linear.pixels.data() + i;
    const auto value = static_cast<float>(luminance<double>(rgb[0], rgb[1], rgb[2]));
    if (value > 0 && std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return 1;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return kMidGrey<double> / *middle;
}

std::uint8_t to_byte(double scaled) {
  if (!(scaled > 0)) return 0;
  return srgb8_from_linear(shoulder(scaled));
}

}  // namespace

ImageF decode_hdr(Bytes hdr, const std::string& file, std::uint64_t most, Shape* stored) {
  return HdrReader(hdr, file, most).read(stored);
}

Image8 tone_map(const ImageF& linear, std::optional<double> exposure) {
  if (linear.channels != 3) {
    throw ArgumentError(fmt::format("tone_map: {} channels, not 3", linear.channels));
  }
  const double scale = exposure ? std::exp2(*exposure) : metered_scale(linear);
  Image8 picture(linear.width, linear.height, 3);
  constexpr std::size_t kGrain = 1U << 16U;
  parallel_for(picture.pixels.size(), kGrain, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) picture.pixels[i] = to_byte(scale * linear.pixels[i]);
  });
  return picture;
}

}  // namespace enfilade::image
