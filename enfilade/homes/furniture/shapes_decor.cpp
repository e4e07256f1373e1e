#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;
using Profile = std::array<double, 2>;
constexpr double kTurn = 2 * std::numbers::pi;

/// Its pattern once over its top.
void rug(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(k.style.rug);
  // The pattern would be drawn out of shape on a long or small one.
  k.box(variant == 0 ? k.style.rug : k.style.accent, {-x, -y, 0}, {x, y, k.h});
  for (const double s : {-1.0, 1.0}) {
    const double a = s * (y - 0.07), b = s * (x - 0.1);
    if (variant == 1) k.box(k.style.linen, {-x, a - 0.02, k.h}, {x, a + 0.02, k.h + 0.001});
    if (variant == 2) k.box(k.style.linen, {b - 0.02, -y, k.h}, {b + 0.02, y, k.h + 0.001});
  }
}
void round_rug(Kit& k, int) {
  const double r = std::min(k.w, k.d) / 2;
  k.spoken(k.style.rug);
  const std::array<Profile, 3> disc{{{r, 0}, {r, k.h}, {0, k.h}}};
  k.lathe(k.style.accent, {0, 0, 0}, disc, 32);
  const std::array<Profile, 2> inner{{{r * 0.82, k.h + 0.001}, {0, k.h + 0.001}}};
  k.lathe(k.style.linen, {0, 0, 0}, inner, 32);
  const std::array<Profile, 2> middle{{{r * 0.72, k.h + 0.002}, {0, k.h + 0.002}}};
  k.lathe(k.style.accent, {0, 0, 0}, middle, 32);
}
void doormat(Kit& k, int) {
  const double x = k.w / 2, y = k.d / 2;
  k.colour = "brown";
  k.box(k.style.pot, {-x, -y, 0}, {x, y, k.h});
  k.box(k.style.black, {-x + 0.04, -y + 0.04, k.h}, {x - 0.04, y - 0.04, k.h + 0.002});
}

void pot(Kit& k, double r, double tall) {
  const std::array<Profile, 6> wall{{{0, 0},
                                     {r * 0.72, 0},
                                     {r, tall},
                                     {r * 0.88, tall},
                                     {r * 0.86, tall - 0.03},
                                     {0, tall - 0.03}}};
  k.lathe(k.rng.below(2) == 0 ? k.style.pot : k.style.white, {0, 0, 0}, wall, 14);
}

/// A leaf from `root` towards an angle, rising and bending over.
void blade(Kit& k, const looks::NamedMaterial& m, Vec3d root, double angle, double reach,
           double rise, double wide) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Vec3d mid{root.x + 0.55 * reach * c, root.y + 0.55 * reach * s, root.z + rise};
  const Vec3d tip{root.x + reach * c, root.y + reach * s, root.z + rise * 0.72};
  const Vec3d l{mid.x - wide * s, mid.y + wide * c, mid.z},
      r{mid.x + wide * s, mid.y - wide * c, mid.z};
  k.leaf(m, root, r, l);
  k.leaf(m, l, r, tip);
}

void upright_blades(Kit& k, double r, double base) {
  for (int i = 0; i < 14; ++i) {
    const double a = kTurn * k.rng.uniform(), q = r * 0.35 * k.rng.uniform(), wide = 0.025;
    const Vec3d foot{q * std::cos(a), q * std::sin(a), base - 0.03};
    const double tall = (k.h - base) * (0.55 + 0.45 * k.rng.uniform());
    const Vec3d tip{foot.x + 0.3 * r * std::cos(a), foot.y + 0.3 * r * std::sin(a), base + tall};
    const double b = kTurn * k.rng.uniform();
    const Vec3d side{wide * std::cos(b), wide * std::sin(b), 0};
    const Vec3d mid{(foot.x + tip.x) / 2, (foot.y + tip.y) / 2, base + tall * 0.5};
    const looks::NamedMaterial m = (k.rng.below(2) == 0 ? k.style.leaf : k.style.leaf2);
    k.leaf(m, foot, mid + side, mid - side);
    k.leaf(m, mid - side, mid + side, tip);
  }
}

