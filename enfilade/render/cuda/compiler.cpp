#include "enfilade/render/cuda/compiler.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/render/cuda/driver.h"

namespace enfilade::render::cuda {

using Program = struct ProgramOfNvrtc*;

// NOLINTBEGIN(readability-identifier-naming): as NVRTC's reference names them
struct Compiler::Functions {
  Library library;
  Function<int(int* major, int* minor)> Version{library, "nvrtcVersion"};
  Function<const char*(int)> GetErrorString{library, "nvrtcGetErrorString"};
  Function<int(int* count)> GetNumSupportedArchs{library, "nvrtcGetNumSupportedArchs"};
  Function<int(int* archs)> GetSupportedArchs{library, "nvrtcGetSupportedArchs"};
  Function<int(Program*, const char* source, const char* name, int headers,
               const char* const* header_texts, const char* const* header_names)>
      CreateProgram{library, "nvrtcCreateProgram"};
  Function<int(Program*)> DestroyProgram{library, "nvrtcDestroyProgram"};
  Function<int(Program, int count, const char* const* options)> CompileProgram{
      library, "nvrtcCompileProgram"};
  Function<int(Program, std::size_t*)> GetProgramLogSize{library, "nvrtcGetProgramLogSize"};
  Function<int(Program, char*)> GetProgramLog{library, "nvrtcGetProgramLog"};
  Function<int(Program, std::size_t*)> GetCUBINSize{library, "nvrtcGetCUBINSize"};
  Function<int(Program, char*)> GetCUBIN{library, "nvrtcGetCUBIN"};
};
// NOLINTEND(readability-identifier-naming)

namespace {

constexpr std::array<const char*, 3> kLibraries{"libnvrtc.so.13", "libnvrtc.so.12",
                                                "libnvrtc.so.11.2"};
constexpr const char* kHowToGet =
    "install it (Debian and Ubuntu with NVIDIA's packages: libnvrtc; PyPI: "
    "nvidia-cuda-nvrtc-cu12), "
    "or name the file libnvrtc.so.* in ENFILADE_NVRTC";

std::filesystem::path variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): never set here
  return value == nullptr ? "" : value;
}

// The library opens libnvrtc-builtins by its name alone, wherever it lies itself; loaded before,
// from the same folder, it is found.
void* open_with_builtins(const std::filesystem::path& file) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(file.parent_path(), ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("libnvrtc-builtins.so.")) {
      dlopen(entry.path().c_str(), RTLD_NOW | RTLD_GLOBAL);
    }
  }
  return dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
}

void* open_library() {
  for (const char* name : kLibraries) {
    if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD)) return library;
  }
  const std::filesystem::path named = variable("ENFILADE_NVRTC");
  if (!named.empty()) {
    if (void* library = open_with_builtins(named)) return library;
    const char* why = dlerror();
    throw Error(fmt::format("CUDA: ENFILADE_NVRTC is {}, which cannot be loaded: {}",
                            named.string(), why == nullptr ? "no reason given" : why));
  }
  for (const char* name : kLibraries) {
    if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return library;
  }
  for (const char* name : kLibraries) {
    const std::filesystem::path file = std::filesystem::path("/usr/local/cuda/lib64") / name;
    if (void* library = open_with_builtins(file)) return library;
  }
  throw Error(fmt::format("CUDA: no runtime compiler, NVRTC, was found (looked for {}): {}",
                          fmt::join(kLibraries, ", "), kHowToGet));
}

}  // namespace

Compiler::Compiler()
    : functions_([]() -> const Functions& {
        static const Functions kLoaded{
            {open_library(), "CUDA: NVRTC has no {}: version 11.2 or later is wanted"}};
        return kLoaded;
      }()) {
  int major = 0, minor = 0, count = 0;
  if (functions_.Version(&major, &minor) != 0 || functions_.GetNumSupportedArchs(&count) != 0) {
    throw Error("CUDA: NVRTC does not tell its version");
  }
  version_ = fmt::format("{}.{}", major, minor);
  capabilities_.resize(static_cast<std::size_t>(count));
  functions_.GetSupportedArchs(capabilities_.data());
  std::ranges::sort(capabilities_);
}

Compiler::Compiled Compiler::compile(const KernelSource& source, int capability) const {
  if (std::ranges::find(capabilities_, capability) == capabilities_.end()) {
    throw Error(
        fmt::format("CUDA: NVRTC {} does not compile for cards of compute capability "
                    "{}.{} (it does for {}): another version of it is wanted",
                    version_, capability / 10, capability % 10, fmt::join(capabilities_, ", ")));
  }
  std::vector<std::string> options{fmt::format("--gpu-architecture=sm_{}", capability),
                                   "--std=c++17",
                                   "--fmad=false",  // bits as on the CPU: detail/pixels.h
                                   "--ptxas-options=-v", "--disable-warnings"};
  for (const std::string& definition : source.definitions) {
    options.push_back(fmt::format("-D{}", definition));
  }
  std::vector<const char*> words;
  for (const std::string& option : options) words.push_back(option.c_str());

  Program program = nullptr;
  const std::string text(kKernels);
  const auto check = [&](int result, const char* doing) {
    if (result == 0) return;
    std::string log;
    std::size_t bytes = 0;
    if (program != nullptr && functions_.GetProgramLogSize(program, &bytes) == 0) {
      log.resize(bytes);
      functions_.GetProgramLog(program, log.data());
    }
    if (program != nullptr) functions_.DestroyProgram(&program);
    throw Error(fmt::format("CUDA: NVRTC {}, {}: {}\n{}", version_, doing,
                            functions_.GetErrorString(result), log.c_str()));
  };
  check(functions_.CreateProgram(&program, text.c_str(), "kernels.cu", 0, nullptr, nullptr),
        "making a program");
  check(functions_.CompileProgram(program, static_cast<int>(words.size()), words.data()),
        "compiling");
  Compiled compiled;
  std::size_t bytes = 0;
  check(functions_.GetProgramLogSize(program, &bytes), "reading its log");
  compiled.log.resize(bytes);
  check(functions_.GetProgramLog(program, compiled.log.data()), "reading its log");
  check(functions_.GetCUBINSize(program, &bytes), "reading machine code");
  compiled.image.resize(bytes);
  check(functions_.GetCUBIN(program, compiled.image.data()), "reading machine code");
  functions_.DestroyProgram(&program);
  return compiled;
}

Images::Images() {
  const std::filesystem::path cache = variable("XDG_CACHE_HOME"), home = variable("HOME");
  if (!cache.empty()) {
    folder_ = cache / "enfilade" / "cuda";
  } else if (!home.empty()) {
    folder_ = home / ".cache" / "enfilade" / "cuda";
  }
}

std::string Images::find_or_compile(const KernelSource& source, int capability) const {
  const std::string all =
      fmt::format("{} {} {}", kKernels, fmt::join(source.definitions, " "), capability);
  const auto hash = XXH3_128bits(all.data(), all.size());
  const std::string name = fmt::format("{:016x}{:016x}.cubin", hash.high64, hash.low64);
  const std::filesystem::path file = folder_ / name;
  if (!folder_.empty()) {
    try {
      if (file_exists(file)) return read_file(file);
    } catch (const FileError&) {  // compiled anew
    }
  }
  std::string image = Compiler().compile(source, capability).image;
  if (!folder_.empty()) {
    try {
      OutputFolder(folder_).write(name, image);
    } catch (const FileError&) {  // the next process compiles, too
    }
  }
  return image;
}

}  // namespace enfilade::render::cuda
