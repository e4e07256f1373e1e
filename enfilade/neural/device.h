/// \file  libtorch on this machine: its version, BLAS, speed and threads.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/enum_names.h"

namespace enfilade::neural {

class Ranks;  // ranks.h

/// The numbers that a card's products are made of in training. Weights, sums, norms and losses are
/// float32 always; evaluation and the CPU have float32 alone.
enum class Precision : std::uint8_t {
  kFloat32,
  kTf32,      ///< factors are rounded to 10 bits in the matrix units, sums are float32
  kBfloat16,  ///< PyTorch's autocast: products, and what lies between them, in bfloat16
};
constexpr std::array<std::string_view, 3> names_of(Precision /*enum*/) {
  return {"float32", "tf32", "bfloat16"};
}

/// Device and processes of a training.
struct Computing {
  std::string device = "cpu";  ///< "cpu", "cuda" (the first card) or "cuda:1"
  Precision precision = Precision::kFloat32;
  Ranks* ranks = nullptr;  ///< processes that train together; null: this one alone
};

/// Libtorch's properties that decide the bits of its results on a CPU, beside its BLAS.
struct TorchKind {
  std::string version;       ///< of libtorch, "1.13.1"
  std::string instructions;  ///< that it uses here: "AVX2", "AVX512", "default"
};
TorchKind torch_kind();

int card_count();  ///< cards that libtorch can use here; 0 if none

/// Below this speed training takes too long. An optimised BLAS is ten times as fast on any current
/// processor, the reference BLAS is slower on all.
inline constexpr double kSlowBlas = 30;  ///< GFLOP/s

/// Which libtorch this is, and how fast its matrix products are here.
struct TorchReport {
  std::string version;  ///< of libtorch, "1.13.1"
  int threads = 0;      ///< that a matrix product runs on
  std::string blas;     ///< the file of sgemm_, links resolved; empty if unknown.
  /// GFLOP/s of a product of the sequence-to-sequence agent's size, (100, 2592) x (2592, 2048): the
  /// best of a few.
  double product_speed = 0;
  std::string cuda;       ///< "works", or why it does not, in libtorch's words
  bool connects = false;  ///< whether processes can train together
  std::string processes;  ///< by which library, or the missing part
};
/// Takes a few tenths of a second, or several seconds with the reference BLAS. Leaves libtorch with
/// one thread per core.
TorchReport examine_torch();

/// Sets the number of threads of libtorch and the BLAS, for the whole process. 0: all cores
void set_threads(int threads);

}  // namespace enfilade::neural