/// A small tree, upright blades, a palm, a bush.
void plant(Kit& k, int variant) {
  const double r = k.w / 2, base = std::min(0.32, k.h * 0.3);
  k.colour = "green";
  pot(k, r * (variant == 1 ? 0.75 : 0.5), base);
  const auto green = [&] { return k.rng.below(2) == 0 ? k.style.leaf : k.style.leaf2; };
  if (variant == 1) return upright_blades(k, r, base);
  const double crown = variant == 3 ? base : (variant == 0 ? k.h * 0.5 : k.h * 0.62);
  if (variant != 3) k.bar(k.style.wood, {0, 0, base - 0.04}, {0, 0, crown + 0.05}, 0.02, 6);
  const int leaves = variant == 2 ? 26 : 44;
  for (int i = 0; i < leaves; ++i) {
    const double a = kTurn * i * 0.381966, t = (i + 0.5) / leaves;
    if (variant == 2) {
      blade(k, green(), {0, 0, crown}, a, r * 0.98, (k.h - crown) * (0.25 + 0.75 * t), 0.035);
    } else {
      const double swell = std::sin(std::numbers::pi * (0.15 + 0.8 * t));
      const double reach = r * (0.35 + 0.63 * swell * (0.7 + 0.3 * k.rng.uniform()));
      blade(k, green(),
            {0.25 * reach * std::cos(a), 0.25 * reach * std::sin(a),
             crown + (k.h - crown - 0.14) * t},
            a, reach * 0.74, 0.1, 0.05);
    }
  }
}

/// In a vase.
void flowers(Kit& k, int) {
  const double r = k.w / 2;
  const looks::NamedMaterial& petals = k.style.paints[k.rng.below(4)];
  k.spoken(petals);
  const std::array<Profile, 5> vase{{{0, 0},
                                     {r * 0.4, 0},
                                     {r * 0.55, k.h * 0.2},
                                     {r * 0.28, k.h * 0.42},
                                     {r * 0.36, k.h * 0.48}}};
  k.lathe(k.style.white, {0, 0, 0}, vase, 12);
  for (int i = 0; i < 7; ++i) {
    const double a = kTurn * i / 7, q = i == 0 ? 0 : r * 0.7;
    const Vec3d head{q * std::cos(a), q * std::sin(a), k.h * (i == 0 ? 0.93 : 0.8)};
    k.bar(k.style.leaf, {0, 0, k.h * 0.4}, head, 0.004, 4);
    k.sphere(petals, head, 0.035, 6);
  }
}

/// Square, round, fluted, panelled.
void column(Kit& k, int variant) {
  const double x = k.w / 2;
  k.spoken(variant == 0 ? k.style.wall : k.style.white);
  k.colour = "white";
  k.material.clear();
  if (variant == 0) {
    k.box(k.style.white, {-x + 0.03, -x + 0.03, 0}, {x - 0.03, x - 0.03, k.h});
  } else if (variant == 1) {
    k.cylinder(k.style.white, {0, 0, 0.1}, x * 0.8, x * 0.72, k.h - 0.2, 20);
  } else {
    k.cylinder(k.style.white, {0, 0, 0.1}, x * 0.7, x * 0.62, k.h - 0.2, 16);
    for (int i = 0; i < 12; ++i) {
      const double a = kTurn * i / 12;
      k.bar(k.style.white, {x * 0.72 * std::cos(a), x * 0.72 * std::sin(a), 0.1},
            {x * 0.64 * std::cos(a), x * 0.64 * std::sin(a), k.h - 0.1}, x * 0.13, 6);
    }
  }
  k.box(k.style.white, {-x, -x, 0}, {x, x, 0.12});
  k.box(k.style.white, {-x, -x, k.h - 0.1}, {x, x, k.h});
}

