#include "enfilade/render/detail/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/render/detail/layers.h"

namespace enfilade::render::detail {
namespace {

using scan::Layer;

auto order(const FaceKey& key) { return std::tuple(key.scan, key.viewpoint, key.layer, key.face); }
bool before(const FaceKey& a, const FaceKey& b) { return order(a) < order(b); }

bool sees(const PreparedView& view, std::size_t face) { return (view.mask >> face & 1U) != 0; }

PreparedView prepare(const Camera& camera, const View& view, const scan::PanoramaSet& panoramas) {
  const Mat3d rotation = panorama_from_camera(view, panoramas);
  return {pixel_rays(camera, rotation), faces_in_view(camera, rotation), {}};
}

}  // namespace

Mat3d panorama_from_camera(const View& view, const scan::PanoramaSet& panoramas) {
  const auto& poses = panoramas.source(view.scan).poses();
  return transpose(poses[view.viewpoint.at()].world_from_panorama) *
         world_from_camera(view.heading, view.elevation);
}

void check_size(const FaceCache& cache, const FaceKey& key, const Face& face, std::uint32_t size) {
  if (face.size == size) return;
  const scan::PanoramaSource& source = cache.panoramas().source(key.scan);
  throw Error(fmt::format(
      "{}: scan {}, viewpoint {}: its {} faces were of {} texels before and are of {} now",
      source.origin(), source.scan(), source.poses()[key.viewpoint.at()].viewpoint,
      to_string(key.layer), size, face.size));
}

Outputs slice(const Camera& camera, const Outputs& outputs, std::size_t first, std::size_t count) {
  const std::size_t view = std::size_t{camera.width} * camera.height;
  Outputs part = outputs;
  const auto cut = [&](auto& output) {
    const std::size_t bytes = view * pixel_bytes(output->format);
    output->pixels = output->pixels.subspan(first * bytes, count * bytes);
  };
  if (part.colour) cut(part.colour);
  if (part.depth) cut(part.depth);
  if (part.classes) cut(part.classes);
  if (part.instances) {
    part.instances->pixels = part.instances->pixels.subspan(first * view, count * view);
  }
  return part;
}

std::size_t ViewBatch::fill(const Camera& camera, std::span<const View> views,
                            const Outputs& outputs, std::size_t bytes) {
  clear();
  std::size_t used = 0;
  for (const View& view : views) {
    const PreparedView prepared = prepare(camera, view, cache_->panoramas());
    const std::size_t before_it = keys_.size();
    used += add_keys(view, prepared, outputs);
    if (used > bytes && !views_.empty()) {  // it belongs to the next batch
      keys_.resize(before_it);
      break;
    }
    views_.push_back(prepared);
  }
  hold_faces(views.first(views_.size()), outputs);
  return views_.size();
}

void ViewBatch::fill_whole(const View& view, const Outputs& outputs) {
  clear();
  views_.push_back({{}, scan::kAllFaces, {}});
  add_keys(view, views_.front(), outputs);
  hold_faces({&view, 1}, outputs);
}

void ViewBatch::hold_faces(std::span<const View> views, const Outputs& outputs) {
  std::ranges::sort(keys_, before);
  const auto repeated = std::ranges::unique(keys_);
  keys_.erase(repeated.begin(), repeated.end());
  faces_.resize(keys_.size());
  cache_->acquire(keys_, faces_);
  held_ = true;
  for (std::size_t v = 0; v < views.size(); ++v) place_faces(views[v], views_[v], outputs);
}

// Appends the keys of the view's faces. Returns the bytes of those that the last views have not
// added already: views of one panorama usually follow each other, and a face that is counted twice
// only makes a batch smaller.
std::size_t ViewBatch::add_keys(const View& view, const PreparedView& prepared,
                                const Outputs& outputs) {
  const scan::FaceSizes sizes = cache_->panoramas().source(view.scan).face_sizes(view.viewpoint);
  std::size_t bytes = 0;
  constexpr std::size_t kLookBack = 3 * kCubeFaces * scan::kLayers;
  for (const Layer layer : kEachLayer) {
    if (!has(layers_of(outputs), layer)) continue;
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      if (!sees(prepared, k)) continue;
      const FaceKey key{view.scan, view.viewpoint, layer, cube_face(k)};
      const std::size_t from = keys_.size() - std::min(keys_.size(), kLookBack);
      const auto recent = std::span(keys_).subspan(from);
      if (std::ranges::find(recent, key) != recent.end()) continue;
      keys_.push_back(key);
      bytes += face_bytes(layer, sizes[index(layer)]);
    }
  }
  return bytes;
}

void ViewBatch::place_faces(const View& view, PreparedView& prepared,
                            const Outputs& outputs) const {
  for (const Layer layer : kEachLayer) {
    if (!has(layers_of(outputs), layer)) continue;
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      if (!sees(prepared, k)) continue;
      const FaceKey key{view.scan, view.viewpoint, layer, cube_face(k)};
      const auto found = std::ranges::lower_bound(keys_, key, before);
      EN_CHECK(found != keys_.end() && *found == key);
      prepared.face[index(layer)][k] = static_cast<std::uint32_t>(found - keys_.begin());
    }
  }
}

void ViewBatch::clear() noexcept {
  if (held_) cache_->release(keys_);
  held_ = false;
  views_.clear();
  keys_.clear();
  faces_.clear();
}

}  // namespace enfilade::render::detail
