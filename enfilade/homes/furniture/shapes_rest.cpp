#include <algorithm>
#include <array>
#include <cmath>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

/// Beds are covered with cloth also where sofas are of leather.
const looks::NamedMaterial& cover(const Kit& k) {
  return k.style.fabric.material == "leather" ? k.style.accent : k.style.fabric;
}

void bedding(Kit& k, double x, double y0, double y1, double base) {
  const double top = base + 0.24;
  k.soft(k.style.linen, {-x, y0, base}, {x, y1, top}, 0.05);
  k.soft(cover(k), {-x - 0.015, y0 + 0.52, base + 0.04}, {x + 0.015, y1 + 0.015, top + 0.05},
         0.045);
  k.soft(k.style.fabric2, {-x - 0.02, y1 - 0.6, base + 0.05}, {x + 0.02, y1 - 0.12, top + 0.065},
         0.03);
  const int pillows = x > 0.6 ? 2 : 1;
  const double each = 2 * x / pillows;
  for (int i = 0; i < pillows; ++i) {
    const double c = -x + each * (i + 0.5), half = std::min(0.33, each / 2 - 0.04);
    k.soft(k.style.linen, {c - half, y0 + 0.04, top - 0.01}, {c + half, y0 + 0.46, top + 0.13},
           0.06);
  }
}

void metal_bed(Kit& k, double x, double y) {
  const double r = 0.02;
  for (const double s : {-x + r, x - r}) {
    k.bar(k.style.metal, {s, -y + r, 0}, {s, -y + r, k.h - 0.02}, r);
    k.bar(k.style.metal, {s, y - r, 0}, {s, y - r, 0.62}, r);
    k.box(k.style.metal, {s - 0.015, -y, 0.24}, {s + 0.015, y, 0.30});
  }
  for (const double z : {0.5, k.h - 0.04}) {
    k.bar(k.style.metal, {-x + r, -y + r, z}, {x - r, -y + r, z}, r * 0.8);
  }
  k.bar(k.style.metal, {-x + r, y - r, 0.60}, {x - r, y - r, 0.60}, r * 0.8);
  for (int i = -3; i <= 3; ++i) {
    const double at = i * x * 0.27;
    k.bar(k.style.metal, {at, -y + r, 0.5}, {at, -y + r, k.h - 0.04}, 0.009, 5);
    k.bar(k.style.metal, {at, y - r, 0.28}, {at, y - r, 0.6}, 0.009, 5);
  }
  bedding(k, x - 0.05, -y + 0.05, y - 0.06, 0.30);
}

/// Panel, upholstered, four posts, metal bars.
void bed(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(cover(k));
  k.material.clear();
  if (variant == 1) {
    k.soft(k.style.fabric2, {-x, -y, 0.1}, {x, -y + 0.1, k.h}, 0.04);
    k.soft(k.style.fabric2, {-x, -y + 0.05, 0.08}, {x, y, 0.30}, 0.04);
    bedding(k, x - 0.04, -y + 0.1, y - 0.04, 0.28);
    return;
  }
  if (variant == 3) return metal_bed(k, x, y);
  k.box(k.style.wood, {-x, -y + 0.05, 0.14}, {x, y, 0.32});
  k.legs(k.style.wood, 0.15, 0.035, 0.0);
  bedding(k, x - 0.04, -y + 0.07, y - 0.04, 0.30);
  if (variant == 0) {
    k.box(k.style.wood, {-x, -y, 0}, {x, -y + 0.05, k.h});
    k.box(k.style.wood, {-x - 0.0, -y, k.h - 0.06}, {x, -y + 0.07, k.h});
    return;
  }
  k.box(k.style.wood, {-x, -y, 0.3}, {x, -y + 0.05, 1.2});
  for (const double sx : {-x + 0.035, x - 0.035}) {
    for (const double sy : {-y + 0.035, y - 0.035}) {
      k.box(k.style.wood, {sx - 0.035, sy - 0.035, 0}, {sx + 0.035, sy + 0.035, k.h});
    }
    k.box(k.style.wood, {sx - 0.03, -y, k.h - 0.06}, {sx + 0.03, y, k.h});
  }
  for (const double sy : {-y + 0.03, y - 0.03}) {
    k.box(k.style.wood, {-x, sy - 0.03, k.h - 0.06}, {x, sy + 0.03, k.h});
  }
}

void bunk_bed(Kit& k, int) {
  const double x = k.w / 2, y = k.d / 2;
  k.spoken(k.style.wood);
  for (const double sx : {-x + 0.035, x - 0.035}) {
    for (const double sy : {-y + 0.035, y - 0.035}) {
      k.box(k.style.wood, {sx - 0.035, sy - 0.035, 0}, {sx + 0.035, sy + 0.035, k.h});
    }
    for (const double z : {0.25, 1.2, 1.52}) {
      k.box(k.style.wood, {sx - 0.015, -y, z}, {sx + 0.015, y, z + 0.1});
    }
  }
  for (const double base : {0.28, 1.22}) {
    k.soft(k.style.linen, {-x + 0.05, -y + 0.05, base}, {x - 0.05, y - 0.05, base + 0.16}, 0.04);
    k.soft(base < 1 ? cover(k) : k.style.fabric2, {-x + 0.05, -y + 0.6, base + 0.02},
           {x - 0.05, y - 0.05, base + 0.2}, 0.04);
    k.soft(k.style.linen, {-0.3, -y + 0.08, base + 0.14}, {0.3, -y + 0.46, base + 0.26}, 0.05);
  }
  for (int i = 0; i < 5; ++i) {
    k.box(k.style.wood, {-0.2, y - 0.03, 0.3 + 0.25 * i}, {0.2, y, 0.34 + 0.25 * i});
  }
}

