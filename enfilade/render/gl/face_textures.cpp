#include "enfilade/render/gl/face_textures.h"

#include <fmt/format.h>

#include <algorithm>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/render/detail/batch.h"
#include "enfilade/render/gl/program.h"

namespace enfilade::render::gl {
namespace {

constexpr std::size_t kLeastSlots = kCubeFaces;  // a view may show all six
// Faces that are decoded, and held in the face cache, at the same time: enough for all cores.
constexpr std::size_t kGroup = 24;

GLint integer(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

}  // namespace

FacePool::FacePool(scan::Layer layer, std::uint32_t size) : layer_(layer), size_(size) {
  const GLint most = integer(GL_MAX_TEXTURE_SIZE);
  if (edge() > static_cast<std::uint32_t>(most)) {
    throw Error(fmt::format(
        "OpenGL: {} faces of {} x {} texels: the device's textures have at most {} x {}",
        to_string(layer), edge(), edge(), most, most));
  }
}

std::size_t FacePool::slot_bytes() const noexcept {
  return std::size_t{edge()} * edge() * detail::kTexelBytes[index(layer_)];
}

void FacePool::limit(std::size_t slots) {
  limit_ = std::min(slots, static_cast<std::size_t>(integer(GL_MAX_ARRAY_TEXTURE_LAYERS)));
  if (slots_.size() <= limit_) return;
  glDeleteTextures(1, &texture_);
  texture_ = 0;
  slots_.clear();
  places_.clear();
}

FacePool::SlotClaim FacePool::claim(const FaceKey& key, std::uint64_t turn) {
  const auto found = places_.find(key);
  const bool fresh = found == places_.end();
  if (fresh) {
    if ((slots_.empty() || slots_.back().turn != 0) && slots_.size() < limit_) grow();
    if (slots_.back().turn == turn) return {};
  }
  const auto slot = fresh ? std::prev(slots_.end()) : found->second;
  if (fresh) {
    if (slot->turn != 0) places_.erase(slot->key);
    places_.emplace(key, slot);
    slot->key = key;
  }
  slot->turn = turn;
  slots_.splice(slots_.begin(), slots_, slot);
  return {slot->number, fresh};
}

void FacePool::grow() {
  const std::size_t before = slots_.size();
  const std::size_t after = std::min(std::max(2 * before, 2 * kLeastSlots), limit_);
  const auto width = static_cast<GLsizei>(edge());
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture);
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, 1, kTexelFormats[index(layer_)].internal, width, width,
                 static_cast<GLsizei>(after));
  const GLint filter = layer_ == scan::Layer::kColour ? GL_LINEAR : GL_NEAREST;
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  if (before > 0) {
    glCopyImageSubData(texture_, GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, texture, GL_TEXTURE_2D_ARRAY, 0,
                       0, 0, 0, width, width, static_cast<GLsizei>(before));
  }
  try {
    check_gl(fmt::format("{} {} faces of {} x {} texels", after, to_string(layer_), width, width));
  } catch (const Error&) {
    glDeleteTextures(1, &texture);
    throw;
  }
  glDeleteTextures(1, &texture_);
  texture_ = texture;
  places_.reserve(after);
  for (std::size_t slot = before; slot < after; ++slot) {
    slots_.push_back({static_cast<std::int32_t>(slot), {}, 0});
  }
}

void FacePool::upload(std::int32_t slot, const Face& face) {
  const TexelFormat& format = kTexelFormats[index(layer_)];
  rows_.resize(slot_bytes());
  switch (layer_) {
    case scan::Layer::kColour:
      image::bordered_rgba(face.cells, face.size, rows_);
      break;
    case scan::Layer::kDepth:
    case scan::Layer::kClass:
      image::ValueCells<std::uint16_t>::to_rows(face.cells, face.size,
                                                reinterpret_cast<std::uint16_t*>(rows_.data()));
      break;
    case scan::Layer::kInstance:
      image::ValueCells<std::uint32_t>::to_rows(face.cells, face.size,
                                                reinterpret_cast<std::uint32_t*>(rows_.data()));
      break;
  }
  const auto width = static_cast<GLsizei>(edge());
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture_);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, slot, width, width, 1, format.format, format.type,
                  rows_.data());
}

