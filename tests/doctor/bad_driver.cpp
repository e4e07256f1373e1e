// A driver of EGL that does what the environment variable EN_BAD_DRIVER says: "crash-at-load", or,
// when a display is asked for, "crash", "abort", "exit", "hang", "chatter", or "refuse".
#include <unistd.h>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

using AnyFunction = void (*)();

// What GLVND, which loads drivers, wants of one: __EGLapiImports of its libeglabi.h.
struct Imports {
  void* (*get_platform_display)(unsigned, void*, const std::intptr_t*);
  unsigned (*get_supports_api)(unsigned);
  const char* (*get_vendor_string)(int);
  AnyFunction (*get_proc_address)(const char*);
  AnyFunction (*get_dispatch_address)(const char*);
  void (*set_dispatch_index)(const char*, int);
  AnyFunction rest[5];  // may be null
};

bool told_to(const char* what) {
  const char* wish = std::getenv("EN_BAD_DRIVER");
  return wish != nullptr && std::strcmp(wish, what) == 0;
}

void crash() {
  volatile int* volatile nowhere = nullptr;
  *nowhere = 1;
}

void* get_platform_display(unsigned, void*, const std::intptr_t*) {
  if (told_to("crash")) crash();
  if (told_to("abort")) std::abort();
  if (told_to("exit")) std::_Exit(7);
  while (told_to("hang")) pause();
  while (told_to("chatter")) {
    std::puts("still at it");
    std::fflush(stdout);
    usleep(10'000);
  }
  return nullptr;
}

void* no() { return nullptr; }
AnyFunction get_proc_address(const char*) { return reinterpret_cast<AnyFunction>(no); }

}  // namespace

// NOLINTNEXTLINE(bugprone-reserved-identifier, readability-identifier-naming): GLVND calls it.
extern "C" unsigned __egl_Main(std::uint32_t, const void*, void*, Imports* imports) {
  if (told_to("crash-at-load")) crash();
  imports->get_platform_display = get_platform_display;
  imports->get_supports_api = [](unsigned) -> unsigned { return 1; };
  imports->get_vendor_string = [](int) -> const char* { return nullptr; };
  imports->get_proc_address = get_proc_address;
  imports->get_dispatch_address = [](const char*) -> AnyFunction { return nullptr; };
  imports->set_dispatch_index = [](const char*, int) {};
  return 1;
}
