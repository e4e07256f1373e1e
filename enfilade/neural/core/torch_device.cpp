#include "enfilade/neural/core/torch_device.h"

#include <ATen/ATen.h>
#include <ATen/Context.h>
#include <ATen/autocast_mode.h>
#include <fmt/format.h>
#include <torch/version.h>
#include <algorithm>
#include <string_view>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"

namespace enfilade::neural::core {
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

namespace {

void set_autocast(bool on) {
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 4)
  at::autocast::set_autocast_dtype(at::kCUDA, at::kBFloat16);
  at::autocast::set_autocast_enabled(at::kCUDA, on);
#else
  at::autocast::set_autocast_gpu_dtype(at::kBFloat16);
  at::autocast::set_enabled(on);
#endif
}

}  // namespace

c10::Device open_agents_device(const std::string& name) {
  const c10::Device device = open_device(name);
  if (device.is_cpu()) return device;
  at::globalContext().setAllowTF32CuDNN(false);
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 5)
  // cuDNN's attention is compiled anew for each shape, and ours differ at each step.
  at::globalContext().setSDPUseCuDNN(false);
#endif
  return device;
}

PrecisionGuard::PrecisionGuard(Precision precision)
    : precision_(precision),
      products_before_(at::globalContext().allowTF32CuBLAS()),
      lstms_before_(at::globalContext().allowTF32CuDNN()) {
  if (precision == Precision::kTf32) {
    at::globalContext().setAllowTF32CuBLAS(true);
    at::globalContext().setAllowTF32CuDNN(true);
  }
  if (precision == Precision::kBfloat16) set_autocast(true);
}

PrecisionGuard::~PrecisionGuard() {
  if (precision_ == Precision::kTf32) {
    at::globalContext().setAllowTF32CuBLAS(products_before_);
    at::globalContext().setAllowTF32CuDNN(lstms_before_);
  }
  if (precision_ != Precision::kBfloat16) return;
  set_autocast(false);
  at::autocast::clear_cache();  // of the weights' copies, which the next update makes stale
}

}  // namespace enfilade::neural::core
