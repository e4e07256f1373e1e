/// \file  Advice of `enfilade doctor` on its measurements: whether they are good enough, and the
/// remedy.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "enfilade/neural/device.h"

namespace enfilade::apps {

/// Is it good enough?
struct Judgement {
  bool good = true;
  std::string text;    ///< the finding
  std::string advice;  ///< what to do; empty if it is good
};

/// \param target the instruction set in use, as render::cpu_target() \param has_avx2 as
/// processor_has_avx2()
Judgement judge_simd(std::string_view target, bool has_avx2);

/// Whether this processor has AVX2 and what compilers expect with it. False for other makes than
/// x86.
bool processor_has_avx2();

/// Judges the speed of matrix products.
Judgement judge_blas(const neural::TorchReport& report);

/// A folder that something is written to.
struct Space {
  std::filesystem::path folder;
  std::uint64_t free = 0, total = 0;  ///< bytes, for this user
  bool has_entries = true;            ///< new files can still be named (inodes)
  bool writable = true;
};
/// \param needed bytes \param for_what what takes them \param change how to take another folder
Judgement judge_space(const Space& space, std::uint64_t needed, std::string_view for_what,
                      std::string_view change);
/// Space of a local folder. \throws FileError if it cannot be examined
Space space_of(const std::filesystem::path& folder);
}  // namespace enfilade::apps