/// Brick with a beam, marble with pilasters, a modern one in a block.
void fireplace(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  const looks::NamedMaterial& m = variant == 0   ? k.style.pot
                                  : variant == 1 ? k.style.stone
                                                 : k.style.white;
  k.spoken(m);
  const double o = variant == 2 ? x * 0.72 : x * 0.55, low = variant == 2 ? 0.45 : 0.08;
  const double high = variant == 2 ? 0.95 : 0.75, top = k.h - (variant == 2 ? 0 : 0.08);
  k.box(m, {-x + 0.06, -y, 0}, {-o, y - 0.1, top});
  k.box(m, {o, -y, 0}, {x - 0.06, y - 0.1, top});
  k.box(m, {-o, -y, high}, {o, y - 0.1, top});
  k.box(m, {-o, -y, 0}, {o, y - 0.1, low});
  k.box(k.style.black, {-o, -y, low}, {o, -y + 0.03, high});
  for (const double s : {-0.18, 0.02, 0.2}) {  // logs and flames
    k.bar(k.style.paints[0], {s - 0.12, 0, low + 0.05}, {s + 0.14, 0.03, low + 0.07}, 0.04, 7);
    k.cylinder(k.style.shade, {s, 0.02, low + 0.08}, 0.06, 0.0, 0.2, 7);
  }
  if (variant == 0) {
    k.box(k.style.wood, {-x, -y, top}, {x, y, k.h});
    for (int i = 0; i < 6; ++i) {  // courses
      const double z = 0.1 + 0.15 * i;
      k.box(k.style.white, {-x + 0.055, y - 0.1, z}, {-o, y - 0.096, z + 0.012});
      k.box(k.style.white, {o, y - 0.1, z}, {x - 0.055, y - 0.096, z + 0.012});
    }
  } else if (variant == 1) {
    k.box(m, {-x, -y, top}, {x, y, k.h});
    for (const double s : {-1.0, 1.0}) {
      const double at = s * (x - 0.16);
      k.box(m, {at - 0.08, y - 0.1, 0.1}, {at + 0.08, y - 0.06, top - 0.04});
      k.box(m, {at - 0.1, y - 0.1, 0}, {at + 0.1, y - 0.04, 0.1});
    }
  }
}

const looks::NamedMaterial& cloth(Kit& k) {
  const std::array<const looks::NamedMaterial*, 5> quiet{
      &k.style.linen, &k.style.black, &k.style.fabric, &k.style.fabric2, &k.style.accent};
  return k.rng.below(3) == 0 ? k.style.paints[k.rng.below(8)] : *quiet[k.rng.below(5)];
}

void row_of_clothes(Kit& k, double x, double y) {
  k.bar(k.style.metal, {-x, 0, k.h - 0.05}, {x, 0, k.h - 0.05}, 0.014, 6);
  double at = -x + 0.04;
  const looks::NamedMaterial& first = cloth(k);
  k.spoken(first);
  while (at < x - 0.1) {
    const double thick = 0.05 + 0.04 * k.rng.uniform(),
                 tall = k.h * (0.55 + 0.35 * k.rng.uniform());
    const looks::NamedMaterial& m = k.rng.below(3) == 0 ? first : cloth(k);
    k.soft(m, {at, -y * 0.8, k.h - 0.08 - tall + 0.05}, {at + thick, y * 0.8, k.h - 0.10}, 0.02);
    k.bar(k.style.metal, {at + thick / 2, 0, k.h - 0.11}, {at + thick / 2, 0, k.h - 0.03}, 0.004,
          4);
    at += thick + 0.015 + (k.rng.below(5) == 0 ? 0.12 : 0.0);
  }
}

/// On a hook: a coat, a hat above a scarf, a row on a rod, a robe.
void clothes(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  if (variant == 2) return row_of_clothes(k, x, y);
  const looks::NamedMaterial& m = variant == 3 ? k.style.linen : cloth(k);
  k.spoken(m);
  if (variant == 1) {
    const std::array<Profile, 6> hat{
        {{0, 0.02}, {x, 0}, {x * 0.55, 0.03}, {x * 0.5, k.h - 0.02}, {x * 0.3, k.h}, {0, k.h}}};
    k.lathe(m, {0, 0, 0}, hat, 16);
    return;
  }
  const double hook = k.h;
  const std::array<Profile, 6> body{{{0, 0},
                                     {x * 0.78, 0},
                                     {x * 0.62, hook * 0.5},
                                     {x * 0.6, hook * 0.82},
                                     {x * 0.25, hook * 0.95},
                                     {0, hook * 0.97}}};
  k.lathe(m, {0, 0, 0}, body, 12, 0.8 * y / x);
  for (const double s : {-1.0, 1.0}) {  // sleeves
    k.bar(m, {s * x * 0.5, 0, hook * 0.84}, {s * x * 0.84, 0.1 * y, hook * 0.36}, x * 0.15, 7);
  }
  k.box(k.style.black, {-x * 0.06, y * 0.62, hook * 0.12}, {x * 0.02, y * 0.66, hook * 0.8});
}

