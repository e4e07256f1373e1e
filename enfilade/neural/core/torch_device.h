/// \file  Devices of libtorch, by name.
#pragma once
#include <c10/core/Device.h>
#include <string>

#include "enfilade/neural/device.h"

namespace enfilade::neural::core {

/// "cpu", "cuda" (the first card) or "cuda:1". \throws ArgumentError for another name; Error, with
/// libtorch's reason, for a device that is not available
c10::Device open_device(const std::string& name);
/// The same for agents. On a card, from now on and in all of the process, cuDNN computes LSTMs (and
/// convolutions) in float32, where libtorch would choose TF32. Attention is not cuDNN's.
/// \throws as open_device()
c10::Device open_agents_device(const std::string& name);

/// The number of threads that set_threads() has set.
int kernel_threads() noexcept;

/// While it lives, products on cards are made of numbers of this precision, in this thread
/// (kBfloat16) or in all (kTf32).
class PrecisionGuard {
 public:
  explicit PrecisionGuard(Precision precision);
  ~PrecisionGuard();
  PrecisionGuard(const PrecisionGuard&) = delete;
  PrecisionGuard& operator=(const PrecisionGuard&) = delete;

 private:
  Precision precision_;
  bool products_before_ = false, lstms_before_ = false;  // whether they were in TF32
};

}  // namespace enfilade::neural::core
