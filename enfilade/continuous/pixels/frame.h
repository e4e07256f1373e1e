/// \file  One picture while it is drawn: which triangle each pixel sees, and how far away.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "enfilade/geometry/cube_map.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::continuous::pixels {

/// Pixels are kept in tiles of 8 x 8, tiles in blocks of 4 x 4.
inline constexpr std::uint32_t kTile = 8, kTilePixels = kTile * kTile;
inline constexpr std::uint32_t kBlock = 4, kBlockTiles = kBlock * kBlock;
/// Triangle of a pixel that sees nothing.
inline constexpr std::int32_t kNothing = -1;
/// The nearness (1 / distance) of nothing: a distance beyond all others.
inline constexpr float kLeastNearness = 1e-30F;

/// Pinhole pictures: the point of the plane z = 1 of each column and each row of pixels, for whole
/// tiles, the last one's surplus included.
struct Lattice {
  std::uint32_t width = 0, height = 0;  ///< pixels
  std::uint32_t tiles_across = 0, tiles_down = 0;
  std::uint32_t blocks_across = 0, blocks_down = 0;
  std::vector<float> x, y;  ///< by column; by row
  /// The same for the 64 pixels of a tile, by column and by row of tiles.
  std::vector<std::array<float, kTilePixels>> tile_x, tile_y;
  float centre_x = 0, centre_y = 0;  ///< column and row of the optical axis
  float focal = 0;                   ///< pixels
  float edge_x = 0, edge_y = 0;      ///< x and y of the picture's edges

  Lattice() = default;
  explicit Lattice(const Camera& camera);
};

/// Position and direction of the eye.
struct Eye {
  Vec3d position;
  /// The position in two parts, so that differences to points near it keep their digits.
  Vec3f whole, rest;
  Vec3f right, down, forward;  ///< axes of the camera in the world, length 1

  Eye() = default;
  Eye(Vec3d at, Radians heading, Radians elevation, Radians roll = Radians(0));
};

/// Rows of tiles begin .. end - 1.
struct TileRows {
  std::uint32_t begin = 0, end = 0;
};

/// The triangles that the pixels of a picture see. Tiles lie by block, row-major both:
/// tile_place().
class VisibilityBuffer {
 public:
  std::vector<float> nearness;         ///< 1 / distance along the optical axis, by pixel
  std::vector<std::int32_t> triangle;  ///< or kNothing
  std::vector<float> tile_far;         ///< the least nearness in each tile
  std::vector<float> block_far;        ///< and in each block

  /// Room for pictures of that size. Keeps its memory.
  void resize(std::uint32_t blocks_across, std::uint32_t blocks_down);
  /// Forgets what these rows of tiles see. Pixels beyond the picture's edge are taken as full.
  /// \param far  what is not nearer, metres, will not be seen
  void clear(const Lattice& lattice, TileRows rows,
             float far = std::numeric_limits<float>::infinity());

  std::size_t tile_place(std::uint32_t tile_x, std::uint32_t tile_y) const {
    const std::size_t block = std::size_t{tile_y / kBlock} * blocks_across_ + tile_x / kBlock;
    return block * kBlockTiles + tile_y % kBlock * kBlock + tile_x % kBlock;
  }
  std::size_t pixel_place(std::uint32_t column, std::uint32_t row) const {
    return tile_place(column / kTile, row / kTile) * kTilePixels + row % kTile * kTile +
           column % kTile;
  }
  std::uint32_t blocks_across() const noexcept { return blocks_across_; }

 private:
  std::uint32_t blocks_across_ = 0;
};

}  // namespace enfilade::continuous::pixels
