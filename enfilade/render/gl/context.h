/// \file  OpenGL contexts without a window or a display server.
#pragma once
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/render/devices.h"

namespace enfilade::render::gl {

/// A way to an EGL display.
struct DisplayWay {
  enum class WayKind { kDevice, kSurfaceless, kDefault };
  WayKind kind = WayKind::kDefault;
  std::string name;  ///< "0", "1", ...; "surfaceless"; "default"
  std::string uuid;  ///< 32 hex digits, if EGL has one
  bool software = false;
  EGLDeviceEXT device = nullptr;
};

/// In the order in which they are to be tried: hardware devices, the software device, surfaceless,
/// default. Empty without an EGL library.
std::vector<DisplayWay> ways();

/// The error message if ways() is empty.
inline constexpr std::string_view kNoEgl =
    "no EGL library (libEGL.so.1) could be loaded; on Debian and Ubuntu: apt-get install "
    "libegl1 libegl-mesa0 libgl1-mesa-dri, or the graphics card's own driver";

/// A context of OpenGL 4.3 core or later. Belongs to no thread: Current lends it to one.
class GlContext {
 public:
  /// \throws Error naming the way and what EGL or OpenGL said
  explicit GlContext(const DisplayWay& way);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  const std::string& renderer() const noexcept { return renderer_; }  ///< GL_RENDERER
  const std::string& version() const noexcept { return version_; }    ///< GL_VERSION
  const std::string& uuid() const noexcept { return uuid_; }  ///< from EGL, else from OpenGL

 private:
  friend class Current;
  void create(const DisplayWay& way);
  void describe();
  void destroy() noexcept;

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;
  std::string renderer_, version_, uuid_;
};

/// Makes a context the thread's current one as long as it lives, then the one that was before.
class Current {
 public:
  /// \throws Error
  explicit Current(const GlContext& context);
  ~Current();
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;

 private:
  EGLenum api_;
  EGLDisplay display_, previous_display_;
  EGLContext previous_;
  EGLSurface previous_draw_, previous_read_;
};

/// Makes the context of a way; throws an Error with the reason if it cannot.
using Open = std::function<std::shared_ptr<GlContext>(const DisplayWay&)>;

/// The context of a device by index or UUID; if `device` is empty, of the first way that works.
/// \throws ArgumentError listing the devices if the name is unknown; Error
std::shared_ptr<GlContext> find_context(const std::string& device, const Open& open);

/// Likewise, after another process has tried the device (set_gl_trial()). \throws as find_context()
std::shared_ptr<GlContext> make_context(const std::string& device);

/// All ways, opened one after the other; see gl_devices().
std::vector<GlDevice> list_devices(const Open& open);

/// \throws Error if OpenGL has recorded one, naming it and the operation
void check_gl(std::string_view doing);

/// "GL_INVALID_ENUM (0x0500)": an error, or a framebuffer's status.
std::string gl_name(GLenum code);

/// Two digits a byte.
std::string hex(std::span<const unsigned char> bytes);

}  // namespace enfilade::render::gl
