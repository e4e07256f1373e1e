#include "enfilade/render/cuda/driver.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <array>
#include <optional>

#include "enfilade/core/errors.h"

namespace enfilade::render::cuda {
namespace {

constexpr Result kSuccess = 0, kInvalidValue = 1, kNoDevice = 100;
// CUdevice_attribute, CUpointer_attribute, CUmemorytype, CUstream_flags, CUevent_flags.
constexpr int kCapabilityMajor = 75, kCapabilityMinor = 76;
constexpr int kMemoryType = 2, kDeviceOrdinal = 9;
constexpr unsigned kMemoryOfDevice = 2;
constexpr int kRelaxed = 2;  // CUstreamCaptureMode
constexpr unsigned kNonBlocking = 1, kNoTiming = 2, kPortable = 1;

// The driver's functions, or why there are none.
struct Loaded {
  Api api{};
  std::string error;
};

Loaded load() {
  Loaded loaded;
  void* library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    loaded.error = "no libcuda.so.1, which comes with the driver of an NVIDIA card";
    return loaded;
  }
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    if (function == nullptr && loaded.error.empty()) {
      loaded.error = fmt::format("libcuda.so.1 has no {}: the driver is too old", name);
    }
  };
  Api& a = loaded.api;
  find(a.Init, "cuInit");
  find(a.DriverGetVersion, "cuDriverGetVersion");
  find(a.GetErrorName, "cuGetErrorName");
  find(a.GetErrorString, "cuGetErrorString");
  find(a.DeviceGetCount, "cuDeviceGetCount");
  find(a.DeviceGet, "cuDeviceGet");
  find(a.DeviceGetName, "cuDeviceGetName");
  find(a.DeviceGetAttribute, "cuDeviceGetAttribute");
  find(a.DeviceTotalMem, "cuDeviceTotalMem_v2");
  find(a.DevicePrimaryCtxRetain, "cuDevicePrimaryCtxRetain");
  find(a.DevicePrimaryCtxRelease, "cuDevicePrimaryCtxRelease_v2");
  find(a.CtxPushCurrent, "cuCtxPushCurrent_v2");
  find(a.CtxPopCurrent, "cuCtxPopCurrent_v2");
  find(a.MemGetInfo, "cuMemGetInfo_v2");
  find(a.ModuleLoadData, "cuModuleLoadData");
  find(a.ModuleUnload, "cuModuleUnload");
  find(a.ModuleGetFunction, "cuModuleGetFunction");
  find(a.FuncGetAttribute, "cuFuncGetAttribute");
  find(a.LaunchKernel, "cuLaunchKernel");
  find(a.MemAlloc, "cuMemAlloc_v2");
  find(a.MemFree, "cuMemFree_v2");
  find(a.MemHostAlloc, "cuMemHostAlloc");
  find(a.MemFreeHost, "cuMemFreeHost");
  find(a.MemcpyHtoDAsync, "cuMemcpyHtoDAsync_v2");
  find(a.MemcpyDtoHAsync, "cuMemcpyDtoHAsync_v2");
  find(a.MemsetD32Async, "cuMemsetD32Async");
  find(a.StreamCreate, "cuStreamCreate");
  find(a.StreamDestroy, "cuStreamDestroy_v2");
  find(a.StreamSynchronize, "cuStreamSynchronize");
  find(a.StreamWaitEvent, "cuStreamWaitEvent");
  find(a.StreamIsCapturing, "cuStreamIsCapturing");
  find(a.ThreadExchangeStreamCaptureMode, "cuThreadExchangeStreamCaptureMode");
  find(a.EventCreate, "cuEventCreate");
  find(a.EventDestroy, "cuEventDestroy_v2");
  find(a.EventRecord, "cuEventRecord");
  find(a.EventSynchronize, "cuEventSynchronize");
  find(a.EventElapsedTime, "cuEventElapsedTime");
  find(a.PointerGetAttribute, "cuPointerGetAttribute");
  if (!loaded.error.empty()) return loaded;
  const Result result = a.Init(0);
  if (result == kNoDevice) {
    loaded.error = "the driver finds no card";
  } else if (result != kSuccess) {
    const char* text = nullptr;
    if (a.GetErrorString(result, &text) != kSuccess || text == nullptr) text = "unknown error";
    loaded.error = fmt::format("cuInit: {} ({})", text, result);
  }
  return loaded;
}

}  // namespace

