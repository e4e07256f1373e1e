#include "enfilade/render/cuda/panoramas.h"

#include <algorithm>
#include <cstring>

#include "enfilade/render/cuda/job.h"
#include "enfilade/render/detail/batch.h"

namespace enfilade::render::cuda {
namespace {

using scan::Layer;

std::size_t bytes_on_card(Layer layer, std::uint32_t size) {
  return kCubeFaces *
         (layer == Layer::kColour ? colour_bytes(size) : scan::cells_bytes(layer, size));
}

constexpr std::uint64_t key_of(ScanIndex scan, ViewpointIndex viewpoint) {
  return std::uint64_t{scan.value} << 32U | viewpoint.value;
}

}  // namespace

Panoramas::Panoramas(std::shared_ptr<FaceCache> faces, std::size_t bytes, FunctionHandle unpack)
    : faces_(std::move(faces)), limit_(bytes), unpack_(unpack) {
  for (StagingArea& stage : stages_) stage.done = make_event();
}

Panoramas::~Panoramas() = default;

void Panoramas::begin_turn() noexcept {
  // If the last turn failed, these were claimed but are not there.
  for (const MissingLayer& missing : missing_) put_aside(*missing.entry, missing.layer);
  missing_.clear();
  ++turn_;
}

void Panoramas::put_aside(KeptPanorama& entry, Layer layer) noexcept {
  const std::size_t k = index(layer);
  if (entry.on_card.sizes[k] == 0) return;
  spare_.emplace_back(bytes_on_card(layer, entry.on_card.sizes[k]), std::move(entry.memory[k]));
  entry.memory[k] = {};
  entry.on_card.faces[k] = 0;
  entry.on_card.sizes[k] = 0;
}

// The first panorama of a turn gets its memory even beyond the limit.
bool Panoramas::make_room(std::size_t bytes) {
  const auto have = [&] {
    return used_ + bytes <= limit_ || std::ranges::find(spare_, bytes, [](const auto& one) {
                                        return one.first;
                                      }) != spare_.end();
  };
  while (!have()) {
    if (!spare_.empty()) {
      used_ -= spare_.back().first;
      spare_.pop_back();
      continue;
    }
    if (entries_.back().turn == turn_) break;
    for (const Layer layer : detail::kEachLayer) put_aside(entries_.back(), layer);
    places_.erase(entries_.back().key);
    entries_.pop_back();
  }
  return have() || std::ranges::count(entries_, turn_, &KeptPanorama::turn) <= 1;
}

Memory Panoramas::take_memory(std::size_t bytes) {
  const auto found = std::ranges::find(spare_, bytes, [](const auto& one) { return one.first; });
  if (found == spare_.end()) {
    Memory memory = allocate(bytes);
    used_ += bytes;
    return memory;
  }
  Memory memory = std::move(found->second);
  std::swap(*found, spare_.back());
  spare_.pop_back();
  return memory;
}

const OnCard* Panoramas::claim(ScanIndex scan, ViewpointIndex viewpoint, scan::LayerMask layers) {
  const std::uint64_t key = key_of(scan, viewpoint);
  auto found = places_.find(key);
  if (found == places_.end()) {
    entries_.emplace_front().key = key;
    found = places_.emplace(key, entries_.begin()).first;
  } else if (found->second != entries_.begin()) {
    entries_.splice(entries_.begin(), entries_, found->second);
  }
  KeptPanorama& entry = *found->second;
  const std::uint64_t last_turn = std::exchange(entry.turn, turn_);
  for (const Layer layer : detail::kEachLayer) {
    if (!detail::has(layers, layer) || entry.on_card.sizes[index(layer)] > 0) continue;
    const scan::PanoramaSource& source = faces_->panoramas().source(scan);
    const std::uint32_t size = source.face_sizes(viewpoint)[index(layer)];
    if (size == 0) {
      entry.turn = last_turn;
      throw source.lacks(layer, viewpoint);
    }
    const std::size_t bytes = bytes_on_card(layer, size);
    if (!make_room(bytes)) {
      entry.turn = last_turn;
      return nullptr;
    }
    entry.memory[index(layer)] = take_memory(bytes);
    entry.on_card.faces[index(layer)] = entry.memory[index(layer)].get();
    entry.on_card.sizes[index(layer)] = size;
    missing_.push_back({&entry, scan, viewpoint, layer});
  }
  return &entry.on_card;
}

void Panoramas::bring_in(StreamHandle stream) {
  while (!missing_.empty()) {
    upload(missing_.back(), stream);
    missing_.pop_back();
  }
}

void Panoramas::upload(const MissingLayer& missing, StreamHandle stream) {
  std::array<FaceKey, kCubeFaces> keys;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    keys[k] = {missing.scan, missing.viewpoint, missing.layer, cube_face(k)};
  }
  std::array<Face, kCubeFaces> faces;
  const detail::HeldFaces held(*faces_, keys, faces);
  const std::uint32_t size = missing.entry->on_card.sizes[index(missing.layer)];
  const std::size_t face = scan::cells_bytes(missing.layer, size), bytes = kCubeFaces * face;
  StagingArea& stage = stages_[next_stage_++ % kStages];
  if (stage.busy) check(api().EventSynchronize(stage.done.get()), "waiting for an upload");
  if (stage.bytes < bytes) {
    stage.pinned = allocate_pinned(bytes);
    stage.cells = allocate(bytes);
    stage.bytes = bytes;
  }
  auto* pinned = static_cast<std::uint8_t*>(stage.pinned.get());
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    detail::check_size(*faces_, keys[k], faces[k], size);
    std::memcpy(pinned + k * face, faces[k].cells, face);
  }
  const DevicePointer to = missing.entry->on_card.faces[index(missing.layer)];
  const bool colour = missing.layer == Layer::kColour;
  const DevicePointer copied = colour ? stage.cells.get() : to;
  check(api().MemcpyHtoDAsync(copied, pinned, bytes, stream), "uploading faces");
  if (colour) {
    constexpr unsigned kThreads = 256;
    std::uint32_t edge = size,
                  texels = static_cast<std::uint32_t>(kCubeFaces) * (size + 2) * (size + 2);
    DevicePointer from = copied, strips = to;
    std::array<void*, 4> parameters{&from, &strips, &edge, &texels};
    check(api().LaunchKernel(unpack_, (texels + kThreads - 1) / kThreads, 1, 1, kThreads, 1, 1, 0,
                             stream, parameters.data(), nullptr),
          "unpacking faces");
  }
  check(api().EventRecord(stage.done.get(), stream), "recording an event");
  stage.busy = true;
}

}  // namespace enfilade::render::cuda
