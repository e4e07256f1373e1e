#include "enfilade/mesh/readers/ply.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "enfilade/core/written_lists.h"
#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh::readers::ply {
namespace {

struct TypeName {
  std::string_view name;
  PropertyType type;
};
constexpr std::array kTypes{
    TypeName{"char", PropertyType::kInt8},     TypeName{"int8", PropertyType::kInt8},
    TypeName{"uchar", PropertyType::kUint8},   TypeName{"uint8", PropertyType::kUint8},
    TypeName{"short", PropertyType::kInt16},   TypeName{"int16", PropertyType::kInt16},
    TypeName{"ushort", PropertyType::kUint16}, TypeName{"uint16", PropertyType::kUint16},
    TypeName{"int", PropertyType::kInt32},     TypeName{"int32", PropertyType::kInt32},
    TypeName{"uint", PropertyType::kUint32},   TypeName{"uint32", PropertyType::kUint32},
    TypeName{"float", PropertyType::kFloat},   TypeName{"float32", PropertyType::kFloat},
    TypeName{"double", PropertyType::kDouble}, TypeName{"float64", PropertyType::kDouble},
};

std::size_t size_of(PropertyType type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}
bool is_float(PropertyType type) {
  return type == PropertyType::kFloat || type == PropertyType::kDouble;
}

enum class Format { kAscii, kLittleEndian, kBigEndian };

/// Reads the lines up to `end_header`.
class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& file) : lines_(bytes), file_(file) {}

  File parse() {
    if (next() != "ply") fail("not a PLY file: the first line is not \"ply\"");
    for (;;) {
      const std::string_view line = next();
      const auto found = words(line);
      if (found.empty() || found[0] == "obj_info") continue;
      if (found[0] == "comment") {
        read_comment(line);
        continue;
      }
      if (found[0] == "end_header") break;
      if (found[0] == "format") {
        read_format(found);
      } else if (found[0] == "element") {
        read_element(found);
      } else if (found[0] == "property") {
        read_property(found);
      } else {
        out_.unknown_lines.add([&] { return lines_.where(); });
      }
    }
    if (!has_format_) fail("no line \"format\"");
    return std::move(out_);
  }
  Format format() const { return format_; }
  const Lines& lines() const { return lines_; }

 private:
  [[noreturn]] void fail(std::string message) const {
    refuse(file_, lines_.where(), "bad-header", std::move(message));
  }
  std::string_view next() {
    const auto line = lines_.next();
    if (!line) fail("the file ends within its header");
    return *line;
  }
  /// `comment TextureFile NAME`, as MeshLab writes it; the names are numbered from 0.
  void read_comment(std::string_view line) {
    cut_word(line);
    if (lower(cut_word(line)) == "texturefile") out_.textures.emplace_back(trimmed(line));
  }
  /// Counts a line that has more words than it needs.
  void count_rest(const std::vector<std::string_view>& found, std::size_t needed) {
    if (found.size() > needed) out_.unknown_lines.add([&] { return lines_.where(); });
  }
  void read_format(const std::vector<std::string_view>& found) {
    constexpr std::array<std::string_view, 3> kNames{"ascii", "binary_little_endian",
                                                     "binary_big_endian"};
    const auto at = found.size() >= 3 ? std::ranges::find(kNames, found[1]) : kNames.end();
    if (at == kNames.end() || found[2] != "1.0") {
      fail("not one of the formats ascii, binary_little_endian, binary_big_endian 1.0");
    }
    count_rest(found, 3);
    format_ = static_cast<Format>(at - kNames.begin());
    has_format_ = true;
  }
  void read_element(const std::vector<std::string_view>& found) {
    const auto rows = found.size() >= 3 ? to_integer(found[2]) : std::nullopt;
    if (!rows || *rows < 0) fail("not \"element NAME COUNT\"");
    count_rest(found, 3);
    out_.elements.push_back({std::string(found[1]), static_cast<std::size_t>(*rows), {}});
  }
  void read_property(const std::vector<std::string_view>& found) {
    const bool list = found.size() >= 5 && found[1] == "list";
    const std::size_t needed = list ? 5 : 3;
    if (found.size() < needed || (!list && found[1] == "list")) {
      fail("not \"property [list TYPE] TYPE NAME\"");
    }
    count_rest(found, needed);
    if (out_.elements.empty()) fail("a property before the first element");
    Column column;
    column.name = found[needed - 1];
    column.type = type(found[needed - 2]);
    column.list = list;
    if (list) {
      column.count_type = type(found[2]);
      if (is_float(column.count_type)) fail("lists are counted in whole numbers");
    }
    out_.elements.back().columns.push_back(std::move(column));
  }
  PropertyType type(std::string_view name) const {
    const auto at = std::ranges::find(kTypes, name, &TypeName::name);
    if (at == kTypes.end()) fail(fmt::format("{}, not a type of PLY", quote(name)));
    return at->type;
  }

  Lines lines_;
  const std::string& file_;
  File out_;
  Format format_ = Format::kAscii;
  bool has_format_ = false;
};

