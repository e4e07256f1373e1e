/// \file  Which OpenGL devices this machine has, for `enfilade doctor` and error messages.
#pragma once
#include <string>
#include <vector>

namespace enfilade::render {

/// One way to an OpenGL context.
struct GlDevice {
  std::string name;      ///< "0", "1", ... for EGL devices; "surfaceless"; "default"
  std::string uuid;      ///< 32 hex digits; empty if the driver tells none
  bool works = false;    ///< a context of the version that we need could be made
  std::string renderer;  ///< GL_RENDERER, GL_VERSION if it works
  std::string version;
  std::string error;  ///< why it does not, in EGL's or OpenGL's words
};

/// Tries all. Takes up to a second a device. Empty list: built without OpenGL, or no EGL library.
std::vector<GlDevice> gl_devices();

/// The instruction set that Backend::kCpu would use here: "AVX3", "AVX2", "SSE4", "NEON", ...
std::string cpu_target();

}  // namespace enfilade::render
