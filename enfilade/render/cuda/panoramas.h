/// \file  Panoramas in the card's memory, within a limit of bytes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "enfilade/render/cuda/driver.h"
#include "enfilade/render/detail/layers.h"
#include "enfilade/render/face_cache.h"

namespace enfilade::render::cuda {

/// Where the layers of a panorama are on the card; 0 and size 0 for one that is not there.
struct OnCard {
  std::array<DevicePointer, scan::kLayers> faces{};
  std::array<std::uint32_t, scan::kLayers> sizes{};
};

/// Keeps whole layers of panoramas, six faces each; the least recently used panorama goes first.
/// The panoramas that views need are claimed, then brought in together, so that faces are decoded
/// in parallel. For one thread, in its device's context.
class Panoramas {
 public:
  /// \param bytes of the card that may be used; one turn's first panorama is kept in any case
  /// \param unpack the kernel of that name
  Panoramas(std::shared_ptr<FaceCache> faces, std::size_t bytes, FunctionHandle unpack);
  ~Panoramas();
  Panoramas(const Panoramas&) = delete;
  Panoramas& operator=(const Panoramas&) = delete;

  /// Claimed panoramas are kept until the next call.
  void begin_turn() noexcept;
  /// The panorama with these layers, perhaps still to be brought in; null if no more fit into this
  /// turn. Valid until the next turn.
  /// \throws as PanoramaSet::source(); LookupError for a layer that it lacks
  const OnCard* claim(ScanIndex scan, ViewpointIndex viewpoint, scan::LayerMask layers);
  /// Whether all panoramas claimed in this turn are on the card.
  bool complete() const noexcept { return missing_.empty(); }
  /// Uploads the missing ones. Later work of `stream` runs after it.
  /// \throws as FaceCache::acquire(); Error
  void bring_in(StreamHandle stream);

 private:
  struct KeptPanorama {
    std::uint64_t key = 0;
    OnCard on_card;
    std::array<Memory, scan::kLayers> memory;
    std::uint64_t turn = 0;
  };
  struct MissingLayer {
    KeptPanorama* entry;
    ScanIndex scan;
    ViewpointIndex viewpoint;
    scan::Layer layer;
  };
  bool make_room(std::size_t bytes);
  Memory take_memory(std::size_t bytes);
  void put_aside(KeptPanorama& entry, scan::Layer layer) noexcept;
  void upload(const MissingLayer& missing, StreamHandle stream);

  static constexpr std::size_t kStages = 2;
  /// Faces on their way: pinned, and for colour as cells on the card.
  struct StagingArea {
    PinnedMemory pinned;
    Memory cells;
    std::size_t bytes = 0;
    Event done;
    bool busy = false;
  };

  std::shared_ptr<FaceCache> faces_;
  std::size_t limit_, used_ = 0;
  FunctionHandle unpack_;
  std::uint64_t turn_ = 0;
  std::list<KeptPanorama> entries_;  // the most recently used first
  std::unordered_map<std::uint64_t, std::list<KeptPanorama>::iterator> places_;
  // Memory of removed panoramas, for others of the same size: freeing would wait for the card.
  std::vector<std::pair<std::size_t, Memory>> spare_;
  std::vector<MissingLayer> missing_;
  std::array<StagingArea, kStages> stages_;
  std::size_t next_stage_ = 0;
};

}  // namespace enfilade::render::cuda
