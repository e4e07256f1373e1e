/// \file  Procedural textures of floors, walls and fabrics: square, sRGB, 3 channels, seamless.
#pragma once
#include <cstdint>
#include <functional>

#include "enfilade/core/rng.h"
#include "enfilade/image/image.h"

namespace enfilade::image {

/// sRGB, each in [0, 1].
struct Rgb {
  double r = 0, g = 0, b = 0;
};
Rgb mix(Rgb a, Rgb b, double t);
/// Lighter (above 1) or darker.
Rgb shade(Rgb a, double by);

/// A picture of 3 channels from the colour at each (u, v), pixel centres in (0, 1), v downwards.
/// `colour` is called from several threads at once.
Image8 paint(std::uint32_t width, std::uint32_t height,
             const std::function<Rgb(double u, double v)>& colour);

/// Value noise in [0, 1] that repeats after `period_x` (`period_y`) cells; smooth.
class Noise {
 public:
  /// The same seed gives the same noise.
  explicit Noise(std::uint64_t seed) : seed_(seed) {}
  /// At a point, in cells.
  double at(double x, double y, unsigned period_x, unsigned period_y) const;
  /// Octaves of halving size and weight; u, v in [0, 1) of a picture.
  double cloud(double u, double v, unsigned cells, unsigned octaves) const;

 private:
  double lattice(std::uint64_t x, std::uint64_t y) const;
  std::uint64_t seed_;
};

/// A texture that is painted when called. All random numbers are drawn when it is created, so that
/// leaving out the painting of one does not change the others.
using Texture = std::function<Image8()>;

/// Floors of wood: boards side by side, or blocks of them alternately turned.
Texture planks(Rng& rng, Rgb tone, unsigned boards);
Texture parquet(Rng& rng, Rgb tone, unsigned blocks);
/// Grain only, for furniture.
Texture wood(Rng& rng, Rgb tone);
/// Alternating `a` and `b`, as on a chess board.
Texture tiles(Rng& rng, Rgb a, Rgb b, Rgb grout, unsigned across);
/// Bricks or oblong tiles, each row shifted by half a brick.
Texture bricks(Rng& rng, Rgb tone, Rgb mortar, unsigned rows, double roughness);
/// Surfaces of one tone, or of a ground with veins.
Texture carpet(Rng& rng, Rgb tone);
Texture marble(Rng& rng, Rgb ground, Rgb veins);
Texture concrete(Rng& rng, Rgb tone);
Texture plaster(Rng& rng, Rgb tone);
Texture leather(Rng& rng, Rgb tone);
/// The pattern of a fabric.
enum class Weave : std::uint8_t { kPlain, kStriped, kChecked };
/// Cloth of two tones.
Texture fabric(Rng& rng, Rgb tone, Rgb second, Weave weave);
/// The pattern of a wallpaper.
enum class Paper : std::uint8_t { kStripes, kDamask, kDots, kLeaves };
/// Motifs on a ground.
Texture wallpaper(Rng& rng, Rgb ground, Rgb motif, Paper paper);
/// The pattern of a rug.
enum class Rug : std::uint8_t { kBordered, kMedallion, kStripes, kDiamonds };
/// Covers the whole rug once; not seamless.
Texture rug(Rng& rng, Rgb tone, Rgb second, Rgb third, Rug pattern);

}  // namespace enfilade::image
