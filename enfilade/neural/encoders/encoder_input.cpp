#include "enfilade/neural/encoders/encoder_input.h"

#include <ATen/ATen.h>
#include <fmt/format.h>

#include "enfilade/core/errors.h"

namespace enfilade::neural::encoders {

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

at::Tensor picture_tensor(std::span<const float> pictures, std::size_t n, const Camera& camera) {
  // libtorch knows no tensors of constants; nothing writes to this one.
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
  return at::from_blob(const_cast<float*>(pictures.data()),
                       {static_cast<std::int64_t>(n), 3, camera.height, camera.width}, at::kFloat);
}

std::span<float> PictureMemory::take(std::size_t n, const Camera& camera) {
  memory_ = at::empty({static_cast<std::int64_t>(n), 3, camera.height, camera.width},
                      at::TensorOptions(at::kFloat).device(device_));
  return {memory_.data_ptr<float>(), static_cast<std::size_t>(memory_.numel())};
}

at::Tensor PictureMemory::tensor(std::span<const float> pictures, std::size_t n,
                                 const Camera& camera) const {
  if (!memory_.defined() || pictures.data() != memory_.data_ptr<float>()) {
    return picture_tensor(pictures, n, camera);
  }
  return memory_.view({-1})
      .narrow(0, 0, static_cast<std::int64_t>(pictures.size()))
      .view({static_cast<std::int64_t>(n), 3, camera.height, camera.width});
}

}  // namespace enfilade::neural::encoders