void FacePool::drop(const FaceKey& key) {
  const auto found = places_.find(key);
  if (found == places_.end()) return;
  const auto slot = found->second;
  places_.erase(found);
  slot->turn = 0;
  slots_.splice(slots_.end(), slots_, slot);
}

FaceTextures::FaceTextures(std::shared_ptr<FaceCache> faces, std::size_t bytes)
    : faces_(std::move(faces)), bytes_(bytes) {}

const scan::FaceSizes& FaceTextures::sizes(ScanIndex scan, ViewpointIndex viewpoint) {
  const std::uint64_t place = std::uint64_t{scan.value} << 32 | viewpoint.value;
  const auto found = sizes_.find(place);
  if (found != sizes_.end()) return found->second;
  const scan::FaceSizes sizes = faces_->panoramas().source(scan).face_sizes(viewpoint);
  return sizes_.emplace(place, sizes).first->second;
}

FacePool* FaceTextures::pool(scan::Layer layer, std::uint32_t size) noexcept {
  const auto found = std::ranges::find_if(
      pools_, [&](const auto& p) { return p->layer() == layer && p->size() == size; });
  return found == pools_.end() ? nullptr : found->get();
}

void FaceTextures::prepare(scan::Layer layer, std::uint32_t size) {
  if (pool(layer, size) != nullptr) return;
  pools_.push_back(std::make_unique<FacePool>(layer, size));
  share_out();
}

// The same number of faces for each pool: a view needs as many of each layer.
void FaceTextures::share_out() {
  std::size_t one_of_each = 0;
  for (const auto& p : pools_) one_of_each += p->slot_bytes();
  for (const auto& p : pools_) p->limit(std::max(kLeastSlots, bytes_ / one_of_each));
}

std::int32_t FaceTextures::claim(const FaceKey& key, std::uint32_t size) {
  FacePool* const here = pool(key.layer, size);
  EN_CHECK(here != nullptr);
  const FacePool::SlotClaim claim = here->claim(key, turn_);
  if (claim.fresh) {
    missing_keys_.push_back(key);
    missing_.push_back({here, claim.slot});
  }
  return claim.slot;
}

void FaceTextures::begin_turn() noexcept {
  // If the last turn failed, these were claimed but never uploaded.
  for (std::size_t k = 0; k < missing_.size(); ++k) missing_[k].pool->drop(missing_keys_[k]);
  missing_.clear();
  missing_keys_.clear();
  ++turn_;
}

void FaceTextures::bring_in() {
  const auto same = [](const FaceKey& a, const FaceKey& b) {
    return a.scan == b.scan && a.viewpoint == b.viewpoint && a.layer == b.layer;
  };
  const std::size_t n = missing_.size();
  for (std::size_t first = 0, end = 0; first < n; first = end) {
    end = std::min(n, first + kGroup);
    // Faces that a source may read together stay together.
    while (end < n && same(missing_keys_[end - 1], missing_keys_[end])) ++end;
    bring_in(first, end - first);
  }
  missing_keys_.clear();
  missing_.clear();
}

void FaceTextures::bring_in(std::size_t first, std::size_t count) {
  acquired_.resize(count);
  const std::span keys = std::span(missing_keys_).subspan(first, count);
  const detail::HeldFaces held(*faces_, keys, acquired_);
  for (std::size_t k = 0; k < count; ++k) {
    const auto [pool, slot] = missing_[first + k];
    detail::check_size(*faces_, keys[k], acquired_[k], pool->size());
    pool->upload(slot, acquired_[k]);
  }
  check_gl("uploading faces");
}

}  // namespace enfilade::render::gl