/// Square, round, roll.
void cushion(Kit& k, int variant) {
  const looks::NamedMaterial& m = k.rng.below(2) == 0 ? k.style.accent : k.style.fabric2;
  k.spoken(m);
  const double x = k.w / 2, y = k.d / 2;
  if (variant == 0) {
    k.soft(m, {-x, -y, 0}, {x, y, k.h}, std::min(y, 0.06) * 0.9);
  } else if (variant == 1) {
    const std::array<std::array<double, 2>, 6> round{{{0, 0},
                                                      {x * 0.8, 0.01},
                                                      {x, k.h * 0.35},
                                                      {x, k.h * 0.65},
                                                      {x * 0.8, k.h - 0.01},
                                                      {0, k.h}}};
    k.lathe(m, {0, 0, 0}, round, 16);
  } else {
    k.bar(m, {-x, 0, k.h / 2}, {x, 0, k.h / 2}, k.h / 2, 12);
  }
}

/// Drawers, an open shelf, round.
void nightstand(Kit& k, int variant) {
  const looks::NamedMaterial& m = k.style.wood;
  k.spoken(m);
  const double x = k.w / 2, y = k.d / 2;
  if (variant == 2) {
    k.cylinder(m, {0, 0, 0}, x * 0.6, x * 0.6, 0.025, 16);
    k.cylinder(m, {0, 0, 0.02}, 0.03, 0.03, 0.3, 8);
    k.cylinder(m, {0, 0, 0.3}, x * 0.9, x * 0.9, k.h - 0.33, 18);
    k.cylinder(k.style.stone, {0, 0, k.h - 0.03}, x, x, 0.03, 18);
    return;
  }
  if (variant == 0) {
    k.legs(m, 0.1, 0.02, 0.01);
    k.box(m, {-x, -y, 0.1}, {x, y - 0.02, k.h});
    k.fronts(k.style.wood2, {-x, 0, 0.1}, {x, 0, k.h - 0.03}, y - 0.018 + 0.014, 1, 2, true);
    return;
  }
  for (const double s : {-x + 0.01, x - 0.01}) k.box(m, {s - 0.01, -y, 0}, {s + 0.01, y, k.h});
  k.box(m, {-x, -y, k.h - 0.03}, {x, y, k.h});
  k.box(m, {-x, -y, 0.12}, {x, y, 0.14});
  k.box(m, {-x, -y, k.h - 0.18}, {x, y - 0.02, k.h - 0.02});
  k.box(m, {-x, -y, 0.12}, {x, -y + 0.015, k.h});
  k.fronts(m, {-x + 0.02, 0, k.h - 0.17}, {x - 0.02, 0, k.h - 0.03}, y - 0.006, 1, 1);
}

/// Wide, tall, bombe.
void dresser(Kit& k, int variant) {
  const looks::NamedMaterial& m = k.style.wood;
  k.spoken(m);
  const double x = k.w / 2, y = k.d / 2, foot = variant == 1 ? 0.04 : 0.12;
  if (variant == 1) {
    k.box(k.style.black, {-x + 0.02, -y + 0.02, 0}, {x - 0.02, y - 0.05, foot + 0.01});
  } else {
    k.legs(m, foot, 0.025, 0.02, variant == 2);
  }
  k.box(m, {-x + 0.01, -y, foot}, {x - 0.01, y - 0.03, k.h - 0.02});
  k.box(variant == 2 ? k.style.stone : m, {-x, -y, k.h - 0.03}, {x, y, k.h});
  const unsigned columns = variant == 0 ? 2 : 1, rows = variant == 1 ? 5 : 3;
  k.fronts(variant == 0 ? m : k.style.wood2, {-x + 0.02, 0, foot + 0.01}, {x - 0.02, 0, k.h - 0.04},
           y - 0.02, columns, rows, variant == 2);
}

constexpr std::array kShapes{
    Shape{"bed", kBed, bed, 0, {1.66, 2.10, 1.05}},
    Shape{"bed", kBed, bed, 1, {1.70, 2.12, 1.20}},
    Shape{"bed", kBed, bed, 2, {1.66, 2.12, 2.05}},
    Shape{"bed", kBed, bed, 3, {1.46, 2.06, 1.15}},
    Shape{"single bed", kBed, bed, 0, {0.98, 2.06, 0.95}, "bed"},
    Shape{"single bed", kBed, bed, 1, {1.00, 2.08, 1.05}, "bed"},
    Shape{"single bed", kBed, bed, 3, {0.96, 2.04, 1.00}, "bed"},
    Shape{"bunk bed", kBed, bunk_bed, 0, {1.00, 2.08, 1.65}, "bed"},
    Shape{"cushion", kCushion, cushion, 0, {0.44, 0.16, 0.42}},
    Shape{"cushion", kCushion, cushion, 1, {0.40, 0.40, 0.12}},
    Shape{"cushion", kCushion, cushion, 2, {0.48, 0.18, 0.18}},
    Shape{"nightstand", kChestOfDrawers, nightstand, 0, {0.48, 0.40, 0.55}},
    Shape{"nightstand", kChestOfDrawers, nightstand, 1, {0.45, 0.38, 0.52}},
    Shape{"nightstand", kChestOfDrawers, nightstand, 2, {0.44, 0.44, 0.56}},
    Shape{"dresser", kChestOfDrawers, dresser, 0, {1.30, 0.48, 0.82}},
    Shape{"dresser", kChestOfDrawers, dresser, 2, {1.00, 0.46, 0.86}},
    Shape{"chest of drawers", kChestOfDrawers, dresser, 1, {0.72, 0.46, 1.18}},
};

}  // namespace

std::span<const Shape> rest_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
