#include "enfilade/render/gl/mesa.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>

// Sanitizers' runtimes end the program where RTLD_DEEPBIND is used.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define EN_DEEPBIND 0
#elif defined(__has_feature)
#define EN_DEEPBIND !(__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define EN_DEEPBIND 1
#endif

namespace enfilade::render::gl {
namespace {

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

}  // namespace

void keep_mesa_to_its_llvm() { [[maybe_unused]] static const bool kDone = load_mesa(); }

}  // namespace enfilade::render::gl
