/// \file  Panoramas whose every pixel can be computed: directions as colours, a room of known
/// walls.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "enfilade/render/renderer.h"
#include "tests/support/panoramas.h"

namespace enfilade::render::testing {

/// The colour of a direction of the panorama frame: its parts, from [-1, 1] to [0, 255].
inline std::array<double, 3> direction_colour(Vec3d d) {
  const double n = length(d);
  return {(d.x / n + 1) * 127.5, (d.y / n + 1) * 127.5, (d.z / n + 1) * 127.5};
}

/// Walls of an axis-aligned box around the eye, metres, in the panorama frame (y down).
struct Room {
  Vec3d low{-2.5, -1.3, -3.1}, high{1.7, 1.5, 4.2};

  /// Distance from the eye to the wall, along a direction of any length.
  double distance(Vec3d d) const {
    const auto to = [](double direction, double a, double b) {
      return direction == 0 ? 1e30 : (direction > 0 ? b : a) / direction;
    };
    return length(d) *
           std::min({to(d.x, low.x, high.x), to(d.y, low.y, high.y), to(d.z, low.z, high.z)});
  }
};

/// Colours of directions, the room's depth, the face's number + 1 as class, and instances that tell
/// face, row and column.
inline scan::Panorama made_panorama(std::uint32_t size) {
  scan::Panorama p = scan::make_panorama(size);
  const Room room;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    for (std::uint32_t y = 0; y < size; ++y) {
      for (std::uint32_t x = 0; x < size; ++x) {
        const Vec3d d = cube_direction(cube_face(k), (x + 0.5) / size, (y + 0.5) / size);
        const auto colour = direction_colour(d);
        for (std::size_t c = 0; c < 3; ++c) {
          p.colour[k].at(x, y)[c] = static_cast<std::uint8_t>(std::lround(colour[c]));
        }
        *p.depth[k].at(x, y) =
            static_cast<std::uint16_t>(std::lround(room.distance(d) * scan::kDepthUnitsPerMetre));
        *p.classes[k].at(x, y) = static_cast<std::uint16_t>(k + 1);
        *p.instances[k].at(x, y) = static_cast<std::uint32_t>((k * size + y) * size + x + 1);
      }
    }
  }
  return p;
}

/// A cache over panoramas of one scan, "v0", "v1", ... level and looking along +y.
inline std::shared_ptr<FaceCache> cache_of(std::vector<scan::Panorama> panoramas,
                                           const FaceCacheConfig& config = {}) {
  const std::size_t count = panoramas.size();
  return std::make_shared<FaceCache>(
      scan::PanoramaSet::of({std::make_shared<const scan::MemoryPanoramas>(
          scan::testing::row_of_viewpoints("made", count), std::move(panoramas))}),
      config);
}

inline std::shared_ptr<FaceCache> made_cache(std::uint32_t size, std::size_t count = 1) {
  return cache_of(std::vector<scan::Panorama>(count, made_panorama(size)));
}

/// The pixel's ray in the panorama frame of such a panorama.
inline Vec3d ray_of(const Camera& camera, const View& view, double row, double column) {
  const Mat3d world_from_panorama{{1, 0, 0, 0, 0, 1, 0, -1, 0}};
  return pixel_rays(camera, transpose(world_from_panorama) *
                                world_from_camera(view.heading, view.elevation))
      .at(row, column);
}

/// Memory for all outputs of n views.
struct Pictures {
  std::size_t pixels;
  std::vector<std::byte> colour;
  std::vector<float> depth;
  std::vector<std::uint16_t> classes;
  std::vector<std::uint32_t> instances;

  Pictures(const Camera& camera, std::size_t views)
      : pixels(views * camera.width * camera.height),
        colour(pixels * 3),
        depth(pixels),
        classes(pixels),
        instances(pixels) {}
  Outputs outputs() {
    return {ColourOutput{ColourFormat::kRgb8, {}, colour},
            DepthOutput{DepthFormat::kMetresFloat32, DepthMeasure::kZ,
                        std::as_writable_bytes(std::span(depth))},
            ClassOutput{ClassFormat::kUint16, std::as_writable_bytes(std::span(classes))},
            InstanceOutput{instances}};
  }
  int channel(std::size_t pixel, std::size_t c) const {
    return std::to_integer<int>(colour[3 * pixel + c]);
  }
  bool operator==(const Pictures&) const = default;
};

inline View random_view(Rng& rng, std::size_t viewpoints = 1) {
  return {ScanIndex(0), ViewpointIndex(rng.below(viewpoints)), Radians((rng.uniform() - 0.5) * 20),
          Radians((rng.uniform() - 0.5) * kPi)};
}

}  // namespace enfilade::render::testing
