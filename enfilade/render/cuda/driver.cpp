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

// The driver's functions, initialised.
Api load() {
  void* library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    throw Error("no libcuda.so.1, which comes with the driver of an NVIDIA card");
  }
  Api a{{library, "libcuda.so.1 has no {}: the driver is too old"}};
  const Result result = a.Init(0);
  if (result == kNoDevice) throw Error("the driver finds no card");
  if (result != kSuccess) {
    const char* text = nullptr;
    if (a.GetErrorString(result, &text) != kSuccess || text == nullptr) text = "unknown error";
    throw Error(fmt::format("cuInit: {} ({})", text, result));
  }
  return a;
}

// The driver's functions, or why there are none.
struct Loaded {
  std::optional<Api> api;
  std::string error;

  Loaded() {
    try {
      api = load();
    } catch (const Error& missing) {
      error = missing.what();
    }
  }
};

}  // namespace

void* Library::find(const char* name) const {
  if (void* found = dlsym(handle, name)) return found;
  throw Error(fmt::format(fmt::runtime(lacks), name));
}

const Api& api() {
  static const Loaded kLoaded;
  if (!kLoaded.api) throw Error(fmt::format("CUDA: {}", kLoaded.error));
  return *kLoaded.api;
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

CurrentDevice::CurrentDevice(const Device& device) {
  check(api().CtxPushCurrent(device.context()), "taking the context");
}

CurrentDevice::~CurrentDevice() {
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

MemorySide side_of(const void* memory, const Device& device, std::string_view what) {
  const auto address = reinterpret_cast<DevicePointer>(memory);
  unsigned type = 0;
  const Result result = api().PointerGetAttribute(&type, kMemoryType, address);
  if (result == kInvalidValue) return MemorySide::kHost;  // memory that CUDA does not know
  check(result, "asking about memory");
  if (type != kMemoryOfDevice) return MemorySide::kHost;
  int ordinal = -1;
  check(api().PointerGetAttribute(&ordinal, kDeviceOrdinal, address), "asking about memory");
  if (ordinal != device.ordinal()) {
    throw ArgumentError(fmt::format("outputs.{}: memory of card {}, but card {} draws", what,
                                    ordinal, device.ordinal()));
  }
  return MemorySide::kCard;
}

}  // namespace enfilade::render::cuda
