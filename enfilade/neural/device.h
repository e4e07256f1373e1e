/// \file  libtorch on this machine: its version, BLAS, speed and threads.
#pragma once
#include <string>

namespace enfilade::neural {

/// Below this speed training takes too long: an optimised BLAS is ten times as fast on any machine
/// of today, the reference BLAS is slower on all.
inline constexpr double kSlowBlas = 30;  ///< GFLOP/s

/// Which libtorch this is, and how fast its matrix products are here.
struct TorchReport {
  std::string version;  ///< of libtorch, "1.13.1"
  int threads = 0;      ///< that a matrix product runs on
  std::string blas;     ///< the file of sgemm_, links resolved; empty if it cannot be found
  /// GFLOP/s of a product of the sequence-to-sequence agent's size, (100, 2592) x (2592, 2048): the
  /// best of a few.
  double product_speed = 0;
  std::string cuda;  ///< "works", or why it does not, in libtorch's words
};
/// Takes a few tenths of a second, or several seconds with the reference BLAS. Leaves libtorch with
/// one thread per core.
TorchReport examine_torch();

}  // namespace enfilade::neural
