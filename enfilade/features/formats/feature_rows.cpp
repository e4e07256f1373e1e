#include "enfilade/features/formats/feature_rows.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/part_file.h"

namespace enfilade::features::formats {

std::size_t row_elements(const FeatureInfo& info) noexcept { return info.views * info.dimensions; }

std::size_t row_bytes(const FeatureInfo& info) noexcept {
  return row_elements(info) * size_of(info.type);
}

std::string name_of(const FeatureKey& key) { return key.scan + '_' + key.viewpoint; }

std::string in_quotes(std::string_view name) { return quote(name, 100); }

FeatureKey key_of(std::string_view name, const std::string& file) {
  const std::size_t at = underscore_between_ids(name);
  if (at == std::string_view::npos) {
    refuse(file, in_quotes(name), "bad-name", "not <scan>_<viewpoint>: no file of features");
  }
  FeatureKey key{std::string(name.substr(0, at)), std::string(name.substr(at + 1))};
  check_key(key, file, in_quotes(name));
  return key;
}

void check_key(const FeatureKey& key, const std::string& file, const std::string& where) {
  for (const std::string& id : {key.scan, key.viewpoint}) {
    if (std::string fault = fault_of_id(id); !fault.empty()) {
      refuse(file, where, "bad-id", std::move(fault));
    }
  }
}

std::string degrees_text(Radians angle) { return fmt::format("{:.14g}", to_degrees(angle)); }

std::map<std::string, std::string> metadata_of(const FeatureInfo& info) {
  return {{"encoder", info.encoder},
          {"preprocessing", info.preprocessing},
          {"weights", info.weights},
          {"image_w", fmt::to_string(info.camera.width)},
          {"image_h", fmt::to_string(info.camera.height)},
          {"vfov", degrees_text(info.camera.vertical_field_of_view)}};
}

SafetensorsLayout lay_out_features(const FeatureInfo& info, const std::vector<FeatureKey>& keys) {
  const std::vector<std::int64_t> shape{static_cast<std::int64_t>(info.views),
                                        static_cast<std::int64_t>(info.dimensions)};
  std::vector<NamedArray> arrays;
  arrays.reserve(keys.size());
  for (const FeatureKey& key : keys) arrays.push_back({name_of(key), info.type, shape, {}});
  return lay_out_safetensors(arrays, metadata_of(info));
}

void read_metadata(const std::map<std::string, std::string>& metadata, const std::string& file,
                   FeatureInfo& info) {
  const auto text = [&](const char* key, const std::string& otherwise) {
    const auto found = metadata.find(key);
    return found == metadata.end() ? otherwise : found->second;
  };
  info.encoder = text("encoder", info.encoder);
  info.preprocessing = text("preprocessing", info.preprocessing);
  info.weights = text("weights", info.weights);
  std::map<std::string, std::string> camera = metadata_of(info);
  const auto number = [&](const char* key) {
    return parse_number(text(key, camera[key]), file, key);
  };
  info.camera = make_camera(number("image_w"), number("image_h"), number("vfov"), file, "camera");
}

double parse_number(std::string_view text, const std::string& file, const std::string& where) {
  const auto value = enfilade::parse_number<double>(text);
  if (!value) {
    refuse(file, where, "bad-number", fmt::format("{}, not a number", quote(text)));
  }
  return *value;
}

Camera make_camera(double width, double height, double degrees_high, const std::string& file,
                   const std::string& where) {
  constexpr double kLargest = 65536;
  const auto is_size = [](double pixels) {
    return pixels >= 1 && pixels <= kLargest && pixels == std::floor(pixels);
  };
  if (!is_size(width) || !is_size(height)) {
    refuse(file, where, "bad-camera",
           fmt::format("pictures of {} x {} pixels, not of 1 to {} each way", width, height,
                       kLargest));
  }
  const Camera camera{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
                      degrees(degrees_high)};
  try {
    validate(camera);
  } catch (const ArgumentError& error) {
    refuse(file, where, "bad-camera", error.what());
  }
  return camera;
}

void check_same_size(std::size_t views, std::size_t dimensions, DType type, const FeatureInfo& info,
                     const std::string& file, const std::string& where) {
  if (views == info.views && dimensions == info.dimensions && type == info.type) return;
  refuse(file, where, "differing-size",
         fmt::format("{} x {} of {}, not {} x {} of {} as the first", views, dimensions,
                     enum_name(type), info.views, info.dimensions, enum_name(info.type)));
}

bool copy_numbers(const std::byte* from, DType type, std::span<float> out) noexcept {
  return type == DType::kFloat16 ? copy_halves(from, out) : copy_floats(from, out);
}

std::span<const std::byte> stored_bytes(std::span<const float> numbers, DType type,
                                        std::vector<std::uint16_t>& halves) {
  if (type != DType::kFloat16) return std::as_bytes(numbers);
  halves.resize(numbers.size());
  std::ranges::transform(numbers, halves.begin(), to_half);
  return std::as_bytes(std::span(halves));
}

// --- safetensors ------------------------------------------------------------------------------

namespace {

void check_array(const NamedArray& array, const FeatureInfo& info, const std::string& file) {
  const std::string where = in_quotes(array.name);
  if (array.shape.size() != 2 || array.shape[0] == 0 || array.shape[1] == 0) {
    refuse(file, where, "bad-shape", "not an array of shape (views, dimensions)");
  }
  if (array.type != DType::kFloat32 && array.type != DType::kFloat16) {
    refuse(file, where, "unsupported-type",
           fmt::format("numbers of type {}, not F32 or F16", enum_name(array.type)));
  }
  check_same_size(static_cast<std::size_t>(array.shape[0]),
                  static_cast<std::size_t>(array.shape[1]), array.type, info, file, where);
}

/// The .part file is the finished file followed by a journal of 8 bytes for each row: the row's
/// checksum once it is written, before that 0. If a row was written only in part, or lost in a
/// power failure, its checksum does not match.
class SafetensorsRows final : public RowWriter {
 public:
  SafetensorsRows(const std::filesystem::path& file, const FeatureInfo& info,
                  const std::vector<FeatureKey>& keys)
      : layout_(lay_out_features(info, keys)),
        type_(info.type),
        row_(row_bytes(info)),
        written_(keys.size()),
        part_(file) {
    if (resume()) return;
    part_.resize(0);
    part_.resize(part_bytes());
    part_.write_at(0, std::as_bytes(std::span(layout_.start)));
  }

