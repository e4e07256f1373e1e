#include "enfilade/render/gl/mesa.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>

#if defined(__has_feature)
#define EN_CLANG_ADDRESS_SANITIZER __has_feature(address_sanitizer)
#else
#define EN_CLANG_ADDRESS_SANITIZER 0
#endif

namespace enfilade::render::gl {
namespace {

bool load_mesa() {
#if defined(__SANITIZE_ADDRESS__) || EN_CLANG_ADDRESS_SANITIZER
  return false;  // its runtime refuses RTLD_DEEPBIND
#else
  // Of Debian's libtorch; the last one of PyTorch's own.
  constexpr std::array kNamesOfLlvm{"LLVMInitializeX86TargetInfo",
                                    "LLVMInitializeAArch64TargetInfo", "llvm_regexec"};
  const bool llvm = std::ranges::any_of(
      kNamesOfLlvm, [](const char* name) { return dlsym(RTLD_DEFAULT, name) != nullptr; });
  // Stays loaded: EGL loads it later, and by then all its libraries are bound.
  return llvm && dlopen("libEGL_mesa.so.0", RTLD_LAZY | RTLD_LOCAL | RTLD_DEEPBIND) != nullptr;
#endif
}

}  // namespace

void keep_mesa_to_its_llvm() { [[maybe_unused]] static const bool kDone = load_mesa(); }

}  // namespace enfilade::render::gl
