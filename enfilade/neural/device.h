/// \file  What libtorch runs on here, for `enfilade doctor`.
#pragma once
#include <string>

namespace enfilade::neural {

/// Below this, networks crawl: an optimised BLAS gives ten times as much on any machine of today,
/// the reference one less on all.
inline constexpr double kSlowBlas = 30;  ///< GFLOP/s

/// Which libtorch this is, and how fast its matrix products are here.
struct TorchReport {
  std::string version;  ///< of libtorch, "1.13.1"
  int threads = 0;      ///< that a product runs on
  std::string blas;     ///< the file that sgemm_ is in, links followed; empty if it is hidden
  /// Of a product of the sequence-to-sequence agent's size, (100, 2592) x (2592, 2048), GFLOP/s:
  /// the best of a few.
  double product_speed = 0;
  std::string cuda;  ///< "works", or why it does not, in libtorch's words
};
/// Takes a few tenths of a second; several seconds with the reference BLAS. Leaves libtorch with a
/// thread a core.
TorchReport examine_torch();

}  // namespace enfilade::neural
