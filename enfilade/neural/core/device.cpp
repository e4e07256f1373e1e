#include <ATen/ATen.h>
#include <ATen/Context.h>
#include <ATen/Parallel.h>
#include <ATen/Version.h>
#include <ATen/autocast_mode.h>
#include <dlfcn.h>
#include <fmt/format.h>
#include <torch/cuda.h>
#include <torch/version.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/threads.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/ranks.h"

namespace enfilade::neural {
namespace {

std::atomic<int> chosen_threads = 0;

// The dynamic linker binds libtorch to whatever library defines sgemm_ first.
std::string blas_library() {
  void* const product = dlsym(RTLD_DEFAULT, "sgemm_");
  Dl_info info{};
  if (product == nullptr || dladdr(product, &info) == 0 || info.dli_fname == nullptr) return {};
  std::error_code code;
  const std::filesystem::path file = std::filesystem::canonical(info.dli_fname, code);
  return code ? info.dli_fname : file.string();
}

double product_speed() {
  constexpr std::int64_t kRows = 100, kInner = 2592, kColumns = 2048;
  constexpr int kRepetitions = 8;  // the first ones wake threads and fill caches
  const at::Tensor a = at::ones({kRows, kInner}), b = at::ones({kInner, kColumns});
  double best = 0;
  for (int i = 0; i < kRepetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const at::Tensor product = at::mm(a, b);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    best = std::max(best, 2e-9 * kRows * kInner * kColumns / took.count());
  }
  return best;
}

// A function of a library that is loaded; null: there is none.
template <class Function>
Function loaded(const char* name) {
  void* const symbol = dlsym(RTLD_DEFAULT, name);
  Function function = nullptr;
  std::memcpy(&function, &symbol, sizeof function);
  return function;
}

// The kind of processor that OpenBLAS takes this one for; empty: another BLAS.
std::string blas_kind() {
  const auto name = loaded<char* (*)()>("openblas_get_corename");
  return name != nullptr ? name() : std::string();
}

std::string cuda_state() {
  try {
    core::open_device("cuda");
    return "works";
  } catch (const Error& error) {
    return error.what();
  }
}

}  // namespace

int core::kernel_threads() noexcept { return chosen_threads; }

void set_threads(int threads) {
  const int wanted = threads_or_all(threads);
  chosen_threads = wanted;
  at::set_num_threads(wanted);
  // libtorch tells only the BLAS it was built with; OpenBLAS has threads of its own.
  if (const auto set = loaded<void (*)(int)>("openblas_set_num_threads")) set(wanted);
}

TorchKind torch_kind() {
  constexpr std::string_view kName = "CPU capability usage: ";
  const std::string build = at::show_config();
  std::string instructions = "unknown";
  if (const std::size_t at = build.find(kName); at != std::string::npos) {
    instructions = build.substr(at + kName.size());
    instructions = instructions.substr(0, instructions.find_first_of(" \n"));
  }
  if (const std::string blas = blas_kind(); !blas.empty()) instructions += ", OpenBLAS " + blas;
  return {TORCH_VERSION, instructions};
}

int card_count() { return static_cast<int>(torch::cuda::device_count()); }

TorchReport examine_torch() {
  set_threads(0);  // libtorch's own choice may be half of the cores
  TorchReport report;
  report.version = TORCH_VERSION;
  report.threads = at::get_num_threads();
  report.blas = blas_library();
  report.product_speed = product_speed();
  report.cuda = cuda_state();
  const RanksReport ranks = examine_ranks();
  report.connects = ranks.works;
  report.processes = ranks.text;
  return report;
}

}  // namespace enfilade::neural

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
