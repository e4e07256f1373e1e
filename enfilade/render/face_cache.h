/// \file  Decoded faces, as many as fit a number of bytes, shared by renderers.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "enfilade/core/ids.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::render {

/// One face of one layer of one panorama.
struct FaceKey {
  ScanIndex scan;
  ViewpointIndex viewpoint;
  scan::Layer layer = scan::Layer::kColour;
  CubeFace face = CubeFace::kFront;
  friend constexpr bool operator==(FaceKey, FaceKey) = default;
};

/// A decoded face. Colour: RGBA, four bytes a texel, with a border of one texel (cube_border.h);
/// depth and class: uint16; instances: uint32; these without a border.
struct Face {
  const std::uint8_t* origin = nullptr;  ///< texel (0, 0)
  std::uint32_t stride = 0;              ///< bytes from a row to the next
  std::uint32_t size = 0;                ///< texels along an edge, border not counted
};

/// What a decoded face takes in a FaceCache, bytes: colour's border and rows' alignment included.
std::size_t face_bytes(scan::Layer layer, std::uint32_t size) noexcept;

struct FaceCacheConfig {
  /// What may be kept; what is in use at the moment is kept in any case. A face of 512 texels takes
  /// 1.06 MB of colour and 0.5 MB of depth.
  std::size_t bytes = std::size_t{64} << 20;
  int threads = 0;              ///< that decode what a call is waiting for; 0: all cores
  bool prefetch_thread = true;  ///< one more decodes what prefetch() names
};

struct FaceCacheCounters {
  std::uint64_t hits = 0, misses = 0;    ///< of acquire()
  std::uint64_t prefetched = 0;          ///< faces decoded ahead
  std::uint64_t decode_nanoseconds = 0;  ///< summed over threads
  std::size_t bytes = 0;                 ///< in memory now
};

/// The least recently used face goes first. All functions may be called from any thread at once;
/// allocates nothing as long as it finds what is asked for.
class FaceCache {
 public:
  explicit FaceCache(std::shared_ptr<const scan::PanoramaSet> panoramas,
                     const FaceCacheConfig& config = {});
  ~FaceCache();
  FaceCache(const FaceCache&) = delete;
  FaceCache& operator=(const FaceCache&) = delete;

  const scan::PanoramaSet& panoramas() const noexcept;
  const FaceCacheConfig& config() const noexcept;

  /// Makes faces ready, decoding what is missing in parallel, and holds them until release() is
  /// called with the same keys. Each distinct key at most once a call.
  /// \throws what the sources throw; then nothing is held
  void acquire(std::span<const FaceKey> keys, std::span<Face> faces);
  void release(std::span<const FaceKey> keys) noexcept;

  /// Decodes these in the background when there is time, if they fit beside what is in use. Faces
  /// that fail are left for acquire() to complain of. The last call's wishes replace earlier ones.
  void prefetch(std::span<const FaceKey> keys);

  FaceCacheCounters counters() const;
  /// Forgets what is not in use, as if nothing had been read: for benchmarks.
  void clear();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::render
