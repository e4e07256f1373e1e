#include <array>
#include <cmath>
#include <numbers>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

void back_legs(Kit& k, const looks::NamedMaterial& m, double seat, double half) {
  const double x = k.w / 2 - half, y = k.d / 2 - half;
  for (const double s : {-x, x}) {
    k.box(m, {s - half, y - half, 0}, {s + half, y + half, seat});
    k.box(m, {s - half, -y - half, 0}, {s + half, -y + half, k.h});
  }
}

/// Slats, ladder, padded, shell.
void chair(Kit& k, int variant) {
  const looks::NamedMaterial& m = k.style.wood;
  const double seat = 0.46, x = k.w / 2, y = k.d / 2;
  k.spoken(m);
  if (variant == 3) {
    k.spoken(k.style.fabric2);
    k.legs(k.style.metal, seat - 0.03, 0.015, 0.05, true);
    k.soft(k.style.fabric2, {-x, -y + 0.02, seat - 0.04}, {x, y, seat + 0.04}, 0.035);
    for (int i = -2; i <= 2; ++i) {  // a curved back of staves
      const double bend = 0.02 * i * i;
      k.soft(k.style.fabric2, {i * x * 0.39 - x * 0.21, -y + bend, seat - 0.02},
             {i * x * 0.39 + x * 0.21, -y + 0.06 + bend, k.h - 0.012 * i * i}, 0.02);
    }
    return;
  }
  back_legs(k, m, seat - 0.03, 0.02);
  if (variant == 2) {
    k.spoken(k.style.fabric);
    k.soft(k.style.fabric, {-x, -y + 0.04, seat - 0.06}, {x, y, seat + 0.03}, 0.03);
    k.soft(k.style.fabric, {-x + 0.01, -y + 0.005, seat + 0.1}, {x - 0.01, -y + 0.075, k.h}, 0.03);
    return;
  }
  k.box(m, {-x, -y, seat - 0.035}, {x, y, seat});
  k.soft(k.style.fabric2, {-x + 0.04, -y + 0.06, seat}, {x - 0.04, y - 0.03, seat + 0.03}, 0.015);
  k.box(m, {-x + 0.04, -y + 0.005, k.h - 0.09}, {x - 0.04, -y + 0.03, k.h});
  if (variant == 0) {
    for (int i = -2; i <= 2; ++i) {
      const double sx = i * x * 0.36;
      k.box(m, {sx - 0.014, -y + 0.01, seat}, {sx + 0.014, -y + 0.026, k.h - 0.08});
    }
  } else {
    for (const double z : {0.58, 0.70}) {
      k.box(m, {-x + 0.04, -y + 0.008, z}, {x - 0.04, -y + 0.028, z + 0.055});
    }
  }
}

void office_chair(Kit& k, int variant) {
  const looks::NamedMaterial& cloth = variant == 0 ? k.style.black : k.style.fabric;
  k.spoken(cloth);
  const double reach = k.w / 2 - 0.03;
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * std::numbers::pi * i / 5 + 0.3;
    const Vec3d end{reach * std::cos(angle), reach * std::sin(angle), 0.06};
    k.bar(k.style.metal, {0, 0, 0.1}, end, 0.018, 5);
    k.sphere(k.style.black, {end.x, end.y, 0.03}, 0.028, 6);
  }
  k.cylinder(k.style.metal, {0, 0, 0.08}, 0.03, 0.025, 0.36, 8);
  const double x = k.w / 2 - 0.08, y = k.d / 2 - 0.06;
  k.soft(cloth, {-x, -y, 0.44}, {x, y, 0.52}, 0.04);
  k.soft(cloth, {-x + 0.02, -y - 0.05, 0.58}, {x - 0.02, -y + 0.03, k.h}, 0.035);
  k.box(k.style.black, {-0.03, -y - 0.03, 0.46}, {0.03, -y + 0.0, 0.62});
  if (variant == 1) return;
  for (const double s : {-1.0, 1.0}) {
    k.bar(k.style.black, {s * x, 0, 0.47}, {s * (x + 0.03), 0, 0.66}, 0.015, 5);
    k.soft(k.style.black, {s * (x + 0.03) - 0.03, -0.13, 0.66}, {s * (x + 0.03) + 0.03, 0.14, 0.7},
           0.015);
  }
}

