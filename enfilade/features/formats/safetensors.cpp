#include "enfilade/features/formats/stored_arrays.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/errors.h"

// Files of weights are little-endian, and so is every machine that this is built for.
static_assert(std::endian::native == std::endian::little);

namespace enfilade::features::formats {
namespace {

constexpr std::uint64_t kLongestHeader = 100'000'000;  // of the format's own reader
constexpr std::size_t kLengthBytes = 8;
constexpr std::size_t kAlignment = 64;  // of a cache line, and of any vector instruction's memory
constexpr std::string_view kMetadata = "__metadata__";

/// The bytes of an array, counted from the end of the header.
struct Range {
  std::uint64_t begin = 0, end = 0;
  std::string name;
  bool read = true;  ///< else of a type that is left out
};

/// Reads what the header says. Faults are collected.
class HeaderReader {
 public:
  HeaderReader(json::Faults& faults, StoredArrays& into, std::vector<Range>& ranges)
      : faults_(faults), into_(into), ranges_(ranges) {}

  void read(json::Element root) {
    const json::Path path;
    const auto object = json::object(root, path, faults_);
    if (!object) return;
    std::set<std::string_view> names;
    for (const auto field : *object) {
      const json::Path at(path, field.key);
      if (!names.insert(field.key).second) {
        faults_.error(at, "repeated-name", "comes twice, not once");
      } else if (field.key == kMetadata) {
        read_metadata(field.value, at);
      } else {
        read_array(field.key, field.value, at);
      }
    }
  }

 private:
  void read_metadata(json::Element element, const json::Path& path) {
    const auto object = json::object(element, path, faults_);
    if (!object) return;
    for (const auto field : *object) {
      const auto value = json::string(field.value, json::Path(path, field.key), faults_);
      if (value) into_.metadata[std::string(field.key)] = *value;
    }
  }

  void read_array(std::string_view name, json::Element element, const json::Path& path) {
    static constexpr std::array<json::Field, 3> kFields{{{"dtype"}, {"shape"}, {"data_offsets"}}};
    std::array<std::optional<json::Element>, 3> found;
    if (!json::fields(element, kFields, found, path, faults_)) return;
    const auto word = json::string(*found[0], json::Path(path, "dtype"), faults_);
    auto shape = read_numbers(*found[1], json::Path(path, "shape"));
    const json::Path offsets_path(path, "data_offsets");
    const auto offsets = read_numbers(*found[2], offsets_path);
    if (!word || !shape || !offsets) return;
    if (offsets->size() != 2 || (*offsets)[0] > (*offsets)[1]) {
      faults_.error(offsets_path, "bad-offsets", "not [begin, end] with begin at or before end");
      return;
    }
    const auto type = find_enum<DType>(*word);
    Range range{static_cast<std::uint64_t>((*offsets)[0]),
                static_cast<std::uint64_t>((*offsets)[1]), std::string(name), type.has_value()};
    if (!type) {
      into_.left_out[range.name] = fmt::format(
          "{}, not F16, BF16, F32, F64, I32, I64, U8, U64 or BOOL", json::describe(*found[0]));
      ranges_.push_back(std::move(range));
      return;
    }
    const auto bytes = bytes_of_shape(*shape, *type);
    if (!bytes || *bytes != range.end - range.begin) {
      faults_.error(
          offsets_path, "bad-size",
          fmt::format("{} bytes, not the {} of {} numbers of type {}", range.end - range.begin,
                      bytes ? fmt::to_string(*bytes) : "too many",
                      shape->empty() ? "1" : fmt::to_string(fmt::join(*shape, " x ")),
                      enum_name(*type)));
      return;
    }
    into_.arrays.push_back({std::string(name), *type, *std::move(shape), {}});
    ranges_.push_back(std::move(range));
  }

  std::optional<std::vector<std::int64_t>> read_numbers(json::Element element,
                                                        const json::Path& path) {
    const auto array = json::array(element, path, faults_);
    if (!array) return std::nullopt;
    std::vector<std::int64_t> numbers;
    for (const json::Element number : *array) {
      const json::Path at(path, numbers.size());
      const auto value = json::integer(number, at, faults_);
      if (!value) return std::nullopt;
      if (*value < 0) {
        faults_.error(at, "negative", fmt::format("{}, not 0 or more", *value));
        return std::nullopt;
      }
      numbers.push_back(*value);
    }
    return numbers;
  }

