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

/// A library that is loaded at run time.
struct Library {
  void* handle = nullptr;
  const char* lacks = nullptr;  ///< message if it lacks a function; {}: the function's name

  /// \throws Error with that message
  void* find(const char* name) const;
};

/// A function of such a library, found by its name when it is made. \throws as Library::find()
template <class Signature>
class Function;
template <class Value, class... Arguments>
class Function<Value(Arguments...)> {
 public:
  Function(const Library& library, const char* name)
      : found_(reinterpret_cast<Value (*)(Arguments...)>(library.find(name))) {}
  Value operator()(Arguments... arguments) const { return found_(arguments...); }

 private:
  Value (*found_)(Arguments...);
};

/// Functions of libcuda.so.1, by their names without "cu".
// NOLINTBEGIN(readability-identifier-naming): as CUDA's reference names them
struct Api {
  Library library;
  Function<Result(unsigned flags)> Init{library, "cuInit"};
  Function<Result(int* version)> DriverGetVersion{library, "cuDriverGetVersion"};
  Function<Result(Result, const char** name)> GetErrorName{library, "cuGetErrorName"};
  Function<Result(Result, const char** text)> GetErrorString{library, "cuGetErrorString"};
  Function<Result(int* count)> DeviceGetCount{library, "cuDeviceGetCount"};
  Function<Result(DeviceNumber*, int ordinal)> DeviceGet{library, "cuDeviceGet"};
  Function<Result(char* name, int size, DeviceNumber)> DeviceGetName{library, "cuDeviceGetName"};
  Function<Result(int* value, int attribute, DeviceNumber)> DeviceGetAttribute{
      library, "cuDeviceGetAttribute"};
  Function<Result(ContextHandle*, DeviceNumber)> DevicePrimaryCtxRetain{library,
                                                                        "cuDevicePrimaryCtxRetain"};
  Function<Result(DeviceNumber)> DevicePrimaryCtxRelease{library, "cuDevicePrimaryCtxRelease_v2"};
  Function<Result(ContextHandle)> CtxPushCurrent{library, "cuCtxPushCurrent_v2"};
  Function<Result(ContextHandle*)> CtxPopCurrent{library, "cuCtxPopCurrent_v2"};
  Function<Result(std::size_t* free, std::size_t* total)> MemGetInfo{library, "cuMemGetInfo_v2"};
  Function<Result(ModuleHandle*, const void* image)> ModuleLoadData{library, "cuModuleLoadData"};
  Function<Result(ModuleHandle)> ModuleUnload{library, "cuModuleUnload"};
  Function<Result(FunctionHandle*, ModuleHandle, const char* name)> ModuleGetFunction{
      library, "cuModuleGetFunction"};
  Function<Result(FunctionHandle, unsigned grid_x, unsigned grid_y, unsigned grid_z,
                  unsigned block_x, unsigned block_y, unsigned block_z, unsigned shared,
                  StreamHandle, void** parameters, void** extra)>
      LaunchKernel{library, "cuLaunchKernel"};
  Function<Result(DevicePointer*, std::size_t bytes)> MemAlloc{library, "cuMemAlloc_v2"};
  Function<Result(DevicePointer)> MemFree{library, "cuMemFree_v2"};
  Function<Result(void**, std::size_t bytes, unsigned flags)> MemHostAlloc{library,
                                                                           "cuMemHostAlloc"};
  Function<Result(void*)> MemFreeHost{library, "cuMemFreeHost"};
  Function<Result(DevicePointer to, const void* from, std::size_t bytes, StreamHandle)>
      MemcpyHtoDAsync{library, "cuMemcpyHtoDAsync_v2"};
  Function<Result(void* to, DevicePointer from, std::size_t bytes, StreamHandle)> MemcpyDtoHAsync{
      library, "cuMemcpyDtoHAsync_v2"};
  Function<Result(DevicePointer, unsigned value, std::size_t words, StreamHandle)> MemsetD32Async{
      library, "cuMemsetD32Async"};
  Function<Result(StreamHandle*, unsigned flags)> StreamCreate{library, "cuStreamCreate"};
  Function<Result(StreamHandle)> StreamDestroy{library, "cuStreamDestroy_v2"};
  Function<Result(StreamHandle)> StreamSynchronize{library, "cuStreamSynchronize"};
  Function<Result(StreamHandle, EventHandle, unsigned flags)> StreamWaitEvent{library,
                                                                              "cuStreamWaitEvent"};
  Function<Result(StreamHandle, int* status)> StreamIsCapturing{library, "cuStreamIsCapturing"};
  Function<Result(int* mode)> ThreadExchangeStreamCaptureMode{library,
                                                              "cuThreadExchangeStreamCaptureMode"};
  Function<Result(EventHandle*, unsigned flags)> EventCreate{library, "cuEventCreate"};
  Function<Result(EventHandle)> EventDestroy{library, "cuEventDestroy_v2"};
  Function<Result(EventHandle, StreamHandle)> EventRecord{library, "cuEventRecord"};
  Function<Result(EventHandle)> EventSynchronize{library, "cuEventSynchronize"};
  Function<Result(float* milliseconds, EventHandle from, EventHandle to)> EventElapsedTime{
      library, "cuEventElapsedTime"};
  Function<Result(void* value, int attribute, DevicePointer)> PointerGetAttribute{
      library, "cuPointerGetAttribute"};
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
class CurrentDevice {
 public:
  explicit CurrentDevice(const Device& device);
  ~CurrentDevice();
  CurrentDevice(const CurrentDevice&) = delete;
  CurrentDevice& operator=(const CurrentDevice&) = delete;
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
enum class MemorySide : std::uint8_t { kHost, kCard };
/// \throws ArgumentError for memory of another card than `device`
MemorySide side_of(const void* memory, const Device& device, std::string_view what);

}  // namespace enfilade::render::cuda