/// Boxy, winged, tub.
void armchair(Kit& k, int variant) {
  const looks::NamedMaterial& m = k.style.fabric;
  k.spoken(m);
  const double x = k.w / 2, y = k.d / 2, arm = variant == 1 ? 0.12 : 0.17;
  k.legs(k.style.wood, 0.13, 0.025, 0.03, true);
  if (variant == 2) {
    for (int i = 0; i <= 8; ++i) {  // a rounded wall of upholstery
      const double angle = std::numbers::pi * (1.0 + i / 8.0);
      const double cx = (x - 0.09) * std::cos(angle), cy = (y - 0.09) * std::sin(angle) * 0.95;
      k.soft(m, {cx - 0.09, cy - 0.09, 0.12}, {cx + 0.09, cy + 0.09, k.h - 0.01 * std::abs(i - 4)},
             0.05);
    }
    for (const double s : {-1.0, 1.0}) {
      const double cx = s * (x - 0.09);
      k.soft(m, {cx - 0.09, 0, 0.12}, {cx + 0.09, y - 0.06, k.h - 0.1}, 0.05);
    }
    k.soft(m, {-x + 0.14, -y + 0.14, 0.12}, {x - 0.14, y - 0.02, 0.44}, 0.06);
    return;
  }
  k.soft(m, {-x, -y, 0.12}, {x, y - 0.03, 0.30}, 0.03);
  k.soft(m, {-x + arm, -y + 0.16, 0.29}, {x - arm, y, 0.46}, 0.05);
  k.soft(m, {-x + 0.03, -y, 0.2}, {x - 0.03, -y + 0.2, k.h}, 0.06);
  for (const double s : {-1.0, 1.0}) {
    const double x0 = s < 0 ? -x : x - arm;
    k.soft(m, {x0, -y + 0.05, 0.12}, {x0 + arm, y - 0.02, 0.62}, 0.05);
    if (variant == 1) k.soft(m, {x0, -y + 0.05, 0.55}, {x0 + arm, -y + 0.36, k.h - 0.06}, 0.05);
  }
}

void patio_chair(Kit& k, int) {
  const looks::NamedMaterial& m = k.style.wood2;
  k.spoken(m);
  const double x = k.w / 2, y = k.d / 2;
  back_legs(k, m, 0.62, 0.022);
  for (int i = 0; i < 5; ++i) {
    const double y0 = -y + 0.05 + i * (k.d - 0.06) / 5;
    k.box(m, {-x + 0.04, y0, 0.40}, {x - 0.04, y0 + (k.d - 0.06) / 5 - 0.015, 0.425});
    const double z0 = 0.48 + i * 0.09;
    k.box(m, {-x + 0.04, -y + 0.01, z0}, {x - 0.04, -y + 0.03, z0 + 0.07});
  }
  for (const double s : {-1.0, 1.0}) {
    k.box(m, {s * (x - 0.03) - 0.03, -y + 0.04, 0.60}, {s * (x - 0.03) + 0.03, y, 0.625});
  }
}

void sofa_body(Kit& k, const looks::NamedMaterial& m, double x0, double x1, double arm, double high,
               unsigned seats) {
  const double y = k.d / 2;
  k.soft(m, {x0, -y, 0.12}, {x1, y - 0.03, 0.30}, 0.03);
  k.soft(m, {x0, -y, 0.2}, {x1, -y + 0.2, k.h - 0.05}, 0.05);
  for (const double a : {x0, x1 - arm}) {
    k.soft(m, {a, -y + 0.03, 0.12}, {a + arm, y - 0.02, high}, 0.06);
  }
  const double each = (x1 - x0 - 2 * arm) / seats;
  for (unsigned i = 0; i < seats; ++i) {
    const double c0 = x0 + arm + each * i;
    k.soft(m, {c0 + 0.004, -y + 0.2, 0.29}, {c0 + each - 0.004, y, 0.45}, 0.045);
    k.soft(m, {c0 + 0.01, -y + 0.14, 0.43}, {c0 + each - 0.01, -y + 0.34, k.h}, 0.07);
  }
}

