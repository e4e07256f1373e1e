#include <fmt/format.h>
#include <hdf5.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/names.h"
#include "enfilade/features/formats/feature_rows.h"
#include "enfilade/features/formats/hdf5_datasets.h"
#include "enfilade/features/hdf5_writer.h"

namespace enfilade::features::formats {
namespace {

using Handle = Hdf5Handle;

// In files and in memory, as this machine is little-endian, too (safetensors.cpp).
Handle type_of(DType type) {
  return type == DType::kFloat16 ? half_type() : Handle(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
}

// --- reading ---

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : name_(path.string()), file_(path, name_) {}

  /// As safetensors.
  void copy_to(SharedMemory& memory) {
    const std::vector<std::string> names = file_.datasets();
    if (names.empty()) refuse(name_, "", "no-features", "holds no viewpoint's features");
    std::vector<FeatureKey> keys;
    for (const std::string& name : names) keys.push_back(key_of(name, name_));
    info_.encoder = text("encoder");
    info_.preprocessing = text("preprocessing");
    info_.weights = text("weights");
    info_ = info_of(names[0], file_.open_dataset(names[0]));
    const SafetensorsLayout layout = lay_out_features(info_, keys);
    memory.write_at(0, std::as_bytes(std::span(layout.start)));
    std::vector<std::byte> row(row_bytes(info_));
    for (std::size_t i = 0; i < names.size(); ++i) {
      read_dataset(names[i], row);
      memory.write_at(layout.offsets[i], row);
    }
  }

 private:
  [[noreturn]] void fail(const std::string& dataset, const char* code, std::string message) const {
    file_.fail(dataset, code, std::move(message));
  }

  // An attribute of the file, if it is a text of fixed length, as ours are.
  std::string text(const char* name) const {
    constexpr std::size_t kLongest = 4096;
    if (H5Aexists(file_.id(), name) <= 0) return {};
    const Handle attribute(H5Aopen(file_.id(), name, H5P_DEFAULT), H5Aclose);
    const Handle type(H5Aget_type(attribute.id()), H5Tclose);
    const Handle space(H5Aget_space(attribute.id()), H5Sclose);
    const std::size_t size = H5Tget_size(type.id());
    if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) != 0 ||
        H5Sget_simple_extent_npoints(space.id()) != 1 || size == 0 || size > kLongest) {
      return {};
    }
    std::string value(size, '\0');
    if (H5Aread(attribute.id(), type.id(), value.data()) < 0) {
      refuse(name_, name, "bad-hdf5", "cannot be read: " + Hdf5Library::reason());
    }
    value.resize(std::min(value.find('\0'), value.size()));
    return value;
  }

  void read_dataset(const std::string& name, std::span<std::byte> row) const {
    const Handle dataset = file_.open_dataset(name);
    file_.check_layout(name, dataset);
    check_equal(name, info_of(name, dataset));
    if (H5Dread(dataset.id(), type_of(info_.type).id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, row.data()) <
        0) {
      file_.fail_unread(name, dataset);
    }
    std::vector<float> floats(row_elements(info_));
    if (!copy_numbers(row.data(), info_.type, floats)) {
      fail(name, "not-finite", "a number that is infinite or NaN");
    }
  }

  FeatureInfo info_of(const std::string& name, const Handle& dataset) const {
    const Handle type(H5Dget_type(dataset.id()), H5Tclose);
    if (!type.good()) file_.fail_damaged(name);
    const std::array<hsize_t, 2> size = file_.size_of(name, dataset);
    if (!is_plain_float(type.id())) {
      fail(name, "unsupported-type", "not floating-point numbers of 16, 32 or 64 bits");
    }
    FeatureInfo info = info_;
    info.views = size[0];
    info.dimensions = size[1];
    info.type = H5Tget_size(type.id()) == 2 ? DType::kFloat16 : DType::kFloat32;
    info.camera = make_camera(
        number(name, dataset, "image_w").value_or(info_.camera.width),
        number(name, dataset, "image_h").value_or(info_.camera.height),
        number(name, dataset, "vfov").value_or(to_degrees(info_.camera.vertical_field_of_view)),
        name_, in_quotes(name));
    return info;
  }

  std::optional<double> number(const std::string& dataset_name, const Handle& dataset,
                               const char* name) const {
    if (H5Aexists(dataset.id(), name) <= 0) return std::nullopt;
    const Handle attribute(H5Aopen(dataset.id(), name, H5P_DEFAULT), H5Aclose);
    const Handle type(H5Aget_type(attribute.id()), H5Tclose);
    const Handle space(H5Aget_space(attribute.id()), H5Sclose);
    double value = 0;
    if (!is_plain_number(type.id()) || H5Sget_simple_extent_npoints(space.id()) != 1 ||
        H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, &value) < 0) {
      fail(dataset_name, "bad-number", fmt::format("attribute {}: not a number", name));
    }
    return value;
  }

  void check_equal(const std::string& name, const FeatureInfo& found) const {
    check_same_size(found.views, found.dimensions, found.type, info_, name_, in_quotes(name));
    if (metadata_of(found) != metadata_of(info_)) {
      fail(name, "differing-camera",
           "image_w, image_h or vfov differ from those of the first dataset");
    }
  }

  std::string name_;
  Hdf5Source file_;
  FeatureInfo info_;
};

// --- writing ---

class Hdf5Rows final : public RowWriter {
 public:
  Hdf5Rows(const std::filesystem::path& file, const FeatureInfo& info,
           const std::vector<FeatureKey>& keys)
      : info_(info),
        keys_(keys),
        writer_(file, {.gzip = 0,
                       .replaces = true,
                       .texts = {{"encoder", info.encoder},
                                 {"preprocessing", info.preprocessing},
                                 {"weights", info.weights}}}) {}

  void write(std::size_t row, std::span<const float> views) override {
    const FeatureKey& key = keys_[row];
    const double vfov = std::stod(degrees_text(info_.camera.vertical_field_of_view));
    Hdf5Value field = vfov;  // whole numbers as integers, as h5py would
    if (vfov == std::floor(vfov)) field = static_cast<std::int64_t>(vfov);
    writer_.write({name_of(key),
                   {info_.type == DType::kFloat16 ? Hdf5Type::kFloat16 : Hdf5Type::kFloat32,
                    {info_.views, info_.dimensions},
                    stored_bytes(views, info_.type, halves_)},
                   {{"scanId", key.scan},
                    {"viewpointId", key.viewpoint},
                    {"image_w", std::int64_t{info_.camera.width}},
                    {"image_h", std::int64_t{info_.camera.height}},
                    {"vfov", std::move(field)}}});
  }

  void finish() override { writer_.finish(); }

 private:
  FeatureInfo info_;
  std::vector<FeatureKey> keys_;
  Hdf5Writer writer_;
  std::vector<std::uint16_t> halves_;
};

}  // namespace

FeatureRows read_feature_hdf5(const std::filesystem::path& file) {
  return feature_rows_of(
      read_isolated(file, [&](SharedMemory& memory) { Reader(file).copy_to(memory); }),
      file.string());
}

std::unique_ptr<RowWriter> write_feature_hdf5(const std::filesystem::path& file,
                                              const FeatureInfo& info,
                                              const std::vector<FeatureKey>& keys) {
  return std::make_unique<Hdf5Rows>(file, info, keys);
}

}  // namespace enfilade::features::formats
