#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>

#include "enfilade/core/errors.h"
#include "enfilade/neural/encoder.h"
#include "enfilade/neural/encoders/encoder_input.h"

namespace enfilade::neural {

std::vector<std::string> encoder_names() {
  return {"resnet18",      "resnet50",      "resnet152", "vit-b-16",
          "clip-vit-b-16", "clip-vit-b-32", "home"};
}

std::unique_ptr<ImageEncoder> make_encoder(const EncoderConfig& config) {
  const std::vector<std::string> names = encoder_names();
  if (std::ranges::find(names, config.name) == names.end()) {
    throw LookupError(
        fmt::format("encoder {:?}: one of {} is expected", config.name, fmt::join(names, ", ")));
  }
  if (config.logits && config.name != "vit-b-16") {
    throw ArgumentError(fmt::format(
        "logits: encoder {:?} gives no class scores; vit-b-16 is expected", config.name));
  }
  if (config.name == "vit-b-16") return encoders::make_vit(config);
  if (config.name.starts_with("clip")) return encoders::make_clip(config);
  if (config.name == "home") return encoders::make_home_encoder(config);
  return encoders::make_resnet(config);
}

}  // namespace enfilade::neural

namespace enfilade::neural::encoders {
namespace {

void check_sizes(std::size_t numbers, std::size_t n, const Camera& camera, std::size_t dimensions,
                 std::size_t features) {
  constexpr std::uint32_t kLeast = 32;  // networks halve pictures five times
  if (camera.width < kLeast || camera.height < kLeast) {
    throw ArgumentError(fmt::format("camera: {} x {} pixels; at least {} x {} are needed",
                                    camera.width, camera.height, kLeast, kLeast));
  }
  if (numbers != n * 3 * camera.height * camera.width) {
    throw ArgumentError(fmt::format("pictures: {} numbers; {} pictures of 3 x {} x {} have {}",
                                    numbers, n, camera.height, camera.width,
                                    n * 3 * camera.height * camera.width));
  }
  if (features != n * dimensions) {
    throw ArgumentError(fmt::format("features: {} numbers; {} pictures have {} of {}", features, n,
                                    n * dimensions, dimensions));
  }
}

}  // namespace

std::span<float> CheckedEncoder::memory(std::size_t n, const Camera& camera) {
  memory_ = at::empty({static_cast<std::int64_t>(n), 3, camera.height, camera.width},
                      at::TensorOptions(at::kFloat).device(device_));
  return {memory_.data_ptr<float>(), static_cast<std::size_t>(memory_.numel())};
}

void CheckedEncoder::encode(std::span<const float> pictures, std::size_t n, const Camera& camera,
                            std::span<float> features) {
  check_sizes(pictures.size(), n, camera, dimensions(), features.size());
  if (n == 0) return;
  const c10::InferenceMode no_gradients;
  const at::Tensor output = run(pictures, n, camera).cpu().contiguous();
  std::ranges::copy_n(output.data_ptr<float>(), output.numel(), features.begin());
}

at::Tensor CheckedEncoder::tensor(std::span<const float> pictures, std::size_t n,
                                  const Camera& camera) const {
  const auto rows = static_cast<std::int64_t>(n);
  if (!memory_.defined() || pictures.data() != memory_.data_ptr<float>()) {
    // libtorch knows no tensors of constants; nothing writes to this one.
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
    return at::from_blob(const_cast<float*>(pictures.data()),
                         {rows, 3, camera.height, camera.width}, at::kFloat);
  }
  return memory_.view({-1})
      .narrow(0, 0, static_cast<std::int64_t>(pictures.size()))
      .view({rows, 3, camera.height, camera.width});
}

}  // namespace enfilade::neural::encoders