  json::Faults& faults_;
  StoredArrays& into_;
  std::vector<Range>& ranges_;
};

std::span<const std::byte> header_of(std::span<const std::byte> file, const std::string& name) {
  if (file.size() < kLengthBytes) {
    refuse(name, "byte 0", "truncated",
           fmt::format("{} bytes, not the 8 and more of a safetensors file", file.size()));
  }
  std::uint64_t bytes = 0;  // little-endian, as this machine (safetensors.cpp)
  std::memcpy(&bytes, file.data(), kLengthBytes);
  if (bytes > kLongestHeader) {
    refuse(name, "byte 0", "bad-header",
           fmt::format("a header of {} bytes, at most {} are allowed: no safetensors file", bytes,
                       kLongestHeader));
  }
  if (bytes > file.size() - kLengthBytes) {
    refuse(name, "byte 0", "truncated",
           fmt::format("a header of {} bytes in a file of {}", bytes, file.size()));
  }
  const auto header = file.subspan(kLengthBytes, bytes);
  if (header.empty() || header[0] != std::byte{'{'}) {
    refuse(name, "byte 8", "bad-header", "a header that does not begin with \"{\"");
  }
  return header;
}

// The format allows no holes, no overlaps, and no bytes after the last array.
void check_ranges(const std::vector<Range>& ranges, std::uint64_t bytes, json::Faults& faults) {
  std::vector<std::size_t> order(ranges.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {},
                    [&](std::size_t i) { return std::pair(ranges[i].begin, ranges[i].end); });
  std::uint64_t end = 0;
  const json::Path root;
  for (const std::size_t i : order) {
    const json::Path array(root, ranges[i].name);
    const json::Path path(array, "data_offsets");
    if (ranges[i].end > bytes) {
      faults.error(
          path, "truncated",
          fmt::format("ends at byte {} of the data, of which there are {}", ranges[i].end, bytes));
      return;
    }
    if (ranges[i].begin != end) {
      faults.error(path, ranges[i].begin < end ? "overlap" : "hole",
                   fmt::format("begins at byte {} of the data, not at {} where the one before ends",
                               ranges[i].begin, end));
      return;
    }
    end = ranges[i].end;
  }
  if (end != bytes) {
    faults.error(root, "surplus",
                 fmt::format("{} bytes of data, of which arrays have {}", bytes, end));
  }
}

nlohmann::ordered_json header_of(std::span<const NamedArray> arrays,
                                 std::span<const std::uint64_t> begins,
                                 const std::map<std::string, std::string>& metadata) {
  nlohmann::ordered_json::object_t header;  // grows at its end; operator[] would search all of it
  if (!metadata.empty()) header.emplace_back(std::string(kMetadata), metadata);
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const NamedArray& array = arrays[i];
    const std::uint64_t bytes = *bytes_of_shape(array.shape, array.type);
    nlohmann::ordered_json entry;
    entry["dtype"] = enum_name(array.type);
    entry["shape"] = array.shape;
    entry["data_offsets"] = {begins[i], begins[i] + bytes};
    header.emplace_back(array.name, std::move(entry));
  }
  return header;
}

void check_names(std::span<const NamedArray> arrays) {
  std::set<std::string_view> names;
  for (const NamedArray& array : arrays) {
    if (array.name == kMetadata || !names.insert(array.name).second) {
      throw ArgumentError(fmt::format(
          "array {}: {}", quote(array.name, 100),
          array.name == kMetadata ? "the format keeps this name" : "comes twice, not once"));
    }
    const auto negative = [](std::int64_t side) { return side < 0; };
    if (std::ranges::any_of(array.shape, negative) || !bytes_of_shape(array.shape, array.type)) {
      throw ArgumentError(
          fmt::format("array {}: a side below 0, or a size beyond memory", quote(array.name, 100)));
    }
  }
}

// The order of the data. It aligns each array as well as a format without gaps allows: first the
// arrays that leave the next one aligned, then by the size of an element.
std::vector<std::size_t> order_of_data(std::span<const NamedArray> arrays) {
  std::vector<std::size_t> order(arrays.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) {
    const NamedArray& array = arrays[i];
    return *bytes_of_shape(array.shape, array.type) % kAlignment == 0 ? kAlignment
                                                                      : size_of(array.type);
  });
  return order;
}

}  // namespace

