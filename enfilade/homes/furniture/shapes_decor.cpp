#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;
constexpr double kTurn = 2 * std::numbers::pi;

/// With a pattern, stretched once over the top; a runner and a bath mat, of one colour with a
/// pale stripe near two edges.
void rug(Kit& k, double x, double y) {
  // On the proportions of a runner or at the size of a mat, the pattern would look distorted.
  k.box(k.variant == 0 ? k.main : k.style.accent, {-x, -y, 0}, {x, y, k.h});
  for (const double s : {-1.0, 1.0}) {
    const double a = s * (y - 0.07), b = s * (x - 0.1);
    if (k.variant == 1) k.box(k.style.linen, {-x, a - 0.02, k.h}, {x, a + 0.02, k.h + 0.001});
    if (k.variant == 2) k.box(k.style.linen, {b - 0.02, -y, k.h}, {b + 0.02, y, k.h + 0.001});
  }
}

void round_rug(Kit& k, double, double) {
  const double r = std::min(k.w, k.d) / 2;
  k.lathe(k.style.accent, {0, 0, 0}, 32, 1, Ring{r, 0}, Ring{r, k.h}, Ring{0, k.h});
  k.lathe(k.style.linen, {0, 0, 0}, 32, 1, Ring{r * 0.82, k.h + 0.001}, Ring{0, k.h + 0.001});
  k.lathe(k.style.accent, {0, 0, 0}, 32, 1, Ring{r * 0.72, k.h + 0.002}, Ring{0, k.h + 0.002});
}

void doormat(Kit& k, double x, double y) {
  k.colour = "brown";
  k.box(k.style.pot, {-x, -y, 0}, {x, y, k.h});
  k.box(k.style.black, {-x + 0.04, -y + 0.04, k.h}, {x - 0.04, y - 0.04, k.h + 0.002});
}

void pot(Kit& k, double r, double tall) {
  k.lathe(k.rng.below(2) == 0 ? k.style.pot : k.style.white, {0, 0, 0}, 14, 1, Ring{0, 0},
          Ring{r * 0.72, 0}, Ring{r, tall}, Ring{r * 0.88, tall}, Ring{r * 0.86, tall - 0.03},
          Ring{0, tall - 0.03});
}

/// A leaf from `root` towards an angle, rising and bending over.
void blade(Kit& k, const NamedMaterial& m, Vec3d root, double angle, double reach, double rise,
           double wide) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Vec3d mid{root.x + 0.55 * reach * c, root.y + 0.55 * reach * s, root.z + rise};
  const Vec3d tip{root.x + reach * c, root.y + reach * s, root.z + rise * 0.72};
  const Vec3d l{mid.x - wide * s, mid.y + wide * c, mid.z};
  const Vec3d r{mid.x + wide * s, mid.y - wide * c, mid.z};
  k.triangle(m, root, r, l);
  k.triangle(m, l, r, tip);
}

const NamedMaterial& green(Kit& k) { return k.rng.below(2) == 0 ? k.style.leaf : k.style.leaf2; }

void upright_blades(Kit& k, double r, double base) {
  for (int i = 0; i < 14; ++i) {
    const double a = kTurn * k.rng.uniform(), q = r * 0.35 * k.rng.uniform(), wide = 0.025;
    const Vec3d foot{q * std::cos(a), q * std::sin(a), base - 0.03};
    const double tall = (k.h - base) * (0.55 + 0.45 * k.rng.uniform());
    const Vec3d tip{foot.x + 0.3 * r * std::cos(a), foot.y + 0.3 * r * std::sin(a), base + tall};
    const double b = kTurn * k.rng.uniform();
    const Vec3d side{wide * std::cos(b), wide * std::sin(b), 0};
    const Vec3d mid{(foot.x + tip.x) / 2, (foot.y + tip.y) / 2, base + tall * 0.5};
    const NamedMaterial& m = green(k);
    k.triangle(m, foot, mid + side, mid - side);
    k.triangle(m, mid - side, mid + side, tip);
  }
}

