#include "enfilade/render/gl/context.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::render::gl {
namespace {

constexpr int kMajor = 4, kMinor = 3;  // glTexStorage3D, glCopyImageSubData

// EGL's name of the thread's last error, which this clears.
std::string egl_error() {
  // By number, from EGL_SUCCESS on: EGL counts its errors without a gap.
  constexpr std::array<const char*, 15> kNames{
      "no EGL error was noted", "EGL_NOT_INITIALIZED",     "EGL_BAD_ACCESS",
      "EGL_BAD_ALLOC",          "EGL_BAD_ATTRIBUTE",       "EGL_BAD_CONFIG",
      "EGL_BAD_CONTEXT",        "EGL_BAD_CURRENT_SURFACE", "EGL_BAD_DISPLAY",
      "EGL_BAD_MATCH",          "EGL_BAD_NATIVE_PIXMAP",   "EGL_BAD_NATIVE_WINDOW",
      "EGL_BAD_PARAMETER",      "EGL_BAD_SURFACE",         "EGL_CONTEXT_LOST"};
  static_assert(EGL_SUCCESS + kNames.size() - 1 == EGL_CONTEXT_LOST);
  const EGLint code = eglGetError();
  const auto place = static_cast<std::size_t>(code - EGL_SUCCESS);
  return place < kNames.size() ? kNames[place] : fmt::format("EGL error 0x{:04x}", code);
}

[[noreturn]] void fail_egl(std::string_view call) {
  throw Error(fmt::format("{}: {}", call, egl_error()));
}

EGLDisplay display_of(const Way& way) {
  // Mesa's number; epoxy's headers do not have it.
  constexpr EGLenum kPlatformSurfaceless = 0x31DD;
  switch (way.kind) {
    case Way::Kind::kDevice:
      return eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, way.device, nullptr);
    case Way::Kind::kSurfaceless:
      return eglGetPlatformDisplayEXT(kPlatformSurfaceless, EGL_DEFAULT_DISPLAY, nullptr);
    case Way::Kind::kDefault:
      break;
  }
  return eglGetDisplay(EGL_DEFAULT_DISPLAY);
}

// Displays are never terminated: EGL returns the same one to everyone in the process who asks for
// this device, and eglTerminate() would destroy their contexts too.
EGLDisplay open_display(const Way& way) {
  const EGLDisplay display = display_of(way);
  if (display == EGL_NO_DISPLAY) fail_egl("eglGetDisplay");
  if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) fail_egl("eglInitialize");
  return display;
}

EGLConfig choose_config(EGLDisplay display) {
  for (const EGLint surface : {EGL_PBUFFER_BIT, 0}) {
    const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, surface, EGL_RENDERABLE_TYPE,
                                       EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (eglChooseConfig(display, wanted.data(), &config, 1, &count) != EGL_TRUE) {
      fail_egl("eglChooseConfig");
    }
    if (count > 0) return config;
  }
  throw Error("eglChooseConfig: the display has no configuration for desktop OpenGL");
}

std::string gl_string(GLenum name) {
  const GLubyte* text = glGetString(name);
  std::string copy;
  for (; text != nullptr && *text != 0; ++text) copy += static_cast<char>(*text);
  return copy;
}

std::mutex& creation_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

Context::Context(const Way& way) {
  // Drivers load themselves, and epoxy looks up its functions, at the first use.
  const std::lock_guard lock(creation_mutex());
  try {
    create(way);
  } catch (const Error& error) {
    destroy();
    throw Error(fmt::format("EGL device {}: {}", way.name, error.what()));
  }
}

Context::~Context() { destroy(); }

