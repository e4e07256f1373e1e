#include "enfilade/continuous/photographs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include "enfilade/continuous/pixels/photo.h"
#include "enfilade/continuous/pixels/rasteriser.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/tone.h"

namespace enfilade::continuous {

using pixels::bordered_texels;
using pixels::Photo;

namespace {

constexpr std::size_t kMostChosen = 8;
constexpr std::uint32_t kLeastFace = 16, kMostFace = 2048;

// One level of a cube map as linear light, without borders.
struct LinearCube {
  std::uint32_t size = 0;
  std::array<std::vector<Vec3f>, kCubeFaces> faces;
  const Vec3f& at(std::size_t face, std::uint32_t x, std::uint32_t y) const {
    return faces[face][std::size_t{y} * size + x];
  }
};

LinearCube linear(const image::CubeMap<std::uint8_t>& cube) {
  const std::array<float, 256>& table = image::linear_bytes();
  LinearCube made;
  made.size = cube[0].width;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const std::uint8_t* from = cube[k].pixels.data();
    made.faces[k].resize(std::size_t{made.size} * made.size);
    for (Vec3f& to : made.faces[k]) {
      to = {table[from[0]], table[from[1]], table[from[2]]};
      from += 3;
    }
  }
  return made;
}

LinearCube half(const LinearCube& whole) {
  LinearCube made;
  made.size = whole.size / 2;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    made.faces[k].reserve(std::size_t{made.size} * made.size);
    for (std::uint32_t y = 0; y < made.size; ++y) {
      for (std::uint32_t x = 0; x < made.size; ++x) {
        made.faces[k].push_back(0.25F * (whole.at(k, 2 * x, 2 * y) + whole.at(k, 2 * x + 1, 2 * y) +
                                         whole.at(k, 2 * x, 2 * y + 1) +
                                         whole.at(k, 2 * x + 1, 2 * y + 1)));
      }
    }
  }
  return made;
}

std::uint32_t rgba_of(Vec3f light) {
  return std::uint32_t{image::srgb8_from_linear(light.x)} |
         std::uint32_t{image::srgb8_from_linear(light.y)} << 8U |
         std::uint32_t{image::srgb8_from_linear(light.z)} << 16U | 255U << 24U;
}

// Appends six faces whose borders show what the neighbours do there.
template <class T, class Texel>
void append_faces(std::uint32_t size, const Texel& texel, std::vector<T>& to) {
  const auto edge = static_cast<int>(size);
  for (std::size_t face = 0; face < kCubeFaces; ++face) {
    for (int y = -1; y <= edge; ++y) {
      for (int x = -1; x <= edge; ++x) {
        if (x >= 0 && y >= 0 && x < edge && y < edge) {
          to.push_back(texel(face, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)));
          continue;
        }
        const FacePoint p =
            project_to_cube(cube_direction(cube_face(face), (x + 0.5) / edge, (y + 0.5) / edge));
        const auto on = [size](double s) {
          return std::min(static_cast<std::uint32_t>(std::max(s, 0.0) * size), size - 1);
        };
        to.push_back(texel(index(p.face), on(p.s), on(p.t)));
      }
    }
  }
}

void add_colours(const image::CubeMap<std::uint8_t>& cube, std::uint32_t face_size, Photo& photo) {
  LinearCube level = linear(cube);
  while (level.size > face_size && level.size % 2 == 0) level = half(level);
  photo.size = level.size;
  while (true) {
    photo.first[photo.levels++] = static_cast<std::int32_t>(photo.colours.size());
    append_faces(
        level.size,
        [&](std::size_t face, std::uint32_t x, std::uint32_t y) {
          return rgba_of(level.at(face, x, y));
        },
        photo.colours);
    if (photo.levels == Photo::kMostLevels || level.size % 2 != 0 || level.size <= 8) return;
    level = half(level);
  }
}

