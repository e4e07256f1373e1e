#include "enfilade/features/formats/feature_rows.h"

#include <fmt/format.h>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {

std::size_t row_elements(const FeatureInfo& info) noexcept { return info.views * info.dimensions; }

std::size_t row_bytes(const FeatureInfo& info) noexcept {
  return row_elements(info) * size_of(info.type);
}

std::string name_of(const FeatureKey& key) { return key.scan + '_' + key.viewpoint; }

FeatureKey key_of(std::string_view name, const std::string& file) {
  const std::size_t at = name.rfind('_');
  if (at == std::string_view::npos || at == 0 || at + 1 == name.size()) {
    refuse(file, fmt::format("{:?}", name.substr(0, 100)), "bad-name",
           "not <scan>_<viewpoint>: no file of features");
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
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    refuse(file, where, "bad-number", fmt::format("{:?}, not a number", text.substr(0, 40)));
  }
  return value;
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

}  // namespace enfilade::features::formats