void coat_rack(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(k.style.wood);
  if (variant == 0) {
    k.box(k.style.wood, {-x, -y, 0.02}, {x, -y + 0.02, 0.14});
    for (double at = -x + 0.1; at < x; at += 0.18) {
      k.bar(k.style.metal, {at, -y + 0.02, 0.07}, {at, y - 0.01, 0.1}, 0.009, 6);
    }
    return;
  }
  k.cylinder(k.style.wood, {0, 0, 0.08}, 0.025, 0.02, k.h - 0.1, 8);
  for (int i = 0; i < 4; ++i) {
    const double a = kTurn * i / 4 + 0.4, c = std::cos(a), s = std::sin(a);
    k.bar(k.style.wood, {0.9 * x * c, 0.9 * x * s, 0.014}, {0, 0, 0.2}, 0.014, 6);
    k.bar(k.style.wood, {0, 0, k.h - 0.2}, {0.5 * x * c, 0.5 * x * s, k.h - 0.05}, 0.011, 6);
  }
  const looks::NamedMaterial& coat = k.style.paints[k.rng.below(6)];
  k.soft(coat, {-x * 0.75, 0.03, k.h - 1.15}, {x * 0.75, 0.03 + x * 0.55, k.h - 0.12}, 0.05);
}

/// Slim, bellied, a bottle.
void vase(Kit& k, int variant) {
  const double r = k.w / 2, h = k.h;
  const looks::NamedMaterial& m = k.style.paints[k.rng.below(7)];
  k.spoken(m);
  if (variant == 0) {
    const std::array<Profile, 6> slim{{{0, 0},
                                       {r * 0.6, 0},
                                       {r, h * 0.5},
                                       {r * 0.5, h * 0.8},
                                       {r * 0.65, h},
                                       {r * 0.4, h * 0.9}}};
    k.lathe(m, {0, 0, 0}, slim, 14);
  } else if (variant == 1) {
    const std::array<Profile, 6> belly{{{0, 0},
                                        {r * 0.5, 0},
                                        {r, h * 0.4},
                                        {r * 0.85, h * 0.75},
                                        {r * 0.35, h * 0.9},
                                        {r * 0.45, h}}};
    k.lathe(m, {0, 0, 0}, belly, 14);
  } else {
    const std::array<Profile, 6> bottle{
        {{0, 0}, {r, 0}, {r, h * 0.6}, {r * 0.35, h * 0.75}, {r * 0.35, h}, {0, h}}};
    k.lathe(m, {0, 0, 0}, bottle, 10);
  }
}

void bowl(Kit& k, int variant) {
  const double r = k.w / 2, h = variant == 0 ? k.h : k.h * 0.7;
  const looks::NamedMaterial& m = variant == 0 ? k.style.white : k.style.wood;
  k.spoken(m);
  const std::array<Profile, 6> dish{
      {{0, 0}, {r * 0.45, 0}, {r, h}, {r * 0.94, h}, {r * 0.4, h * 0.25}, {0, h * 0.2}}};
  k.lathe(m, {0, 0, 0}, dish, 16);
  if (variant == 0) return;
  for (int i = 0; i < 5; ++i) {  // fruit
    const double a = kTurn * i / 5;
    k.sphere(k.style.paints[static_cast<std::size_t>(i) % 4],
             {r * 0.45 * std::cos(a), r * 0.45 * std::sin(a), h * 0.25 + 0.045}, 0.042, 8);
  }
}

/// A pile, a row, open papers.
void books(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(k.style.paints[0]);
  if (variant == 1) {
    k.books(-x, x, -y, 0, k.h, k.d);
    return;
  }
  const int n = std::max(2, static_cast<int>(k.h / 0.03));
  for (int i = 0; i < n; ++i) {
    const double less = 0.02 * k.rng.uniform();
    k.box(k.style.paints[static_cast<std::size_t>(i) % 8], {-x + less, -y + less, k.h * i / n},
          {x - less * 0.5, y - 0.02 * k.rng.uniform(), k.h * (i + 1) / n});
  }
}