// What the panorama sees of the mesh.
void add_nearness(const pixels::SceneParts& scene, Vec3d position, Photo& photo) {
  const pixels::Lattice lattice(Camera{photo.size, photo.size, degrees(90)});
  const pixels::TileRows rows{0, lattice.blocks_down * pixels::kBlock};
  std::array<pixels::VisibilityBuffer, kCubeFaces> frames;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    pixels::Eye eye(position, Radians(0), Radians(0));
    const auto turned = [&](Vec3d axis) {
      return static_cast<float>(axis.x) * photo.right + static_cast<float>(axis.y) * photo.down +
             static_cast<float>(axis.z) * photo.forward;
    };
    eye.right = turned(kFaceAxes[k].right);
    eye.down = turned(kFaceAxes[k].down);
    eye.forward = turned(kFaceAxes[k].forward);
    frames[k].resize(lattice.blocks_across, lattice.blocks_down);
    frames[k].clear(lattice, rows);
    pixels::best_rasteriser()({scene.tree, scene.surfaces, lattice, eye}, rows, frames[k]);
  }
  append_faces(
      photo.size,
      [&](std::size_t face, std::uint32_t x, std::uint32_t y) {
        return frames[face].nearness[frames[face].pixel_place(x, y)];
      },
      photo.nearness);
}

// Texels at the edges of things show two things at once, mixed. In a plane nearness is linear, so
// that its second difference tells them; a negative nearness agrees with no point.
void leave_out_edges(Photo& photo) {
  constexpr float kBend = 0.03F, kLeastBend = 1e-3F;
  const std::size_t pitch = std::size_t{photo.size} + 2, face = bordered_texels(photo.size);
  std::vector<std::size_t> edges;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    for (std::size_t y = 1; y <= photo.size; ++y) {
      for (std::size_t x = 1; x <= photo.size; ++x) {
        const std::size_t at = k * face + y * pitch + x;
        const float* const n = photo.nearness.data() + at;
        const float bend = std::max(std::abs(n[-1] + n[1] - 2 * n[0]),
                                    std::abs(*(n - pitch) + n[pitch] - 2 * n[0]));
        if (bend > kBend * n[0] + kLeastBend) edges.push_back(at);
      }
    }
  }
  for (const std::size_t at : edges) photo.nearness[at] = -1;
}

void check(const PhotographsOptions& options) {
  if (options.face_size < kLeastFace || options.face_size > kMostFace) {
    throw ArgumentError(fmt::format("face_size: {} texels, not {} .. {}", options.face_size,
                                    kLeastFace, kMostFace));
  }
  if (options.nearest < 1 || options.nearest > kMostChosen) {
    throw ArgumentError(fmt::format("nearest: {}, not 1 .. {}", options.nearest, kMostChosen));
  }
}

}  // namespace

struct Photographs::Impl {
  struct Slot {
    ViewpointIndex viewpoint;
    std::mutex reading;                  // held by who reads it
    std::shared_ptr<const Photo> photo;  // null: not kept (here and below: under `mutex`)
    std::uint64_t used = 0;
  };
  std::shared_ptr<const scan::PanoramaSet> panoramas;
  const scan::PanoramaSource* source = nullptr;
  std::shared_ptr<const Scene> scene;
  PhotographsOptions options;
  std::vector<Vec3d> positions;
  std::unique_ptr<Slot[]> slots;
  std::mutex mutex;
  std::uint64_t uses = 0;
  std::size_t bytes = 0;

  static std::size_t bytes_of(const Photo& photo) {
    return sizeof photo + 4 * (photo.colours.capacity() + photo.nearness.capacity());
  }
  std::shared_ptr<const Photo> find(Slot& slot) {
    const std::lock_guard lock(mutex);
    slot.used = ++uses;
    return slot.photo;
  }
  void keep(Slot& slot, std::shared_ptr<const Photo> photo) {
    const std::lock_guard lock(mutex);
    slot.used = ++uses;
    bytes += bytes_of(*photo);
    slot.photo = std::move(photo);
    while (bytes > options.bytes) {
      Slot* oldest = nullptr;
      for (Slot* s = slots.get(); s != slots.get() + positions.size(); ++s) {
        if (s == &slot || s->photo == nullptr) continue;
        if (oldest == nullptr || s->used < oldest->used) oldest = s;
      }
      if (oldest == nullptr) return;
      bytes -= bytes_of(*oldest->photo);
      oldest->photo.reset();  // who draws with it has a share of it
    }
  }

  std::shared_ptr<const Photo> read(const Slot& slot) const {
    const scan::Panorama panorama =
        scan::read_panorama(*source, slot.viewpoint, scan::mask_of(scan::Layer::kColour));
    const scan::PanoramaPose& pose = source->poses()[slot.viewpoint.at()];
    Photo photo;
    photo.centre = to_float(pose.position);
    const auto& m = pose.world_from_panorama.m;
    photo.right = to_float({m[0], m[3], m[6]});
    photo.down = to_float({m[1], m[4], m[7]});
    photo.forward = to_float({m[2], m[5], m[8]});
    add_colours(panorama.colour, options.face_size, photo);
    add_nearness(scene->parts(), pose.position, photo);
    leave_out_edges(photo);
    return std::make_shared<const Photo>(std::move(photo));
  }
};