/// Boxy, on turned legs with a frame of wood, corner sofa, chesterfield-like.
void sofa(Kit& k, int variant) {
  const looks::NamedMaterial& m = k.style.fabric;
  k.spoken(m);
  const double x = k.w / 2, y = k.d / 2;
  const auto seats = k.w > 1.9 ? 3U : 2U;
  if (variant == 0) {
    k.box(k.style.black, {-x + 0.05, -y + 0.05, 0}, {x - 0.05, y - 0.08, 0.13});
    sofa_body(k, m, -x, x, 0.2, 0.62, seats);
  } else if (variant == 1) {
    k.legs(k.style.wood, 0.2, 0.025, 0.04, true);
    k.box(k.style.wood, {-x, -y, 0.18}, {x, y - 0.02, 0.24});
    k.soft(m, {-x + 0.02, -y, 0.24}, {x - 0.02, -y + 0.18, k.h}, 0.06);
    k.soft(m, {-x + 0.02, -y + 0.16, 0.24}, {x - 0.02, y, 0.45}, 0.05);
    for (const double s : {-1.0, 1.0}) {
      const double a = s * (x - 0.03);
      k.box(k.style.wood, {a - 0.03, -y + 0.1, 0.56}, {a + 0.03, y - 0.03, 0.60});
      k.box(k.style.wood, {a - 0.02, y - 0.09, 0.2}, {a + 0.02, y - 0.05, 0.57});
    }
  } else {
    k.legs(k.style.wood, 0.13, 0.03, 0.05, true);
    k.soft(m, {-x, -y, 0.12}, {x, y - 0.04, 0.32}, 0.04);
    k.soft(m, {-x + 0.16, -y + 0.2, 0.3}, {x - 0.16, y, 0.46}, 0.06);
    k.soft(m, {-x, -y, 0.25}, {x, -y + 0.22, k.h - 0.05}, 0.05);
    k.bar(m, {-x, -y + 0.12, k.h - 0.1}, {x, -y + 0.12, k.h - 0.1}, 0.1, 10);
    for (const double s : {-1.0, 1.0}) {
      const double a = s * (x - 0.11);
      k.soft(m, {a - 0.1, -y + 0.04, 0.2}, {a + 0.1, y - 0.04, k.h - 0.14}, 0.04);
      k.bar(m, {a, -y + 0.1, k.h - 0.14}, {a, y - 0.02, k.h - 0.14}, 0.11, 10);
    }
  }
}

/// Its long end is at +x.
void corner_sofa(Kit& k, int) {
  const looks::NamedMaterial& m = k.style.fabric;
  k.spoken(m);
  const double x = k.w / 2, y = k.d / 2, deep = 0.92;
  const double front = -y + deep;
  k.soft(m, {-x, -y, 0.06}, {x - 0.8, front - 0.03, 0.30}, 0.03);
  k.soft(m, {-x, -y, 0.2}, {x, -y + 0.2, k.h - 0.05}, 0.05);
  k.soft(m, {-x, -y + 0.03, 0.06}, {-x + 0.2, front - 0.02, 0.6}, 0.06);
  const double each = (k.w - 0.2 - 0.8) / 2;
  for (int i = 0; i < 2; ++i) {
    const double c0 = -x + 0.2 + each * i;
    k.soft(m, {c0 + 0.004, -y + 0.2, 0.29}, {c0 + each - 0.004, front, 0.45}, 0.045);
    k.soft(m, {c0 + 0.01, -y + 0.14, 0.43}, {c0 + each - 0.01, -y + 0.34, k.h}, 0.07);
  }
  k.soft(m, {x - 0.8, -y + 0.14, 0.43}, {x - 0.02, -y + 0.34, k.h}, 0.07);
  k.part();
  k.soft(m, {x - 0.8, -y + 0.1, 0.06}, {x, y - 0.03, 0.30}, 0.03);
  k.soft(m, {x - 0.8, -y + 0.2, 0.29}, {x, y, 0.45}, 0.045);
}

/// Bar stools: plain, with a back, of three legs.
void stool(Kit& k, int variant) {
  const double x = k.w / 2;
  k.spoken(variant == 1 ? k.style.fabric2 : k.style.wood);
  if (variant == 1) {
    k.cylinder(k.style.metal, {0, 0, 0}, x, x, 0.025, 16);
    k.cylinder(k.style.metal, {0, 0, 0.02}, 0.025, 0.025, k.h - 0.3, 8);
    k.cylinder(k.style.fabric2, {0, 0, k.h - 0.31}, x * 0.95, x, 0.08, 16);
    k.soft(k.style.fabric2, {-x * 0.8, -x, k.h - 0.2}, {x * 0.8, -x + 0.05, k.h}, 0.02);
    k.box(k.style.metal, {-0.02, -x, k.h - 0.3}, {0.02, -x + 0.02, k.h - 0.15});
    return;
  }
  const int legs = variant == 0 ? 4 : 3;
  for (int i = 0; i < legs; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / legs, r = x - 0.02;
    k.bar(k.style.wood, {r * std::cos(angle), r * std::sin(angle), 0.012},
          {0.6 * r * std::cos(angle), 0.6 * r * std::sin(angle), k.h - 0.04}, 0.016, 6);
  }
  k.cylinder(k.style.wood, {0, 0, k.h - 0.05}, x * 0.92, x, 0.05, 16);
  k.cylinder(k.style.metal, {0, 0, k.h * 0.35}, x * 0.75, x * 0.75, 0.015, 16);
}