/// Cardboard, a crate with toys, a basket.
void box(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  const looks::NamedMaterial& m = variant == 0   ? k.style.paints[6 % k.style.paints.size()]
                                  : variant == 1 ? k.style.wood
                                                 : k.style.pot;
  k.spoken(m);
  if (variant == 0) {
    k.box(m, {-x, -y, 0}, {x, y, k.h});
    k.box(k.style.white, {-0.03, -y - 0.001, k.h - 0.001}, {0.03, y + 0.001, k.h + 0.002});
    return;
  }
  k.hollow(m, {-x, -y, 0}, {x, y, k.h}, 0.02, 0.02);
  for (int i = 0; i < 4; ++i) {
    const double px = (i % 2 == 0 ? -0.4 : 0.4) * x, py = (i < 2 ? -0.4 : 0.4) * y;
    const looks::NamedMaterial& c = k.style.paints[k.rng.below(6)];
    const double s = std::min(x, y) * 0.32;
    if (variant == 2) {
      k.soft(k.style.linen, {px - s, py - s, 0.05}, {px + s, py + s, k.h + 0.01}, 0.03);
    } else if (i % 2 == 0) {
      k.sphere(c, {px, py, k.h - s * 0.7}, s, 9);
    } else {
      k.box(c, {px - s, py - s, 0.03}, {px + s, py + s, k.h - 0.02});
    }
  }
}

/// A cylinder with a rim, square.
void trash_can(Kit& k, int variant) {
  const double r = k.w / 2;
  k.spoken(k.style.metal);
  if (variant == 0) {
    const std::array<Profile, 6> can{
        {{0, 0}, {r * 0.8, 0}, {r, k.h}, {r * 0.94, k.h}, {r * 0.75, 0.03}, {0, 0.03}}};
    k.lathe(k.style.metal, {0, 0, 0}, can, 16);
  } else {
    k.cylinder(k.style.metal, {0, 0, 0}, r, r, k.h * 0.85, 16);
    const std::array<Profile, 4> lid{
        {{r, k.h * 0.85}, {r * 0.9, k.h * 0.93}, {r * 0.5, k.h}, {0, k.h}}};
    k.lathe(k.style.black, {0, 0, 0}, lid, 16);
  }
}

/// Stones on each other, a ring, a head-like form.
void sculpture(Kit& k, int variant) {
  const double r = k.w / 2;
  const looks::NamedMaterial& m = variant == 0 ? k.style.stone : k.style.metal;
  k.spoken(m);
  k.cylinder(k.style.wood, {0, 0, 0}, r, r, 0.02, 14);
  if (variant == 0) {
    const std::array<Profile, 7> stones{{{0, 0.02},
                                         {r * 0.8, k.h * 0.2},
                                         {r * 0.3, k.h * 0.42},
                                         {r * 0.6, k.h * 0.58},
                                         {r * 0.2, k.h * 0.75},
                                         {r * 0.38, k.h * 0.9},
                                         {0, k.h}}};
    k.lathe(m, {0, 0, 0}, stones, 14);
    return;
  }
  const double rr = std::min(r * 0.8, (k.h - 0.04) / 2 - 0.02);
  for (int i = 0; i < 16; ++i) {
    const double a = kTurn * i / 16, b = kTurn * (i + 1) / 16, z = 0.04 + rr;
    k.bar(m, {rr * std::cos(a), 0, z + rr * std::sin(a)},
          {rr * std::cos(b), 0, z + rr * std::sin(b)}, 0.018, 6);
  }
}

void candles(Kit& k, int) {
  k.spoken(k.style.linen);
  for (int i = 0; i < 3; ++i) {
    const double at = (i - 1) * k.w * 0.33, tall = k.h * (0.5 + 0.2 * ((i * 2) % 3));
    k.cylinder(k.style.linen, {at, 0, 0}, 0.024, 0.024, tall, 10);
    k.cylinder(k.style.shade, {at, 0, tall}, 0.006, 0.0, 0.02, 5);
  }
}

