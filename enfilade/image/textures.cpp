#include "enfilade/image/textures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "enfilade/core/threads.h"

namespace enfilade::image {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr std::uint32_t kLarge = 256, kSmall = 128;

template <class Colour>
Texture picture(std::uint32_t size, Colour colour) {
  return [size, colour = std::move(colour)] { return paint(size, size, colour); };
}

double distance(double x, double y) { return std::sqrt(x * x + y * y); }
double fraction(double x) { return x - std::floor(x); }
double smooth(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
/// 0 at a cell's edges, 1 from `width` (share of the cell) on.
double inside(double cell, double width) { return smooth(0, width, std::min(cell, 1 - cell)); }
std::uint64_t cell_of(double x) { return static_cast<std::uint64_t>(std::floor(x)); }

double grain(const Noise& noise, double u, double v, double offset) {
  const double rings = noise.at(u * 3, v * 24 + offset, 3, 24);
  const double fine = noise.at(u * 10, v * 110 + offset, 10, 110);
  return 0.62 * rings + 0.38 * fine;
}

/// How much of a mirrored, flower-like figure lies at a point of its cell, [-1, 1]^2.
double damask(double x, double y) {
  const double ax = std::abs(x);
  const double r = std::sqrt(ax * ax + y * y), angle = std::atan2(ax, y);
  const double flower = 0.30 + 0.17 * std::cos(5 * angle) + 0.12 * std::cos(2 * angle);
  double in = smooth(0.03, -0.03, r - flower);
  in = std::max(in, smooth(0.02, -0.02, std::abs(r - 0.62) - 0.035 - 0.04 * std::cos(8 * angle)));
  const double leaf = distance((ax - 0.68) * 1.6, (y - 0.68) * 0.9);
  in = std::max(in, smooth(0.03, -0.03, leaf - 0.24));
  if (r < 0.12) in = 0;
  return in;
}

double leaves(double x, double y) {
  const double ax = std::abs(x);
  double in = smooth(0.02, -0.02, ax - 0.035);
  for (const double at : {-0.7, -0.1, 0.5}) {
    const double dx = ax - 0.33, dy = y - at - 0.5 * dx;
    in = std::max(in, smooth(0.03, -0.03, distance(dx * 0.75, dy * 2.1) - 0.23));
  }
  return in;
}

}  // namespace

Image8 paint(std::uint32_t width, std::uint32_t height,
             const std::function<Rgb(double u, double v)>& colour) {
  Image8 out(width, height, 3);
  const auto byte = [](double x) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0, 1.0) * 255));
  };
  constexpr std::size_t kGrain = 32;
  parallel_for(height, kGrain, 0, [&](std::size_t first, std::size_t last) {
    for (auto y = static_cast<std::uint32_t>(first); y < last; ++y) {
      for (std::uint32_t x = 0; x < width; ++x) {
        const Rgb c = colour((x + 0.5) / width, (y + 0.5) / height);
        std::uint8_t* p = out.at(x, y);
        p[0] = byte(c.r);
        p[1] = byte(c.g);
        p[2] = byte(c.b);
      }
    }
  });
  return out;
}

Rgb mix(Rgb a, Rgb b, double t) {
  return {a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t};
}
Rgb shade(Rgb a, double by) { return {a.r * by, a.g * by, a.b * by}; }

double Noise::lattice(std::uint64_t x, std::uint64_t y) const {
  std::uint64_t h = seed_ + x * 0x9E3779B97F4A7C15U + y * 0xC2B2AE3D27D4EB4FU;
  h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9U;
  h = (h ^ (h >> 27)) * 0x94D049BB133111EBU;
  return static_cast<double>((h ^ (h >> 31)) >> 11) * 0x1p-53;
}

double Noise::at(double x, double y, unsigned period_x, unsigned period_y) const {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto wrap = [](double value, unsigned period) {
    const auto p = static_cast<std::int64_t>(period);
    return static_cast<std::uint64_t>((static_cast<std::int64_t>(value) % p + p) % p);
  };
  const std::uint64_t x0 = wrap(fx, period_x), x1 = wrap(fx + 1, period_x);
  const std::uint64_t y0 = wrap(fy, period_y), y1 = wrap(fy + 1, period_y);
  const double tx = smooth(0, 1, x - fx), ty = smooth(0, 1, y - fy);
  const double a = lattice(x0, y0) + (lattice(x1, y0) - lattice(x0, y0)) * tx;
  const double b = lattice(x0, y1) + (lattice(x1, y1) - lattice(x0, y1)) * tx;
  return a + (b - a) * ty;
}

double Noise::cloud(double u, double v, unsigned cells, unsigned octaves) const {
  double sum = 0, weight = 1, whole = 0;
  for (unsigned i = 0; i < octaves; ++i, cells *= 2, weight /= 2) {
    sum += weight * at(u * cells, v * cells, cells, cells);
    whole += weight;
  }
  return sum / whole;
}

