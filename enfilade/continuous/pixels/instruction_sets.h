/// \file  The versions of a function that Highway compiled for instruction sets.
#pragma once
#include <hwy/highway.h>

#include <cstdint>
#include <vector>

namespace enfilade::continuous::pixels {

/// Results of find(name of the set), called for each instruction set that the processor supports,
/// the best first. HWY_DYNAMIC_DISPATCH in it gives that set's function. Better targets have lower
/// bits; see enfilade/render/cpu/simd_kernels.cpp.
template <class Version, class Find>
std::vector<Version> find_versions(const Find& find) {
  std::vector<Version> found;
  std::int64_t supported = (hwy::SupportedTargets() | HWY_STATIC_TARGET) & HWY_TARGETS;
  for (; supported != 0; supported &= supported - 1) {
    const std::int64_t target = supported & -supported;
    hwy::GetChosenTarget().Update(target);
    found.push_back(find(hwy::TargetName(target)));
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return found;
}

}  // namespace enfilade::continuous::pixels
