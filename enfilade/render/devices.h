/// \file  The devices and the instruction set of this machine that can draw, for diagnosis and
/// error messages; a picture to test them with.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/render/face_cache.h"
#include "enfilade/render/renderer.h"

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

/// One scan of one viewpoint, of one grey all around.
std::shared_ptr<FaceCache> sample_faces();

/// Draws them. \param renderer made with sample_faces() \throws Error if a pixel has another
/// colour; as Renderer::render()
void check_sample(Renderer& renderer);

}  // namespace enfilade::render
