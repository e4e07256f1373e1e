#include "enfilade/features/formats/feature_rows.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"
#include "enfilade/core/numbers.h"

namespace enfilade::features::formats {

std::size_t row_elements(const FeatureInfo& info) noexcept { return info.views * info.dimensions; }

std::size_t row_bytes(const FeatureInfo& info) noexcept {
  return row_elements(info) * size_of(info.type);
}

std::string name_of(const FeatureKey& key) { return key.scan + '_' + key.viewpoint; }

std::string in_quotes(std::string_view name) { return fmt::format("{:?}", name.substr(0, 100)); }

FeatureKey key_of(std::string_view name, const std::string& file) {
  const std::size_t at = name.rfind('_');
  if (at == std::string_view::npos || at == 0 || at + 1 == name.size()) {
    refuse(file, in_quotes(name), "bad-name", "not <scan>_<viewpoint>: no file of features");
  }
  return {std::string(name.substr(0, at)), std::string(name.substr(at + 1))};
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
    refuse(file, where, "bad-number", fmt::format("{:?}, not a number", text.substr(0, 40)));
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
                     to_string(type), info.views, info.dimensions, to_string(info.type)));
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

}  // namespace enfilade::features::formats
