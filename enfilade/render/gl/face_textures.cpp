#include "enfilade/render/gl/face_textures.h"

#include <fmt/format.h>

#include <algorithm>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

namespace enfilade::render::gl {
namespace {

constexpr std::size_t kLeastSlots = kCubeFaces;  // a view may show all six
// Faces that are decoded, and held in the face cache, at once: enough for all cores.
constexpr std::size_t kGroup = 24;

/// How a layer's texels are stored here and come from the cache.
struct Texels {
  GLint internal;
  GLenum format, type;
  std::size_t bytes;
  std::uint32_t border;
};

Texels texels_of(scan::Layer layer) {
  switch (layer) {
    case scan::Layer::kColour:
      return {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 1};
    case scan::Layer::kInstance:
      return {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, 4, 0};
    case scan::Layer::kDepth:
    case scan::Layer::kClass:
      break;
  }
  return {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, 2, 0};
}

GLint integer(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

/// Faces of the cache, acquired while it lives.
class Held {
 public:
  Held(FaceCache& cache, std::span<const FaceKey> keys, std::span<Face> faces)
      : cache_(cache), keys_(keys) {
    cache_.acquire(keys, faces);
  }
  ~Held() { cache_.release(keys_); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

 private:
  FaceCache& cache_;
  std::span<const FaceKey> keys_;
};

}  // namespace

std::size_t FaceKeyHash::operator()(const FaceKey& key) const noexcept {
  const std::uint64_t place = std::uint64_t{key.scan.value} << 32 | key.viewpoint.value;
  const std::uint64_t all = place * 32 + index(key.layer) * 8 + index(key.face);
  return static_cast<std::size_t>(all * 0x9E3779B97F4A7C15U >> 20);  // 2^64 / golden ratio
}

FacePool::FacePool(scan::Layer layer, std::uint32_t size) : layer_(layer), size_(size) {
  const std::uint32_t edge = size + 2 * texels_of(layer).border;
  const GLint most = integer(GL_MAX_TEXTURE_SIZE);
  if (edge > static_cast<std::uint32_t>(most)) {
    throw Error(fmt::format(
        "OpenGL: {} faces of {} x {} texels: the device's textures have at most {} x {}",
        to_string(layer), edge, edge, most, most));
  }
}

std::size_t FacePool::slot_bytes() const noexcept {
  const Texels texels = texels_of(layer_);
  const std::size_t edge = size_ + 2 * texels.border;
  return edge * edge * texels.bytes;
}

void FacePool::limit(std::size_t slots) {
  limit_ = std::min(slots, static_cast<std::size_t>(integer(GL_MAX_ARRAY_TEXTURE_LAYERS)));
  if (slots_.size() <= limit_) return;
  glDeleteTextures(1, &texture_);
  texture_ = 0;
  slots_.clear();
  places_.clear();
  newest_ = oldest_ = -1;
}

FacePool::Claim FacePool::claim(const FaceKey& key, std::uint64_t turn) {
  const auto found = places_.find(key);
  if (found != places_.end()) {
    const std::int32_t slot = found->second;
    slots_[static_cast<std::size_t>(slot)].turn = turn;
    unlink(slot);
    make_newest(slot);
    return {slot, false};
  }
  const std::int32_t slot = free_slot(turn);
  if (slot < 0) return {};
  Slot& entry = slots_[static_cast<std::size_t>(slot)];
  if (entry.turn != 0) places_.erase(entry.key);
  places_.emplace(key, slot);
  entry.key = key;
  entry.turn = turn;
  unlink(slot);
  make_newest(slot);
  return {slot, true};
}

// Free slots are the oldest.
std::int32_t FacePool::free_slot(std::uint64_t turn) {
  const auto turn_of_oldest = [&] { return slots_[static_cast<std::size_t>(oldest_)].turn; };
  if ((oldest_ < 0 || turn_of_oldest() != 0) && slots_.size() < limit_) grow();
  return turn_of_oldest() == turn ? -1 : oldest_;
}

void FacePool::grow() {
  const std::size_t before = slots_.size();
  const std::size_t after = std::min(std::max(2 * before, 2 * kLeastSlots), limit_);
  const Texels texels = texels_of(layer_);
  const auto edge = static_cast<GLsizei>(size_ + 2 * texels.border);
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture);
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, 1, static_cast<GLenum>(texels.internal), edge, edge,
                 static_cast<GLsizei>(after));
  const GLint filter = layer_ == scan::Layer::kColour ? GL_LINEAR : GL_NEAREST;
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  if (before > 0) {
    glCopyImageSubData(texture_, GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, texture, GL_TEXTURE_2D_ARRAY, 0,
                       0, 0, 0, edge, edge, static_cast<GLsizei>(before));
  }
  try {
    check_gl(fmt::format("{} {} faces of {} x {} texels", after, to_string(layer_), edge, edge));
  } catch (const Error&) {
    glDeleteTextures(1, &texture);
    throw;
  }
  glDeleteTextures(1, &texture_);
  texture_ = texture;
  slots_.resize(after);
  places_.reserve(after);
  for (std::size_t slot = before; slot < after; ++slot) {
    const auto fresh = static_cast<std::int32_t>(slot);
    slots_[slot].newer = oldest_;
    if (oldest_ >= 0) slots_[static_cast<std::size_t>(oldest_)].older = fresh;
    oldest_ = fresh;
    if (newest_ < 0) newest_ = fresh;
  }
}

void FacePool::unlink(std::int32_t slot) {
  const auto [newer, older] = std::pair(slots_[static_cast<std::size_t>(slot)].newer,
                                        slots_[static_cast<std::size_t>(slot)].older);
  (newer < 0 ? newest_ : slots_[static_cast<std::size_t>(newer)].older) = older;
  (older < 0 ? oldest_ : slots_[static_cast<std::size_t>(older)].newer) = newer;
}

void FacePool::make_newest(std::int32_t slot) {
  Slot& entry = slots_[static_cast<std::size_t>(slot)];
  entry.newer = -1;
  entry.older = newest_;
  (newest_ < 0 ? oldest_ : slots_[static_cast<std::size_t>(newest_)].newer) = slot;
  newest_ = slot;
}

void FacePool::upload(std::int32_t slot, const Face& face) {
  const Texels texels = texels_of(layer_);
  EN_CHECK_EQ(face.stride % texels.bytes, 0U);
  const std::size_t before = texels.border * (face.stride + texels.bytes);
  const auto edge = static_cast<GLsizei>(size_ + 2 * texels.border);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture_);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<GLint>(face.stride / texels.bytes));
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, slot, edge, edge, 1, texels.format, texels.type,
                  face.origin - before);
}

