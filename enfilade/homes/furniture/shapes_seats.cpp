#include <algorithm>
#include <cmath>
#include <numbers>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

void back_legs(Kit& k, const NamedMaterial& m, double seat, double half) {
  const double x = k.w / 2 - half, y = k.d / 2 - half;
  k.pairs(m, {{{x - half, y - half, 0}, {x + half, y + half, seat}},
              {{x - half, -y - half, 0}, {x + half, -y + half, k.h}}});
}

/// Slats, ladder, padded, shell.
void chair(Kit& k, double x, double y) {
  const NamedMaterial& m = k.style.wood;
  const double seat = 0.46;
  if (k.variant == 3) {
    k.legs(k.style.metal, seat - 0.03, 0.015, 0.05, true);
    k.soft(k.main, {-x, -y + 0.02, seat - 0.04}, {x, y, seat + 0.04}, 0.035);
    for (int i = -2; i <= 2; ++i) {  // a curved back of staves
      const double at = i * x * 0.39, half = x * 0.21, bend = 0.02 * i * i;
      const Vec3d high{at + half, -y + 0.06 + bend, k.h - 0.012 * i * i};
      k.soft(k.main, {at - half, -y + bend, seat - 0.02}, high, 0.02);
    }
    return;
  }
  back_legs(k, m, seat - 0.03, 0.02);
  if (k.variant == 2) {
    k.soft(k.main, {-x, -y + 0.04, seat - 0.06}, {x, y, seat + 0.03}, 0.03);
    k.soft(k.main, {-x + 0.01, -y + 0.005, seat + 0.1}, {x - 0.01, -y + 0.075, k.h}, 0.03);
    return;
  }
  k.box(m, {-x, -y, seat - 0.035}, {x, y, seat});
  k.soft(k.style.fabric2, {-x + 0.04, -y + 0.06, seat}, {x - 0.04, y - 0.03, seat + 0.03}, 0.015);
  k.box(m, {-x + 0.04, -y + 0.005, k.h - 0.09}, {x - 0.04, -y + 0.03, k.h});
  if (k.variant == 0) {
    for (int i = -2; i <= 2; ++i) {
      const double sx = i * x * 0.36;
      k.box(m, {sx - 0.014, -y + 0.01, seat}, {sx + 0.014, -y + 0.026, k.h - 0.08});
    }
    return;
  }
  for (const double z : {0.58, 0.70}) {
    k.box(m, {-x + 0.04, -y + 0.008, z}, {x - 0.04, -y + 0.028, z + 0.055});
  }
}

void office_chair(Kit& k, double, double) {
  const double reach = k.w / 2 - 0.03;
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * std::numbers::pi * i / 5 + 0.3;
    const Vec3d end{reach * std::cos(angle), reach * std::sin(angle), 0.06};
    k.bar(k.style.metal, {0, 0, 0.1}, end, 0.018, 5);
    k.sphere(k.style.black, {end.x, end.y, 0.03}, 0.028, 6);
  }
  k.cylinder(k.style.metal, {0, 0, 0.08}, 0.03, 0.025, 0.36, 8);
  const double x = k.w / 2 - 0.08, y = k.d / 2 - 0.06;
  k.soft(k.main, {-x, -y, 0.44}, {x, y, 0.52}, 0.04);
  k.soft(k.main, {-x + 0.02, -y - 0.05, 0.58}, {x - 0.02, -y + 0.03, k.h}, 0.035);
  k.box(k.style.black, {-0.03, -y - 0.03, 0.46}, {0.03, -y, 0.62});
  if (k.variant == 1) return;
  for (const double s : {-1.0, 1.0}) {
    const double arm = s * (x + 0.03);
    k.bar(k.style.black, {s * x, 0, 0.47}, {arm, 0, 0.66}, 0.015, 5);
    k.soft(k.style.black, {arm - 0.03, -0.13, 0.66}, {arm + 0.03, 0.14, 0.7}, 0.015);
  }
}

