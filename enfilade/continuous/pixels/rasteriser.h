/// \file  The triangle that each pixel of a pinhole picture sees. All triangles are drawn from
/// front to back, and hidden ones are left out early.
///
/// A pixel sees the triangle of the largest nearness there, of equal ones the lowest number. That
/// does not depend on the order of drawing, so that all versions below, in any number of bands,
/// give the same bits.
#pragma once
#include <limits>
#include <string>
#include <vector>

#include "enfilade/continuous/pixels/frame.h"
#include "enfilade/continuous/pixels/surfaces.h"
#include "enfilade/continuous/pixels/tree.h"

namespace enfilade::continuous::pixels {

/// Scene and eye of a picture.
struct RasterView {
  const Tree& tree;
  const Surfaces& surfaces;
  const Lattice& lattice;
  const Eye& eye;
  bool fronts_only = false;  ///< triangles whose corners are clockwise are left out
  float near = 0;            ///< pixels of a triangle that are nearer are left out, metres

  float most_nearness() const {
    return near > 0 ? 1 / near : std::numeric_limits<float>::infinity();
  }
};

/// Draws these rows of tiles, whole rows of blocks. \pre frame.clear()
using Rasteriser = void (*)(const RasterView& sight, TileRows rows, VisibilityBuffer& frame);

/// With the processor's best vector instructions.
Rasteriser best_rasteriser();
/// One triangle and one pixel after another: the reference for the others.
void rasterise_plainly(const RasterView& sight, TileRows rows, VisibilityBuffer& frame);

struct RasteriserVariant {
  std::string name;  ///< of the instruction set: "AVX2"
  Rasteriser draw;
};
/// All that the processor supports, the best first.
const std::vector<RasteriserVariant>& rasteriser_variants();

/// Whether a triangle's texture has no hole where a pixel sees it, at (x, y) of the lattice.
inline bool is_there(const Surfaces& surfaces, const Eye& eye, std::uint32_t triangle, float x,
                     float y, float nearness) {
  const Surface& surface = surfaces.all[triangle];
  const Vec3f from = (eye.whole - surface.origin) + eye.rest +
                     (1 / nearness) * (x * eye.right + y * eye.down + eye.forward);
  return surfaces.is_there(triangle, weights_at(surface, from));
}

/// Corners nearer than this to the plane through the eye, metres, have no place in the picture.
inline constexpr float kLeastDepth = 1e-4F;
/// How far outside the corners' box, in pixels, a pixel's middle may be: corners are rounded.
inline constexpr float kBoxSlack = 0.02F;

}  // namespace enfilade::continuous::pixels