Texture wood(Rng& rng, Rgb tone) {
  const Noise noise(rng.next());
  return picture(
      kLarge, [=](double u, double v) { return shade(tone, 0.80 + 0.36 * grain(noise, u, v, 0)); });
}

Texture planks(Rng& rng, Rgb tone, unsigned boards) {
  const Noise noise(rng.next());
  std::vector<double> joint(boards), light(2 * std::size_t{boards});
  for (double& j : joint) j = rng.uniform();
  for (double& l : light) l = 0.86 + 0.26 * rng.uniform();
  return picture(kLarge, [=](double u, double v) {
    const std::uint64_t board = cell_of(v * boards);
    const double along = fraction(u - joint[board]);
    const bool second = along > 0.5;
    const double edge = inside(fraction(v * boards), 0.06) * inside(fraction(2 * along), 0.006);
    const double by = light[2 * board + (second ? 1 : 0)] *
                      (0.84 + 0.30 * grain(noise, u, v, double(board) * 7.3));
    return shade(tone, by * (0.55 + 0.45 * edge));
  });
}

Texture parquet(Rng& rng, Rgb tone, unsigned blocks) {
  const Noise noise(rng.next());
  constexpr unsigned kSlats = 4;
  return picture(kLarge, [=](double u, double v) {
    const std::uint64_t bx = cell_of(u * blocks), by = cell_of(v * blocks);
    const bool upright = (bx + by) % 2 == 1;
    const double across = upright ? fraction(u * blocks) : fraction(v * blocks);
    const double along = upright ? fraction(v * blocks) : fraction(u * blocks);
    const std::uint64_t slat = cell_of(across * kSlats);
    const double light =
        0.84 + 0.3 * noise.at(double(bx * 4 + slat) + 0.01, double(by) + 0.01, 64, 64);
    const double g = upright ? grain(noise, v, u, 0) : grain(noise, u, v, 0);
    const double edge = inside(fraction(across * kSlats), 0.08) * inside(along, 0.02);
    return shade(tone, light * (0.86 + 0.26 * g) * (0.62 + 0.38 * edge));
  });
}

Texture tiles(Rng& rng, Rgb a, Rgb b, Rgb grout, unsigned across) {
  const Noise noise(rng.next());
  return picture(kLarge, [=](double u, double v) {
    const double x = u * across, y = v * across;
    const std::uint64_t ix = cell_of(x), iy = cell_of(y);
    const double own = noise.at(double(ix) + 0.001, double(iy) + 0.001, across, across);
    const Rgb tile = shade((ix + iy) % 2 == 0 ? a : b,
                           0.95 + 0.06 * own + 0.05 * (noise.cloud(u, v, 8, 3) - 0.5));
    return mix(grout, tile, inside(fraction(x), 0.05) * inside(fraction(y), 0.05));
  });
}

Texture bricks(Rng& rng, Rgb tone, Rgb mortar, unsigned rows, double roughness) {
  const Noise noise(rng.next());
  const unsigned columns = rows / 2;
  return picture(kLarge, [=](double u, double v) {
    const double y = v * rows;
    const std::uint64_t iy = cell_of(y);
    const double x = u * columns + (iy % 2 == 1 ? 0.5 : 0);
    const std::uint64_t ix = cell_of(x) % columns;
    const double own = noise.at(double(ix) + 0.001, double(iy) + 0.001, columns, rows);
    const double rough = noise.cloud(u, v, 24, 3) - 0.5;
    const Rgb brick = shade(tone, 1 + roughness * (0.55 * (own - 0.5) + 0.5 * rough));
    return mix(mortar, brick, inside(fraction(x), 0.035) * inside(fraction(y), 0.07));
  });
}

Texture carpet(Rng& rng, Rgb tone) {
  const Noise noise(rng.next());
  return picture(kSmall, [=](double u, double v) {
    const double tuft = noise.at(u * 64, v * 64, 64, 64), wide = noise.cloud(u, v, 4, 2);
    return shade(tone, 0.80 + 0.30 * tuft + 0.1 * wide);
  });
}

Texture marble(Rng& rng, Rgb ground, Rgb veins) {
  const Noise noise(rng.next());
  return picture(kLarge, [=](double u, double v) {
    const double bend = 2.2 * noise.cloud(u, v, 3, 5);
    const double vein = std::abs(std::sin(kTwoPi * (u + v + bend)));
    const double fine = std::abs(std::sin(kTwoPi * (2 * u - v + 1.7 * noise.cloud(v, u, 4, 4))));
    const double a = (1 - vein) * (1 - vein), b = (1 - fine) * (1 - fine);
    const double dark = 0.75 * a * a * (1 - vein) + 0.35 * b * b * b * b;
    return mix(shade(ground, 0.95 + 0.08 * noise.cloud(u, v, 5, 3)), veins, std::min(dark, 0.85));
  });
}