const Api& api() {
  static const Loaded kLoaded = load();
  if (!kLoaded.error.empty()) throw Error(fmt::format("CUDA: {}", kLoaded.error));
  return kLoaded.api;
}

void check(Result result, std::string_view doing) {
  if (result == kSuccess) return;
  const char *name = nullptr, *text = nullptr;
  if (api().GetErrorName(result, &name) != kSuccess || name == nullptr) name = "unknown";
  if (api().GetErrorString(result, &text) != kSuccess || text == nullptr) text = "unknown error";
  throw Error(fmt::format("CUDA: {}: {} ({}, {})", doing, text, name, result));
}

Device::Device(int ordinal) : ordinal_(ordinal) {
  int count = 0;
  check(api().DeviceGetCount(&count), "counting cards");
  if (ordinal < 0 || ordinal >= count) {
    throw ArgumentError(
        fmt::format("config.cuda_device: {}, but there {} {} card{} of CUDA, "
                    "counted from 0",
                    ordinal, count == 1 ? "is" : "are", count, count == 1 ? "" : "s"));
  }
  check(api().DeviceGet(&number_, ordinal), "finding a card");
  std::array<char, 256> name{};
  check(api().DeviceGetName(name.data(), static_cast<int>(name.size()) - 1, number_),
        "asking a card's name");
  name_ = name.data();
  int major = 0, minor = 0;
  check(api().DeviceGetAttribute(&major, kCapabilityMajor, number_), "asking about a card");
  check(api().DeviceGetAttribute(&minor, kCapabilityMinor, number_), "asking about a card");
  capability_ = 10 * major + minor;
  check(api().DevicePrimaryCtxRetain(&context_, number_), "making a context");
}

Device::~Device() { api().DevicePrimaryCtxRelease(number_); }

Current::Current(const Device& device) {
  check(api().CtxPushCurrent(device.context()), "taking the context");
}

Current::~Current() {
  ContextHandle context = nullptr;
  api().CtxPopCurrent(&context);
}

RelaxedCapture::RelaxedCapture() : mode_(kRelaxed) {
  check(api().ThreadExchangeStreamCaptureMode(&mode_), "changing the mode of capturing");
}

RelaxedCapture::~RelaxedCapture() { api().ThreadExchangeStreamCaptureMode(&mode_); }

Stream make_stream() {
  StreamHandle stream = nullptr;
  check(api().StreamCreate(&stream, kNonBlocking), "making a stream");
  return Stream(stream);
}

Event make_event() {
  EventHandle event = nullptr;
  check(api().EventCreate(&event, kNoTiming), "making an event");
  return Event(event);
}

Memory allocate(std::size_t bytes) {
  DevicePointer memory = 0;
  check(api().MemAlloc(&memory, bytes), fmt::format("allocating {} bytes of the card", bytes));
  return Memory(memory);
}

PinnedMemory allocate_pinned(std::size_t bytes) {
  void* memory = nullptr;
  check(api().MemHostAlloc(&memory, bytes, kPortable),
        fmt::format("allocating {} pinned bytes", bytes));
  return PinnedMemory(memory);
}

Side side_of(const void* memory, const Device& device, std::string_view what) {
  const auto address = reinterpret_cast<DevicePointer>(memory);
  unsigned type = 0;
  const Result result = api().PointerGetAttribute(&type, kMemoryType, address);
  if (result == kInvalidValue) return Side::kHost;  // memory that CUDA does not know
  check(result, "asking about memory");
  if (type != kMemoryOfDevice) return Side::kHost;
  int ordinal = -1;
  check(api().PointerGetAttribute(&ordinal, kDeviceOrdinal, address), "asking about memory");
  if (ordinal != device.ordinal()) {
    throw ArgumentError(fmt::format("outputs.{}: memory of card {}, but card {} draws", what,
                                    ordinal, device.ordinal()));
  }
  return Side::kCard;
}

}  // namespace enfilade::render::cuda