/// Gives values one by one, and the number of bytes left.
class BinarySource {
 public:
  BinarySource(std::string_view bytes, bool swap) : bytes_(bytes), swap_(swap) {}

  static std::size_t least_bytes(PropertyType type) { return size_of(type); }
  std::size_t left() const { return bytes_.size(); }
  bool next_row() { return true; }
  std::string fault() const { return "the file ends"; }
  std::string where() const { return ""; }
  bool row_done() const { return true; }
  static bool odd() { return false; }

  std::optional<double> count(PropertyType type) { return value(type); }
  std::optional<double> value(PropertyType type) {
    // In the order of PropertyType.
    constexpr std::array kNumbers{
        &BinarySource::number<std::int8_t>,  &BinarySource::number<std::uint8_t>,
        &BinarySource::number<std::int16_t>, &BinarySource::number<std::uint16_t>,
        &BinarySource::number<std::int32_t>, &BinarySource::number<std::uint32_t>,
        &BinarySource::number<float>,        &BinarySource::number<double>};
    return (this->*kNumbers[static_cast<std::size_t>(type)])();
  }

 private:
  template <class T>
  std::optional<double> number() {
    if (bytes_.size() < sizeof(T)) return std::nullopt;
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes_.data(), sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    if (swap_) std::ranges::reverse(raw);
    return static_cast<double>(std::bit_cast<T>(raw));
  }

  std::string_view bytes_;
  bool swap_;
};

class AsciiSource {
 public:
  explicit AsciiSource(const Lines& lines) : lines_(lines) {}

  static std::size_t least_bytes(PropertyType) { return 1; }
  std::size_t left() const { return line_.size() + lines_.rest().size(); }
  /// Each row is a line.
  bool next_row() {
    do {
      const auto line = lines_.next();
      if (!line) return false;
      line_ = trimmed(*line);
    } while (line_.empty());
    return true;
  }
  std::string where() const { return lines_.where() + ", "; }
  std::string fault() const {
    return word_.empty() ? "too few values"
                         : quote(word_) + " is not a number, or not one of its type";
  }
  bool row_done() const { return trimmed(line_).empty(); }

  /// Whether the last value was a word that is no number.
  bool odd() const { return odd_; }

  /// The length of a list.
  std::optional<double> count(PropertyType type) {
    word_ = cut_word(line_);
    odd_ = false;
    const auto whole = to_integer(word_);
    constexpr std::array<std::int64_t, 6> kMost{127, 255, 32767, 65535, INT32_MAX, UINT32_MAX};
    const auto t = static_cast<std::size_t>(type);
    if (!whole || *whole > kMost[t]) return std::nullopt;
    return static_cast<double>(*whole);
  }
  /// NaN for a word that is no finite number. A number outside of its type stays as it is.
  std::optional<double> value(PropertyType /*type*/) {
    word_ = cut_word(line_);
    if (word_.empty()) return std::nullopt;
    const auto number = to_any_number(word_);
    odd_ = !number;
    return number.value_or(kNotANumber);
  }

 private:
  Lines lines_;
  std::string_view line_, word_;
  bool odd_ = false;
};