std::span<const std::byte> StoredArrays::aligned(std::span<const std::byte> bytes, DType type) {
  if (std::bit_cast<std::uintptr_t>(bytes.data()) % size_of(type) == 0) return bytes;
  const auto copy = allocate(bytes.size());
  std::ranges::copy(bytes, copy.begin());
  return copy;
}

std::span<std::byte> StoredArrays::allocate(std::size_t bytes) {
  // new[], and not std::make_shared: its memory is aligned for any type.
  const std::shared_ptr<std::byte[]> room(new std::byte[bytes]);
  memory.push_back(room);
  return {room.get(), bytes};
}

std::optional<std::size_t> bytes_of_shape(std::span<const std::int64_t> shape,
                                          DType type) noexcept {
  // An empty array is empty whatever its other sides are.
  if (std::ranges::find(shape, 0) != shape.end()) return 0;
  std::size_t bytes = size_of(type);
  for (const std::int64_t side : shape) {
    if (__builtin_mul_overflow(bytes, static_cast<std::size_t>(side), &bytes)) return std::nullopt;
  }
  return bytes;
}

StoredArrays read_safetensors(std::span<const std::byte> file, const std::string& name) {
  const auto header = header_of(file, name);
  const auto document =
      json::Document::parse({reinterpret_cast<const char*>(header.data()), header.size()}, name);
  const auto data = file.subspan(kLengthBytes + header.size());
  StoredArrays read;
  std::vector<Range> ranges;
  json::Faults faults(name);
  HeaderReader(faults, read, ranges).read(document.root());
  faults.throw_if_errors();
  check_ranges(ranges, data.size(), faults);
  const json::Path root;
  if (read.arrays.empty()) {
    for (const auto& [array, reason] : read.left_out) {
      const json::Path entry(root, array);
      faults.error(json::Path(entry, "dtype"), "unsupported-type", reason);
    }
  }
  faults.throw_if_errors();
  std::size_t next = 0;
  for (const Range& range : ranges) {
    if (!range.read) continue;
    NamedArray& array = read.arrays[next++];
    array.bytes = read.aligned(data.subspan(range.begin, range.end - range.begin), array.type);
  }
  return read;
}

SafetensorsLayout lay_out_safetensors(std::span<const NamedArray> arrays,
                                      const std::map<std::string, std::string>& metadata) {
  check_names(arrays);
  SafetensorsLayout layout;
  layout.offsets.resize(arrays.size());
  std::uint64_t end = 0;
  for (const std::size_t i : order_of_data(arrays)) {
    layout.offsets[i] = end;
    end += *bytes_of_shape(arrays[i].shape, arrays[i].type);
  }
  std::string header;
  try {
    header = header_of(arrays, layout.offsets, metadata).dump();
  } catch (const nlohmann::json::exception& error) {
    throw ArgumentError(fmt::format("a name or metadata: no UTF-8 ({})", error.what()));
  }
  header.resize(
      (kLengthBytes + header.size() + kAlignment - 1) / kAlignment * kAlignment - kLengthBytes,
      ' ');
  if (header.size() > kLongestHeader) {
    throw ArgumentError(fmt::format("{} arrays: a header of {} bytes, at most {} are allowed",
                                    arrays.size(), header.size(), kLongestHeader));
  }
  const std::uint64_t length = header.size();
  layout.start.append(reinterpret_cast<const char*>(&length), kLengthBytes);
  layout.start += header;
  for (std::uint64_t& offset : layout.offsets) offset += layout.start.size();
  layout.file_bytes = layout.start.size() + end;
  return layout;
}

}  // namespace enfilade::features::formats
