#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <vector>

#include "enfilade/homes/looks/style.h"
#include "enfilade/image/textures.h"

namespace enfilade::homes::looks {
namespace {

using image::mix;
using image::Noise;
using image::Rgb;

Rgb any_colour(Rng& rng) {
  constexpr Rgb kColours[] = {{0.78, 0.20, 0.16}, {0.90, 0.55, 0.18}, {0.95, 0.80, 0.35},
                              {0.25, 0.48, 0.34}, {0.14, 0.30, 0.52}, {0.35, 0.62, 0.72},
                              {0.45, 0.25, 0.45}, {0.93, 0.90, 0.82}, {0.15, 0.15, 0.18},
                              {0.80, 0.62, 0.56}, {0.55, 0.60, 0.42}, {0.62, 0.42, 0.28}};
  return kColours[rng.below(std::size(kColours))];
}

/// Paints a picture with brush strokes all over it.
image::Image8 paint(std::uint32_t width, std::uint32_t height, const Noise& strokes,
                    const std::function<Rgb(double u, double v)>& colour) {
  return image::paint(width, height, [&](double u, double v) {
    return image::shade(colour(u, v), 0.9 + 0.2 * strokes.cloud(u, v, 16, 3));
  });
}

/// Colours of a landscape: the sky above and at the horizon, far and near hills, the sun.
struct Scene {
  Rgb high, low, far, near, sun;
};
constexpr Scene kScenes[] = {
    Scene{Rgb{0.35, 0.55, 0.80}, Rgb{0.85, 0.88, 0.88}, Rgb{0.45, 0.58, 0.62},
          Rgb{0.25, 0.42, 0.20}, Rgb{1.0, 0.96, 0.8}},
    Scene{Rgb{0.30, 0.28, 0.50}, Rgb{0.96, 0.62, 0.36}, Rgb{0.45, 0.30, 0.42},
          Rgb{0.16, 0.12, 0.18}, Rgb{1.0, 0.9, 0.6}},
    Scene{Rgb{0.62, 0.70, 0.74}, Rgb{0.90, 0.89, 0.84}, Rgb{0.62, 0.66, 0.66},
          Rgb{0.40, 0.42, 0.34}, Rgb{0.98, 0.97, 0.92}},
    Scene{Rgb{0.20, 0.42, 0.66}, Rgb{0.92, 0.85, 0.68}, Rgb{0.72, 0.55, 0.36},
          Rgb{0.70, 0.52, 0.25}, Rgb{1.0, 0.98, 0.85}},
};

/// Sky over ranges of hills, or over the sea.
image::Image8 landscape(Rng& rng, std::uint32_t width, std::uint32_t height) {
  const Noise noise(rng.next());
  const Scene& s = kScenes[rng.below(std::size(kScenes))];
  const double horizon = 0.40 + 0.25 * rng.uniform(), sun_x = 0.2 + 0.6 * rng.uniform();
  const bool sea = rng.below(3) == 0;
  return paint(width, height, noise, [&](double u, double v) {
    const double dx = (u - sun_x) * width / height, dy = v - horizon * 0.6;
    Rgb c = mix(s.high, s.low, std::min(1.0, v / horizon));
    c = mix(c, {0.97, 0.96, 0.94}, 0.5 * std::max(0.0, noise.cloud(u, v * 2, 3, 4) - 0.45));
    if (dx * dx + dy * dy < 0.004) c = s.sun;
    if (sea) {
      if (v > horizon) {
        const double wave = noise.at(u * 7, v * 46, 64, 64);
        c = mix(image::shade(s.high, 0.75), s.low, 0.15 + 0.5 * wave * wave);
      }
      const double shore = 0.88 + 0.05 * noise.at(u * 4, 3.3, 64, 64);
      return v > shore ? mix(s.near, s.low, 0.45) : c;
    }
    for (unsigned ridge = 0; ridge < 4; ++ridge) {
      const double t = ridge / 3.0;
      const double top = horizon - 0.08 + 0.16 * ridge +
                         (0.22 - 0.04 * ridge) * (noise.cloud(u, 0.1 + 0.2 * ridge, 3, 4) - 0.5);
      if (v > top) c = image::shade(mix(s.far, s.near, t), 0.85 + 0.3 * noise.cloud(u, v, 12, 2));
    }
    return c;
  });
}

/// Overlapping discs and bars on a plain ground.
image::Image8 shapes(Rng& rng, std::uint32_t width, std::uint32_t height) {
  struct Mark {
    double x, y, a, b;
    bool round;
    Rgb colour;
  };
  std::vector<Mark> marks(5 + rng.below(6));
  for (Mark& m : marks) {
    m = {
        rng.uniform(),     rng.uniform(),  0.06 + 0.24 * rng.uniform(), 0.06 + 0.24 * rng.uniform(),
        rng.below(2) == 0, any_colour(rng)};
  }
  const Rgb ground = mix(any_colour(rng), {0.95, 0.93, 0.88}, 0.7);
  const Noise noise(rng.next());
  return paint(width, height, noise, [&](double u, double v) {
    Rgb c = ground;
    for (const Mark& m : marks) {
      const double x = (u - m.x) * width / height, y = v - m.y;
      const bool in = m.round ? x * x + y * y < m.a * m.a : std::abs(x) < m.a && std::abs(y) < m.b;
      if (in) c = mix(c, m.colour, 0.88);
    }
    return c;
  });
}

/// Fields of colour that run into each other.
image::Image8 fields(Rng& rng, std::uint32_t width, std::uint32_t height) {
  const std::array<Rgb, 4> colours{any_colour(rng), any_colour(rng), any_colour(rng),
                                   any_colour(rng)};
  const Noise noise(rng.next());
  return paint(width, height, noise, [&](double u, double v) {
    const double t = 3.999 * std::clamp(1.6 * noise.cloud(u, v, 3, 4) - 0.3, 0.0, 1.0);
    const auto i = static_cast<std::size_t>(t);
    const double edge = std::clamp((t - double(i) - 0.8) * 5, 0.0, 1.0);
    return mix(colours[i], colours[std::min<std::size_t>(i + 1, 3)], edge);
  });
}

/// Head and shoulders of an invented person.
image::Image8 portrait(Rng& rng, std::uint32_t width, std::uint32_t height) {
  const Rgb ground = image::shade(any_colour(rng), 0.5), coat = any_colour(rng);
  constexpr std::array<Rgb, 3> kSkins{{{0.88, 0.70, 0.58}, {0.62, 0.43, 0.31}, {0.40, 0.27, 0.20}}};
  constexpr std::array<Rgb, 4> kHair{
      {{0.16, 0.11, 0.08}, {0.45, 0.28, 0.14}, {0.80, 0.66, 0.38}, {0.70, 0.70, 0.70}}};
  const Rgb skin = kSkins[rng.below(3)], hair = kHair[rng.below(4)];
  const double fringe = 0.16 + 0.1 * rng.uniform(), length = 0.3 + 0.4 * rng.uniform();
  const Noise noise(rng.next());
  const auto in = [](double x, double y, double cx, double cy, double rx, double ry) {
    const double a = (x - cx) / rx, b = (y - cy) / ry;
    return a * a + b * b < 1;
  };
  return paint(width, height, noise, [&](double u, double v) {
    const double x = (u - 0.5) * width / height;
    Rgb c = mix(ground, image::shade(ground, 1.9), std::max(0.0, 0.8 - v - std::abs(x)));
    if (in(x, v, 0, 0.40, 0.20, 0.24) || (v > 0.4 && v < length && std::abs(x) < 0.2)) c = hair;
    if (in(x, v, 0, 1.05, 0.42, 0.38)) c = coat;
    if (std::abs(x) < 0.06 && v > 0.5 && v < 0.74) c = image::shade(skin, 0.85);
    if (in(x, v, 0, 0.42, 0.145, 0.20) && v > fringe + 0.06) c = skin;
    for (const double side : {-0.055, 0.055}) {
      if (in(x, v, side, 0.40, 0.02, 0.012)) c = {0.12, 0.10, 0.10};
    }
    if (in(x, v, 0, 0.53, 0.045, 0.012)) c = {0.62, 0.25, 0.24};
    return c;
  });
}

}  // namespace

image::Image8 paint_picture(Rng& rng, std::uint32_t width, std::uint32_t height) {
  constexpr std::array kPainters{shapes, fields, portrait, landscape, landscape, landscape};
  return kPainters[rng.below(kPainters.size())](rng, width, height);
}

}  // namespace enfilade::homes::looks
