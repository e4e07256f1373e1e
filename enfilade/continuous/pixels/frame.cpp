#include "enfilade/continuous/pixels/frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace enfilade::continuous::pixels {
namespace {

constexpr std::uint32_t parts(std::uint32_t of, std::uint32_t size) {
  return (of + size - 1) / size;
}

// The points of one axis: (k - middle) / focal for k = 0 ..
std::vector<float> points(std::uint32_t count, double middle, double focal) {
  std::vector<float> at(count);
  for (std::uint32_t k = 0; k < count; ++k) at[k] = static_cast<float>((k - middle) / focal);
  return at;
}

}  // namespace

Lattice::Lattice(const Camera& camera)
    : width(camera.width),
      height(camera.height),
      tiles_across(parts(width, kTile)),
      tiles_down(parts(height, kTile)),
      blocks_across(parts(tiles_across, kBlock)),
      blocks_down(parts(tiles_down, kBlock)) {
  const double half = std::tan(camera.vertical_field_of_view.value / 2);
  const double pixels = height / (2 * half);
  const double middle_x = (width - 1.0) / 2, middle_y = (height - 1.0) / 2;
  x = points(blocks_across * kBlock * kTile, middle_x, pixels);
  y = points(blocks_down * kBlock * kTile, middle_y, pixels);
  tile_x.resize(tiles_across);
  tile_y.resize(tiles_down);
  for (std::uint32_t t = 0; t < tiles_across; ++t) {
    for (std::uint32_t k = 0; k < kTilePixels; ++k) tile_x[t][k] = x[t * kTile + k % kTile];
  }
  for (std::uint32_t t = 0; t < tiles_down; ++t) {
    for (std::uint32_t k = 0; k < kTilePixels; ++k) tile_y[t][k] = y[t * kTile + k / kTile];
  }
  centre_x = static_cast<float>(middle_x);
  centre_y = static_cast<float>(middle_y);
  focal = static_cast<float>(pixels);
  edge_x = static_cast<float>(half * width / height);
  edge_y = static_cast<float>(half);
}

Eye::Eye(Vec3d at, Radians heading, Radians elevation, Radians roll)
    : position(at), whole(to_float(at)) {
  rest = to_float(at - to_double(whole));
  const Mat3d axes = world_from_camera(heading, elevation);
  Vec3d across{axes.m[0], axes.m[3], axes.m[6]}, below{axes.m[1], axes.m[4], axes.m[7]};
  if (roll.value != 0) {  // otherwise zeros keep their signs
    const double c = std::cos(roll.value), s = std::sin(roll.value);
    const Vec3d level = across;
    across = c * level + s * below;
    below = c * below - s * level;
  }
  right = to_float(across);
  down = to_float(below);
  forward = to_float({axes.m[2], axes.m[5], axes.m[8]});
}

void VisibilityBuffer::resize(std::uint32_t blocks_across, std::uint32_t blocks_down) {
  blocks_across_ = blocks_across;
  const std::size_t blocks = std::size_t{blocks_across} * blocks_down;
  const std::size_t tiles = blocks * kBlockTiles;
  nearness.resize(tiles * kTilePixels);
  triangle.resize(tiles * kTilePixels);
  tile_far.resize(tiles);
  block_far.resize(blocks);
}

void VisibilityBuffer::clear(const Lattice& lattice, TileRows rows, float far) {
  constexpr float kFull = std::numeric_limits<float>::max();
  const float least = std::max(1 / far, kLeastNearness);
  for (std::uint32_t ty = rows.begin; ty < rows.end; ++ty) {
    for (std::uint32_t tx = 0; tx < blocks_across_ * kBlock; ++tx) {
      const std::size_t tile = tile_place(tx, ty);
      const bool outside = tx >= lattice.tiles_across || ty >= lattice.tiles_down;
      tile_far[tile] = outside ? kFull : least;
      if (outside) continue;
      const std::size_t first = tile * kTilePixels;
      std::fill_n(nearness.begin() + static_cast<std::ptrdiff_t>(first), kTilePixels, least);
      std::fill_n(triangle.begin() + static_cast<std::ptrdiff_t>(first), kTilePixels, kNothing);
      const std::uint32_t columns = std::min(lattice.width - tx * kTile, kTile);
      const std::uint32_t lines = std::min(lattice.height - ty * kTile, kTile);
      for (std::uint32_t k = 0; k < kTilePixels; ++k) {
        if (k % kTile >= columns || k / kTile >= lines) nearness[first + k] = kFull;
      }
    }
  }
  // The bands that threads draw are whole rows of blocks.
  for (std::uint32_t by = rows.begin / kBlock; by < (rows.end + kBlock - 1) / kBlock; ++by) {
    std::fill_n(block_far.begin() + static_cast<std::ptrdiff_t>(std::size_t{by} * blocks_across_),
                blocks_across_, least);
  }
}

}  // namespace enfilade::continuous::pixels