/// Ottomans: a drum, a block on legs.
void ottoman(Kit& k, int variant) {
  k.spoken(k.style.fabric2);
  const double x = k.w / 2, y = k.d / 2;
  if (variant == 0) {
    k.cylinder(k.style.wood, {0, 0, 0}, x * 0.9, x * 0.9, 0.04, 18);
    const std::array<std::array<double, 2>, 6> drum{
        {{0, 0.04}, {x * 0.96, 0.05}, {x, 0.1}, {x, k.h - 0.06}, {x * 0.93, k.h - 0.01}, {0, k.h}}};
    k.lathe(k.style.fabric2, {0, 0, 0}, drum, 18);
  } else {
    k.legs(k.style.wood, 0.14, 0.02, 0.03, true);
    k.soft(k.style.fabric2, {-x, -y, 0.13}, {x, y, k.h}, 0.05);
  }
}

/// Planks on trestles, padded, with a back.
void bench(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2, seat = variant == 2 ? 0.45 : k.h;
  k.spoken(variant == 1 ? k.style.fabric2 : k.style.wood);
  if (variant == 1) {
    k.legs(k.style.metal, seat - 0.1, 0.018, 0.03);
    k.soft(k.style.fabric2, {-x, -y, seat - 0.11}, {x, y, seat}, 0.04);
    return;
  }
  for (const double s : {-1.0, 1.0}) {
    const double at = s * (x - 0.12);
    k.box(k.style.wood, {at - 0.025, -y + 0.03, 0}, {at + 0.025, y - 0.03, seat - 0.04});
    if (variant == 2) k.box(k.style.wood, {at - 0.025, -y, 0}, {at + 0.025, -y + 0.04, k.h});
  }
  k.box(k.style.wood, {-x, -y, seat - 0.045}, {x, y, seat});
  if (variant == 0) k.box(k.style.wood, {-x + 0.1, -0.02, 0.15}, {x - 0.1, 0.02, 0.2});
  if (variant == 2) {
    for (const double z : {0.55, 0.68, 0.81}) {
      if (z + 0.08 <= k.h) k.box(k.style.wood, {-x, -y + 0.01, z}, {x, -y + 0.035, z + 0.08});
    }
  }
}

constexpr std::array kShapes{
    Shape{"chair", kChair, chair, 0, {0.44, 0.46, 0.92}},
    Shape{"chair", kChair, chair, 1, {0.44, 0.46, 0.86}},
    Shape{"chair", kChair, chair, 2, {0.47, 0.52, 0.96}},
    Shape{"chair", kChair, chair, 3, {0.50, 0.50, 0.80}},
    Shape{"office chair", kChair, office_chair, 0, {0.62, 0.62, 1.02}},
    Shape{"office chair", kChair, office_chair, 1, {0.58, 0.58, 0.88}},
    Shape{"armchair", kChair, armchair, 0, {0.86, 0.84, 0.80}},
    Shape{"armchair", kChair, armchair, 1, {0.78, 0.80, 1.04}},
    Shape{"armchair", kChair, armchair, 2, {0.80, 0.78, 0.76}},
    Shape{"patio chair", kChair, patio_chair, 0, {0.56, 0.58, 0.92}},
    Shape{"sofa", kSofa, sofa, 0, {2.10, 0.92, 0.82}},
    Shape{"sofa", kSofa, sofa, 1, {1.95, 0.82, 0.80}},
    Shape{"sofa", kSofa, sofa, 2, {2.05, 0.90, 0.78}},
    Shape{"loveseat", kSofa, sofa, 0, {1.50, 0.88, 0.82}},
    Shape{"loveseat", kSofa, sofa, 1, {1.40, 0.80, 0.80}},
    Shape{"corner sofa", kSofa, corner_sofa, 0, {2.60, 1.70, 0.80}, "l shape sofa"},
    Shape{"bar stool", kStool, stool, 0, {0.36, 0.36, 0.68}, "stool"},
    Shape{"bar stool", kStool, stool, 1, {0.40, 0.40, 0.92}, "stool"},
    Shape{"bar stool", kStool, stool, 2, {0.36, 0.36, 0.66}, "stool"},
    Shape{"stool", kStool, stool, 0, {0.36, 0.36, 0.45}},
    Shape{"stool", kStool, stool, 2, {0.34, 0.34, 0.44}},
    Shape{"ottoman", kStool, ottoman, 0, {0.52, 0.52, 0.42}},
    Shape{"ottoman", kStool, ottoman, 1, {0.66, 0.50, 0.40}},
    Shape{"bench", kSeating, bench, 0, {1.20, 0.36, 0.45}},
    Shape{"bench", kSeating, bench, 1, {1.15, 0.40, 0.47}},
    Shape{"bench", kSeating, bench, 2, {1.25, 0.45, 0.90}},
};

}  // namespace

std::span<const Shape> seat_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