/// A small tree, upright blades, a palm, a bush.
void plant(Kit& k, double r, double) {
  const double base = std::min(0.32, k.h * 0.3);

  pot(k, r * (k.variant == 1 ? 0.75 : 0.5), base);

  if (k.variant == 1) return upright_blades(k, r, base);
  const double crown = k.variant == 3 ? base : (k.variant == 0 ? k.h * 0.5 : k.h * 0.62);
  if (k.variant != 3) k.bar(k.style.wood, {0, 0, base - 0.04}, {0, 0, crown + 0.05}, 0.02, 6);
  const int leaves = k.variant == 2 ? 26 : 44;
  for (int i = 0; i < leaves; ++i) {
    const double a = kTurn * i * 0.381966, t = (i + 0.5) / leaves;
    if (k.variant == 2) {
      blade(k, green(k), {0, 0, crown}, a, r * 0.98, (k.h - crown) * (0.25 + 0.75 * t), 0.035);
    } else {
      const double swell = std::sin(std::numbers::pi * (0.15 + 0.8 * t));
      const double reach = r * (0.35 + 0.63 * swell * (0.7 + 0.3 * k.rng.uniform()));
      const double root = 0.25 * reach, z = crown + (k.h - crown - 0.14) * t;
      blade(k, green(k), {root * std::cos(a), root * std::sin(a), z}, a, reach * 0.74, 0.1, 0.05);
    }
  }
}

/// In a vase.
void flowers(Kit& k, double r, double) {
  const NamedMaterial& petals = k.spoken(k.style.paints[k.rng.below(4)]);
  k.lathe(k.style.white, {0, 0, 0}, 12, 1, Ring{0, 0}, Ring{r * 0.4, 0}, Ring{r * 0.55, k.h * 0.2},
          Ring{r * 0.28, k.h * 0.42}, Ring{r * 0.36, k.h * 0.48});
  for (int i = 0; i < 7; ++i) {
    const double a = kTurn * i / 7, q = i == 0 ? 0 : r * 0.7;
    const Vec3d head{q * std::cos(a), q * std::sin(a), k.h * (i == 0 ? 0.93 : 0.8)};
    k.bar(k.style.leaf, {0, 0, k.h * 0.4}, head, 0.004, 4);
    k.sphere(petals, head, 0.035, 6);
  }
}

/// Square, round, fluted.
void column(Kit& k, double x, double) {
  if (k.variant == 0) {
    k.box(k.main, {-x + 0.03, -x + 0.03, 0}, {x - 0.03, x - 0.03, k.h});
  } else if (k.variant == 1) {
    k.cylinder(k.main, {0, 0, 0.1}, x * 0.8, x * 0.72, k.h - 0.2, 20);
  } else {
    k.cylinder(k.main, {0, 0, 0.1}, x * 0.7, x * 0.62, k.h - 0.2, 16);
    k.splayed_legs(k.main, 12, 0, {{{x * 0.72, 0.1}, {x * 0.64, k.h - 0.1}}}, x * 0.13);
  }
  k.box(k.main, {-x, -x, 0}, {x, x, 0.12});
  k.box(k.main, {-x, -x, k.h - 0.1}, {x, x, k.h});
}

