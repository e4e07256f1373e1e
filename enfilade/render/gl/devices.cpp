#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "enfilade/core/errors.h"
#include "enfilade/render/gl/context.h"
#include "enfilade/render/gl/mesa.h"
#include "enfilade/render/gl/trial.h"
#include "enfilade/render/gl_devices.h"

namespace enfilade::render {
namespace gl {
namespace {

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

std::vector<Way> devices() {
  const bool listed = has_client_extension("EGL_EXT_device_base") ||
                      (has_client_extension("EGL_EXT_device_enumeration") &&
                       has_client_extension("EGL_EXT_device_query"));
  if (!listed || !has_client_extension("EGL_EXT_platform_device")) return {};
  std::array<EGLDeviceEXT, 64> handles{};
  EGLint count = 0;
  if (eglQueryDevicesEXT(static_cast<EGLint>(handles.size()), handles.data(), &count) != EGL_TRUE) {
    return {};
  }
  std::vector<Way> found;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const char* extensions = eglQueryDeviceStringEXT(handles[i], EGL_EXTENSIONS);
    found.push_back({Way::Kind::kDevice, std::to_string(i), uuid_of(handles[i], extensions),
                     has_word(extensions, "EGL_MESA_device_software"), handles[i]});
  }
  return found;
}

std::string list_of(const std::vector<Way>& all) {
  std::string text;
  for (const Way& way : all) {
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
std::shared_ptr<Context> find_by_uuid(const std::vector<Way>& all, const std::string& uuid,
                                      const Open& open) {
  for (const Way& way : all) {
    if (way.kind != Way::Kind::kDevice || (!way.uuid.empty() && way.uuid != uuid)) continue;
    try {
      auto context = open(way);
      if (context->uuid() == uuid) return context;
    } catch (const Error&) {
      if (way.uuid == uuid) throw;
    }
  }
  return nullptr;
}

std::shared_ptr<Context> first_that_works(const std::vector<Way>& all, const Open& open) {
  std::string faults;
  for (const Way& way : all) {
    try {
      return open(way);
    } catch (const Error& error) {
      faults += fmt::format("\n  {}", error.what());
    }
  }
  throw Error("no OpenGL device works:" + faults);
}

std::shared_ptr<Context> open_here(const Way& way) { return std::make_shared<Context>(way); }

}  // namespace

std::vector<Way> ways() {
  keep_mesa_to_its_llvm();
  if (!epoxy_has_egl()) return {};
  std::vector<Way> all = devices();
  std::ranges::stable_sort(all, {}, &Way::software);
  if (has_client_extension("EGL_EXT_platform_base") &&
      has_client_extension("EGL_MESA_platform_surfaceless")) {
    all.push_back({Way::Kind::kSurfaceless, "surfaceless", "", false, nullptr});
  }
  all.push_back({Way::Kind::kDefault, "default", "", false, nullptr});
  return all;
}

std::shared_ptr<Context> find_context(const std::string& device, const Open& open) {
  const std::vector<Way> all = ways();
  if (all.empty()) throw Error(std::string(kNoEgl));
  if (device.empty()) return first_that_works(all, open);
  const auto named = std::ranges::find(all, device, &Way::name);
  if (named != all.end()) return open(*named);
  const std::string uuid = digits_of(device);
  if (uuid.size() == 32) {
    if (auto context = find_by_uuid(all, uuid, open)) return context;
  }
  throw ArgumentError(fmt::format(
      "gl_device {:?}: no index or UUID of an EGL device; there are: {}", device, list_of(all)));
}

std::shared_ptr<Context> make_context(const std::string& device) {
  return find_context(tried_way(device).value_or(device), open_here);
}

std::vector<GlDevice> list_devices(const Open& open) {
  std::vector<GlDevice> found;
  for (const Way& way : ways()) {
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
