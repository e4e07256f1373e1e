#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/render/cpu/pack.h"
#include "enfilade/render/cuda/compiler.h"
#include "enfilade/render/cuda/driver.h"
#include "enfilade/render/cuda/job.h"
#include "enfilade/render/cuda/panoramas.h"
#include "enfilade/render/detail/batch.h"
#include "enfilade/render/detail/layers.h"

namespace enfilade::render::cuda {
namespace {

using scan::Layer;

// Views of one launch: while the card draws them, the host prepares the next ones.
constexpr std::size_t kMostViews = 1024;
// Launches whose views may be on their way at the same time.
constexpr std::size_t kSlots = 4;
// Pictures for the host's memory are drawn into so much of the card's at a time.
constexpr std::size_t kStagingBytes = std::size_t{256} << 20U;

int ordinal_of(const std::string& device) {
  if (device.empty()) return 0;
  int ordinal = 0;
  const char* end = device.data() + device.size();
  const auto [stop, code] = std::from_chars(device.data(), end, ordinal);
  if (code != std::errc() || stop != end) {
    throw ArgumentError(
        fmt::format("config.cuda_device: {:?}, not a card's number, counted from 0", device));
  }
  return ordinal;
}

// Calls each(name, memory) for the outputs that there are; memory is a span.
template <class Each>
void each_output(Outputs& outputs, const Each& each) {
  if (outputs.colour) each("colour", outputs.colour->pixels);
  if (outputs.depth) each("depth", outputs.depth->pixels);
  if (outputs.classes) each("classes", outputs.classes->pixels);
  if (outputs.instances) each("instances", outputs.instances->pixels);
}

/// The views of a launch, on both sides.
struct Slot {
  PinnedMemory pinned;
  Memory views;
  Event done;
  bool busy = false;

  DeviceView* host() const { return static_cast<DeviceView*>(pinned.get()); }
};

Slot make_slot() {
  constexpr std::size_t kBytes = kMostViews * sizeof(DeviceView);
  return {allocate_pinned(kBytes), allocate(kBytes), make_event()};
}

// Made and ended while the context is current.
class State {
 public:
  State(std::shared_ptr<FaceCache> faces, const RendererConfig& config, const Device& device);
  void render(const Camera& camera, std::span<const View> views, const Outputs& outputs);

 private:
  /// All of a call, fixed while it runs.
  struct Frame {
    const Camera& camera;
    Kinds kinds;
    StreamHandle stream;
    bool captured;
    DevicePointer depth_factors;
  };

  FunctionHandle kernel(const Kinds& kinds);
  DevicePointer depth_factors(const Camera& camera, DepthMeasure measure, bool captured);
  void draw(const Frame& frame, std::span<const View> views, const Outputs& outputs);
  void draw_by_way_of_card(const Frame& frame, std::span<const View> views, const Outputs& outputs,
                           const std::array<bool, scan::kLayers>& on_host);
  std::size_t draw_some(const Frame& frame, std::span<const View> views, const Outputs& outputs,
                        Slot& slot);
  void launch(const Frame& frame, const Kinds& kinds, const Outputs& outputs, const Slot& slot,
              std::size_t count);
  Slot& take_slot(bool captured);

