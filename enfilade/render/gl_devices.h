/// \file  OpenGL devices and instruction set of this machine, for diagnosis and error messages.
#pragma once
#include <string>
#include <vector>

namespace enfilade::render {

/// A way to make an OpenGL context.
struct GlDevice {
  std::string name;      ///< "0", "1", ... for EGL devices; "surfaceless"; "default"
  std::string uuid;      ///< 32 hex digits; empty if the driver has none
  bool works = false;    ///< a context of the required version could be made
  std::string renderer;  ///< GL_RENDERER, GL_VERSION if it works
  std::string version;
  std::string error;  ///< message of EGL or OpenGL if it does not work
};

/// Tries all devices; takes up to a second each. Empty if built without OpenGL or if there is no
/// EGL library.
std::vector<GlDevice> gl_devices();

/// The instruction set that Backend::kCpu uses here: "AVX3_DL gathers", "AVX2", "SSE4", "NEON", ...
std::string cpu_target();
/// All that it can use here, for RendererConfig::cpu_target.
std::vector<std::string> cpu_targets();

}  // namespace enfilade::render
