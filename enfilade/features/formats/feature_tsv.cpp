#include "enfilade/features/formats/feature_tsv.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <string_view>

#include "enfilade/core/base64.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/part_file.h"
#include "enfilade/core/threads.h"
#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {
namespace {

constexpr std::size_t kColumns = 6;  // scanId, viewpointId, image_w, image_h, vfov, features
using Fields = std::array<std::string_view, kColumns>;

// Python's csv module ends rows with "\r\n".
std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty()) lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// The rows of a file of this name, for messages.
class RowReader {
 public:
  explicit RowReader(const std::string& file) : file_(file) {}

  Fields fields_of(std::string_view line, std::size_t row) const {
    Fields fields;
    std::size_t found = 0;
    for (bool more = true; more; ++found) {
      const std::size_t end = line.find('\t');
      more = end != std::string_view::npos;
      if (found < kColumns) fields[found] = line.substr(0, end);
      line.remove_prefix(more ? end + 1 : line.size());
    }
    if (found != kColumns) {
      refuse(file_, fmt::format("row {}", row + 1), "bad-row",
             fmt::format("{} columns, not the {} scanId, viewpointId, image_w, image_h, vfov and "
                         "features",
                         found, kColumns));
    }
    if (fields[0].empty() || fields[1].empty()) {
      refuse(file_, fmt::format("row {}", row + 1), "bad-row", "no scan or no viewpoint");
    }
    return fields;
  }

  std::string place(const Fields& fields, std::size_t row) const {
    return fmt::format("row {}, scan {:?}, viewpoint {:?}", row + 1, fields[0].substr(0, 64),
                       fields[1].substr(0, 64));
  }

  Camera camera_of(const Fields& fields, std::size_t row) const {
    const std::string where = place(fields, row);
    return make_camera(parse_number(fields[2], file_, where + ", image_w"),
                       parse_number(fields[3], file_, where + ", image_h"),
                       parse_number(fields[4], file_, where + ", vfov"), file_, where);
  }

  std::size_t dimensions_of(const Fields& fields, std::size_t row) const {
    const auto bytes = base64_bytes(fields[5]);
    constexpr std::size_t kView = kTsvViews * sizeof(float);
    if (!bytes || *bytes == 0 || *bytes % kView != 0) {
      refuse(file_, place(fields, row) + ", features", "bad-base64",
             fmt::format("{} characters, not those of {} views of 32 bit floats", fields[5].size(),
                         kTsvViews));
    }
    return *bytes / kView;
  }

  void decode(const Fields& fields, std::size_t row, std::span<std::byte> out) const {
    const std::size_t fault = decode_base64(fields[5], out);
    if (fault != std::string_view::npos) {
      refuse(file_, place(fields, row) + ", features", "bad-base64",
             fmt::format("character {} is {:?}, which base64 does not have there", fault + 1,
                         fields[5].substr(fault, 1)));
    }
    std::array<float, 64> floats;
    for (std::size_t at = 0; at < out.size(); at += sizeof(floats)) {
      const std::size_t bytes = std::min(sizeof(floats), out.size() - at);
      if (!copy_floats(out.data() + at, std::span(floats).first(bytes / sizeof(float)))) {
        refuse(file_, place(fields, row) + ", features", "not-finite",
               "a number that is infinite or none");
      }
    }
  }

 private:
  const std::string& file_;
};

void check_equal(const RowReader& reader, const std::string& file, const Fields& fields,
                 std::size_t row, const FeatureInfo& info) {
  const std::size_t dimensions = reader.dimensions_of(fields, row);
  if (dimensions != info.dimensions) {
    refuse(file, reader.place(fields, row), "differing-size",
           fmt::format("{} numbers a view, not {} as the first", dimensions, info.dimensions));
  }
  if (reader.camera_of(fields, row) != info.camera) {
    refuse(file, reader.place(fields, row), "differing-camera",
           fmt::format("{} x {} pixels and {} degrees, not as the first", fields[2], fields[3],
                       fields[4]));
  }
}

class TsvRows final : public RowWriter {
 public:
  TsvRows(const std::filesystem::path& file, const FeatureInfo& info,
          const std::vector<FeatureKey>& keys)
      : info_(info), keys_(keys), part_(file) {
    part_.resize(0);
  }

  bool written(std::size_t) const override { return false; }

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
  const RowReader reader(name);
  FeatureRows read;
  std::vector<Fields> rows;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    rows.push_back(reader.fields_of(lines[i], i));
    if (i == 0) {
      read.info.camera = reader.camera_of(rows[0], 0);
      read.info.dimensions = reader.dimensions_of(rows[0], 0);
    }
    check_equal(reader, name, rows[i], i, read.info);
    read.keys.push_back({std::string(rows[i][0]), std::string(rows[i][1])});
  }
  const std::size_t bytes = row_bytes(read.info);
  const std::shared_ptr<std::byte[]> memory(new std::byte[bytes * rows.size()]);
  parallel_for(rows.size(), 4, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      reader.decode(rows[i], i, {memory.get() + i * bytes, bytes});
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
                    file.string(), info.views, to_string(info.type), kTsvViews));
  }
  return std::make_unique<TsvRows>(file, info, keys);
}

}  // namespace enfilade::features::formats