void FacePool::drop(const FaceKey& key) {
  const auto found = places_.find(key);
  if (found == places_.end()) return;
  const std::int32_t slot = found->second;
  places_.erase(found);
  slots_[static_cast<std::size_t>(slot)].turn = 0;
  // To the old end, where free slots are looked for.
  unlink(slot);
  Slot& entry = slots_[static_cast<std::size_t>(slot)];
  entry.older = -1;
  entry.newer = oldest_;
  (oldest_ < 0 ? newest_ : slots_[static_cast<std::size_t>(oldest_)].older) = slot;
  oldest_ = slot;
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
  const FacePool::Claim claim = here->claim(key, turn_);
  if (claim.fresh) {
    missing_keys_.push_back(key);
    missing_.push_back({here, claim.slot});
  }
  return claim.slot;
}

void FaceTextures::begin_turn() noexcept {
  // Left over if the last turn failed: claimed, but never brought in.
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
  const Held held(*faces_, {missing_keys_.data() + first, count}, acquired_);
  for (std::size_t k = 0; k < count; ++k) {
    const auto [pool, slot] = missing_[first + k];
    if (acquired_[k].size != pool->size()) {
      const FaceKey& key = missing_keys_[first + k];
      const scan::PanoramaSource& source = faces_->panoramas().source(key.scan);
      throw Error(
          fmt::format("{}: scan {}, viewpoint {}: its {} faces were of {} texels before and "
                      "are of {} now",
                      source.origin(), source.scan(), source.poses()[key.viewpoint.at()].viewpoint,
                      to_string(key.layer), pool->size(), acquired_[k].size));
    }
    pool->upload(slot, acquired_[k]);
  }
  check_gl("uploading faces");
}

}  // namespace enfilade::render::gl