template <class Source>
class RowReader {
 public:
  RowReader(Source source, const std::string& file, std::span<const std::string_view> wanted,
            File& out)
      : source_(std::move(source)), file_(file), wanted_(wanted), out_(out) {}

  void read(Element& element) {
    if (element.rows == 0) return;
    check_size(element);
    std::vector<bool> keep;
    for (Column& column : element.columns) {
      keep.push_back(std::ranges::find(wanted_, column.name) != wanted_.end());
      if (!keep.back()) continue;
      column.values.reserve(element.rows);
      if (column.list) column.ends.reserve(element.rows);
    }
    for (row_ = 0; row_ < element.rows; ++row_) {
      if (!source_.next_row()) fail(element, "the file ends");
      for (std::size_t c = 0; c < element.columns.size(); ++c) {
        read(element, element.columns[c], keep[c]);
      }
      if (!source_.row_done()) out_.long_rows.add([&] { return where(element); });
    }
  }

 private:
  /// Before memory is allocated.
  void check_size(const Element& element) {
    std::size_t row = 0;
    for (const Column& column : element.columns) {
      row += Source::least_bytes(column.list ? column.count_type : column.type);
    }
    if (row == 0) {
      refuse(file_, "element " + element.name, "bad-header", "rows without a property");
    }
    if (element.rows > source_.left() / row) {
      refuse(file_, "element " + element.name, "truncated",
             fmt::format("{} rows, but only {} bytes are left", element.rows, source_.left()));
    }
  }
  void read(const Element& element, Column& column, bool keep) {
    if (!column.list) {
      const double value = number(element, column);
      if (keep) column.values.push_back(value);
      return;
    }
    const auto length = source_.count(column.count_type);
    if (!length) fail(element, source_.fault());
    const double count = *length;
    if (count < 0) fail(element, fmt::format("a list of {}", count));
    if (count > static_cast<double>(source_.left() / Source::least_bytes(column.type))) {
      fail(element, fmt::format("a list of {}, but only {} bytes are left", count, source_.left()));
    }
    for (double i = 0; i < count; ++i) {
      const double value = number(element, column);
      if (keep) column.values.push_back(value);
    }
    if (keep) column.ends.push_back(column.values.size());
  }
  double number(const Element& element, const Column& column) {
    const auto value = source_.value(column.type);
    // A word among corners means that columns are shifted. Among positions it is NaN, which
    // geometry() refuses where a face uses it.
    if (!value || (source_.odd() && names_corners(column.name))) fail(element, source_.fault());
    if (source_.odd()) out_.odd_values.add([&] { return where(element); });
    return *value;
  }
  static bool names_corners(std::string_view name) {
    return name == "vertex_indices" || name == "vertex_index";
  }
  std::string where(const Element& element) const {
    return fmt::format("{}{} {}", source_.where(), element.name, row_);
  }
  [[noreturn]] void fail(const Element& element, const std::string& what) const {
    refuse(file_, where(element), "bad-row",
           fmt::format("{} in row {} of {}", what, row_ + 1, element.rows));
  }

  Source source_;
  const std::string& file_;
  std::span<const std::string_view> wanted_;
  File& out_;
  std::size_t row_ = 0;
};

}  // namespace

const Column* Element::find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view wanted : names) {
    const auto at = std::ranges::find(columns, wanted, &Column::name);
    if (at != columns.end()) return &*at;
  }
  return nullptr;
}

const Element* File::find(std::string_view wanted) const {
  const auto at = std::ranges::find(elements, wanted, &Element::name);
  return at == elements.end() ? nullptr : &*at;
}

File parse(std::string_view bytes, const std::string& file,
           std::span<const std::string_view> wanted) {
  HeaderParser header(bytes, file);
  File out = header.parse();
  const auto read_all = [&](auto source) {
    RowReader reader(std::move(source), file, wanted, out);
    for (Element& element : out.elements) reader.read(element);
  };
  if (header.format() == Format::kAscii) {
    read_all(AsciiSource(header.lines()));
  } else {
    const bool little = header.format() == Format::kLittleEndian;
    read_all(BinarySource(header.lines().rest(),
                          little != (std::endian::native == std::endian::little)));
  }
  return out;
}

}  // namespace enfilade::mesh::readers::ply