  bool written(std::size_t row) const override { return written_[row]; }

  void write(std::size_t row, std::span<const float> views) override {
    const auto bytes = stored_bytes(views, type_, halves_);
    part_.write_at(layout_.offsets[row], bytes);
    mark(row, checksum(row, bytes));
  }

  void finish() override {
    part_.synchronise();
    // resume() treats a part without the journal as complete, so the rows have to be on the disk
    // before it is cut off.
    part_.resize(layout_.file_bytes);
    part_.finish();
  }

 private:
  std::uint64_t part_bytes() const {
    return layout_.file_bytes + sizeof(std::uint64_t) * written_.size();
  }

  std::uint64_t checksum(std::size_t row, std::span<const std::byte> bytes) const {
    return std::max<std::uint64_t>(XXH3_64bits_withSeed(bytes.data(), bytes.size(), row + 1), 1);
  }

  void mark(std::size_t row, std::uint64_t checksum) {
    part_.write_at(layout_.file_bytes + sizeof(checksum) * row,
                   std::as_bytes(std::span(&checksum, 1)));
    written_[row] = true;
  }

  bool resume() {
    const MappedFile map(part_.path());
    const auto bytes = std::as_bytes(map.bytes());
    const auto start = std::as_bytes(std::span(layout_.start));
    // An earlier run was killed between finish()'s cutting the journal off and renaming the file.
    const bool whole = bytes.size() == layout_.file_bytes;
    if ((!whole && bytes.size() != part_bytes()) ||
        !std::ranges::equal(bytes.first(start.size()), start)) {
      return false;
    }
    for (std::size_t row = 0; row < written_.size(); ++row) {
      const std::uint64_t found = checksum(row, bytes.subspan(layout_.offsets[row], row_));
      if (whole) {
        mark(row, found);
        continue;
      }
      std::uint64_t kept = 0;
      std::memcpy(&kept, bytes.data() + layout_.file_bytes + sizeof(kept) * row, sizeof(kept));
      written_[row] = kept == found;
    }
    return true;
  }

  SafetensorsLayout layout_;
  DType type_;
  std::size_t row_;  ///< bytes
  std::vector<bool> written_;
  PartFile part_;
  std::vector<std::uint16_t> halves_;
};

}  // namespace

FeatureRows read_feature_safetensors(const std::filesystem::path& file) {
  return feature_rows_of(std::make_shared<const MappedFile>(file), file.string());
}

FeatureRows feature_rows_of(const std::shared_ptr<const MappedFile>& map, const std::string& name) {
  StoredArrays stored = read_safetensors(std::as_bytes(map->bytes()), name);
  if (stored.arrays.empty()) refuse(name, "", "no-features", "holds no viewpoint's features");
  for (const auto& [array, reason] : stored.left_out) {
    refuse(name, in_quotes(array), "unsupported-type", reason);
  }
  std::ranges::sort(stored.arrays, {}, &NamedArray::name);
  FeatureRows read;
  const NamedArray& first = stored.arrays[0];
  if (first.shape.size() == 2) {
    read.info.views = static_cast<std::size_t>(first.shape[0]);
    read.info.dimensions = static_cast<std::size_t>(first.shape[1]);
  }
  read.info.type = first.type;
  read_metadata(stored.metadata, name, read.info);
  for (const NamedArray& array : stored.arrays) {
    read.keys.push_back(key_of(array.name, name));
    check_array(array, read.info, name);
    read.rows.push_back(array.bytes.data());
  }
  read.memory = std::move(stored.memory);
  read.memory.push_back(map);
  return read;
}

std::unique_ptr<RowWriter> write_feature_safetensors(const std::filesystem::path& file,
                                                     const FeatureInfo& info,
                                                     const std::vector<FeatureKey>& keys) {
  return std::make_unique<SafetensorsRows>(file, info, keys);
}

}  // namespace enfilade::features::formats