void Context::create(const Way& way) {
  display_ = open_display(way);
  const EGLConfig config = choose_config(display_);
  const EGLenum api = eglQueryAPI();
  if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) fail_egl("eglBindAPI(EGL_OPENGL_API)");
  constexpr std::array<EGLint, 7> kWanted{EGL_CONTEXT_MAJOR_VERSION,
                                          kMajor,
                                          EGL_CONTEXT_MINOR_VERSION,
                                          kMinor,
                                          EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                          EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                          EGL_NONE};
  context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, kWanted.data());
  const std::string refusal = context_ == EGL_NO_CONTEXT ? egl_error() : "";
  // Any context can tell which version the device has instead.
  if (context_ == EGL_NO_CONTEXT) {
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, nullptr);
  }
  eglBindAPI(api);
  if (context_ != EGL_NO_CONTEXT) {
    if (!epoxy_has_egl_extension(display_, "EGL_KHR_surfaceless_context")) {
      constexpr std::array<EGLint, 5> kSize{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
      surface_ = eglCreatePbufferSurface(display_, config, kSize.data());
      if (surface_ == EGL_NO_SURFACE) fail_egl("eglCreatePbufferSurface");
    }
    describe();
  }
  if (!refusal.empty()) {
    throw Error(fmt::format("eglCreateContext: OpenGL {}.{} core is needed: {}; the device has {}",
                            kMajor, kMinor, refusal,
                            version_.empty() ? "no OpenGL" : "OpenGL " + version_));
  }
  if (!way.uuid.empty()) uuid_ = way.uuid;
}

void Context::describe() {
  const Current current(*this);
  renderer_ = gl_string(GL_RENDERER);
  version_ = gl_string(GL_VERSION);
  if (epoxy_has_gl_extension("GL_EXT_memory_object")) {
    std::array<GLubyte, 16> uuid{};
    glGetUnsignedBytei_vEXT(GL_DEVICE_UUID_EXT, 0, uuid.data());
    const bool known = glGetError() == GL_NO_ERROR && uuid != std::array<GLubyte, 16>{};
    if (known) uuid_ = hex(uuid);
  }
}

void Context::destroy() noexcept {
  // The context's objects are deleted with it.
  if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
  if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
}

Current::Current(const Context& context) : api_(eglQueryAPI()), display_(context.display_) {
  eglBindAPI(EGL_OPENGL_API);
  previous_display_ = eglGetCurrentDisplay();
  previous_ = eglGetCurrentContext();
  previous_draw_ = eglGetCurrentSurface(EGL_DRAW);
  previous_read_ = eglGetCurrentSurface(EGL_READ);
  if (eglMakeCurrent(display_, context.surface_, context.surface_, context.context_) != EGL_TRUE) {
    eglBindAPI(api_);
    fail_egl("eglMakeCurrent");
  }
}

Current::~Current() {
  if (previous_ == EGL_NO_CONTEXT) {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  } else {
    eglMakeCurrent(previous_display_, previous_draw_, previous_read_, previous_);
  }
  eglBindAPI(api_);
}

void check_gl(std::string_view doing) {
  const GLenum code = glGetError();
  if (code == GL_NO_ERROR) return;
  while (glGetError() != GL_NO_ERROR) {
  }
  throw Error(fmt::format("OpenGL: {}: {}", doing, gl_name(code)));
}

std::string gl_name(GLenum code) {
  using Name = std::pair<GLenum, const char*>;
  constexpr std::array kNames{
      Name{GL_INVALID_ENUM, "GL_INVALID_ENUM"},
      Name{GL_INVALID_VALUE, "GL_INVALID_VALUE"},
      Name{GL_INVALID_OPERATION, "GL_INVALID_OPERATION"},
      Name{GL_INVALID_FRAMEBUFFER_OPERATION, "GL_INVALID_FRAMEBUFFER_OPERATION"},
      Name{GL_OUT_OF_MEMORY, "GL_OUT_OF_MEMORY"},
      Name{GL_FRAMEBUFFER_UNDEFINED, "GL_FRAMEBUFFER_UNDEFINED"},
      Name{GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT, "GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT"},
      Name{GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT,
           "GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT"},
      Name{GL_FRAMEBUFFER_INCOMPLETE_DRAW_BUFFER, "GL_FRAMEBUFFER_INCOMPLETE_DRAW_BUFFER"},
      Name{GL_FRAMEBUFFER_INCOMPLETE_READ_BUFFER, "GL_FRAMEBUFFER_INCOMPLETE_READ_BUFFER"},
      Name{GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE, "GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE"},
      Name{GL_FRAMEBUFFER_UNSUPPORTED, "GL_FRAMEBUFFER_UNSUPPORTED"}};
  const auto known = std::ranges::find(kNames, code, &Name::first);
  return fmt::format("{} (0x{:04x})", known == kNames.end() ? "unknown" : known->second, code);
}

std::string hex(std::span<const unsigned char> bytes) {
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

}  // namespace enfilade::render::gl
