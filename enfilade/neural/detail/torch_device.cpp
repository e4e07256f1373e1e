#include "enfilade/neural/detail/torch_device.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <string_view>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"

namespace enfilade::neural::detail {
namespace {

constexpr std::string_view kCuda = "cuda";

c10::Device parse_device(const std::string& name) {
  if (name == "cpu") return c10::kCPU;
  if (name == kCuda) return {c10::kCUDA, 0};
  if (name.starts_with("cuda:")) {
    const auto card = parse_number<c10::DeviceIndex>(name.substr(kCuda.size() + 1));
    if (card && *card >= 0) return {c10::kCUDA, *card};
  }
  throw ArgumentError(
      fmt::format("device {:?}: \"cpu\", \"cuda\", or \"cuda:N\" for card N is allowed", name));
}

}  // namespace

c10::Device open_device(const std::string& name) {
  const c10::Device device = parse_device(name);
  if (device.is_cpu()) return device;
  try {
    // Other checks differ between versions of libtorch, with and without CUDA.
    (void)at::zeros({1}, at::TensorOptions(device)).cpu();
  } catch (const std::exception& error) {
    const std::string_view reason = error.what();
    // The rest of the message is a stack trace or names places in libtorch's source.
    throw Error(fmt::format("device {}: libtorch cannot use it: {}", name,
                            reason.substr(0, std::min(reason.find('\n'), reason.find(". ")))));
  }
  return device;
}

}  // namespace enfilade::neural::detail