void laptop(Kit& k, int) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(k.style.metal);
  k.box(k.style.metal, {-x, -y + 0.03, 0}, {x, y, 0.016});
  k.box(k.style.black, {-x + 0.02, -y + 0.05, 0.016}, {x - 0.02, y - 0.08, 0.018});
  k.quad(k.style.screen, {x, -y + 0.03, 0.016}, {-x, -y + 0.03, 0.016}, {-x, -y, k.h},
         {x, -y, k.h});
  k.quad(k.style.metal, {-x, -y + 0.024, 0.016}, {x, -y + 0.024, 0.016}, {x, -y - 0.004, k.h},
         {-x, -y - 0.004, k.h});
}

void keyboard(Kit& k, int) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(k.style.black);
  k.box(k.style.black, {-x, -y, 0}, {x, y, 0.012});
  for (int i = 0; i < 4; ++i) {
    const double y0 = -y + 0.012 + i * (k.d - 0.02) / 4;
    k.box(k.style.white, {-x + 0.012, y0, 0.012}, {x - 0.012, y0 + 0.022, k.h});
  }
}

void cups(Kit& k, int) {
  k.spoken(k.style.white);
  for (int i = 0; i < 2; ++i) {
    const double at = (i == 0 ? -0.3 : 0.3) * k.w;
    k.cylinder(i == 0 ? k.style.white : k.style.paints[1], {at, 0, 0}, 0.03, 0.04, k.h, 12);
  }
}

void plates(Kit& k, int) {
  k.spoken(k.style.white);
  const double r = k.w * 0.36;
  const std::array<Profile, 4> plate{{{0, 0}, {r * 0.6, 0}, {r, 0.02}, {0, 0.008}}};
  k.lathe(k.style.white, {0, 0, 0}, plate, 18);
  k.cylinder(k.style.glass, {k.w * 0.38, k.d * 0.2, 0}, 0.028, 0.036, k.h, 10);
  k.box(k.style.metal, {-k.w / 2, -0.09, 0}, {-k.w / 2 + 0.015, 0.09, 0.006});
}

void bottles(Kit& k, int) {
  k.spoken(k.style.paints[0]);
  for (int i = 0; i < 3; ++i) {
    const double at = (i - 1) * k.w * 0.34, tall = k.h * (0.7 + 0.15 * ((i * 2) % 3));
    k.cylinder(k.style.paints[static_cast<std::size_t>(i)], {at, 0, 0}, 0.026, 0.026, tall * 0.8,
               10);
    k.cylinder(k.style.white, {at, 0, tall * 0.8}, 0.012, 0.012, tall * 0.2, 8);
  }
}

void shoes(Kit& k, int) {
  const looks::NamedMaterial& m = k.style.paints[k.rng.below(8)];
  k.spoken(m);
  for (const double s : {-1.0, 1.0}) {
    const double at = s * k.w * 0.27;
    k.soft(m, {at - 0.045, -k.d / 2, 0}, {at + 0.045, k.d / 2, 0.06}, 0.02);
    k.soft(m, {at - 0.042, -k.d / 2, 0.03}, {at + 0.042, -k.d * 0.05, k.h}, 0.02);
  }
}

void teddy(Kit& k, int) {
  const looks::NamedMaterial& m = k.style.paints[k.rng.below(8)];
  k.spoken(m);
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

void heater(Kit& k, int) {
  const double x = k.w / 2, y = k.d / 2;
  k.colour = "white";
  const int ribs = static_cast<int>(k.w / 0.08);
  for (int i = 0; i < ribs; ++i) {
    const double at = -x + k.w * (i + 0.5) / ribs;
    k.soft(k.style.white, {at - 0.03, -y, 0.08}, {at + 0.03, y, k.h}, 0.015);
  }
  k.box(k.style.white, {-x + 0.03, -y * 0.4, 0}, {-x + 0.06, y * 0.4, 0.1});
  k.box(k.style.white, {x - 0.06, -y * 0.4, 0}, {x - 0.03, y * 0.4, 0.1});
}

void piano(Kit& k, int) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(k.style.black);
  k.box(k.style.black, {-x, -y, 0}, {x, -y + 0.3, k.h});
  k.box(k.style.black, {-x, -y + 0.3, 0.58}, {x, y, 0.68});
  k.box(k.style.white, {-x + 0.08, y - 0.17, 0.68}, {x - 0.08, y - 0.02, 0.70});
  for (double at = -x + 0.12; at < x - 0.12; at += 0.055) {
    k.box(k.style.black, {at, y - 0.17, 0.70}, {at + 0.02, y - 0.08, 0.712});
  }
  for (const double s : {-x + 0.04, x - 0.04}) {
    k.box(k.style.black, {s - 0.04, y - 0.1, 0}, {s + 0.04, y - 0.02, 0.58});
    k.box(k.style.black, {s - 0.04, -y + 0.3, 0.68}, {s + 0.04, y, 0.74});
  }
}