/// Brick with a beam, marble with pilasters, a modern one in a block.
void fireplace(Kit& k, double x, double y) {
  const NamedMaterial& m = k.main;
  const double o = k.variant == 2 ? x * 0.72 : x * 0.55, low = k.variant == 2 ? 0.45 : 0.08;
  const double high = k.variant == 2 ? 0.95 : 0.75, top = k.h - (k.variant == 2 ? 0 : 0.08);
  k.box(m, {-x + 0.06, -y, 0}, {-o, y - 0.1, top});
  k.box(m, {o, -y, 0}, {x - 0.06, y - 0.1, top});
  k.box(m, {-o, -y, high}, {o, y - 0.1, top});
  k.box(m, {-o, -y, 0}, {o, y - 0.1, low});
  k.box(k.style.black, {-o, -y, low}, {o, -y + 0.03, high});
  for (const double s : {-0.18, 0.02, 0.2}) {  // logs and flames
    k.bar(k.style.paints[0], {s - 0.12, 0, low + 0.05}, {s + 0.14, 0.03, low + 0.07}, 0.04, 7);
    k.cylinder(k.style.shade, {s, 0.02, low + 0.08}, 0.06, 0.0, 0.2, 7);
  }
  if (k.variant == 0) {
    k.box(k.style.wood, {-x, -y, top}, {x, y, k.h});
    for (int i = 0; i < 6; ++i) {  // courses
      const double z = 0.1 + 0.15 * i;
      k.box(k.style.white, {-x + 0.055, y - 0.1, z}, {-o, y - 0.096, z + 0.012});
      k.box(k.style.white, {o, y - 0.1, z}, {x - 0.055, y - 0.096, z + 0.012});
    }
  } else if (k.variant == 1) {
    k.box(m, {-x, -y, top}, {x, y, k.h});
    const double at = x - 0.16;
    k.pairs(m, {{{at - 0.08, y - 0.1, 0.1}, {at + 0.08, y - 0.06, top - 0.04}},
                {{at - 0.1, y - 0.1, 0}, {at + 0.1, y - 0.04, 0.1}}});
  }
}

const NamedMaterial& cloth(Kit& k) {
  const std::array<const NamedMaterial*, 5> quiet{&k.style.linen, &k.style.black, &k.style.fabric,
                                                  &k.style.fabric2, &k.style.accent};
  return k.rng.below(3) == 0 ? k.style.paints[k.rng.below(8)] : *quiet[k.rng.below(5)];
}

void row_of_clothes(Kit& k, double x, double y) {
  k.bar(k.style.metal, {-x, 0, k.h - 0.05}, {x, 0, k.h - 0.05}, 0.014, 6);
  double at = -x + 0.04;
  const NamedMaterial& first = k.spoken(cloth(k));
  while (at < x - 0.1) {
    const double thick = 0.05 + 0.04 * k.rng.uniform();
    const double tall = k.h * (0.55 + 0.35 * k.rng.uniform());
    const NamedMaterial& m = k.rng.below(3) == 0 ? first : cloth(k);
    k.soft(m, {at, -y * 0.8, k.h - 0.08 - tall + 0.05}, {at + thick, y * 0.8, k.h - 0.10}, 0.02);
    const double hook = at + thick / 2;
    k.bar(k.style.metal, {hook, 0, k.h - 0.11}, {hook, 0, k.h - 0.03}, 0.004, 4);
    at += thick + 0.015 + (k.rng.below(5) == 0 ? 0.12 : 0.0);
  }
}

/// A coat, a hat, a row on a rod, a robe.
void clothes(Kit& k, double x, double y) {
  if (k.variant == 2) return row_of_clothes(k, x, y);
  const NamedMaterial& m = k.spoken(k.variant == 3 ? k.style.linen : cloth(k));
  if (k.variant == 1) {
    k.lathe(m, {0, 0, 0}, 16, 1, Ring{0, 0.02}, Ring{x, 0}, Ring{x * 0.55, 0.03},
            Ring{x * 0.5, k.h - 0.02}, Ring{x * 0.3, k.h}, Ring{0, k.h});
    return;
  }
  k.lathe(m, {0, 0, 0}, 12, 0.8 * y / x, Ring{0, 0}, Ring{x * 0.78, 0}, Ring{x * 0.62, k.h * 0.5},
          Ring{x * 0.6, k.h * 0.82}, Ring{x * 0.25, k.h * 0.95}, Ring{0, k.h * 0.97});
  for (const double s : {-1.0, 1.0}) {  // sleeves
    k.bar(m, {s * x * 0.5, 0, k.h * 0.84}, {s * x * 0.84, 0.1 * y, k.h * 0.36}, x * 0.15, 7);
  }
  k.box(k.style.black, {-x * 0.06, y * 0.62, k.h * 0.12}, {x * 0.02, y * 0.66, k.h * 0.8});
}

