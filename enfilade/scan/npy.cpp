#include "enfilade/scan/npy.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/utf8.h"

namespace enfilade::scan {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kMostHeader = std::size_t{1} << 16U, kMostDimensions = 8;
constexpr std::size_t kMostText = 4096;  // characters of an element
constexpr std::uint32_t kNoCharacter = 0xfffd;

std::string shape_of(const std::vector<std::size_t>& shape) {
  return shape.size() == 1 ? fmt::format("({},)", shape[0])
                           : fmt::format("({})", fmt::join(shape, ", "));
}

// The header: a dictionary as Python writes it, with the keys descr, fortran_order and shape.
class NpyHeader {
 public:
  explicit NpyHeader(std::string_view text) : text_(text) {}

  void read() {
    take('{');
    while (!ended('}')) {
      const std::string key = string();
      take(':');
      value(key);
      if (!ended('}', false)) take(',');
    }
    skip_blanks();
    if (at_ != text_.size()) fail("the end of the header");
    if (type.empty() || !shape || !fortran) {
      throw Error("the header lacks one of the keys \"descr\", \"fortran_order\", \"shape\"");
    }
  }

  std::string type;
  std::optional<std::vector<std::size_t>> shape;
  std::optional<bool> fortran;

 private:
  void value(const std::string& key) {
    if (key == "descr") {
      if (next() == '[') throw Error("an array of records; numbers, bools or texts are read");
      type = string();
    } else if (key == "fortran_order") {
      fortran = boolean();
    } else if (key == "shape") {
      shape = tuple();
    } else {
      throw Error(
          fmt::format("the header has the key {}; \"descr\", \"fortran_order\" and "
                      "\"shape\" are known",
                      quote(key)));
    }
  }

  std::string string() {
    const char quote = next();
    if (quote != '\'' && quote != '"') fail("a text in quotes");
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == text_.npos) fail("a text that ends");
    std::string text(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return text;
  }

  bool boolean() {
    skip_blanks();
    for (const bool one : {true, false}) {
      const std::string_view name = one ? "True" : "False";
      if (!text_.substr(at_).starts_with(name)) continue;
      at_ += name.size();
      return one;
    }
    fail("True or False");
  }