/// Boxy, winged, tub.
void armchair(Kit& k, double x, double y) {
  const double arm = k.variant == 1 ? 0.12 : 0.17;
  k.legs(k.style.wood, 0.13, 0.025, 0.03, true);
  if (k.variant == 2) {
    for (int i = 0; i <= 8; ++i) {  // a rounded wall of upholstery
      const double angle = std::numbers::pi * (1.0 + i / 8.0);
      const double cx = (x - 0.09) * std::cos(angle), cy = (y - 0.09) * std::sin(angle) * 0.95;
      const double top = k.h - 0.01 * std::abs(i - 4);
      k.soft(k.main, {cx - 0.09, cy - 0.09, 0.12}, {cx + 0.09, cy + 0.09, top}, 0.05);
    }
    const double side = x - 0.09;
    k.pairs(k.main, {{{side - 0.09, 0, 0.12}, {side + 0.09, y - 0.06, k.h - 0.1}}}, 0.05);
    k.soft(k.main, {-x + 0.14, -y + 0.14, 0.12}, {x - 0.14, y - 0.02, 0.44}, 0.06);
    return;
  }
  k.soft(k.main, {-x, -y, 0.12}, {x, y - 0.03, 0.30}, 0.03);
  k.soft(k.main, {-x + arm, -y + 0.16, 0.29}, {x - arm, y, 0.46}, 0.05);
  k.soft(k.main, {-x + 0.03, -y, 0.2}, {x - 0.03, -y + 0.2, k.h}, 0.06);
  for (const double x0 : {-x, x - arm}) {
    const double x1 = x0 + arm;
    k.soft(k.main, {x0, -y + 0.05, 0.12}, {x1, y - 0.02, 0.62}, 0.05);
    if (k.variant == 1) k.soft(k.main, {x0, -y + 0.05, 0.55}, {x1, -y + 0.36, k.h - 0.06}, 0.05);
  }
}

void patio_chair(Kit& k, double x, double y) {
  back_legs(k, k.main, 0.62, 0.022);
  for (int i = 0; i < 5; ++i) {
    const double y0 = -y + 0.05 + i * (k.d - 0.06) / 5;
    k.box(k.main, {-x + 0.04, y0, 0.40}, {x - 0.04, y0 + (k.d - 0.06) / 5 - 0.015, 0.425});
    const double z0 = 0.48 + i * 0.09;
    k.box(k.main, {-x + 0.04, -y + 0.01, z0}, {x - 0.04, -y + 0.03, z0 + 0.07});
  }
  k.pairs(k.main, {{{x - 0.03 - 0.03, -y + 0.04, 0.60}, {x - 0.03 + 0.03, y, 0.625}}});
}

/// Seat and back cushions from x on; the seats reach forward to `front`.
void seat_cushions(Kit& k, double x, double each, unsigned seats, double front) {
  const double back = -k.d / 2;
  for (unsigned i = 0; i < seats; ++i) {
    const double c0 = x + each * i;
    k.soft(k.main, {c0 + 0.004, back + 0.2, 0.29}, {c0 + each - 0.004, front, 0.45}, 0.045);
    k.soft(k.main, {c0 + 0.01, back + 0.14, 0.43}, {c0 + each - 0.01, back + 0.34, k.h}, 0.07);
  }
}

void boxy_sofa(Kit& k, double x, double y) {
  const double arm = 0.2;
  const unsigned seats = k.w > 1.9 ? 3 : 2;
  k.box(k.style.black, {-x + 0.05, -y + 0.05, 0}, {x - 0.05, y - 0.08, 0.13});
  k.soft(k.main, {-x, -y, 0.12}, {x, y - 0.03, 0.30}, 0.03);
  k.soft(k.main, {-x, -y, 0.2}, {x, -y + 0.2, k.h - 0.05}, 0.05);
  for (const double a : {-x, x - arm}) {
    k.soft(k.main, {a, -y + 0.03, 0.12}, {a + arm, y - 0.02, 0.62}, 0.06);
  }
  seat_cushions(k, -x + arm, (k.w - 2 * arm) / seats, seats, y);
}