void coat_rack(Kit& k, double x, double y) {
  if (k.variant == 0) {
    k.box(k.main, {-x, -y, 0.02}, {x, -y + 0.02, 0.14});
    for (double at = -x + 0.1; at < x; at += 0.18) {
      k.bar(k.style.metal, {at, -y + 0.02, 0.07}, {at, y - 0.01, 0.1}, 0.009, 6);
    }
    return;
  }
  k.cylinder(k.main, {0, 0, 0.08}, 0.025, 0.02, k.h - 0.1, 8);
  for (int i = 0; i < 4; ++i) {
    const double a = kTurn * i / 4 + 0.4, c = std::cos(a), s = std::sin(a);
    k.bar(k.main, {0.9 * x * c, 0.9 * x * s, 0.014}, {0, 0, 0.2}, 0.014, 6);
    k.bar(k.main, {0, 0, k.h - 0.2}, {0.5 * x * c, 0.5 * x * s, k.h - 0.05}, 0.011, 6);
  }
  const NamedMaterial& coat = k.style.paints[k.rng.below(6)];
  k.soft(coat, {-x * 0.75, 0.03, k.h - 1.15}, {x * 0.75, 0.03 + x * 0.55, k.h - 0.12}, 0.05);
}

/// Slim, bellied, a bottle.
void vase(Kit& k, double r, double) {
  const double h = k.h;
  const NamedMaterial& m = k.spoken(k.style.paints[k.rng.below(7)]);
  if (k.variant == 0) {
    k.lathe(m, {0, 0, 0}, 14, 1, Ring{0, 0}, Ring{r * 0.6, 0}, Ring{r, h * 0.5},
            Ring{r * 0.5, h * 0.8}, Ring{r * 0.65, h}, Ring{r * 0.4, h * 0.9});
  } else if (k.variant == 1) {
    k.lathe(m, {0, 0, 0}, 14, 1, Ring{0, 0}, Ring{r * 0.5, 0}, Ring{r, h * 0.4},
            Ring{r * 0.85, h * 0.75}, Ring{r * 0.35, h * 0.9}, Ring{r * 0.45, h});
  } else {
    k.lathe(m, {0, 0, 0}, 10, 1, Ring{0, 0}, Ring{r, 0}, Ring{r, h * 0.6}, Ring{r * 0.35, h * 0.75},
            Ring{r * 0.35, h}, Ring{0, h});
  }
}

void bowl(Kit& k, double r, double) {
  const double h = k.variant == 0 ? k.h : k.h * 0.7;
  k.lathe(k.main, {0, 0, 0}, 16, 1, Ring{0, 0}, Ring{r * 0.45, 0}, Ring{r, h}, Ring{r * 0.94, h},
          Ring{r * 0.4, h * 0.25}, Ring{0, h * 0.2});
  if (k.variant == 0) return;
  for (unsigned i = 0; i < 5; ++i) {  // fruit
    const double a = kTurn * i / 5, x = r * 0.45 * std::cos(a), y = r * 0.45 * std::sin(a);
    k.sphere(k.style.paints[i % 4], {x, y, h * 0.25 + 0.045}, 0.042, 8);
  }
}

/// A pile, a row.
void books(Kit& k, double x, double y) {
  k.spoken(k.style.paints[0]);
  if (k.variant == 1) return k.books(-x, x, -y, 0, k.h, k.d);
  const int n = std::max(2, static_cast<int>(k.h / 0.03));
  for (int i = 0; i < n; ++i) {
    const double less = 0.02 * k.rng.uniform();
    k.box(k.style.paints[static_cast<std::size_t>(i) % 8], {-x + less, -y + less, k.h * i / n},
          {x - less * 0.5, y - 0.02 * k.rng.uniform(), k.h * (i + 1) / n});
  }
}