void globe(Kit& k, int) {
  const double r = k.w / 2;
  k.colour = "blue";
  k.cylinder(k.style.wood, {0, 0, 0}, r * 0.7, r * 0.6, 0.03, 14);
  k.bar(k.style.metal, {0, 0, 0.03}, {0, 0, k.h}, 0.008, 6);
  k.sphere(k.style.paints[1], {0, 0, k.h - r * 0.95}, r * 0.92, 16);
}

void toilet_paper(Kit& k, int) {
  const double y0 = -k.d / 2;
  k.colour = "white";
  k.box(k.style.metal, {-k.w / 2, y0, k.h * 0.6}, {k.w / 2, y0 + 0.02, k.h});
  k.bar(k.style.white, {-k.w / 2 + 0.01, 0.01, k.h * 0.5}, {k.w / 2 - 0.01, 0.01, k.h * 0.5},
        k.h * 0.42, 14);
}

void toilet_brush(Kit& k, int) {
  k.colour = "white";
  k.cylinder(k.style.white, {0, 0, 0}, k.w / 2, k.w * 0.42, 0.16, 12);
  k.bar(k.style.metal, {0, 0, 0.14}, {0, 0, k.h}, 0.01, 6);
}

void fence(Kit& k, int) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(k.style.wood2);
  for (double at = -x; at < x - 0.05; at += 0.14) {
    k.box(k.style.wood2, {at, -y, 0}, {at + 0.09, -y + 0.02, k.h});
  }
  for (const double z : {0.2, k.h - 0.25}) {
    k.box(k.style.wood2, {-x, -y + 0.02, z}, {x, y, z + 0.07});
  }
}

void grill(Kit& k, int) {
  const double r = k.w / 2;
  k.colour = "black";
  for (int i = 0; i < 3; ++i) {
    const double a = kTurn * i / 3;
    k.bar(k.style.metal, {0.8 * r * std::cos(a), 0.8 * r * std::sin(a), 0.012},
          {0.4 * r * std::cos(a), 0.4 * r * std::sin(a), 0.6}, 0.014, 6);
  }
  const std::array<Profile, 8> kettle{{{0, 0.5},
                                       {r * 0.6, 0.55},
                                       {r, 0.75},
                                       {r, 0.8},
                                       {r * 0.8, k.h - 0.08},
                                       {r * 0.4, k.h - 0.03},
                                       {0, k.h - 0.02},
                                       {0, k.h - 0.02}}};
  k.lathe(k.style.black, {0, 0, 0}, kettle, 18);
  k.box(k.style.wood, {-0.06, -0.012, k.h - 0.03}, {0.06, 0.012, k.h});
}