Photographs::Photographs(std::shared_ptr<const scan::PanoramaSet> panoramas, ScanIndex scan,
                         std::shared_ptr<const Scene> scene, const PhotographsOptions& options)
    : impl_(std::make_unique<Impl>()) {
  check(options);
  if (panoramas == nullptr) throw ArgumentError("panoramas: none");
  if (scene == nullptr) throw ArgumentError("scene: none");
  if (scan.at() >= panoramas->size()) {
    throw ArgumentError(
        fmt::format("scan: {}, but there are {} scans", scan.value, panoramas->size()));
  }
  impl_->source = &panoramas->source(scan);
  impl_->panoramas = std::move(panoramas);
  impl_->scene = std::move(scene);
  impl_->options = options;
  std::vector<ViewpointIndex> viewpoints;
  for (std::uint32_t v = 0; v < impl_->source->size(); ++v) {
    const scan::PanoramaPose& pose = impl_->source->poses()[v];
    if (!pose.included) continue;
    if (impl_->source->face_sizes(ViewpointIndex(v))[index(scan::Layer::kColour)] == 0) continue;
    viewpoints.emplace_back(v);
    impl_->positions.push_back(pose.position);
  }
  if (viewpoints.empty()) {
    throw LookupError(fmt::format("scan {}: no viewpoint has pictures in {}", impl_->source->scan(),
                                  impl_->source->origin()));
  }
  impl_->slots = std::make_unique<Impl::Slot[]>(viewpoints.size());
  for (std::size_t k = 0; k < viewpoints.size(); ++k) impl_->slots[k].viewpoint = viewpoints[k];
}

Photographs::~Photographs() = default;

std::size_t Photographs::size() const noexcept { return impl_->positions.size(); }
const Scene& Photographs::scene() const noexcept { return *impl_->scene; }
std::span<const Vec3d> Photographs::positions() const noexcept { return impl_->positions; }

void Photographs::load_all(int threads) const {
  parallel_for(size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) photo(k);
  });
}

std::size_t Photographs::choose(Vec3d eye, std::span<std::size_t> chosen) const {
  struct Candidate {
    double distance = std::numeric_limits<double>::infinity();
    std::size_t place = 0;
  };
  // The nearest ones; then those that the eye sees before others that are not much nearer.
  constexpr std::size_t kCandidates = 12;
  constexpr double kUnseen = 3;
  std::array<Candidate, kCandidates> best;
  std::size_t count = 0;
  const auto insert = [&](Candidate candidate, std::size_t limit) {
    if (count == limit && !(candidate.distance < best[count - 1].distance)) return;
    if (count < limit) ++count;
    std::size_t at = count - 1;
    for (; at > 0 && best[at - 1].distance > candidate.distance; --at) best[at] = best[at - 1];
    best[at] = candidate;
  };
  for (std::size_t k = 0; k < impl_->positions.size(); ++k) {
    insert({length(impl_->positions[k] - eye), k}, kCandidates);
  }
  const std::array<Candidate, kCandidates> near = best;
  const std::size_t found = count;
  const std::size_t wanted = std::min(impl_->options.nearest, chosen.size());
  count = 0;
  for (std::size_t k = 0; k < found; ++k) {
    Candidate candidate = near[k];
    const Vec3d at = impl_->positions[candidate.place];
    if (!impl_->scene->tracer().sees(to_float(eye), to_float(at))) candidate.distance *= kUnseen;
    insert(candidate, wanted);
  }
  for (std::size_t k = 0; k < count; ++k) chosen[k] = best[k].place;
  return count;
}

std::shared_ptr<const Photo> Photographs::photo(std::size_t k) const {
  Impl::Slot& slot = impl_->slots[k];
  if (auto kept = impl_->find(slot)) return kept;
  const std::lock_guard reading(slot.reading);
  if (auto kept = impl_->find(slot)) return kept;
  std::shared_ptr<const Photo> made = impl_->read(slot);
  impl_->keep(slot, made);
  return made;
}

}  // namespace enfilade::continuous
