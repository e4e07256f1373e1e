/// \file  The part of CUDA's driver API that the renderer needs, loaded at its first use. No build
/// needs CUDA's headers; without a card, an Error reports it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace enfilade::render::cuda {

// Handles and numbers of CUDA's binary interface (CUDA Driver API reference, 12 and 13).
using Result = int;
using DeviceNumber = int;
using DevicePointer = std::uint64_t;
using ContextHandle = struct ContextOfCuda*;
using ModuleHandle = struct ModuleOfCuda*;
using FunctionHandle = struct FunctionOfCuda*;
using StreamHandle = struct StreamOfCuda*;
using EventHandle = struct EventOfCuda*;

/// Functions of libcuda.so.1, by their names without "cu".
// NOLINTBEGIN(readability-identifier-naming): as CUDA's reference names them
struct Api {
  Result (*Init)(unsigned flags);
  Result (*DriverGetVersion)(int* version);
  Result (*GetErrorName)(Result, const char** name);
  Result (*GetErrorString)(Result, const char** text);
  Result (*DeviceGetCount)(int* count);
  Result (*DeviceGet)(DeviceNumber*, int ordinal);
  Result (*DeviceGetName)(char* name, int size, DeviceNumber);
  Result (*DeviceGetAttribute)(int* value, int attribute, DeviceNumber);
  Result (*DeviceTotalMem)(std::size_t* bytes, DeviceNumber);
  Result (*DevicePrimaryCtxRetain)(ContextHandle*, DeviceNumber);
  Result (*DevicePrimaryCtxRelease)(DeviceNumber);
  Result (*CtxPushCurrent)(ContextHandle);
  Result (*CtxPopCurrent)(ContextHandle*);
  Result (*MemGetInfo)(std::size_t* free, std::size_t* total);
  Result (*ModuleLoadData)(ModuleHandle*, const void* image);
  Result (*ModuleUnload)(ModuleHandle);
  Result (*ModuleGetFunction)(FunctionHandle*, ModuleHandle, const char* name);
  Result (*FuncGetAttribute)(int* value, int attribute, FunctionHandle);
  Result (*LaunchKernel)(FunctionHandle, unsigned grid_x, unsigned grid_y, unsigned grid_z,
                         unsigned block_x, unsigned block_y, unsigned block_z, unsigned shared,
                         StreamHandle, void** parameters, void** extra);
  Result (*MemAlloc)(DevicePointer*, std::size_t bytes);
  Result (*MemFree)(DevicePointer);
  Result (*MemHostAlloc)(void**, std::size_t bytes, unsigned flags);
  Result (*MemFreeHost)(void*);
  Result (*MemcpyHtoDAsync)(DevicePointer to, const void* from, std::size_t bytes, StreamHandle);
  Result (*MemcpyDtoHAsync)(void* to, DevicePointer from, std::size_t bytes, StreamHandle);
  Result (*MemsetD32Async)(DevicePointer, unsigned value, std::size_t words, StreamHandle);
  Result (*StreamCreate)(StreamHandle*, unsigned flags);
  Result (*StreamDestroy)(StreamHandle);
  Result (*StreamSynchronize)(StreamHandle);
  Result (*StreamWaitEvent)(StreamHandle, EventHandle, unsigned flags);
  Result (*StreamIsCapturing)(StreamHandle, int* status);
  Result (*ThreadExchangeStreamCaptureMode)(int* mode);
  Result (*EventCreate)(EventHandle*, unsigned flags);
  Result (*EventDestroy)(EventHandle);
  Result (*EventRecord)(EventHandle, StreamHandle);
  Result (*EventSynchronize)(EventHandle);
  Result (*EventElapsedTime)(float* milliseconds, EventHandle from, EventHandle to);
  Result (*PointerGetAttribute)(void* value, int attribute, DevicePointer);
};
// NOLINTEND(readability-identifier-naming)

/// The driver's functions, initialised.
/// \throws Error naming what is missing: the library, one of its functions, or a card
const Api& api();

/// \throws Error "CUDA: DOING: TEXT (NAME)" unless the result is success
void check(Result result, std::string_view doing);

/// A card. Its primary context is shared with all others of the process, such as PyTorch.
class Device {
 public:
  /// \throws ArgumentError for a number that no card has; Error with CUDA's words
  explicit Device(int ordinal);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  int ordinal() const noexcept { return ordinal_; }
  const std::string& name() const noexcept { return name_; }
  /// Compute capability: 90 for 9.0.
  int capability() const noexcept { return capability_; }
  ContextHandle context() const noexcept { return context_; }

 private:
  int ordinal_, capability_ = 0;
  DeviceNumber number_ = 0;
  ContextHandle context_ = nullptr;
  std::string name_;
};

/// The device's context is the thread's while this lives.
class Current {
 public:
  explicit Current(const Device& device);
  ~Current();
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;
};

/// While this lives, the thread may allocate although a stream of it is captured; the allocations
/// are not part of the graph.
class RelaxedCapture {
 public:
  RelaxedCapture();
  ~RelaxedCapture();
  RelaxedCapture(const RelaxedCapture&) = delete;
  RelaxedCapture& operator=(const RelaxedCapture&) = delete;

 private:
  int mode_;
};

/// Something of CUDA's that one call makes and another one ends, while its context is current.
template <class Handle, auto End>
class Owned {
 public:
  Owned() = default;
  explicit Owned(Handle handle) : handle_(handle) {}
  ~Owned() { reset(); }
  Owned(Owned&& other) noexcept : handle_(std::exchange(other.handle_, Handle{})) {}
  Owned& operator=(Owned&& other) noexcept {
    if (this != &other) {
      reset();
      handle_ = std::exchange(other.handle_, Handle{});
    }
    return *this;
  }
  void reset() noexcept {
    if (handle_ != Handle{}) (api().*End)(handle_);
    handle_ = Handle{};
  }
  Handle get() const noexcept { return handle_; }

 private:
  Handle handle_{};
};
using Module = Owned<ModuleHandle, &Api::ModuleUnload>;
using Stream = Owned<StreamHandle, &Api::StreamDestroy>;
using Event = Owned<EventHandle, &Api::EventDestroy>;
using Memory = Owned<DevicePointer, &Api::MemFree>;
using PinnedMemory = Owned<void*, &Api::MemFreeHost>;

Stream make_stream();
Event make_event();  ///< without timing
/// \throws Error naming the bytes if the card has no room
Memory allocate(std::size_t bytes);
/// Memory of the host, mapped so that copies need no detour.
PinnedMemory allocate_pinned(std::size_t bytes);

/// Where memory is.
enum class Side : std::uint8_t { kHost, kCard };
/// \throws ArgumentError for memory of another card than `device`
Side side_of(const void* memory, const Device& device, std::string_view what);

}  // namespace enfilade::render::cuda
