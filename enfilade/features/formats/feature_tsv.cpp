#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <string_view>

#include "enfilade/core/base64.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/part_file.h"
#include "enfilade/core/threads.h"
#include "enfilade/features/formats/feature_rows.h"

namespace enfilade::features::formats {
namespace {

constexpr std::size_t kColumns = 6;    // scanId, viewpointId, image_w, image_h, vfov, features
constexpr std::size_t kTsvViews = 36;  // the format does not say how many

// Not std::views::split, which compares byte by byte: find() runs at memchr's speed, and these
// files have gigabytes. Python's csv module ends rows with "\r\n".
std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

/// A row of a file.
class Row {
 public:
  /// \param index from 0 \param file its name, for messages; must outlive *this
  Row(std::string_view line, std::size_t index, const std::string& file)
      : index_(index), file_(&file) {
    std::size_t found = 0;
    for (bool more = true; more; ++found) {
      const std::size_t end = line.find('\t');
      more = end != std::string_view::npos;
      if (found < kColumns) fields_[found] = line.substr(0, end);
      line.remove_prefix(more ? end + 1 : line.size());
    }
    if (found != kColumns) {
      refuse(file, fmt::format("row {}", index + 1), "bad-row",
             fmt::format("{} columns, not the {} scanId, viewpointId, image_w, image_h, vfov and "
                         "features",
                         found, kColumns));
    }
    check_key(key(), file, fmt::format("row {}", index + 1));
  }

  FeatureKey key() const { return {std::string(fields_[0]), std::string(fields_[1])}; }

  Camera camera() const {
    return make_camera(number(2, ", image_w"), number(3, ", image_h"), number(4, ", vfov"), *file_,
                       place());
  }

  std::size_t dimensions() const {
    const auto bytes = base64_bytes(fields_[5]);
    constexpr std::size_t kView = kTsvViews * sizeof(float);
    if (!bytes || *bytes == 0 || *bytes % kView != 0) {
      fail(", features", "bad-base64",
           fmt::format("{} characters, not those of {} views of 32 bit floats", fields_[5].size(),
                       kTsvViews));
    }
    return *bytes / kView;
  }

  void check_equal(const FeatureInfo& first) const {
    if (dimensions() != first.dimensions) {
      fail("", "differing-size",
           fmt::format("{} numbers a view, not {} as the first", dimensions(), first.dimensions));
    }
    if (camera() != first.camera) {
      fail("", "differing-camera",
           fmt::format("{} x {} pixels and {} degrees, not as the first", fields_[2], fields_[3],
                       fields_[4]));
    }
  }

  void decode(std::span<std::byte> out) const {
    const std::size_t fault = decode_base64(fields_[5], out);
    if (fault != std::string_view::npos) {
      fail(", features", "bad-base64",
           fmt::format("character {} is {}, which base64 does not have there", fault + 1,
                       quote(fields_[5].substr(fault, 1))));
    }
    std::array<float, 64> floats;
    for (std::size_t at = 0; at < out.size(); at += sizeof(floats)) {
      const std::size_t bytes = std::min(sizeof(floats), out.size() - at);
      if (!copy_floats(out.data() + at, std::span(floats).first(bytes / sizeof(float)))) {
        fail(", features", "not-finite", "a number that is infinite or NaN");
      }
    }
  }

 private:
  std::string place() const {
    return fmt::format("row {}, scan {}, viewpoint {}", index_ + 1, quote(fields_[0]),
                       quote(fields_[1]));
  }
  [[noreturn]] void fail(const char* field, const char* code, std::string message) const {
    refuse(*file_, place() + field, code, std::move(message));
  }
  double number(std::size_t column, const char* field) const {
    return parse_number(fields_[column], *file_, place() + field);
  }

  std::array<std::string_view, kColumns> fields_;
  std::size_t index_;
  const std::string* file_;
};

class TsvRows final : public RowWriter {
 public:
  TsvRows(const std::filesystem::path& file, const FeatureInfo& info,
          const std::vector<FeatureKey>& keys)
      : info_(info), keys_(keys), part_(file) {
    part_.resize(0);
  }

  void write(std::size_t row, std::span<const float> views) override {
    text_ = fmt::format("{}\t{}\t{}\t{}\t{}\t", keys_[row].scan, keys_[row].viewpoint,
                        info_.camera.width, info_.camera.height,
                        degrees_text(info_.camera.vertical_field_of_view));
    append_base64(std::as_bytes(views), text_);
    text_ += '\n';
    part_.write_at(end_, std::as_bytes(std::span(text_)));
    end_ += text_.size();
  }

  void finish() override { part_.finish(); }

 private:
  FeatureInfo info_;
  std::vector<FeatureKey> keys_;
  PartFile part_;
  std::uint64_t end_ = 0;
  std::string text_;
};

}  // namespace

FeatureRows read_feature_tsv(const std::filesystem::path& file) {
  const MappedFile map(file);
  const std::string name = file.string();
  const auto lines =
      lines_of({reinterpret_cast<const char*>(map.bytes().data()), map.bytes().size()});
  if (lines.empty()) refuse(name, "", "no-features", "holds no viewpoint's features");
  FeatureRows read;
  std::vector<Row> rows;
  for (const std::string_view line : lines) {
    const Row& row = rows.emplace_back(line, rows.size(), name);
    if (rows.size() == 1) {
      read.info.camera = row.camera();
      read.info.dimensions = row.dimensions();
    }
    row.check_equal(read.info);
    read.keys.push_back(row.key());
  }
  const std::size_t bytes = row_bytes(read.info);
  const std::shared_ptr<std::byte[]> memory(new std::byte[bytes * rows.size()]);
  parallel_for(rows.size(), 4, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      rows[i].decode({memory.get() + i * bytes, bytes});
    }
  });
  for (std::size_t i = 0; i < rows.size(); ++i) read.rows.push_back(memory.get() + i * bytes);
  read.memory.push_back(memory);
  return read;
}

std::unique_ptr<RowWriter> write_feature_tsv(const std::filesystem::path& file,
                                             const FeatureInfo& info,
                                             const std::vector<FeatureKey>& keys) {
  if (info.views != kTsvViews || info.type != DType::kFloat32) {
    throw ArgumentError(
        fmt::format("{}: {} views of type {}, but TSV holds {} of type F32; write safetensors or "
                    "HDF5",
                    file.string(), info.views, enum_name(info.type), kTsvViews));
  }
  return std::make_unique<TsvRows>(file, info, keys);
}

}  // namespace enfilade::features::formats