/// Cardboard, a crate with toys, a basket.
void box(Kit& k, double x, double y) {
  if (k.variant == 0) {
    k.box(k.spoken(k.style.paints[6]), {-x, -y, 0}, {x, y, k.h});
    k.box(k.style.white, {-0.03, -y - 0.001, k.h - 0.001}, {0.03, y + 0.001, k.h + 0.002});
    return;
  }
  k.hollow(k.main, {-x, -y, 0}, {x, y, k.h}, 0.02, 0.02);
  for (int i = 0; i < 4; ++i) {
    const double px = (i % 2 == 0 ? -0.4 : 0.4) * x, py = (i < 2 ? -0.4 : 0.4) * y;
    const NamedMaterial& c = k.style.paints[k.rng.below(6)];
    const double s = std::min(x, y) * 0.32;
    if (k.variant == 2) {
      k.soft(k.style.linen, {px - s, py - s, 0.05}, {px + s, py + s, k.h + 0.01}, 0.03);
    } else if (i % 2 == 0) {
      k.sphere(c, {px, py, k.h - s * 0.7}, s, 9);
    } else {
      k.box(c, {px - s, py - s, 0.03}, {px + s, py + s, k.h - 0.02});
    }
  }
}

/// Open with a rim, with a lid.
void trash_can(Kit& k, double r, double) {
  if (k.variant == 0) {
    k.lathe(k.main, {0, 0, 0}, 16, 1, Ring{0, 0}, Ring{r * 0.8, 0}, Ring{r, k.h},
            Ring{r * 0.94, k.h}, Ring{r * 0.75, 0.03}, Ring{0, 0.03});
  } else {
    k.cylinder(k.main, {0, 0, 0}, r, r, k.h * 0.85, 16);
    k.lathe(k.style.black, {0, 0, 0}, 16, 1, Ring{r, k.h * 0.85}, Ring{r * 0.9, k.h * 0.93},
            Ring{r * 0.5, k.h}, Ring{0, k.h});
  }
}

/// Stones on each other, a ring.
void sculpture(Kit& k, double r, double) {
  const NamedMaterial& m = k.main;
  k.cylinder(k.style.wood, {0, 0, 0}, r, r, 0.02, 14);
  if (k.variant == 0) {
    k.lathe(m, {0, 0, 0}, 14, 1, Ring{0, 0.02}, Ring{r * 0.8, k.h * 0.2}, Ring{r * 0.3, k.h * 0.42},
            Ring{r * 0.6, k.h * 0.58}, Ring{r * 0.2, k.h * 0.75}, Ring{r * 0.38, k.h * 0.9},
            Ring{0, k.h});
    return;
  }
  const double rr = std::min(r * 0.8, (k.h - 0.04) / 2 - 0.02), z = 0.04 + rr;
  const auto at = [&](double a) { return Vec3d{rr * std::cos(a), 0, z + rr * std::sin(a)}; };
  for (int i = 0; i < 16; ++i) k.bar(m, at(kTurn * i / 16), at(kTurn * (i + 1) / 16), 0.018, 6);
}

void candles(Kit& k, double, double) {
  for (int i = 0; i < 3; ++i) {
    const double at = (i - 1) * k.w * 0.33, tall = k.h * (0.5 + 0.2 * ((i * 2) % 3));
    k.cylinder(k.main, {at, 0, 0}, 0.024, 0.024, tall, 10);
    k.cylinder(k.style.shade, {at, 0, tall}, 0.006, 0.0, 0.02, 5);
  }
}

void laptop(Kit& k, double x, double y) {
  k.box(k.main, {-x, -y + 0.03, 0}, {x, y, 0.016});
  k.box(k.style.black, {-x + 0.02, -y + 0.05, 0.016}, {x - 0.02, y - 0.08, 0.018});
  k.quad(k.style.screen, {x, -y + 0.03, 0.016}, {-x, -y + 0.03, 0.016}, {-x, -y, k.h},
         {x, -y, k.h});
  k.quad(k.main, {-x, -y + 0.024, 0.016}, {x, -y + 0.024, 0.016}, {x, -y - 0.004, k.h},
         {-x, -y - 0.004, k.h});
}

void keyboard(Kit& k, double x, double y) {
  k.box(k.main, {-x, -y, 0}, {x, y, 0.012});
  for (int i = 0; i < 4; ++i) {
    const double y0 = -y + 0.012 + i * (k.d - 0.02) / 4;
    k.box(k.style.white, {-x + 0.012, y0, 0.012}, {x - 0.012, y0 + 0.022, k.h});
  }
}