constexpr std::array kShapes{
    Shape{"rug", kFloor, rug, 0, {2.0, 1.4, 0.012}},
    Shape{"rug", kFloor, round_rug, 0, {1.6, 1.6, 0.012}},
    Shape{"runner", kFloor, rug, 1, {2.2, 0.7, 0.010}, "rug"},
    Shape{"bath mat", kFloor, rug, 2, {0.80, 0.50, 0.020}},
    Shape{"doormat", kFloor, doormat, 0, {0.75, 0.45, 0.015}},
    Shape{"plant", kPlant, plant, 0, {0.60, 0.60, 1.35}},
    Shape{"plant", kPlant, plant, 1, {0.36, 0.36, 0.95}},
    Shape{"plant", kPlant, plant, 2, {0.90, 0.90, 1.70}},
    Shape{"plant", kPlant, plant, 3, {0.50, 0.50, 0.80}},
    Shape{"small plant", kPlant, plant, 3, {0.20, 0.20, 0.26}, "potted plant"},
    Shape{"small plant", kPlant, plant, 1, {0.14, 0.14, 0.28}, "potted plant"},
    Shape{"flowers", kPlant, flowers, 0, {0.22, 0.22, 0.38}},
    Shape{"bush", kPlant, plant, 3, {0.80, 0.80, 0.95}},
    Shape{"column", kColumn, column, 0, {0.34, 0.34, 2.6}},
    Shape{"column", kColumn, column, 1, {0.36, 0.36, 2.6}},
    Shape{"column", kColumn, column, 2, {0.36, 0.36, 2.6}},
    Shape{"fireplace", kFireplace, fireplace, 0, {1.50, 0.46, 1.15}},
    Shape{"fireplace", kFireplace, fireplace, 1, {1.45, 0.42, 1.12}},
    Shape{"fireplace", kFireplace, fireplace, 2, {1.60, 0.40, 1.30}},
    Shape{"coat", kClothes, clothes, 0, {0.50, 0.16, 0.95}},
    Shape{"hat", kClothes, clothes, 1, {0.28, 0.28, 0.13}},
    Shape{"hanging clothes", kClothes, clothes, 2, {1.20, 0.50, 1.15}},
    Shape{"bathrobe", kClothes, clothes, 3, {0.48, 0.14, 1.05}},
    Shape{"coat rack", kMisc, coat_rack, 0, {0.95, 0.12, 0.16}},
    Shape{"coat stand", kMisc, coat_rack, 1, {0.50, 0.50, 1.75}, "coat rack"},
    Shape{"vase", kObjects, vase, 0, {0.14, 0.14, 0.32}},
    Shape{"vase", kObjects, vase, 1, {0.20, 0.20, 0.24}},
    Shape{"bottle", kObjects, vase, 2, {0.08, 0.08, 0.28}},
    Shape{"bowl", kObjects, bowl, 0, {0.24, 0.24, 0.08}},
    Shape{"fruit bowl", kObjects, bowl, 1, {0.28, 0.28, 0.13}, "bowl of fruit"},
    Shape{"books", kObjects, books, 0, {0.24, 0.18, 0.10}},
    Shape{"books", kObjects, books, 1, {0.34, 0.18, 0.24}},
    Shape{"box", kObjects, box, 0, {0.45, 0.36, 0.32}},
    Shape{"toy box", kObjects, box, 1, {0.60, 0.38, 0.34}, "box"},
    Shape{"basket", kObjects, box, 2, {0.42, 0.42, 0.40}},
    Shape{"trash can", kObjects, trash_can, 0, {0.28, 0.28, 0.32}},
    Shape{"trash can", kObjects, trash_can, 1, {0.30, 0.30, 0.62}},
    Shape{"sculpture", kObjects, sculpture, 0, {0.18, 0.18, 0.34}},
    Shape{"sculpture", kObjects, sculpture, 1, {0.26, 0.26, 0.30}},
    Shape{"candles", kObjects, candles, 0, {0.24, 0.08, 0.20}, "candle"},
    Shape{"laptop", kObjects, laptop, 0, {0.34, 0.27, 0.23}},
    Shape{"keyboard", kObjects, keyboard, 0, {0.42, 0.13, 0.02}},
    Shape{"cups", kObjects, cups, 0, {0.24, 0.10, 0.09}, "cup"},
    Shape{"plate", kObjects, plates, 0, {0.34, 0.26, 0.13}},
    Shape{"bottles", kObjects, bottles, 0, {0.22, 0.08, 0.20}},
    Shape{"shoes", kObjects, shoes, 0, {0.24, 0.27, 0.11}},
    Shape{"stuffed animal", kObjects, teddy, 0, {0.30, 0.24, 0.31}},
    Shape{"radiator", kObjects, heater, 0, {0.90, 0.10, 0.55}},
    Shape{"piano", kObjects, piano, 0, {1.48, 0.62, 1.20}},
    Shape{"globe", kMisc, globe, 0, {0.28, 0.28, 0.40}},
    Shape{"toilet paper", kMisc, toilet_paper, 0, {0.14, 0.12, 0.13}, "toilet paper holder"},
    Shape{"toilet brush", kMisc, toilet_brush, 0, {0.12, 0.12, 0.42}},
    Shape{"fence", kMisc, fence, 0, {1.50, 0.06, 0.90}},
    Shape{"grill", kMisc, grill, 0, {0.56, 0.56, 1.02}},
};

}  // namespace

std::span<const Shape> decor_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
