/// \file  Colours of pixels, by the triangles that they see.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/continuous/eyes.h"
#include "enfilade/continuous/pixels/frame.h"
#include "enfilade/continuous/pixels/photo.h"
#include "enfilade/continuous/pixels/scene_parts.h"
#include "enfilade/render/renderer.h"

namespace enfilade::continuous::pixels {

/// Directions of the pixels of an equirectangular picture.
struct Sphere {
  std::uint32_t width = 0, height = 0;
  std::vector<Vec3f> column;     ///< level, relative to heading 0: right, forward as x, y
  std::vector<float> level, up;  ///< by row: cosine and sine of the elevation

  Sphere() = default;
  Sphere(std::uint32_t width, std::uint32_t height);
};

/// Pixels of a picture as rays: of a lattice or a sphere, one of the two.
struct Pixels {
  const Lattice* lattice = nullptr;
  const Sphere* sphere = nullptr;
  float spread = 0;  ///< angle between two pixels, about

  std::uint32_t width() const { return lattice != nullptr ? lattice->width : sphere->width; }
  std::uint32_t height() const { return lattice != nullptr ? lattice->height : sphere->height; }
  /// In the world; of length 1 along the optical axis of a lattice, and of length 1 of a sphere.
  Vec3f towards(const Eye& eye, std::uint32_t column, std::uint32_t row) const {
    if (lattice != nullptr) {
      return lattice->x[column] * eye.right + lattice->y[row] * eye.down + eye.forward;
    }
    const Vec3f c = sphere->column[column];
    // A sphere's eye is level: right and forward are horizontal.
    return sphere->level[row] * (c.x * eye.right + c.y * eye.forward) +
           Vec3f{0, 0, sphere->up[row]};
  }
};

/// Functions that compute the colours of tiles.
struct Colouring {
  Shader shader = nullptr;  ///< null: PixelPainter::look() for each pixel
  Reprojector reprojector = reproject_plainly;
};

/// Paints the pictures of one eye.
class PixelPainter {
 public:
  /// \param photos the panoramas that colours come from where they see
  PixelPainter(const SceneParts& scene, const Pixels& pixels, const Eye& eye,
               const Colouring& colouring, std::span<const Photo* const> photos = {})
      : scene_(scene), pixels_(pixels), eye_(eye), colouring_(colouring), photos_(photos) {}

  /// Finds what pixels see by rays. \pre frame.resize()
  void trace(TileRows rows, const DepthRange& range, VisibilityBuffer& frame) const;
  /// Writes the outputs of view `view` for these rows of tiles. \param line room for a row of
  /// pixels
  void paint(const VisibilityBuffer& frame, TileRows rows, const render::Outputs& outputs,
             std::size_t view, std::vector<std::uint32_t>& lines) const;
  static std::uint32_t line_pitch(std::uint32_t width) {
    return (width + kTile - 1) / kTile * kTile;
  }

  /// Light from a point of a triangle, or the sky. \param distance in lengths of `towards`
  Vec3f look(std::int32_t triangle, Vec3f towards, float distance) const {
    if (triangle < 0) return sky(towards);
    const Surface& surface = scene_.surfaces.all[static_cast<std::size_t>(triangle)];
    const Vec3f from = (eye_.whole - surface.origin) + eye_.rest + distance * towards;
    const Paint& paint = scene_.surfaces.paints[surface.paint];
    const Vec3f light = look(surface, paint, from, towards, distance);
    return paint.mirror > 0 ? mirrored(surface, paint, from, towards, light) : light;
  }

 private:
  // Whether textures are averaged as OpenGL does, which needs the picture's axes.
  bool takes_longer_step() const { return scene_.habitat && pixels_.lattice != nullptr; }
  float longer_step(const Surface& surface, Vec3f towards, float across) const;
  Vec3f sky(Vec3f towards) const;
  Vec3f look(const Surface& surface, const Paint& paint, Vec3f from, Vec3f towards,
             float distance) const;
  Vec3f mirrored(const Surface& surface, const Paint& paint, Vec3f from, Vec3f towards,
                 Vec3f light) const;
  void find_directions(std::uint32_t tile_x, std::uint32_t tile_y, Directions& out) const;
  void find_directions(const Lattice& lattice, std::uint32_t tile_x, std::uint32_t tile_y,
                       Directions& out) const;
  void colour(const TileColours& tile, std::array<std::uint32_t, kTilePixels>& rgba) const;
  void colour_tiles(const VisibilityBuffer& frame, std::uint32_t tile_y,
                    std::vector<std::uint32_t>& lines) const;
  void paint_depth(const VisibilityBuffer& frame, std::uint32_t row,
                   const render::DepthOutput& output, std::size_t first) const;

  const SceneParts& scene_;
  const Pixels& pixels_;
  const Eye& eye_;
  Colouring colouring_;
  std::span<const Photo* const> photos_;
};

}  // namespace enfilade::continuous::pixels
