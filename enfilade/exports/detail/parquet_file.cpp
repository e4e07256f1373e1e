#include "enfilade/exports/detail/parquet_file.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>

#include "enfilade/core/errors.h"

namespace enfilade::exports::detail {

namespace {

static_assert(std::endian::native == std::endian::little);

// parquet.thrift's numbers.
enum class Type : std::int32_t { kInt64 = 2, kFloat = 4, kByteArray = 6 };
enum class Repetition : std::int32_t { kOptional = 1, kRepeated = 2 };
constexpr std::int32_t kPlain = 0, kRle = 3, kUtf8 = 0, kList = 3, kDataPage = 0;

void put_varint(std::string& to, std::uint64_t value) {
  while (value >= 0x80) {
    to += static_cast<char>(value | 0x80);
    value >>= 7;
  }
  to += static_cast<char>(value);
}

template <class T>
void put_plain(std::string& to, std::span<const T> values) {
  const std::size_t at = to.size();
  to.resize(at + values.size_bytes());
  if (!values.empty()) std::memcpy(to.data() + at, values.data(), values.size_bytes());
}

void put_length(std::string& to, std::size_t bytes) {
  const auto length = static_cast<std::uint32_t>(bytes);
  put_plain<std::uint32_t>(to, {&length, 1});
}

// Thrift's compact protocol: one struct. Fields have to come in the order of their numbers.
class ThriftStruct {
 public:
  ThriftStruct& number(int field, std::int32_t value) { return integer(field, 5, value); }
  ThriftStruct& large(int field, std::int64_t value) { return integer(field, 6, value); }
  ThriftStruct& text(int field, std::string_view value) {
    header(field, 8);
    put_text(value);
    return *this;
  }
  ThriftStruct& group(int field, const ThriftStruct& value) {
    header(field, 12);
    text_ += value.finished();
    return *this;
  }
  ThriftStruct& numbers(int field, std::span<const std::int32_t> values) {
    list(field, 5, values.size());
    for (const std::int32_t value : values) put_varint(text_, zigzag(value));
    return *this;
  }
  ThriftStruct& texts(int field, std::span<const std::string> values) {
    list(field, 8, values.size());
    for (const std::string& value : values) put_text(value);
    return *this;
  }
  ThriftStruct& groups(int field, std::span<const ThriftStruct> values) {
    list(field, 12, values.size());
    for (const ThriftStruct& value : values) text_ += value.finished();
    return *this;
  }
  std::string finished() const { return text_ + '\0'; }

 private:
  static std::uint64_t zigzag(std::int64_t value) {
    return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
  }
  void header(int field, int type) {
    text_ += static_cast<char>(((field - last_) << 4) | type);
    last_ = field;
  }
  ThriftStruct& integer(int field, int type, std::int64_t value) {
    header(field, type);
    put_varint(text_, zigzag(value));
    return *this;
  }
  void put_text(std::string_view value) {
    put_varint(text_, value.size());
    text_ += value;
  }
  void list(int field, int type, std::size_t size) {
    header(field, 9);
    if (size < 15) {
      text_ += static_cast<char>((size << 4) | static_cast<unsigned>(type));
    } else {
      text_ += static_cast<char>(0xF0 | type);
      put_varint(text_, size);
    }
  }

  std::string text_;
  int last_ = 0;
};

ThriftStruct leaf(Type type, std::string_view name) {
  ThriftStruct element;
  element.number(1, static_cast<std::int32_t>(type));
  element.number(3, static_cast<std::int32_t>(Repetition::kOptional)).text(4, name);
  return element;
}
ThriftStruct branch(std::string_view name, Repetition repetition, std::int32_t children) {
  ThriftStruct element;
  element.number(3, static_cast<std::int32_t>(repetition)).text(4, name).number(5, children);
  return element;
}

// Levels of one or two bits, in runs: how many of which.
std::string levels(std::span<const std::pair<std::size_t, char>> runs) {
  std::string bytes;
  for (const auto& [count, level] : runs) {
    if (count == 0) continue;
    put_varint(bytes, std::uint64_t{count} << 1);
    bytes += level;
  }
  std::string result;
  put_length(result, bytes.size());
  return result + bytes;
}

// Every value is there: a definition level is the number of optional and repeated steps to it.
// Columns are optional because `datasets` takes no other field for the one that its features name.
std::string all_there(std::size_t values, char steps) {
  const std::pair<std::size_t, char> run{values, steps};
  return levels({&run, 1});
}

// A file that grows by columns.
class File {
 public:
  explicit File(std::size_t rows) : rows_(rows) {}

  void add(const ParquetColumn& column) {
    ++children_;
    std::visit([&](const auto& cells) { add(column.name, cells); }, column.cells);
  }

  std::string finish(const std::vector<std::pair<std::string, std::string>>& metadata) && {
    std::vector<ThriftStruct> schema{ThriftStruct().text(4, "schema").number(5, children_)};
    schema.insert(schema.end(), schema_.begin(), schema_.end());
    std::vector<ThriftStruct> pairs;
    for (const auto& [key, value] : metadata) {
      pairs.push_back(ThriftStruct().text(1, key).text(2, value));
    }
    const auto rows = static_cast<std::int64_t>(rows_);
    const ThriftStruct group = ThriftStruct()
                                   .groups(1, chunks_)
                                   .large(2, static_cast<std::int64_t>(text_.size() - 4))
                                   .large(3, rows);
    const std::string footer = ThriftStruct()
                                   .number(1, 1)
                                   .groups(2, schema)
                                   .large(3, rows)
                                   .groups(4, {&group, 1})
                                   .groups(5, pairs)
                                   .text(6, "Enfilade")
                                   .finished();
    text_ += footer;
    put_length(text_, footer.size());
    return std::move(text_) + "PAR1";
  }