void cups(Kit& k, double, double) {
  for (int i = 0; i < 2; ++i) {
    const double at = (i == 0 ? -0.3 : 0.3) * k.w;
    k.cylinder(i == 0 ? k.main : k.style.paints[1], {at, 0, 0}, 0.03, 0.04, k.h, 12);
  }
}

void plates(Kit& k, double x, double) {
  const double r = k.w * 0.36;
  k.lathe(k.main, {0, 0, 0}, 18, 1, Ring{0, 0}, Ring{r * 0.6, 0}, Ring{r, 0.02}, Ring{0, 0.008});
  k.cylinder(k.style.glass, {k.w * 0.38, k.d * 0.2, 0}, 0.028, 0.036, k.h, 10);
  k.box(k.style.metal, {-x, -0.09, 0}, {-x + 0.015, 0.09, 0.006});
}

void bottles(Kit& k, double, double) {
  k.spoken(k.style.paints[0]);
  for (unsigned i = 0; i < 3; ++i) {
    const double at = (i - 1.0) * k.w * 0.34, tall = k.h * (0.7 + 0.15 * ((i * 2) % 3));
    k.cylinder(k.style.paints[i], {at, 0, 0}, 0.026, 0.026, tall * 0.8, 10);
    k.cylinder(k.style.white, {at, 0, tall * 0.8}, 0.012, 0.012, tall * 0.2, 8);
  }
}

void shoes(Kit& k, double, double y) {
  const NamedMaterial& m = k.spoken(k.style.paints[k.rng.below(8)]);
  const double at = k.w * 0.27;
  k.pairs(m,
          {{{at - 0.045, -y, 0}, {at + 0.045, y, 0.06}},
           {{at - 0.042, -y, 0.03}, {at + 0.042, -k.d * 0.05, k.h}}},
          0.02);
}

void teddy(Kit& k, double, double) {
  const NamedMaterial& m = k.spoken(k.style.paints[k.rng.below(8)]);
  const double r = k.w * 0.32;
  k.sphere(m, {0, 0, r}, r, 10);
  k.sphere(m, {0, 0.01, 2.3 * r}, r * 0.72, 10);
  for (const double s : {-1.0, 1.0}) {
    k.sphere(m, {s * r * 0.6, 0, 2.95 * r}, r * 0.26, 7);
    k.sphere(m, {s * r * 1.1, r * 0.4, 1.3 * r}, r * 0.36, 7);
    k.sphere(m, {s * r * 0.7, r * 0.8, 0.4 * r}, r * 0.4, 7);
  }
  k.sphere(k.style.black, {0, r * 0.75, 2.25 * r}, r * 0.12, 6);
}

void heater(Kit& k, double x, double y) {
  const int ribs = static_cast<int>(k.w / 0.08);
  for (int i = 0; i < ribs; ++i) {
    const double at = -x + k.w * (i + 0.5) / ribs;
    k.soft(k.main, {at - 0.03, -y, 0.08}, {at + 0.03, y, k.h}, 0.015);
  }
  k.pairs(k.main, {{{x - 0.06, -y * 0.4, 0}, {x - 0.03, y * 0.4, 0.1}}});
}

void piano(Kit& k, double x, double y) {
  k.box(k.main, {-x, -y, 0}, {x, -y + 0.3, k.h});
  k.box(k.main, {-x, -y + 0.3, 0.58}, {x, y, 0.68});
  k.box(k.style.white, {-x + 0.08, y - 0.17, 0.68}, {x - 0.08, y - 0.02, 0.70});
  for (double at = -x + 0.12; at < x - 0.12; at += 0.055) {
    k.box(k.main, {at, y - 0.17, 0.70}, {at + 0.02, y - 0.08, 0.712});
  }
  const double end = x - 0.04;
  k.pairs(k.main, {{{end - 0.04, y - 0.1, 0}, {end + 0.04, y - 0.02, 0.58}},
                   {{end - 0.04, -y + 0.3, 0.68}, {end + 0.04, y, 0.74}}});
}

