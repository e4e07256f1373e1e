/// \file  OpenGL devices that another process has tried, as a driver may crash or hang.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "enfilade/render/gl_devices.h"

namespace enfilade::render::gl {

/// The name of the way that works on this device (empty: on the first that works). No value without
/// a trial process (set_gl_trial()). Each device is tried once; the result is remembered.
/// \throws ArgumentError listing the devices if the name is unknown
/// \throws Error if no context can be made, or if the driver crashed or hung
std::optional<std::string> tried_way(const std::string& device);

/// All devices, tried each time; no value as tried_way().
std::optional<std::vector<GlDevice>> tried_devices();

}  // namespace enfilade::render::gl
