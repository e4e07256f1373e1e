#include "enfilade/neural/device.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <ATen/Version.h>
#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <torch/cuda.h>
#include <torch/version.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/ranks.h"

namespace enfilade::neural {
namespace {

std::atomic<int> chosen_threads = 0;

constexpr std::array<std::string_view, 3> kPrecisions{"float32", "tf32", "bfloat16"};

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

// The kind of processor that OpenBLAS takes this one for; empty: another BLAS.
std::string blas_kind() {
  void* const symbol = dlsym(RTLD_DEFAULT, "openblas_get_corename");
  if (symbol == nullptr) return {};
  char* (*name)() = nullptr;
  std::memcpy(&name, &symbol, sizeof name);
  return name();
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
  using SetThreads = void (*)(int);
  if (void* symbol = dlsym(RTLD_DEFAULT, "openblas_set_num_threads"); symbol != nullptr) {
    SetThreads set = nullptr;
    std::memcpy(&set, &symbol, sizeof set);
    set(wanted);
  }
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

std::string_view to_string(Precision value) noexcept {
  return kPrecisions[static_cast<std::size_t>(value)];
}

Precision parse_precision(std::string_view name) {
  const auto found = std::ranges::find(kPrecisions, name);
  if (found != kPrecisions.end()) return static_cast<Precision>(found - kPrecisions.begin());
  throw ArgumentError(
      fmt::format("precision {:?}: {} is allowed", name, fmt::join(kPrecisions, " or ")));
}

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