 private:
  void add(const std::string& name, const std::vector<std::int64_t>& values) {
    std::string data = all_there(values.size(), 1);
    put_plain<std::int64_t>(data, values);
    schema_.push_back(leaf(Type::kInt64, name));
    chunk(Type::kInt64, {name}, values.size(), data);
  }
  void add(const std::string& name, const std::vector<float>& values) {
    std::string data = all_there(values.size(), 1);
    put_plain<float>(data, values);
    schema_.push_back(leaf(Type::kFloat, name));
    chunk(Type::kFloat, {name}, values.size(), data);
  }
  void add(const std::string& name, const FloatLists& lists) {
    // A repetition of 0 begins a list.
    std::vector<std::pair<std::size_t, char>> repetition;
    for (std::size_t row = 0; row < rows_; ++row) {
      repetition.insert(repetition.end(), {{1, '\0'}, {lists.columns - 1, '\1'}});
    }
    std::string data = levels(repetition) + all_there(lists.values.size(), 3);
    put_plain<float>(data, lists.values);
    schema_.push_back(branch(name, Repetition::kOptional, 1).number(6, kList));
    schema_.push_back(branch("list", Repetition::kRepeated, 1));
    schema_.push_back(leaf(Type::kFloat, "element"));
    chunk(Type::kFloat, {name, "list", "element"}, lists.values.size(), data);
  }
  void add(const std::string& name, const PictureCells& cells) {
    schema_.push_back(branch(name, Repetition::kOptional, 2));
    schema_.push_back(leaf(Type::kByteArray, "bytes"));
    schema_.push_back(leaf(Type::kByteArray, "path").number(6, kUtf8));
    chunk(Type::kByteArray, {name, "bytes"}, cells.bytes.size(), byte_arrays(cells.bytes));
    chunk(Type::kByteArray, {name, "path"}, cells.paths.size(), byte_arrays(cells.paths));
  }
  static std::string byte_arrays(const std::vector<std::string>& values) {
    std::string data = all_there(values.size(), 2);
    for (const std::string& value : values) {
      put_length(data, value.size());
      data += value;
    }
    return data;
  }

  // One page, and what the footer says of it.
  void chunk(Type type, const std::vector<std::string>& path, std::size_t values,
             const std::string& data) {
    if (data.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
      throw ArgumentError(fmt::format("column {}: {} bytes are too many for a page of Parquet",
                                      path.front(), data.size()));
    }
    const auto bytes = static_cast<std::int32_t>(data.size());
    const ThriftStruct page = ThriftStruct()
                                  .number(1, static_cast<std::int32_t>(values))
                                  .number(2, kPlain)
                                  .number(3, kRle)
                                  .number(4, kRle);
    const std::size_t at = text_.size();
    text_ += ThriftStruct()
                 .number(1, kDataPage)
                 .number(2, bytes)
                 .number(3, bytes)
                 .group(5, page)
                 .finished();
    text_ += data;
    const auto size = static_cast<std::int64_t>(text_.size() - at);
    const std::array<std::int32_t, 2> encodings{kPlain, kRle};
    const ThriftStruct about = ThriftStruct()
                                   .number(1, static_cast<std::int32_t>(type))
                                   .numbers(2, encodings)
                                   .texts(3, path)
                                   .number(4, 0)  // not packed
                                   .large(5, static_cast<std::int64_t>(values))
                                   .large(6, size)
                                   .large(7, size)
                                   .large(9, static_cast<std::int64_t>(at));
    chunks_.push_back(ThriftStruct().large(2, static_cast<std::int64_t>(at)).group(3, about));
  }

  std::size_t rows_;
  std::string text_ = "PAR1";
  std::int32_t children_ = 0;
  std::vector<ThriftStruct> schema_, chunks_;
};

std::size_t rows_of(const ParquetColumn& column) {
  struct Rows {
    std::size_t operator()(const std::vector<std::int64_t>& v) const { return v.size(); }
    std::size_t operator()(const std::vector<float>& v) const { return v.size(); }
    std::size_t operator()(const FloatLists& v) const {
      return v.columns == 0 || v.values.size() % v.columns != 0 ? std::size_t(-1)
                                                                : v.values.size() / v.columns;
    }
    std::size_t operator()(const PictureCells& v) const {
      return v.bytes.size() == v.paths.size() ? v.bytes.size() : std::size_t(-1);
    }
  };
  return std::visit(Rows{}, column.cells);
}

}  // namespace

std::string parquet_file(const std::vector<ParquetColumn>& columns,
                         const std::vector<std::pair<std::string, std::string>>& metadata) {
  if (columns.empty()) throw ArgumentError("a table needs a column");
  const std::size_t rows = rows_of(columns.front());
  File file(rows);
  for (const ParquetColumn& column : columns) {
    if (rows_of(column) != rows || rows == std::size_t(-1)) {
      throw ArgumentError(fmt::format("column {}: not {} rows", column.name, rows));
    }
    file.add(column);
  }
  return std::move(file).finish(metadata);
}

}  // namespace enfilade::exports::detail
