#include "apps/enfilade/advice.h"

#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::apps {
namespace {

std::string mebibytes(std::uint64_t bytes) {
  constexpr double kMebi = 1 << 20, kGibi = 1 << 30;
  const auto size = static_cast<double>(bytes);
  return size < kGibi ? fmt::format("{:.0f} MiB", size / kMebi)
                      : fmt::format("{:.1f} GiB", size / kGibi);
}

}  // namespace

Judgement judge_simd(std::string_view target, bool has_avx2) {
  constexpr std::array<std::string_view, 4> kSlow{"SSE4", "SSSE3", "SSE2", "EMU128"};
  if (std::ranges::find(kSlow, target) == kSlow.end()) return {true, std::string(target), ""};
  if (has_avx2) {
    return {false, fmt::format("{}; the processor has AVX2, this build does not use it", target),
            "build again with g++ 12 or newer (or clang 16), without options that forbid AVX2"};
  }
  if (target == "EMU128") {
    return {false, "EMU128: none, plain C++",
            "pictures take many times as long as with AVX2 or NEON: build for this processor with "
            "g++ 12 or newer, or use another machine"};
  }
  return {
      false, fmt::format("{}; no AVX2", target),
      "pictures and networks take several times as long as with AVX2, which processors have "
      "since Intel's Haswell (2013) and AMD's Zen (2017): use such a one; in a virtual machine, "
      "show it the processor of its host (QEMU: -cpu host)"};
}

// Not from /proc/cpuinfo, which in an emulator is that of another processor.
bool processor_has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") &&
         __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

Judgement judge_blas(const neural::TorchReport& report) {
  std::string text = fmt::format("{:.0f} GFLOP/s on {} threads, (100, 2592) x (2592, 2048)",
                                 report.product_speed, report.threads);
  if (report.product_speed >= neural::kSlowBlas) return {true, std::move(text), ""};
  // Where Debian and Ubuntu keep the reference BLAS: .../blas/libblas.so.3.12.1
  const std::filesystem::path file(report.blas);
  const bool reference =
      file.filename().string().starts_with("libblas.so") && file.parent_path().filename() == "blas";
  if (reference) {
    return {false, std::move(text),
            "training crawls on the reference BLAS: apt-get install libopenblas0-pthread; "
            "`update-alternatives --display libblas.so.3-$(uname -m)-linux-gnu` then tells which "
            "BLAS is used"};
  }
  return {false, std::move(text),
          fmt::format("training crawls. Is the machine busy, or are its threads limited "
                      "(OMP_NUM_THREADS, OPENBLAS_NUM_THREADS)? Else another BLAS helps, such as: "
                      "apt-get install libopenblas0-pthread{}",
                      report.blas.empty() ? "" : "; in use now: " + report.blas)};
}

Judgement judge_space(const Space& space, std::uint64_t needed, std::string_view for_what,
                      std::string_view change) {
  std::string text = fmt::format("{}: {} free of {}", space.folder.string(), mebibytes(space.free),
                                 mebibytes(space.total));
  if (!space.writable) {
    return {false, text + ", not writable for this user",
            fmt::format("{} cannot be written there: {}", for_what, change)};
  }
  if (!space.has_entries) {
    return {false, text + ", but no new file can be made (no inodes left)",
            fmt::format("remove files from its disk, or {}", change)};
  }
  if (space.free >= needed) return {true, std::move(text), ""};
  return {false, std::move(text),
          fmt::format("{} take up to {}: make room on that disk, or {}", for_what,
                      mebibytes(needed), change)};
}

Space space_of(const std::filesystem::path& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0) {
    throw FileError(fmt::format("{}: {}", folder.string(), std::generic_category().message(errno)));
  }
  const std::uint64_t unit = disk.f_frsize;
  // File systems without a fixed number of files say 0 of 0.
  const bool has_entries = disk.f_files == 0 || disk.f_favail > 0;
  return {folder, unit * disk.f_bavail, unit * disk.f_blocks, has_entries,
          ::access(folder.c_str(), W_OK) == 0};
}

}  // namespace enfilade::apps
