/// \file  Where libtorch computes.
#pragma once
#include <c10/core/Device.h>
#include <string>

namespace enfilade::neural::detail {

/// "cpu", "cuda" (the first card) or "cuda:1". \throws ArgumentError for another word; Error, with
/// libtorch's reason, for a device that is not there
c10::Device open_device(const std::string& name);

}  // namespace enfilade::neural::detail
