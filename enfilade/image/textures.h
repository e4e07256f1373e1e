/// \file  Seamless pictures of surfaces, made by arithmetic. All are square, sRGB, 3 channels.
#pragma once
#include <cstdint>

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

/// Noise in [0, 1] that repeats after `period_x` (`period_y`) cells; smooth.
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

/// Floors of wood: boards side by side, or blocks of them turned by turns.
Image8 planks(Rng& rng, Rgb tone, unsigned boards);
Image8 parquet(Rng& rng, Rgb tone, unsigned blocks);
/// Grain only, for furniture.
Image8 wood(Rng& rng, Rgb tone);
/// `a` and `b` take turns like a chess board's fields.
Image8 tiles(Rng& rng, Rgb a, Rgb b, Rgb grout, unsigned across);
/// Bricks or oblong tiles: each row half a brick aside.
Image8 bricks(Rng& rng, Rgb tone, Rgb mortar, unsigned rows, double roughness);
/// Surfaces of one tone, or of a ground with veins.
Image8 carpet(Rng& rng, Rgb tone);
Image8 marble(Rng& rng, Rgb ground, Rgb veins);
Image8 concrete(Rng& rng, Rgb tone);
Image8 plaster(Rng& rng, Rgb tone);
Image8 leather(Rng& rng, Rgb tone);
/// The pattern of a fabric.
enum class Weave : std::uint8_t { kPlain, kStriped, kChecked };
/// Cloth of two tones.
Image8 fabric(Rng& rng, Rgb tone, Rgb second, Weave weave);
/// The pattern of a wallpaper.
enum class Paper : std::uint8_t { kStripes, kDamask, kDots, kLeaves };
/// Motifs on a ground.
Image8 wallpaper(Rng& rng, Rgb ground, Rgb motif, Paper paper);
/// The pattern of a rug.
enum class Rug : std::uint8_t { kBordered, kMedallion, kStripes, kDiamonds };
/// Once over, not seamless.
Image8 rug(Rng& rng, Rgb tone, Rgb second, Rgb third, Rug pattern);

}  // namespace enfilade::image