  std::shared_ptr<FaceCache> faces_;
  Legacy legacy_;
  const Device& device_;
  Images images_;
  struct Loaded {
    Module module;
    FunctionHandle draw = nullptr;
  };
  std::map<Kinds, Loaded> kernels_;
  Stream stream_;
  Event drawn_;  // by the last call
  StreamHandle last_stream_ = nullptr;
  bool has_drawn_ = false;
  std::array<Slot, kSlots> slots_;
  std::size_t next_slot_ = 0;
  std::vector<std::unique_ptr<Slot>> captured_slots_;  // belong to graphs: never used again
  std::optional<std::pair<Camera, DepthMeasure>> depth_factors_of_;
  Memory depth_factors_;
  Memory staging_;
  std::size_t staging_bytes_ = 0;
  std::optional<Panoramas> panoramas_;
};

State::State(std::shared_ptr<FaceCache> faces, const RendererConfig& config, const Device& device)
    : faces_(std::move(faces)),
      legacy_(config.legacy),
      device_(device),
      stream_(make_stream()),
      drawn_(make_event()) {
  for (Slot& slot : slots_) slot = make_slot();
  const Kinds first{.colour = kRgb, .clamped = legacy_.clamped_edges};
  kernel(first);
  FunctionHandle unpack = nullptr;
  check(api().ModuleGetFunction(&unpack, kernels_.at(first).module.get(), "unpack"),
        "finding a kernel");
  std::size_t bytes = config.cuda_bytes;
  if (bytes == 0) {
    std::size_t free = 0, total = 0;
    check(api().MemGetInfo(&free, &total), "asking for free memory");
    bytes = free / 2;
  }
  panoramas_.emplace(faces_, bytes, unpack);
}

FunctionHandle State::kernel(const Kinds& kinds) {
  const auto found = kernels_.find(kinds);
  if (found != kernels_.end()) return found->second.draw;
  const std::string image = images_.find_or_compile({kinds.definitions()}, device_.capability());
  Loaded loaded;
  ModuleHandle module = nullptr;
  check(api().ModuleLoadData(&module, image.data()), "loading kernels");
  loaded.module = Module(module);
  check(api().ModuleGetFunction(&loaded.draw, module, "draw"), "finding a kernel");
  return kernels_.emplace(kinds, std::move(loaded)).first->second.draw;
}

// What a ray's length is multiplied with, for each pixel.
DevicePointer State::depth_factors(const Camera& camera, DepthMeasure measure, bool captured) {
  const std::pair wanted{camera, measure};
  if (depth_factors_of_ == wanted) return depth_factors_.get();
  if (captured) {
    throw ArgumentError("camera: render depth with it once before the stream is captured");
  }
  const std::vector<float> factors = cpu::depth_factors(camera, measure);
  const std::size_t bytes = factors.size() * sizeof(float);
  depth_factors_of_.reset();
  depth_factors_ = allocate(bytes);
  check(api().MemcpyHtoDAsync(depth_factors_.get(), factors.data(), bytes, stream_.get()),
        "uploading lengths of rays");
  check(api().StreamSynchronize(stream_.get()), "uploading lengths of rays");
  depth_factors_of_ = wanted;
  return depth_factors_.get();
}

void State::render(const Camera& camera, std::span<const View> views, const Outputs& outputs) {
  Outputs places = outputs;
  std::array<bool, scan::kLayers> on_host{};
  bool some_on_host = false, some_on_card = false;
  std::size_t k = 0;
  each_output(places, [&](const char* name, const auto& memory) {
    on_host[k] = side_of(memory.data(), device_, name) == MemorySide::kHost;
    (on_host[k] ? some_on_host : some_on_card) = true;
    ++k;
  });
  const auto* wanted = outputs.stream ? &*outputs.stream : nullptr;
  const auto stream = wanted != nullptr ? static_cast<StreamHandle>(wanted->handle) : stream_.get();
  int capturing = 0;
  if (wanted != nullptr) {
    check(api().StreamIsCapturing(stream, &capturing), "asking about the stream");
  }
  const bool captured = capturing != 0;
  std::optional<RelaxedCapture> relaxed;
  if (captured) relaxed.emplace();
  if (captured && some_on_host) {
    throw ArgumentError("outputs: memory of the host, but a captured stream draws into the card's");
  }
  if (wanted == nullptr && some_on_card) {
    // What the caller did with the memory before, in the stream that everybody has.
    check(api().StreamSynchronize(nullptr), "waiting for the default stream");
  }
  // The panoramas' memory goes from one to another in the order of calls, not of streams.
  if (has_drawn_ && last_stream_ != stream && !captured) {
    check(api().StreamWaitEvent(stream, drawn_.get(), 0), "waiting for the last pictures");
  }
  Frame frame{camera, kinds_of(outputs, legacy_), stream, captured, 0};
  if (outputs.depth) {
    frame.depth_factors = depth_factors(camera, outputs.depth->measure, captured);
  }
  if (some_on_host) {
    draw_by_way_of_card(frame, views, outputs, on_host);
  } else {
    draw(frame, views, outputs);
  }
  if (captured) return;
  check(api().EventRecord(drawn_.get(), stream), "recording an event");
  has_drawn_ = true;
  last_stream_ = stream;
  if (wanted == nullptr || some_on_host) {
    check(api().StreamSynchronize(stream), "drawing");
  }
}

void State::draw_by_way_of_card(const Frame& frame, std::span<const View> views,
                                const Outputs& outputs,
                                const std::array<bool, scan::kLayers>& on_host) {
  // Each output's part of the staging begins at a multiple of this.
  constexpr std::size_t kAlignment = 256;
  const auto rounded_up = [](std::size_t bytes) {
    return (bytes + kAlignment - 1) / kAlignment * kAlignment;
  };
  std::size_t view_bytes = 0;
  Outputs all = outputs;
  each_output(all, [&](const char*, const auto& memory) {
    view_bytes += memory.size_bytes() / views.size();
  });
  const std::size_t most =
      std::clamp<std::size_t>(kStagingBytes / view_bytes, 1, std::min(views.size(), kMostViews));
  const std::size_t bytes = most * view_bytes + scan::kLayers * kAlignment;
  if (staging_bytes_ < bytes) {
    staging_bytes_ = 0;
    staging_.reset();
    staging_ = allocate(bytes);
    staging_bytes_ = bytes;
  }
  struct Copy {
    void* to;
    DevicePointer from;
    std::size_t bytes;
  };
  for (std::size_t first = 0; first < views.size(); first += most) {
    const std::size_t count = std::min(most, views.size() - first);
    Outputs part = detail::slice(frame.camera, outputs, first, count);
    std::array<Copy, scan::kLayers> copies{};
    std::size_t n = 0, k = 0;
    DevicePointer next = staging_.get();
    each_output(part, [&](const char*, auto& memory) {
      if (!on_host[k++]) return;
      copies[n++] = {memory.data(), next, memory.size_bytes()};
      using Value = typename std::remove_reference_t<decltype(memory)>::element_type;
      memory = {reinterpret_cast<Value*>(next), memory.size()};
      next += rounded_up(memory.size_bytes());
    });
    draw(frame, views.subspan(first, count), part);
    for (const Copy& copy : std::span(copies).first(n)) {
      check(api().MemcpyDtoHAsync(copy.to, copy.from, copy.bytes, frame.stream),
            "copying pictures");
    }
  }
}

void State::draw(const Frame& frame, std::span<const View> views, const Outputs& outputs) {
  for (std::size_t first = 0; first < views.size();) {
    Slot& slot = take_slot(frame.captured);
    const std::size_t most = std::min(kMostViews, views.size() - first);
    const std::size_t count = draw_some(frame, views.subspan(first, most),
                                        detail::slice(frame.camera, outputs, first, most), slot);
    first += count;
  }
}

Slot& State::take_slot(bool captured) {
  if (captured) {
    captured_slots_.push_back(std::make_unique<Slot>(make_slot()));
    return *captured_slots_.back();
  }
  Slot& slot = slots_[next_slot_++ % kSlots];
  if (slot.busy) check(api().EventSynchronize(slot.done.get()), "waiting for views");
  slot.busy = false;
  return slot;
}

// As many of the first views as have their panoramas on the card at once.
std::size_t State::draw_some(const Frame& frame, std::span<const View> views,
                             const Outputs& outputs, Slot& slot) {
  const scan::LayerMask layers = layers_of(frame.kinds);
  panoramas_->begin_turn();
  std::size_t count = 0;
  bool same_sizes = true;  // of all layers of each view
  for (const View& view : views) {
    const OnCard* panorama = panoramas_->claim(view.scan, view.viewpoint, layers);
    if (panorama == nullptr) break;
    DeviceView& prepared = slot.host()[count++];
    prepared.rays = rays_of(frame.camera, view, faces_->panoramas());
    std::uint32_t size = 0;
    for (const Layer layer : detail::kEachLayer) {
      const std::size_t k = index(layer);
      prepared.faces[k] = panorama->faces[k];
      prepared.sizes[k] = panorama->sizes[k];
      if (!detail::has(layers, layer)) continue;
      same_sizes = same_sizes && (size == 0 || size == panorama->sizes[k]);
      size = panorama->sizes[k];
    }
  }
  EN_CHECK_LT(0U, count);
  if (!panoramas_->complete()) {
    if (frame.captured) {
      throw ArgumentError(
          "views: draw them once before the stream is captured, so that their "
          "panoramas are on the card");
    }
    panoramas_->bring_in(frame.stream);
  }
  check(api().MemcpyHtoDAsync(slot.views.get(), slot.host(), count * sizeof(DeviceView),
                              frame.stream),
        "uploading views");
  if (same_sizes) {
    launch(frame, frame.kinds, outputs, slot, count);
  } else {
    for (const Layer layer : detail::kEachLayer) {
      if (detail::has(layers, layer)) launch(frame, only(frame.kinds, layer), outputs, slot, count);
    }
  }
  if (!frame.captured) {
    check(api().EventRecord(slot.done.get(), frame.stream), "recording an event");
    slot.busy = true;
  }
  return count;
}

void State::launch(const Frame& frame, const Kinds& kinds, const Outputs& outputs, const Slot& slot,
                   std::size_t count) {
  Job job = make_job(frame.camera, kinds, outputs);
  job.views = reinterpret_cast<const DeviceView*>(slot.views.get());
  job.depth_factors = reinterpret_cast<const float*>(frame.depth_factors);
  std::array<void*, 1> parameters{&job};
  check(api().LaunchKernel(kernel(kinds), static_cast<unsigned>(count) * job.bands, 1, 1,
                           kWarps * kLanes, 1, 1, 0, frame.stream, parameters.data(), nullptr),
        "drawing");
}

class CudaRenderer final : public Renderer {
 public:
  CudaRenderer(std::shared_ptr<FaceCache> faces, const RendererConfig& config)
      : faces_(std::move(faces)), device_(ordinal_of(config.cuda_device)) {
    const CurrentDevice current(device_);
    state_.emplace(faces_, config, device_);
  }
  ~CudaRenderer() override {
    const CurrentDevice current(device_);
    state_.reset();
  }
  CudaRenderer(const CudaRenderer&) = delete;
  CudaRenderer& operator=(const CudaRenderer&) = delete;

  void render(const Camera& camera, std::span<const View> views, const Outputs& outputs) override {
    validate(camera, views, outputs, faces_->panoramas());
    if (views.empty() || detail::layers_of(outputs) == 0) return;
    const CurrentDevice current(device_);
    state_->render(camera, views, outputs);
  }
  std::string description() const override {
    return fmt::format("cuda ({}, compute capability {}.{})", device_.name(),
                       device_.capability() / 10, device_.capability() % 10);
  }

 private:
  std::shared_ptr<FaceCache> faces_;
  Device device_;
  std::optional<State> state_;
};

}  // namespace

}  // namespace enfilade::render::cuda

namespace enfilade::render::detail {

std::unique_ptr<Renderer> make_cuda_renderer(std::shared_ptr<FaceCache> faces,
                                             const RendererConfig& config) {
  return std::make_unique<cuda::CudaRenderer>(std::move(faces), config);
}

}  // namespace enfilade::render::detail
