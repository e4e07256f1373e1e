/// \file  Devices of libtorch, by name.
#pragma once
#include <c10/core/Device.h>
#include <string>

namespace enfilade::neural::detail {

/// "cpu", "cuda" (the first card) or "cuda:1". \throws ArgumentError for another name; Error, with
/// libtorch's reason, for a device that is not available
c10::Device open_device(const std::string& name);

}  // namespace enfilade::neural::detail
