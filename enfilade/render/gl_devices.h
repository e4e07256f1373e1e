/// \file  OpenGL devices and instruction set of this machine, for diagnosis and error messages.
#pragma once
#include <span>
#include <string>
#include <vector>

namespace enfilade::render {

/// A way to make an OpenGL context.
struct GlDevice {
  std::string name;  ///< "0", "1", ... for EGL devices; "surfaceless"; "default"
  std::string uuid;  ///< 32 hex digits; empty if the driver has none
  bool works =
      false;  ///< a context of the required version could be made; after a trial: and draws
  std::string renderer;  ///< GL_RENDERER, GL_VERSION if it works
  std::string version;
  std::string error;    ///< message of EGL or OpenGL if it does not work
  bool broken = false;  ///< its driver crashed or hung; only a trial (set_gl_trial()) can find that
};

/// Tries all devices; takes up to a second each. Empty if built without OpenGL or without an EGL
/// library. With a trial set, no driver is loaded into this process. If listing the devices already
/// ends the trial, the result is one device "all".
/// \throws ArgumentError if ENFILADE_GL_SECONDS is not a number
std::vector<GlDevice> gl_devices();

/// Sets the command of a process that tries OpenGL devices before they are used here, as a driver
/// may crash or hang. It is a program (its file, not searched on PATH) and its first arguments; it
/// passes all further ones to try_gl(). Making a renderer of Backend::kGl then throws an Error that
/// names device, driver and signal. A trial costs the start of that program and the making of a
/// context, once per device and process; nothing without OpenGL.
///
/// The environment variable ENFILADE_GL_SECONDS is how long a driver may be silent (30; 0: no
/// trials). Without this call, and if the command cannot be started, drivers are loaded untried.
/// The program `enfilade` and the Python module call it. Thread-safe.
void set_gl_trial(std::vector<std::string> command);

/// The other side: tries devices and ends the process. Returns only for arguments that are not a
/// trial's: 2, an exit status. To be called before anything else uses OpenGL.
int try_gl(std::span<const std::string> arguments);

/// The instruction set that Backend::kCpu uses here: "AVX3_DL gathers", "AVX2", "SSE4", "NEON", ...
std::string cpu_target();
/// All that it can use here, for RendererConfig::cpu_target.
std::vector<std::string> cpu_targets();

}  // namespace enfilade::render