void globe(Kit& k, double r, double) {
  k.colour = "blue";
  k.cylinder(k.style.wood, {0, 0, 0}, r * 0.7, r * 0.6, 0.03, 14);
  k.bar(k.style.metal, {0, 0, 0.03}, {0, 0, k.h}, 0.008, 6);
  k.sphere(k.style.paints[1], {0, 0, k.h - r * 0.95}, r * 0.92, 16);
}

void paper(Kit& k, double x, double y) {
  const double z = k.h * 0.5;
  k.box(k.style.metal, {-x, -y, k.h * 0.6}, {x, -y + 0.02, k.h});
  k.bar(k.main, {-x + 0.01, 0.01, z}, {x - 0.01, 0.01, z}, k.h * 0.42, 14);
}

void toilet_brush(Kit& k, double, double) {
  k.cylinder(k.main, {0, 0, 0}, k.w / 2, k.w * 0.42, 0.16, 12);
  k.bar(k.style.metal, {0, 0, 0.14}, {0, 0, k.h}, 0.01, 6);
}

void fence(Kit& k, double x, double y) {
  for (double at = -x; at < x - 0.05; at += 0.14) {
    k.box(k.main, {at, -y, 0}, {at + 0.09, -y + 0.02, k.h});
  }
  for (const double z : {0.2, k.h - 0.25}) k.box(k.main, {-x, -y + 0.02, z}, {x, y, z + 0.07});
}

void grill(Kit& k, double r, double) {
  k.splayed_legs(k.style.metal, 3, 0, {{{0.8 * r, 0.012}, {0.4 * r, 0.6}}}, 0.014);
  k.lathe(k.style.black, {0, 0, 0}, 18, 1, Ring{0, 0.5}, Ring{r * 0.6, 0.55}, Ring{r, 0.75},
          Ring{r, 0.8}, Ring{r * 0.8, k.h - 0.08}, Ring{r * 0.4, k.h - 0.03}, Ring{0, k.h - 0.02},
          Ring{0, k.h - 0.02});
  k.box(k.style.wood, {-0.06, -0.012, k.h - 0.03}, {0.06, 0.012, k.h});
}

