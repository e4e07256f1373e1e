#include "enfilade/render/gl/context.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/render/gl/trial.h"

// Sanitizers' runtimes end the program where RTLD_DEEPBIND is used.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define EN_DEEPBIND 0
#elif defined(__has_feature)
#define EN_DEEPBIND !(__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define EN_DEEPBIND 1
#endif

namespace enfilade::render {
namespace gl {
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

EGLDisplay display_of(const DisplayWay& way) {
  // Mesa's number; epoxy's headers do not have it.
  constexpr EGLenum kPlatformSurfaceless = 0x31DD;
  switch (way.kind) {
    case DisplayWay::WayKind::kDevice:
      return eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, way.device, nullptr);
    case DisplayWay::WayKind::kSurfaceless:
      return eglGetPlatformDisplayEXT(kPlatformSurfaceless, EGL_DEFAULT_DISPLAY, nullptr);
    case DisplayWay::WayKind::kDefault:
      break;
  }
  return eglGetDisplay(EGL_DEFAULT_DISPLAY);
}

// Displays are never terminated: EGL returns the same one to everyone in the process who asks for
// this device, and eglTerminate() would destroy their contexts too.
EGLDisplay open_display(const DisplayWay& way) {
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

// --- devices -------------------------------------------------------------------------------------

// If the program is linked to a copy of LLVM, as Debian 13's libtorch has one, loads Mesa so that
// it finds its own copy first; else llvmpipe crashes (docs/design/driver-trials.md). To be called
// before anything else loads EGL.
bool load_mesa() {
#if EN_DEEPBIND
  // Of Debian's libtorch; the last one of PyTorch's own.
  constexpr std::array kNamesOfLlvm{"LLVMInitializeX86TargetInfo",
                                    "LLVMInitializeAArch64TargetInfo", "llvm_regexec"};
  const bool llvm = std::ranges::any_of(
      kNamesOfLlvm, [](const char* name) { return dlsym(RTLD_DEFAULT, name) != nullptr; });
  // Stays loaded: EGL loads it later, and by then all its libraries are bound.
  return llvm && dlopen("libEGL_mesa.so.0", RTLD_LAZY | RTLD_LOCAL | RTLD_DEEPBIND) != nullptr;
#else
  return false;
#endif
}

bool has_client_extension(const char* name) {
  return epoxy_has_egl_extension(EGL_NO_DISPLAY, name);
}

bool has_word(const char* list, std::string_view word) {
  const std::string wanted = fmt::format(" {} ", word);
  return list != nullptr && fmt::format(" {} ", list).find(wanted) != std::string::npos;
}

// EGL_EXT_device_persistent_id, which epoxy 1.5 does not know.
std::string uuid_of(EGLDeviceEXT device, const char* extensions) {
  if (!has_word(extensions, "EGL_EXT_device_persistent_id")) return "";
  using QueryBinary = EGLBoolean (*)(EGLDeviceEXT, EGLint, EGLint, void*, EGLint*);
  constexpr EGLint kDeviceUuid = 0x335C;
  // eglGetProcAddress() returns functions of any type.
  const auto query = reinterpret_cast<QueryBinary>(eglGetProcAddress("eglQueryDeviceBinaryEXT"));
  std::array<unsigned char, 16> bytes{};
  EGLint size = 0;
  if (query == nullptr || query(device, kDeviceUuid, static_cast<EGLint>(bytes.size()),
                                bytes.data(), &size) != EGL_TRUE) {
    return "";
  }
  return hex(bytes);
}

std::vector<DisplayWay> devices() {
  const bool listed = has_client_extension("EGL_EXT_device_base") ||
                      (has_client_extension("EGL_EXT_device_enumeration") &&
                       has_client_extension("EGL_EXT_device_query"));
  if (!listed || !has_client_extension("EGL_EXT_platform_device")) return {};
  std::array<EGLDeviceEXT, 64> handles{};
  EGLint count = 0;
  if (eglQueryDevicesEXT(static_cast<EGLint>(handles.size()), handles.data(), &count) != EGL_TRUE) {
    return {};
  }
  std::vector<DisplayWay> found;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const char* extensions = eglQueryDeviceStringEXT(handles[i], EGL_EXTENSIONS);
    found.push_back({DisplayWay::WayKind::kDevice, std::to_string(i),
                     uuid_of(handles[i], extensions),
                     has_word(extensions, "EGL_MESA_device_software"), handles[i]});
  }
  return found;
}

std::string list_of(const std::vector<DisplayWay>& all) {
  std::string text;
  for (const DisplayWay& way : all) {
    text += text.empty() ? "" : ", ";
    text += way.name;
    if (way.software) text += " (software)";
    if (!way.uuid.empty()) text += fmt::format(" (UUID {})", way.uuid);
  }
  return text;
}

std::string digits_of(std::string text) {
  std::erase(text, '-');
  std::ranges::transform(text, text.begin(), [](char c) {
    return c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return text;
}

// If only OpenGL has the UUIDs, this makes a context for each device.
std::shared_ptr<GlContext> find_by_uuid(const std::vector<DisplayWay>& all, const std::string& uuid,
                                        const Open& open) {
  for (const DisplayWay& way : all) {
    if (way.kind != DisplayWay::WayKind::kDevice || (!way.uuid.empty() && way.uuid != uuid))
      continue;
    try {
      auto context = open(way);
      if (context->uuid() == uuid) return context;
    } catch (const Error&) {
      if (way.uuid == uuid) throw;
    }
  }
  return nullptr;
}

std::shared_ptr<GlContext> first_that_works(const std::vector<DisplayWay>& all, const Open& open) {
  std::string faults;
  for (const DisplayWay& way : all) {
    try {
      return open(way);
    } catch (const Error& error) {
      faults += fmt::format("\n  {}", error.what());
    }
  }
  throw Error("no OpenGL device works:" + faults);
}

std::shared_ptr<GlContext> open_here(const DisplayWay& way) {
  return std::make_shared<GlContext>(way);
}

}  // namespace

GlContext::GlContext(const DisplayWay& way) {
  // Drivers load themselves, and epoxy looks up its functions, at the first use.
  const std::lock_guard lock(creation_mutex());
  try {
    create(way);
  } catch (const Error& error) {
    destroy();
    throw Error(fmt::format("EGL device {}: {}", way.name, error.what()));
  }
}

GlContext::~GlContext() { destroy(); }

void GlContext::create(const DisplayWay& way) {
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

void GlContext::describe() {
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

void GlContext::destroy() noexcept {
  // The context's objects are deleted with it.
  if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
  if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
}

Current::Current(const GlContext& context) : api_(eglQueryAPI()), display_(context.display_) {
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

std::vector<DisplayWay> ways() {
  [[maybe_unused]] static const bool kMesaKeptToItsLlvm = load_mesa();
  if (!epoxy_has_egl()) return {};
  std::vector<DisplayWay> all = devices();
  std::ranges::stable_sort(all, {}, &DisplayWay::software);
  if (has_client_extension("EGL_EXT_platform_base") &&
      has_client_extension("EGL_MESA_platform_surfaceless")) {
    all.push_back({DisplayWay::WayKind::kSurfaceless, "surfaceless", "", false, nullptr});
  }
  all.push_back({DisplayWay::WayKind::kDefault, "default", "", false, nullptr});
  return all;
}

std::shared_ptr<GlContext> find_context(const std::string& device, const Open& open) {
  const std::vector<DisplayWay> all = ways();
  if (all.empty()) throw Error(std::string(kNoEgl));
  if (device.empty()) return first_that_works(all, open);
  const auto named = std::ranges::find(all, device, &DisplayWay::name);
  if (named != all.end()) return open(*named);
  const std::string uuid = digits_of(device);
  if (uuid.size() == 32) {
    if (auto context = find_by_uuid(all, uuid, open)) return context;
  }
  throw ArgumentError(fmt::format(
      "gl_device {:?}: no index or UUID of an EGL device; there are: {}", device, list_of(all)));
}

std::shared_ptr<GlContext> make_context(const std::string& device) {
  return find_context(tried_way(device).value_or(device), open_here);
}

std::vector<GlDevice> list_devices(const Open& open) {
  std::vector<GlDevice> found;
  for (const DisplayWay& way : ways()) {
    GlDevice device;
    device.name = way.name;
    device.uuid = way.uuid;
    try {
      const auto context = open(way);
      device.works = true;
      device.uuid = context->uuid();
      device.renderer = context->renderer();
      device.version = context->version();
    } catch (const Error& error) {
      device.error = error.what();
    }
    found.push_back(std::move(device));
  }
  return found;
}

}  // namespace gl

std::vector<GlDevice> gl_devices() {
  if (auto tried = gl::tried_devices()) return std::move(*tried);
  return gl::list_devices(gl::open_here);
}

}  // namespace enfilade::render