/// Boxy, on turned legs with a frame of wood, with rolls along its back and arms.
void sofa(Kit& k, double x, double y) {
  if (k.variant == 0) return boxy_sofa(k, x, y);
  if (k.variant == 1) {
    k.legs(k.style.wood, 0.2, 0.025, 0.04, true);
    k.box(k.style.wood, {-x, -y, 0.18}, {x, y - 0.02, 0.24});
    k.soft(k.main, {-x + 0.02, -y, 0.24}, {x - 0.02, -y + 0.18, k.h}, 0.06);
    k.soft(k.main, {-x + 0.02, -y + 0.16, 0.24}, {x - 0.02, y, 0.45}, 0.05);
    const double arm = x - 0.03;
    k.pairs(k.style.wood, {{{arm - 0.03, -y + 0.1, 0.56}, {arm + 0.03, y - 0.03, 0.60}},
                           {{arm - 0.02, y - 0.09, 0.2}, {arm + 0.02, y - 0.05, 0.57}}});
  } else {
    k.legs(k.style.wood, 0.13, 0.03, 0.05, true);
    k.soft(k.main, {-x, -y, 0.12}, {x, y - 0.04, 0.32}, 0.04);
    k.soft(k.main, {-x + 0.16, -y + 0.2, 0.3}, {x - 0.16, y, 0.46}, 0.06);
    k.soft(k.main, {-x, -y, 0.25}, {x, -y + 0.22, k.h - 0.05}, 0.05);
    k.bar(k.main, {-x, -y + 0.12, k.h - 0.1}, {x, -y + 0.12, k.h - 0.1}, 0.1, 10);
    for (const double s : {-1.0, 1.0}) {
      const double a = s * (x - 0.11);
      k.soft(k.main, {a - 0.1, -y + 0.04, 0.2}, {a + 0.1, y - 0.04, k.h - 0.14}, 0.04);
      k.bar(k.main, {a, -y + 0.1, k.h - 0.14}, {a, y - 0.02, k.h - 0.14}, 0.11, 10);
    }
  }
}

/// Its long end is at +x.
void corner_sofa(Kit& k, double x, double y) {
  const double front = -y + 0.92;
  k.soft(k.main, {-x, -y, 0.06}, {x - 0.8, front - 0.03, 0.30}, 0.03);
  k.soft(k.main, {-x, -y, 0.2}, {x, -y + 0.2, k.h - 0.05}, 0.05);
  k.soft(k.main, {-x, -y + 0.03, 0.06}, {-x + 0.2, front - 0.02, 0.6}, 0.06);
  seat_cushions(k, -x + 0.2, (k.w - 0.2 - 0.8) / 2, 2, front);
  k.soft(k.main, {x - 0.8, -y + 0.14, 0.43}, {x - 0.02, -y + 0.34, k.h}, 0.07);
  k.part();
  k.soft(k.main, {x - 0.8, -y + 0.1, 0.06}, {x, y - 0.03, 0.30}, 0.03);
  k.soft(k.main, {x - 0.8, -y + 0.2, 0.29}, {x, y, 0.45}, 0.045);
}

/// Bar stools: plain, with a back, of three legs.
void stool(Kit& k, double x, double) {
  if (k.variant == 1) {
    k.cylinder(k.style.metal, {0, 0, 0}, x, x, 0.025, 16);
    k.cylinder(k.style.metal, {0, 0, 0.02}, 0.025, 0.025, k.h - 0.3, 8);
    k.cylinder(k.main, {0, 0, k.h - 0.31}, x * 0.95, x, 0.08, 16);
    k.soft(k.main, {-x * 0.8, -x, k.h - 0.2}, {x * 0.8, -x + 0.05, k.h}, 0.02);
    k.box(k.style.metal, {-0.02, -x, k.h - 0.3}, {0.02, -x + 0.02, k.h - 0.15});
    return;
  }
  const double r = x - 0.02;
  k.splayed_legs(k.main, k.variant == 0 ? 4 : 3, 0.5, {{{r, 0.012}, {0.6 * r, k.h - 0.04}}}, 0.016);
  k.cylinder(k.main, {0, 0, k.h - 0.05}, x * 0.92, x, 0.05, 16);
  k.cylinder(k.style.metal, {0, 0, k.h * 0.35}, x * 0.75, x * 0.75, 0.015, 16);
}

/// Ottomans: a drum, a block on legs.
void ottoman(Kit& k, double x, double y) {
  if (k.variant == 0) {
    k.cylinder(k.style.wood, {0, 0, 0}, x * 0.9, x * 0.9, 0.04, 18);
    k.lathe(k.main, {0, 0, 0}, 18, 1, Ring{0, 0.04}, Ring{x * 0.96, 0.05}, Ring{x, 0.1},
            Ring{x, k.h - 0.06}, Ring{x * 0.93, k.h - 0.01}, Ring{0, k.h});
  } else {
    k.legs(k.style.wood, 0.14, 0.02, 0.03, true);
    k.soft(k.main, {-x, -y, 0.13}, {x, y, k.h}, 0.05);
  }
}