  std::vector<std::size_t> tuple() {
    std::vector<std::size_t> numbers;
    take('(');
    while (!ended(')')) {
      skip_blanks();
      const std::size_t end = std::min(text_.find_first_not_of("0123456789", at_), text_.size());
      const auto number = parse_number<std::size_t>(text_.substr(at_, end - at_));
      if (!number) fail("a size");
      at_ = end;
      numbers.push_back(*number);
      if (!ended(')', false)) take(',');
    }
    return numbers;
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::string_view(" \t\n").find(text_[at_]) != text_.npos) ++at_;
  }
  char next() {
    skip_blanks();
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  void take(char c) {
    if (next() != c) fail(std::string(1, c));
    ++at_;
  }
  // \param consume  whether to go past it
  bool ended(char c, bool consume = true) {
    if (next() != c) return false;
    if (consume) ++at_;
    return true;
  }
  [[noreturn]] void fail(std::string_view wanted) const {
    throw Error(fmt::format("a damaged header: {} is expected at its byte {}", wanted, at_));
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

// The header's bytes, and where the data begin.
std::pair<std::string_view, std::size_t> npy_header_of(std::string_view bytes) {
  if (!bytes.starts_with(kMagic) || bytes.size() < kMagic.size() + 4) {
    throw Error("no array of NumPy's: it does not begin with \\x93NUMPY");
  }
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
  const unsigned version = byte(kMagic.size());
  if (version < 1 || version > 3) {
    throw Error(fmt::format("version {}; 1, 2 and 3 are read", version));
  }
  const std::size_t size_bytes = version == 1 ? 2 : 4, at = kMagic.size() + 2;
  std::size_t size = 0;
  for (std::size_t k = 0; k < size_bytes && at + k < bytes.size(); ++k) {
    size |= std::size_t{byte(at + k)} << (8 * k);
  }
  const std::size_t begin = at + size_bytes;
  if (size > kMostHeader || begin + size > bytes.size()) {
    throw Error(fmt::format("a header of {} bytes; {} are there, and {} are read", size,
                            bytes.size() - std::min(begin, bytes.size()), kMostHeader));
  }
  return {bytes.substr(begin, size), begin + size};
}

NpyKind kind_of(const std::string& type) {
  constexpr std::string_view kLetters = "fiubUS";  // in the order of NpyKind
  const std::size_t kind = type.size() < 3 ? kLetters.npos : kLetters.find(type[1]);
  if (kind != kLetters.npos) return static_cast<NpyKind>(kind);
  throw Error(
      fmt::format("elements of type {}; numbers, bools and texts (\"<f4\", \"|b1\", "
                  "\"<U32\") are read",
                  quote(type)));
}

std::size_t bytes_of_item(const std::string& type, NpyKind kind) {
  const auto count = parse_number<std::size_t>(std::string_view(type).substr(2));
  const bool text = kind == NpyKind::kText || kind == NpyKind::kBytes;
  const bool fits =
      count && (text                     ? *count <= kMostText
                : kind == NpyKind::kBool ? *count == 1
                                         : std::has_single_bit(*count) && *count <= 8 &&
                                               (kind != NpyKind::kFloat || *count > 1));
  if (!fits || std::string_view("<>|=").find(type[0]) == std::string_view::npos) {
    throw Error(fmt::format("elements of type {}, whose size is not read", quote(type)));
  }
  return kind == NpyKind::kText ? *count * 4 : *count;
}

// \throws Error if it, or its number of bytes, is too large
std::size_t product(const std::vector<std::size_t>& shape, std::size_t item) {
  if (shape.size() > kMostDimensions) {
    throw Error(fmt::format("{} dimensions; {} at most are read", shape.size(), kMostDimensions));
  }
  std::size_t size = 1;
  const std::size_t most = std::numeric_limits<std::size_t>::max() / std::max<std::size_t>(item, 1);
  for (const std::size_t one : shape) {
    if (one != 0 && size > most / one) {
      throw Error(fmt::format("a shape of {}, which is too large", shape_of(shape)));
    }
    size *= one;
  }
  // Elements without bytes (texts of no character) could be any number.
  if (item == 0 && size > kMostHeader) {
    throw Error(fmt::format("{} empty texts", size));
  }
  return size;
}

std::string npy(std::string_view type, const std::vector<std::size_t>& shape,
                std::string_view data) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type,
                                   shape_of(shape));
  // Data begin at a multiple of 64.
  constexpr std::size_t kAligned = 64;
  const std::size_t before = kMagic.size() + 4;
  const std::size_t unpadded = before + header.size() + 1;
  header.append((kAligned - unpadded % kAligned) % kAligned, ' ');
  header += '\n';
  std::string bytes(kMagic);
  bytes += '\x01';
  bytes += '\0';
  bytes += static_cast<char>(header.size() & 0xffU);
  bytes += static_cast<char>(header.size() >> 8U);
  return bytes.append(header).append(data);
}

void put(std::string& bytes, std::uint32_t value) {
  for (const unsigned shift : {0U, 8U, 16U, 24U}) {
    bytes += static_cast<char>(value >> shift & 0xffU);
  }
}

// The code points of UTF-8.
std::vector<std::uint32_t> codes_of(std::string_view text) {
  std::vector<std::uint32_t> codes;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) throw ArgumentError("text that is not UTF-8 cannot be written");
    const auto first = static_cast<unsigned char>(text[0]);
    std::uint32_t code = length == 1 ? first : first & (0xffU >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
      code = code << 6U | (static_cast<unsigned char>(text[k]) & 0x3fU);
    }
    codes.push_back(code);
    text.remove_prefix(length);
  }
  return codes;
}

}  // namespace

NpyArray NpyArray::parse(std::string bytes) {
  NpyArray array;
  array.bytes_ = std::move(bytes);
  const auto [text, data] = npy_header_of(array.bytes_);
  NpyHeader header(text);
  header.read();
  array.kind_ = kind_of(header.type);
  array.item_ = bytes_of_item(header.type, array.kind_);
  array.type_ = std::move(header.type);
  array.shape_ = *std::move(header.shape);
  array.size_ = product(array.shape_, array.item_);
  array.data_ = data;
  const std::size_t there = array.bytes_.size() - data, wanted = array.size_ * array.item_;
  if (there != wanted) {
    throw Error(fmt::format("{} bytes of elements, not the {} of shape {} and type {}", there,
                            wanted, shape_of(array.shape_), quote(array.type_)));
  }
  array.put_in_order(*header.fortran, array.type_[0] == '>');
  return array;
}

std::string NpyArray::shape_text() const { return shape_of(shape_); }

