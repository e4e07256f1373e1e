#include <algorithm>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

/// Beds are covered with cloth also where sofas are of leather.
const NamedMaterial& cover(const Kit& k) {
  return k.style.fabric.material == "leather" ? k.style.accent : k.style.fabric;
}

void bedding(Kit& k, double x, double y0, double y1, double base) {
  const double top = base + 0.24;
  k.soft(k.style.linen, {-x, y0, base}, {x, y1, top}, 0.05);
  const double out = x + 0.015, wide = x + 0.02;
  k.soft(cover(k), {-out, y0 + 0.52, base + 0.04}, {out, y1 + 0.015, top + 0.05}, 0.045);
  k.soft(k.style.fabric2, {-wide, y1 - 0.6, base + 0.05}, {wide, y1 - 0.12, top + 0.065}, 0.03);
  const int pillows = x > 0.6 ? 2 : 1;
  const double each = 2 * x / pillows;
  for (int i = 0; i < pillows; ++i) {
    const double c = -x + each * (i + 0.5), half = std::min(0.33, each / 2 - 0.04);
    const Vec3d low{c - half, y0 + 0.04, top - 0.01}, high{c + half, y0 + 0.46, top + 0.13};
    k.soft(k.style.linen, low, high, 0.06);
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

constexpr double kPost = 0.035;  // half the thickness of a bed's posts

/// A post on the +x side: at the head (-1) or the foot (1).
Block post(const Kit& k, double end) {
  const double x = k.w / 2 - kPost, y = end * (k.d / 2 - kPost);
  return {{x - kPost, y - kPost, 0}, {x + kPost, y + kPost, k.h}};
}

/// A rail between the two posts of the +x side.
Block rail(const Kit& k, double half, double z0, double z1) {
  const double x = k.w / 2 - kPost, y = k.d / 2;
  return {{x - half, -y, z0}, {x + half, y, z1}};
}

/// Panel, upholstered, four posts, metal bars.
void bed(Kit& k, double x, double y) {
  k.spoken(cover(k));
  k.material.clear();
  if (k.variant == 1) {
    k.soft(k.style.fabric2, {-x, -y, 0.1}, {x, -y + 0.1, k.h}, 0.04);
    k.soft(k.style.fabric2, {-x, -y + 0.05, 0.08}, {x, y, 0.30}, 0.04);
    bedding(k, x - 0.04, -y + 0.1, y - 0.04, 0.28);
    return;
  }
  if (k.variant == 3) return metal_bed(k, x, y);
  k.box(k.style.wood, {-x, -y + 0.05, 0.14}, {x, y, 0.32});
  k.legs(k.style.wood, 0.15, 0.035, 0.0);
  bedding(k, x - 0.04, -y + 0.07, y - 0.04, 0.30);
  if (k.variant == 0) {
    k.box(k.style.wood, {-x, -y, 0}, {x, -y + 0.05, k.h});
    k.box(k.style.wood, {-x, -y, k.h - 0.06}, {x, -y + 0.07, k.h});
    return;
  }
  k.box(k.style.wood, {-x, -y, 0.3}, {x, -y + 0.05, 1.2});
  k.pairs(k.style.wood, {post(k, -1), post(k, 1), rail(k, 0.03, k.h - 0.06, k.h)});
  for (const double sy : {-y + 0.03, y - 0.03}) {
    k.box(k.style.wood, {-x, sy - 0.03, k.h - 0.06}, {x, sy + 0.03, k.h});
  }
}

void bunk_bed(Kit& k, double x, double y) {
  k.pairs(k.main, {post(k, -1), post(k, 1), rail(k, 0.015, 0.25, 0.25 + 0.1),
                   rail(k, 0.015, 1.2, 1.2 + 0.1), rail(k, 0.015, 1.52, 1.52 + 0.1)});
  for (const double base : {0.28, 1.22}) {
    k.soft(k.style.linen, {-x + 0.05, -y + 0.05, base}, {x - 0.05, y - 0.05, base + 0.16}, 0.04);
    const NamedMaterial& m = base < 1 ? cover(k) : k.style.fabric2;
    k.soft(m, {-x + 0.05, -y + 0.6, base + 0.02}, {x - 0.05, y - 0.05, base + 0.2}, 0.04);
    k.soft(k.style.linen, {-0.3, -y + 0.08, base + 0.14}, {0.3, -y + 0.46, base + 0.26}, 0.05);
  }
  for (int i = 0; i < 5; ++i) {
    k.box(k.main, {-0.2, y - 0.03, 0.3 + 0.25 * i}, {0.2, y, 0.34 + 0.25 * i});
  }
}

/// Square, round, roll.
void cushion(Kit& k, double x, double y) {
  const NamedMaterial& m = k.spoken(k.rng.below(2) == 0 ? k.style.accent : k.style.fabric2);
  if (k.variant == 0) {
    k.soft(m, {-x, -y, 0}, {x, y, k.h}, std::min(y, 0.06) * 0.9);
  } else if (k.variant == 1) {
    k.lathe(m, {0, 0, 0}, 16, 1, Ring{0, 0}, Ring{x * 0.8, 0.01}, Ring{x, k.h * 0.35},
            Ring{x, k.h * 0.65}, Ring{x * 0.8, k.h - 0.01}, Ring{0, k.h});
  } else {
    k.bar(m, {-x, 0, k.h / 2}, {x, 0, k.h / 2}, k.h / 2, 12);
  }
}

/// Drawers, an open shelf, round.
void nightstand(Kit& k, double x, double y) {
  if (k.variant == 2) {
    k.cylinder(k.main, {0, 0, 0}, x * 0.6, x * 0.6, 0.025, 16);
    k.cylinder(k.main, {0, 0, 0.02}, 0.03, 0.03, 0.3, 8);
    k.cylinder(k.main, {0, 0, 0.3}, x * 0.9, x * 0.9, k.h - 0.33, 18);
    k.cylinder(k.style.stone, {0, 0, k.h - 0.03}, x, x, 0.03, 18);
    return;
  }
  if (k.variant == 0) {
    k.legs(k.main, 0.1, 0.02, 0.01);
    k.box(k.main, {-x, -y, 0.1}, {x, y - 0.02, k.h});
    k.fronts(k.style.wood2, {-x, 0, 0.1}, {x, 0, k.h - 0.03}, y - 0.018 + 0.014, 1, 2, true);
    return;
  }
  k.pairs(k.main, {{{x - 0.01 - 0.01, -y, 0}, {x - 0.01 + 0.01, y, k.h}}});
  k.box(k.main, {-x, -y, k.h - 0.03}, {x, y, k.h});
  k.box(k.main, {-x, -y, 0.12}, {x, y, 0.14});
  k.box(k.main, {-x, -y, k.h - 0.18}, {x, y - 0.02, k.h - 0.02});
  k.box(k.main, {-x, -y, 0.12}, {x, -y + 0.015, k.h});
  k.fronts(k.main, {-x + 0.02, 0, k.h - 0.17}, {x - 0.02, 0, k.h - 0.03}, y - 0.006, 1, 1);
}

/// Wide, tall, with a stone top.
void dresser(Kit& k, double x, double y) {
  const double foot = k.variant == 1 ? 0.04 : 0.12;
  if (k.variant == 1) {
    k.box(k.style.black, {-x + 0.02, -y + 0.02, 0}, {x - 0.02, y - 0.05, foot + 0.01});
  } else {
    k.legs(k.main, foot, 0.025, 0.02, k.variant == 2);
  }
  k.box(k.main, {-x + 0.01, -y, foot}, {x - 0.01, y - 0.03, k.h - 0.02});
  k.box(k.variant == 2 ? k.style.stone : k.main, {-x, -y, k.h - 0.03}, {x, y, k.h});
  const unsigned columns = k.variant == 0 ? 2 : 1, rows = k.variant == 1 ? 5 : 3;
  k.fronts(k.variant == 0 ? k.main : k.style.wood2, {-x + 0.02, 0, foot + 0.01},
           {x - 0.02, 0, k.h - 0.04}, y - 0.02, columns, rows, k.variant == 2);
}

constexpr Shape kShapes[] = {
    {"bed", kBed, bed, 0, {1.66, 2.10, 1.05}, nullptr},
    {"bed", kBed, bed, 1, {1.70, 2.12, 1.20}, nullptr},
    {"bed", kBed, bed, 2, {1.66, 2.12, 2.05}, nullptr},
    {"bed", kBed, bed, 3, {1.46, 2.06, 1.15}, nullptr},
    {"single bed", kBed, bed, 0, {0.98, 2.06, 0.95}, nullptr, "bed"},
    {"single bed", kBed, bed, 1, {1.00, 2.08, 1.05}, nullptr, "bed"},
    {"single bed", kBed, bed, 3, {0.96, 2.04, 1.00}, nullptr, "bed"},
    {"bunk bed", kBed, bunk_bed, 0, {1.00, 2.08, 1.65}, &Style::wood, "bed"},
    {"cushion", kCushion, cushion, 0, {0.44, 0.16, 0.42}, nullptr},
    {"cushion", kCushion, cushion, 1, {0.40, 0.40, 0.12}, nullptr},
    {"cushion", kCushion, cushion, 2, {0.48, 0.18, 0.18}, nullptr},
    {"nightstand", kChestOfDrawers, nightstand, 0, {0.48, 0.40, 0.55}, &Style::wood},
    {"nightstand", kChestOfDrawers, nightstand, 1, {0.45, 0.38, 0.52}, &Style::wood},
    {"nightstand", kChestOfDrawers, nightstand, 2, {0.44, 0.44, 0.56}, &Style::wood},
    {"dresser", kChestOfDrawers, dresser, 0, {1.30, 0.48, 0.82}, &Style::wood},
    {"dresser", kChestOfDrawers, dresser, 2, {1.00, 0.46, 0.86}, &Style::wood},
    {"chest of drawers", kChestOfDrawers, dresser, 1, {0.72, 0.46, 1.18}, &Style::wood},
};

}  // namespace

std::span<const Shape> rest_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