/// Planks on trestles, padded, with a back.
void bench(Kit& k, double x, double y) {
  const double seat = k.variant == 2 ? 0.45 : k.h;
  if (k.variant == 1) {
    k.legs(k.style.metal, seat - 0.1, 0.018, 0.03);
    k.soft(k.main, {-x, -y, seat - 0.11}, {x, y, seat}, 0.04);
    return;
  }
  for (const double s : {-1.0, 1.0}) {
    const double at = s * (x - 0.12);
    k.box(k.main, {at - 0.025, -y + 0.03, 0}, {at + 0.025, y - 0.03, seat - 0.04});
    if (k.variant == 2) k.box(k.main, {at - 0.025, -y, 0}, {at + 0.025, -y + 0.04, k.h});
  }
  k.box(k.main, {-x, -y, seat - 0.045}, {x, y, seat});
  if (k.variant == 0) k.box(k.main, {-x + 0.1, -0.02, 0.15}, {x - 0.1, 0.02, 0.2});
  if (k.variant == 2) {
    for (const double z : {0.55, 0.68, 0.81}) {
      if (z + 0.08 <= k.h) k.box(k.main, {-x, -y + 0.01, z}, {x, -y + 0.035, z + 0.08});
    }
  }
}

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
BlockCorners post(const Kit& k, double end) {
  const double x = k.w / 2 - kPost, y = end * (k.d / 2 - kPost);
  return {{x - kPost, y - kPost, 0}, {x + kPost, y + kPost, k.h}};
}

/// A rail between the two posts of the +x side.
BlockCorners rail(const Kit& k, double half, double z0, double z1) {
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

constexpr FurnitureShape kSeats[] = {
    {"chair", kChair, chair, 0, {0.44, 0.46, 0.92}, &Style::wood},
    {"chair", kChair, chair, 1, {0.44, 0.46, 0.86}, &Style::wood},
    {"chair", kChair, chair, 2, {0.47, 0.52, 0.96}, &Style::fabric},
    {"chair", kChair, chair, 3, {0.50, 0.50, 0.80}, &Style::fabric2},
    {"office chair", kChair, office_chair, 0, {0.62, 0.62, 1.02}, &Style::black},
    {"office chair", kChair, office_chair, 1, {0.58, 0.58, 0.88}, &Style::fabric},
    {"armchair", kChair, armchair, 0, {0.86, 0.84, 0.80}, &Style::fabric},
    {"armchair", kChair, armchair, 1, {0.78, 0.80, 1.04}, &Style::fabric},
    {"armchair", kChair, armchair, 2, {0.80, 0.78, 0.76}, &Style::fabric},
    {"patio chair", kChair, patio_chair, 0, {0.56, 0.58, 0.92}, &Style::wood2},
    {"sofa", kSofa, sofa, 0, {2.10, 0.92, 0.82}, &Style::fabric},
    {"sofa", kSofa, sofa, 1, {1.95, 0.82, 0.80}, &Style::fabric},
    {"sofa", kSofa, sofa, 2, {2.05, 0.90, 0.78}, &Style::fabric},
    {"loveseat", kSofa, sofa, 0, {1.50, 0.88, 0.82}, &Style::fabric},
    {"loveseat", kSofa, sofa, 1, {1.40, 0.80, 0.80}, &Style::fabric},
    {"corner sofa", kSofa, corner_sofa, 0, {2.60, 1.70, 0.80}, &Style::fabric, "l shape sofa"},
    {"bar stool", kStool, stool, 0, {0.36, 0.36, 0.68}, &Style::wood, "stool"},
    {"bar stool", kStool, stool, 1, {0.40, 0.40, 0.92}, &Style::fabric2, "stool"},
    {"bar stool", kStool, stool, 2, {0.36, 0.36, 0.66}, &Style::wood, "stool"},
    {"stool", kStool, stool, 0, {0.36, 0.36, 0.45}, &Style::wood},
    {"stool", kStool, stool, 2, {0.34, 0.34, 0.44}, &Style::wood},
    {"ottoman", kStool, ottoman, 0, {0.52, 0.52, 0.42}, &Style::fabric2},
    {"ottoman", kStool, ottoman, 1, {0.66, 0.50, 0.40}, &Style::fabric2},
    {"bench", kSeating, bench, 0, {1.20, 0.36, 0.45}, &Style::wood},
    {"bench", kSeating, bench, 1, {1.15, 0.40, 0.47}, &Style::fabric2},
    {"bench", kSeating, bench, 2, {1.25, 0.45, 0.90}, &Style::wood},
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

std::span<const FurnitureShape> seat_shapes() { return kSeats; }

}  // namespace enfilade::homes::furniture
