/// \file  NVRTC: compiles the kernels for a card, when they are first needed.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::render::cuda {

/// The text of detail/pixels.h and kernels.h, embedded by the build.
extern const std::string_view kKernels;

/// Input of a compilation: macros of kernels.h.
struct KernelSource {
  std::vector<std::string> definitions;  ///< "EN_COLOUR=1", ...
};

/// The runtime compiler of CUDA 11.2 or later. The first of: already loaded (for example by
/// PyTorch), the file that ENFILADE_NVRTC names, the system's, that of /usr/local/cuda.
class Compiler {
 public:
  /// \throws Error with the searched places, and how to get it
  Compiler();

  const std::string& version() const noexcept { return version_; }  ///< "12.9"
  /// Compute capabilities that it compiles for, ascending: 50, ..., 90, ...
  const std::vector<int>& capabilities() const noexcept { return capabilities_; }

  struct Compiled {
    std::string image;  ///< machine code of a card (a cubin)
    std::string log;    ///< registers, stack and spills of each kernel
  };
  /// \throws Error with the compiler's messages
  Compiled compile(const KernelSource& source, int capability) const;

 private:
  struct Functions;
  const Functions& functions_;
  std::string version_;
  std::vector<int> capabilities_;
};

/// Compiled images, cached in a folder: $XDG_CACHE_HOME/enfilade/cuda or ~/.cache/enfilade/cuda.
/// The compiler is not even loaded while all requested images are there. If nothing can be written,
/// each process compiles for itself.
class Images {
 public:
  Images();  ///< in the user's folder
  explicit Images(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// \throws Error as Compiler
  std::string find_or_compile(const KernelSource& source, int capability) const;

 private:
  std::filesystem::path folder_;  // empty: none
};

}  // namespace enfilade::render::cuda
