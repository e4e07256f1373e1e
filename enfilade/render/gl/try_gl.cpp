// The process that tries drivers for another one.
#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <map>

#include "enfilade/core/errors.h"
#include "enfilade/render/detail/layers.h"
#include "enfilade/render/devices.h"
#include "enfilade/render/gl/context.h"
#include "enfilade/render/gl/trial.h"

namespace enfilade::render {
namespace gl {
namespace {

void write_all(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = write(STDOUT_FILENO, text.data(), text.size());
    if (count <= 0) return;  // the reader has gone
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

void tell(const std::vector<std::string_view>& words) { write_all(line_of(words)); }

std::string_view file_of(std::string_view path) { return path.substr(path.rfind('/') + 1); }

const void* place_of_crash([[maybe_unused]] const void* context) {
#if defined(__x86_64__)
  const auto* state = static_cast<const ucontext_t*>(context);
  return reinterpret_cast<const void*>(state->uc_mcontext.gregs[REG_RIP]);
#elif defined(__aarch64__)
  const auto* state = static_cast<const ucontext_t*>(context);
  return reinterpret_cast<const void*>(state->uc_mcontext.pc);
#else
  return nullptr;
#endif
}

// Not safe in a handler by the letter; but this process is lost, and another one watches the clock.
void tell_crash(int signal, siginfo_t*, void* context) {
  std::signal(signal, SIG_DFL);
  Dl_info info{};
  // abort() is the C library's, which is no news.
  if (signal != SIGABRT && dladdr(place_of_crash(context), &info) != 0) {
    tell({kPlace, file_of(info.dli_fname)});
  }
  std::raise(signal);  // comes when this returns
}

// A crash only tells about the driver: no core, no handler that a library of ours has set.
void prepare_to_crash() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  static std::array<std::byte, 64 << 10> stack;  // the other one may have overflowed
  stack_t other{};
  other.ss_sp = stack.data();
  other.ss_size = stack.size();
  sigaltstack(&other, nullptr);
  struct sigaction action {};
  action.sa_sigaction = tell_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) {
    sigaction(signal, &action, nullptr);
  }
}

// "libEGL_mesa.so.0, libEGL_nvidia.so.0": drivers of EGL are named so.
std::string loaded_drivers() {
  std::string list;
  const auto add = [](dl_phdr_info* info, std::size_t, void* to) {
    const std::string_view file = file_of(info->dlpi_name);
    auto& names = *static_cast<std::string*>(to);
    if (file.starts_with("libEGL_")) names += fmt::format("{}{}", names.empty() ? "" : ", ", file);
    return 0;
  };
  dl_iterate_phdr(add, &list);
  return list;
}

using Faults = std::map<std::string, std::string>;  // by way

// A context that draws right, or an Error.
std::shared_ptr<GlContext> try_way(const DisplayWay& way, const Faults& faults) {
  if (const auto fault = faults.find(way.name); fault != faults.end()) {
    throw Error(fmt::format("EGL device {}: {}", way.name, fault->second));
  }
  tell({kTrying, way.name, loaded_drivers()});
  auto context = std::make_shared<GlContext>(way);
  RendererConfig config;
  config.backend = Backend::kGl;
  check_sample(*detail::make_gl_renderer(sample_faces(), config, context));
  return context;
}

void list(const Faults& faults) {
  for (const GlDevice& d :
       list_devices([&](const DisplayWay& way) { return try_way(way, faults); })) {
    const bool broken = faults.contains(d.name);
    tell({kDeviceLine, d.name, d.uuid, d.works ? kYes : kNo, d.renderer, d.version, d.error,
          broken ? kYes : kNo});
  }
}

}  // namespace
}  // namespace gl

int try_gl(std::span<const std::string> words) {
  using namespace gl;
  if (words.size() < 2 || words.size() % 2 != 0 || (words[0] != kList && words[0] != kFind))
    return 2;
  prepare_to_crash();
  Faults faults;
  for (std::size_t i = 2; i < words.size(); i += 2) faults[words[i]] = words[i + 1];
  try {
    if (words[0] == kList) {
      list(faults);
    } else {
      find_context(words[1], [&](const DisplayWay& way) { return try_way(way, faults); });
    }
    tell({kFinished});
  } catch (const ArgumentError& error) {
    tell({kRefused, kYes, error.what()});
  } catch (const Error& error) {
    tell({kRefused, kNo, error.what()});
  }
  // At once: what a driver does at a process's end is no matter of this one's.
  _exit(0);
}

}  // namespace enfilade::render