// The elements in C order, each little-endian.
void NpyArray::put_in_order(bool fortran, bool big_endian) {
  const std::size_t width = kind_ == NpyKind::kText ? 4 : kind_ == NpyKind::kBytes ? 1 : item_;
  const bool swapped = big_endian && width > 1;
  if (!fortran && !swapped) return;
  std::string ordered(size_ * item_, '\0');
  for (std::size_t i = 0; i < size_; ++i) {
    std::size_t from = i;
    if (fortran) {
      // From the last dimension, which C order counts fastest; in the file the first is.
      std::size_t stride = size_, rest = i;
      from = 0;
      for (std::size_t d = shape_.size(); d-- > 0;) {
        stride /= shape_[d];
        from += rest % shape_[d] * stride;
        rest /= shape_[d];
      }
    }
    for (std::size_t k = 0; k < item_; ++k) {
      const std::size_t at = swapped ? k / width * width + (width - 1 - k % width) : k;
      ordered[i * item_ + at] = bytes_[data_ + from * item_ + k];
    }
  }
  bytes_ = std::move(ordered);
  data_ = 0;
}

static_assert(std::endian::native == std::endian::little, "elements are kept little-endian");

std::uint64_t NpyArray::integer(std::size_t begin, std::size_t bytes) const {
  std::uint64_t value = 0;
  std::memcpy(&value, bytes_.data() + data_ + begin, bytes);
  return value;
}

double NpyArray::number(std::size_t i) const {
  EN_CHECK_LT(i, size_);
  const std::uint64_t bits = integer(i * item_, item_);
  if (kind_ == NpyKind::kBool) return bits != 0 ? 1 : 0;
  if (kind_ == NpyKind::kUnsigned) return static_cast<double>(bits);
  if (kind_ == NpyKind::kInteger) {
    const unsigned unused = static_cast<unsigned>(64 - 8 * item_);
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
  }
  if (item_ == 8) return std::bit_cast<double>(bits);
  if (item_ == 4) return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
  const auto half = static_cast<std::uint16_t>(bits);
  float value = 0;
  const bool finite = copy_halves(reinterpret_cast<const std::byte*>(&half), {&value, 1});
  return finite ? value : std::numeric_limits<double>::quiet_NaN();
}

void NpyArray::copy_elements(std::span<std::byte> out) const {
  EN_CHECK_EQ(out.size(), size_ * item_);
  if (!out.empty()) std::memcpy(out.data(), bytes_.data() + data_, out.size());
}

std::string NpyArray::text(std::size_t i) const {
  EN_CHECK_LT(i, size_);
  const std::size_t begin = i * item_, width = kind_ == NpyKind::kText ? 4 : 1;
  std::vector<std::uint32_t> codes;
  for (std::size_t k = 0; k < item_; k += width) {
    const auto code = static_cast<std::uint32_t>(integer(begin + k, width));
    const bool character = code <= 0x10ffff && (code < 0xd800 || code >= 0xe000);
    codes.push_back(character && (width == 4 || code < 0x80) ? code : kNoCharacter);
  }
  while (!codes.empty() && codes.back() == 0) codes.pop_back();
  std::string text;
  for (const std::uint32_t code : codes) append_utf8(code, text);
  return text;
}

std::string write_npy(std::span<const float> values, const std::vector<std::size_t>& shape) {
  EN_CHECK_EQ(product(shape, 4), values.size());
  std::string data;
  data.reserve(4 * values.size());
  for (const float value : values) put(data, std::bit_cast<std::uint32_t>(value));
  return npy("<f4", shape, data);
}

std::string write_npy(std::span<const std::uint8_t> bools, const std::vector<std::size_t>& shape) {
  EN_CHECK_EQ(product(shape, 1), bools.size());
  std::string data;
  data.reserve(bools.size());
  for (const std::uint8_t one : bools) data += one != 0 ? '\x01' : '\0';
  return npy("|b1", shape, data);
}

std::string write_npy(std::span<const std::string> texts, const std::vector<std::size_t>& shape) {
  EN_CHECK_EQ(product(shape, 4), texts.size());
  std::vector<std::vector<std::uint32_t>> all;
  std::size_t longest = 1;
  for (const std::string& text : texts) {
    longest = std::max(longest, all.emplace_back(codes_of(text)).size());
  }
  if (longest > kMostText) {
    throw ArgumentError(
        fmt::format("a text of {} characters; {} at most are written", longest, kMostText));
  }
  std::string data;
  data.reserve(4 * longest * texts.size());
  for (std::vector<std::uint32_t>& codes : all) {
    codes.resize(longest);
    for (const std::uint32_t code : codes) put(data, code);
  }
  return npy(fmt::format("<U{}", longest), shape, data);
}

}  // namespace enfilade::scan
