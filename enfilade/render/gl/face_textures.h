/// \file  Cache of faces in textures of the graphics card, within a limit of bytes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "enfilade/render/detail/layers.h"
#include "enfilade/render/face_cache.h"
#include "enfilade/render/gl/context.h"

namespace enfilade::render::gl {

/// The faces of one layer and size: layers ("slots") of one array texture. It grows up to a number
/// of slots, then the least recently used face goes first. Belongs to the current context.
class FacePool {
 public:
  FacePool(scan::Layer layer, std::uint32_t size);
  FacePool(const FacePool&) = delete;
  FacePool& operator=(const FacePool&) = delete;

  scan::Layer layer() const noexcept { return layer_; }
  std::uint32_t size() const noexcept { return size_; }  ///< texels, border not counted
  GLuint texture() const noexcept { return texture_; }
  std::size_t slot_bytes() const noexcept;  ///< of a face on the card

  /// Sets how many slots there may be; forgets everything if there are more already.
  void limit(std::size_t slots);

  struct SlotClaim {
    std::int32_t slot = -1;  ///< -1: all slots are claimed in this turn
    bool fresh = false;      ///< the face is not there yet: upload() it, or drop() it
  };
  /// The slot of a face, kept for it until the turn changes. \throws Error if out of memory
  SlotClaim claim(const FaceKey& key, std::uint64_t turn);
  void upload(std::int32_t slot, const Face& face);
  void drop(const FaceKey& key);

 private:
  struct TextureSlot {
    std::int32_t number = 0;
    FaceKey key;
    std::uint64_t turn = 0;  ///< of the last claim; 0: free
  };
  /// Texels along an edge, border included.
  std::uint32_t edge() const { return size_ + 2 * detail::border_of(layer_); }
  void grow();

  scan::Layer layer_;
  std::uint32_t size_;
  std::size_t limit_ = 0;
  GLuint texture_ = 0;
  std::vector<std::uint8_t> rows_;  // a face on its way
  std::list<TextureSlot> slots_;    // the most recently used first, free ones last
  std::unordered_map<FaceKey, std::list<TextureSlot>::iterator, detail::FaceKeyHash> places_;
};

/// All pools of a renderer. Faces are claimed view by view, then brought in from the face cache at
/// once, so that they are decoded in parallel.
class FaceTextures {
 public:
  /// `bytes`: of all pools together; six faces of each are kept in any case.
  FaceTextures(std::shared_ptr<FaceCache> faces, std::size_t bytes);

  /// Slots of claimed faces are kept until the next call.
  void begin_turn() noexcept;
  /// The panorama's faces' sizes, 0 where it lacks a layer. \throws FileError, InvalidInput
  const scan::FaceSizes& sizes(ScanIndex scan, ViewpointIndex viewpoint);
  /// Makes room for faces of a layer and size. Not in the middle of a turn: it may forget faces.
  void prepare(scan::Layer layer, std::uint32_t size);
  /// \returns the face's slot; -1 if no more faces fit in this turn. \pre prepare()
  std::int32_t claim(const FaceKey& key, std::uint32_t size);
  /// Uploads the claimed faces of this turn that are missing.
  /// \throws as FaceCache::acquire(), Error
  void bring_in();
  GLuint texture(scan::Layer layer, std::uint32_t size) { return pool(layer, size)->texture(); }

 private:
  struct MissingFace {
    FacePool* pool;
    std::int32_t slot;
  };
  FacePool* pool(scan::Layer layer, std::uint32_t size) noexcept;
  void share_out();
  void bring_in(std::size_t first, std::size_t count);

  std::shared_ptr<FaceCache> faces_;
  std::size_t bytes_;
  std::uint64_t turn_ = 0;
  std::vector<std::unique_ptr<FacePool>> pools_;
  std::vector<FaceKey> missing_keys_;
  std::vector<MissingFace> missing_;
  std::vector<Face> acquired_;
  std::unordered_map<std::uint64_t, scan::FaceSizes> sizes_;  // by scan << 32 | viewpoint
};

}  // namespace enfilade::render::gl
