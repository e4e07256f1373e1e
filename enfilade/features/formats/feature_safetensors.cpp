#include <fmt/format.h>
#include <xxhash.h>
#include <algorithm>
#include <cstring>

#include "enfilade/core/errors.h"
#include "enfilade/core/part_file.h"
#include "enfilade/features/formats/feature_rows.h"
#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {
namespace {

// --- reading ---

void check_array(const NamedArray& array, const FeatureInfo& info, const std::string& file) {
  const std::string where = fmt::format("{:?}", array.name);
  if (array.shape.size() != 2 || array.shape[0] == 0 || array.shape[1] == 0) {
    refuse(file, where, "bad-shape", "not an array of shape (views, dimensions)");
  }
  if (array.type != DType::kFloat32 && array.type != DType::kFloat16) {
    refuse(file, where, "unsupported-type",
           fmt::format("numbers of type {}, not F32 or F16", to_string(array.type)));
  }
  check_same_size(static_cast<std::size_t>(array.shape[0]),
                  static_cast<std::size_t>(array.shape[1]), array.type, info, file, where);
}

// --- writing ---

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