constexpr FurnitureShape kDecor[] = {
    {"rug", kFloor, rug, 0, {2.0, 1.4, 0.012}, &Style::rug},
    {"rug", kFloor, round_rug, 0, {1.6, 1.6, 0.012}, &Style::rug},
    {"runner", kFloor, rug, 1, {2.2, 0.7, 0.010}, &Style::rug, "rug"},
    {"bath mat", kFloor, rug, 2, {0.80, 0.50, 0.020}, &Style::rug},
    {"doormat", kFloor, doormat, 0, {0.75, 0.45, 0.015}, nullptr},
    {"plant", kPlant, plant, 0, {0.60, 0.60, 1.35}, &Style::leaf},
    {"plant", kPlant, plant, 1, {0.36, 0.36, 0.95}, &Style::leaf},
    {"plant", kPlant, plant, 2, {0.90, 0.90, 1.70}, &Style::leaf},
    {"plant", kPlant, plant, 3, {0.50, 0.50, 0.80}, &Style::leaf},
    {"small plant", kPlant, plant, 3, {0.20, 0.20, 0.26}, &Style::leaf, "potted plant"},
    {"small plant", kPlant, plant, 1, {0.14, 0.14, 0.28}, &Style::leaf, "potted plant"},
    {"flowers", kPlant, flowers, 0, {0.22, 0.22, 0.38}, nullptr},
    {"bush", kPlant, plant, 3, {0.80, 0.80, 0.95}, &Style::leaf},
    {"column", kColumn, column, 0, {0.34, 0.34, 2.6}, &Style::white},
    {"column", kColumn, column, 1, {0.36, 0.36, 2.6}, &Style::white},
    {"column", kColumn, column, 2, {0.36, 0.36, 2.6}, &Style::white},
    {"fireplace", kFireplace, fireplace, 0, {1.50, 0.46, 1.15}, &Style::pot},
    {"fireplace", kFireplace, fireplace, 1, {1.45, 0.42, 1.12}, &Style::stone},
    {"fireplace", kFireplace, fireplace, 2, {1.60, 0.40, 1.30}, &Style::white},
    {"coat", kClothes, clothes, 0, {0.50, 0.16, 0.95}, nullptr},
    {"hat", kClothes, clothes, 1, {0.28, 0.28, 0.13}, nullptr},
    {"hanging clothes", kClothes, clothes, 2, {1.20, 0.50, 1.15}, nullptr},
    {"bathrobe", kClothes, clothes, 3, {0.48, 0.14, 1.05}, nullptr},
    {"coat rack", kMisc, coat_rack, 0, {0.95, 0.12, 0.16}, &Style::wood},
    {"coat stand", kMisc, coat_rack, 1, {0.50, 0.50, 1.75}, &Style::wood, "coat rack"},
    {"vase", kObjects, vase, 0, {0.14, 0.14, 0.32}, nullptr},
    {"vase", kObjects, vase, 1, {0.20, 0.20, 0.24}, nullptr},
    {"bottle", kObjects, vase, 2, {0.08, 0.08, 0.28}, nullptr},
    {"bowl", kObjects, bowl, 0, {0.24, 0.24, 0.08}, &Style::white},
    {"fruit bowl", kObjects, bowl, 1, {0.28, 0.28, 0.13}, &Style::wood, "bowl of fruit"},
    {"books", kObjects, books, 0, {0.24, 0.18, 0.10}, nullptr},
    {"books", kObjects, books, 1, {0.34, 0.18, 0.24}, nullptr},
    {"box", kObjects, box, 0, {0.45, 0.36, 0.32}, nullptr},
    {"toy box", kObjects, box, 1, {0.60, 0.38, 0.34}, &Style::wood, "box"},
    {"basket", kObjects, box, 2, {0.42, 0.42, 0.40}, &Style::pot},
    {"trash can", kObjects, trash_can, 0, {0.28, 0.28, 0.32}, &Style::metal},
    {"trash can", kObjects, trash_can, 1, {0.30, 0.30, 0.62}, &Style::metal},
    {"sculpture", kObjects, sculpture, 0, {0.18, 0.18, 0.34}, &Style::stone},
    {"sculpture", kObjects, sculpture, 1, {0.26, 0.26, 0.30}, &Style::metal},
    {"candles", kObjects, candles, 0, {0.24, 0.08, 0.20}, &Style::linen, "candle"},
    {"laptop", kObjects, laptop, 0, {0.34, 0.27, 0.23}, &Style::metal},
    {"keyboard", kObjects, keyboard, 0, {0.42, 0.13, 0.02}, &Style::black},
    {"cups", kObjects, cups, 0, {0.24, 0.10, 0.09}, &Style::white, "cup"},
    {"plate", kObjects, plates, 0, {0.34, 0.26, 0.13}, &Style::white},
    {"bottles", kObjects, bottles, 0, {0.22, 0.08, 0.20}, nullptr},
    {"shoes", kObjects, shoes, 0, {0.24, 0.27, 0.11}, nullptr},
    {"stuffed animal", kObjects, teddy, 0, {0.30, 0.24, 0.31}, nullptr},
    {"radiator", kObjects, heater, 0, {0.90, 0.10, 0.55}, &Style::white},
    {"piano", kObjects, piano, 0, {1.48, 0.62, 1.20}, &Style::black},
    {"globe", kMisc, globe, 0, {0.28, 0.28, 0.40}, nullptr},
    {"toilet paper", kMisc, paper, 0, {0.14, 0.12, 0.13}, &Style::white, "toilet paper holder"},
    {"toilet brush", kMisc, toilet_brush, 0, {0.12, 0.12, 0.42}, &Style::white},
    {"fence", kMisc, fence, 0, {1.50, 0.06, 0.90}, &Style::wood2},
    {"grill", kMisc, grill, 0, {0.56, 0.56, 1.02}, &Style::black},
};

}  // namespace

std::span<const FurnitureShape> decor_shapes() { return kDecor; }

}  // namespace enfilade::homes::furniture
