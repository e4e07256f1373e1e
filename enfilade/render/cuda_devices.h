/// \file  The installed parts of CUDA, for diagnosis.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace enfilade::render {

/// A card that Backend::kCuda can draw with.
struct CudaDevice {
  std::string name;                       ///< "NVIDIA H200"
  std::string capability;                 ///< compute capability: "9.0"
  std::size_t bytes = 0, free_bytes = 0;  ///< of its memory
};

/// The result of cuda_report().
struct CudaReport {
  std::string driver;               ///< the newest CUDA that it supports: "13.0"; empty: none
  std::vector<CudaDevice> devices;  ///< by their numbers
  std::string error;                ///< why there is no driver or no card
  std::string compiler;             ///< NVRTC's version, "12.9"; empty: none found
  std::string compiler_error;       ///< why, and how to get it
};

/// Loads the driver and makes a context of each card: takes up to a second. Never throws.
CudaReport cuda_report();

}  // namespace enfilade::render
