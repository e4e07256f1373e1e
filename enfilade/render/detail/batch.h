/// \file  Preparation of a batch, shared by the back ends: rays, visible faces, decoded faces.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/render/renderer.h"

namespace enfilade::render::detail {

/// The rotation from the view's camera to its panorama.
Mat3d panorama_from_camera(const View& view, const scan::PanoramaSet& panoramas);

/// Faces of a cache, acquired while this lives.
class HeldFaces {
 public:
  /// \throws as FaceCache::acquire()
  HeldFaces(FaceCache& cache, std::span<const FaceKey> keys, std::span<Face> faces)
      : cache_(cache), keys_(keys) {
    cache_.acquire(keys, faces);
  }
  ~HeldFaces() { cache_.release(keys_); }
  HeldFaces(const HeldFaces&) = delete;
  HeldFaces& operator=(const HeldFaces&) = delete;

 private:
  FaceCache& cache_;
  std::span<const FaceKey> keys_;
};
/// \throws Error if a face is not of the size that its source gave before
void check_size(const FaceCache& cache, const FaceKey& key, const Face& face, std::uint32_t size);

/// One view, ready to be drawn.
struct PreparedView {
  PixelRays rays;           ///< in the panorama frame
  scan::FaceMask mask = 0;  ///< faces that it may show
  /// Where its faces are in ViewBatch::faces, by index(Layer), index(CubeFace); only those of
  /// `mask`.
  std::array<std::array<std::uint32_t, kCubeFaces>, scan::kLayers> face{};
};

/// Views that are drawn together, as their faces fit into the cache at once. Holds these faces
/// until it is destroyed or filled again. Its vectors keep their memory, so that a renderer that
/// has one allocates nothing.
class ViewBatch {
 public:
  explicit ViewBatch(std::shared_ptr<FaceCache> cache) : cache_(std::move(cache)) {}
  ~ViewBatch() { clear(); }
  ViewBatch(const ViewBatch&) = delete;
  ViewBatch& operator=(const ViewBatch&) = delete;

  /// Takes as many of the first views as have their faces within `bytes`, at least one. Makes the
  /// faces ready.
  /// \returns the number of views taken
  /// \pre validate() was called
  /// \throws as FaceCache::acquire()
  std::size_t fill(const Camera& camera, std::span<const View> views, const Outputs& outputs,
                   std::size_t bytes);
  /// All faces of one panorama, whatever the view shows of them.
  void fill_whole(const View& view, const Outputs& outputs);
  void clear() noexcept;

  std::span<const PreparedView> views() const noexcept { return views_; }
  std::span<const FaceKey> keys() const noexcept { return keys_; }  ///< of faces(), sorted
  std::span<const Face> faces() const noexcept { return faces_; }
  FaceCache& cache() noexcept { return *cache_; }

 private:
  std::size_t add_keys(const View& view, const PreparedView& prepared, const Outputs& outputs);
  void hold_faces(std::span<const View> views, const Outputs& outputs);
  void place_faces(const View& view, PreparedView& prepared, const Outputs& outputs) const;

  std::shared_ptr<FaceCache> cache_;
  bool held_ = false;
  std::vector<PreparedView> views_;
  std::vector<FaceKey> keys_;
  std::vector<Face> faces_;
};

/// The part of the outputs that belongs to `count` views from the one at `first` on.
Outputs slice(const Camera& camera, const Outputs& outputs, std::size_t first, std::size_t count);

}  // namespace enfilade::render::detail
