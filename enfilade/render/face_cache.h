/// \file  FaceCache: decoded cube map faces, shared by renderers, within a limit of bytes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
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

/// A decoded face, in the cells of face_cells.h: ColourCells for colour, ValueCells<std::uint16_t>
/// for depth and class, ValueCells<std::uint32_t> for instances.
struct Face {
  const std::uint8_t* cells = nullptr;
  std::uint32_t size = 0;  ///< texels along an edge, border not counted
};

/// Bytes of a decoded face in a FaceCache.
std::size_t face_bytes(scan::Layer layer, std::uint32_t size) noexcept;

/// A sixteenth of available_memory() (core/threads.h), at least 64 MiB and at most 1 GiB. That
/// holds a building's panoramas on most computers, with room for a dozen such processes.
std::size_t default_cache_bytes();

/// A file in which the processes of a computer share decoded faces: each face is decoded once and
/// is in memory once. They have to be of one user. The first process that needs the file makes it,
/// and the last removes it. If that one is killed the file stays, and is used again or may be
/// removed by hand at any time. While it is used it must not be truncated.
struct SharedCacheConfig {
  /// The file, preferably on a disk in memory; empty: shared_cache_path(bytes).
  std::filesystem::path path;
  /// Size of the file, allocated when it is made: a whole number of MiB, the same in all processes
  /// that use the path. When the file is full, the least recently used face is replaced.
  std::size_t bytes = std::size_t{1} << 30U;
};
/// "/dev/shm/enfilade-cache-USER-MIB-VERSION": the user's id, the size, the layout's version.
std::filesystem::path shared_cache_path(std::size_t bytes);

/// How much a cache keeps.
struct FaceCacheConfig {
  /// Limit of memory that is this cache's own; faces in use are kept even beyond it. A face of 512
  /// texels takes 0.95 MB of colour and 0.52 MB of depth. Not of faces in a shared file: of that, a
  /// process keeps its part of one half.
  std::size_t bytes = default_cache_bytes();
  int threads = 0;              ///< for decoding in acquire(); 0: all cores
  bool prefetch_thread = true;  ///< whether prefetch() decodes, in one further thread
  /// Shared cache with other processes; no value: none. Faces that do not fit there are kept in the
  /// cache's own memory, as are faces of sources whose state() is unknown.
  std::optional<SharedCacheConfig> shared = {};
};

/// Counts of a cache since it was made.
struct FaceCacheCounters {
  std::uint64_t hits = 0, misses = 0;    ///< per face of acquire()
  std::uint64_t prefetched = 0;          ///< faces made ready by prefetch()
  std::uint64_t decoded = 0;             ///< faces, by acquire() and prefetch()
  std::uint64_t shared_hits = 0;         ///< faces that were in the shared file, likewise
  std::uint64_t decode_nanoseconds = 0;  ///< summed over threads
  std::size_t bytes = 0;                 ///< in memory of its own now
  std::size_t shared_bytes = 0;          ///< kept in the shared file now
};

/// Cache of decoded faces; the least recently used one is removed first. All functions may be
/// called from any thread at once. Does not allocate while all requested faces are in memory.
///
/// In a forked child, faces that were acquired before the fork must be released, and not be read
/// any more, if the cache is shared.
class FaceCache {
 public:
  /// Empty. Faces are decoded at their first use.
  /// \throws ArgumentError for an invalid configuration
  /// \throws FileError naming the shared file and the remedy if it cannot be used: another user's,
  /// another size, no room
  explicit FaceCache(std::shared_ptr<const scan::PanoramaSet> panoramas,
                     const FaceCacheConfig& config = {});
  ~FaceCache();
  FaceCache(const FaceCache&) = delete;
  FaceCache& operator=(const FaceCache&) = delete;

  const scan::PanoramaSet& panoramas() const noexcept;
  const FaceCacheConfig& config() const noexcept;

  /// Decodes faces that are missing, in parallel, and keeps all until release() is called with the
  /// same keys. \pre keys are distinct
  /// \throws the sources' errors; then nothing is held
  void acquire(std::span<const FaceKey> keys, std::span<Face> faces);
  void release(std::span<const FaceKey> keys) noexcept;

  /// Decodes faces in the background, if they fit beside those in use. Errors are left to
  /// acquire(). Each call replaces the list of the last one.
  void prefetch(std::span<const FaceKey> keys);

  FaceCacheCounters counters() const;
  /// Removes all faces that are not in use: for benchmarks.
  void clear();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::render