Texture concrete(Rng& rng, Rgb tone) {
  const Noise noise(rng.next());
  return picture(kLarge, [=](double u, double v) {
    const double pore = noise.at(u * 90, v * 90, 90, 90) > 0.93 ? 0.9 : 1.0;
    return shade(tone, pore * (0.86 + 0.26 * noise.cloud(u, v, 4, 5)));
  });
}

Texture plaster(Rng& rng, Rgb tone) {
  const Noise noise(rng.next());
  return picture(kSmall, [=](double u, double v) {
    return shade(tone, 0.965 + 0.06 * noise.cloud(u, v, 8, 4));
  });
}

Texture leather(Rng& rng, Rgb tone) {
  const Noise noise(rng.next());
  return picture(kSmall, [=](double u, double v) {
    const double crease = std::abs(noise.cloud(u, v, 20, 2) - 0.5) * 2;
    return shade(tone, 0.80 + 0.14 * noise.cloud(v, u, 4, 3) + 0.3 * smooth(0, 0.25, crease));
  });
}

Texture fabric(Rng& rng, Rgb tone, Rgb second, Weave weave) {
  const Noise noise(rng.next());
  constexpr double kThreads = 42;
  return picture(kSmall, [=](double u, double v) {
    Rgb base = tone;
    if (weave == Weave::kStriped) {
      const double s = fraction(u * 4);
      base = s < 0.42 ? tone : (s < 0.5 || s > 0.92 ? mix(tone, second, 0.5) : second);
    } else if (weave == Weave::kChecked) {
      const int both = (fraction(u * 3) < 0.5 ? 1 : 0) + (fraction(v * 3) < 0.5 ? 1 : 0);
      base = mix(tone, second, 0.5 * both);
    }
    const double a = std::sin(kTwoPi * kThreads * u), b = std::sin(kTwoPi * kThreads * v);
    const double thread = a * b > 0 ? 0.5 + 0.5 * std::abs(a) : 0.5 + 0.5 * std::abs(b);
    return shade(base, 0.84 + 0.14 * thread + 0.12 * (noise.cloud(u, v, 6, 4) - 0.3));
  });
}

Texture wallpaper(Rng& rng, Rgb ground, Rgb motif, Paper paper) {
  const Noise noise(rng.next());
  const unsigned cells = paper == Paper::kDots ? 5 : 2;
  return picture(kLarge, [=](double u, double v) {
    const std::uint64_t column = cell_of(u * cells);
    const double half = column % 2 == 1 && paper != Paper::kDots ? 0.5 : 0;
    const double x = 2 * fraction(u * cells) - 1, y = 2 * fraction(v * cells + half) - 1;
    double in = 0;
    if (paper == Paper::kStripes) {
      in = fraction(u * 5) < 0.5 ? 1 : 0;
    } else if (paper == Paper::kDots) {
      in = smooth(0.03, -0.03, distance(x, y) - 0.3);
    } else {
      in = paper == Paper::kDamask ? damask(x, y) : leaves(x, y);
    }
    return shade(mix(ground, motif, in), 0.97 + 0.05 * noise.cloud(u, v, 16, 3));
  });
}

Texture rug(Rng& rng, Rgb tone, Rgb second, Rgb third, Rug pattern) {
  const Noise noise(rng.next());
  return picture(kLarge, [=](double u, double v) {
    const double edge = std::min({u, v, 1 - u, 1 - v});
    const double x = 2 * u - 1, y = 2 * v - 1;
    Rgb base = tone;
    if (pattern == Rug::kStripes) {
      const double s = fraction(u * 9);
      base = s < 0.55 ? tone : (s < 0.7 ? third : second);
    } else if (pattern == Rug::kDiamonds) {
      const double d = fraction(std::abs(fraction(u * 4) - 0.5) + std::abs(fraction(v * 4) - 0.5));
      base = d < 0.16 ? third : (d > 0.42 && d < 0.52 ? second : tone);
    } else if (pattern == Rug::kMedallion) {
      const double r = distance(x, y) * (1 + 0.1 * std::cos(8 * std::atan2(y, x)));
      if (r < 0.62) base = r < 0.2 ? third : (r < 0.27 ? tone : (r < 0.54 ? second : third));
      if (r >= 0.62 && damask(2 * fraction(u * 6) - 1, 2 * fraction(v * 6) - 1) > 0.5) {
        base = mix(tone, second, 0.55);
      }
    }
    if (pattern != Rug::kStripes) {
      if (edge < 0.10) base = fraction((u + v) * 14) < 0.5 ? second : tone;
      if (edge < 0.035 || (edge > 0.085 && edge < 0.10)) base = third;
    }
    return shade(base, 0.82 + 0.28 * noise.at(u * 110, v * 110, 110, 110));
  });
}

}  // namespace enfilade::image
