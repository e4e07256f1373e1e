#include <array>
#include <cmath>
#include <numbers>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;
using Profile = std::array<double, 2>;

/// Open above and below; the light itself hangs below it, for what is inside casts no light out.
void drum(Kit& k, Vec3d foot, double r0, double r1, double tall) {
  const std::array<Profile, 2> wall{{{r0, 0}, {r1, tall}}};
  k.lathe(k.style.shade, foot, wall, 18);
}

/// A dish of glass, a drum, three globes.
void ceiling_lamp(Kit& k, int variant) {
  const double r = k.w / 2;
  k.spoken(k.style.white);
  if (variant == 0) {
    const std::array<Profile, 5> dish{
        {{0, 0}, {r * 0.6, 0.02}, {r * 0.95, 0.07}, {r, k.h}, {0, k.h}}};
    k.lathe(k.style.glow, {0, 0, 0}, dish, 24);
    k.cylinder(k.style.metal, {0, 0, k.h - 0.02}, r + 0.002, r + 0.002, 0.02, 24);
  } else if (variant == 1) {
    k.spoken(k.style.shade);
    k.cylinder(k.style.shade, {0, 0, 0}, r, r, k.h - 0.03, 22);
    k.cylinder(k.style.metal, {0, 0, k.h - 0.03}, 0.06, 0.06, 0.03, 12);
  } else {
    k.cylinder(k.style.metal, {0, 0, k.h - 0.03}, 0.09, 0.09, 0.03, 14);
    for (int i = 0; i < 3; ++i) {
      const double a = 2 * std::numbers::pi * i / 3, x = r * 0.68 * std::cos(a),
                   y = r * 0.68 * std::sin(a);
      k.bar(k.style.metal, {0, 0, k.h - 0.03}, {x, y, 0.16}, 0.01, 6);
      k.sphere(k.style.glow, {x, y, 0.08}, r * 0.32, 12);
    }
  }
  k.lamp({0, 0, -0.09}, 1);
}

/// Hangs: a metal cone, a globe, a wide drum.
void pendant(Kit& k, int variant) {
  const double r = k.w / 2;
  k.bar(k.style.black, {0, 0, 0.2}, {0, 0, k.h}, 0.006, 4);
  k.cylinder(k.style.metal, {0, 0, k.h - 0.03}, 0.05, 0.05, 0.03, 12);
  if (variant == 0) {
    k.spoken(k.style.metal);
    const std::array<Profile, 4> cone{{{r, 0}, {r * 0.8, 0.06}, {0.05, 0.2}, {0.03, 0.26}}};
    k.lathe(k.style.metal, {0, 0, 0}, cone, 20);
    k.sphere(k.style.glow, {0, 0, 0.06}, 0.05, 10);
  } else if (variant == 1) {
    k.spoken(k.style.glow);
    k.sphere(k.style.glow, {0, 0, r}, r, 16);
  } else {
    k.spoken(k.style.shade);
    drum(k, {0, 0, 0}, r, r * 0.85, 0.24);
    k.sphere(k.style.glow, {0, 0, 0.1}, 0.06, 10);
    k.bar(k.style.metal, {-r * 0.85, 0, 0.23}, {r * 0.85, 0, 0.23}, 0.004, 4);
  }
  k.lamp({0, 0, -0.09}, 1);
}

void chandelier(Kit& k, int variant) {
  const double r = k.w / 2 - 0.06;
  const int arms = variant == 0 ? 6 : 5;
  k.spoken(k.style.metal);
  k.bar(k.style.metal, {0, 0, 0.1}, {0, 0, k.h}, 0.012, 6);
  k.sphere(k.style.metal, {0, 0, 0.1}, 0.06, 10);
  k.cylinder(k.style.metal, {0, 0, k.h - 0.03}, 0.06, 0.06, 0.03, 12);
  for (int i = 0; i < arms; ++i) {
    const double a = 2 * std::numbers::pi * i / arms, c = std::cos(a), s = std::sin(a);
    k.bar(k.style.metal, {0, 0, 0.1}, {0.5 * r * c, 0.5 * r * s, 0.03}, 0.01, 6);
    k.bar(k.style.metal, {0.5 * r * c, 0.5 * r * s, 0.03}, {r * c, r * s, 0.12}, 0.01, 6);
    if (variant == 0) {
      k.cylinder(k.style.white, {r * c, r * s, 0.11}, 0.014, 0.014, 0.08, 6);
      k.sphere(k.style.glow, {r * c, r * s, 0.21}, 0.03, 8);
    } else {
      drum(k, {r * c, r * s, 0.11}, 0.06, 0.035, 0.1);
    }
  }
  k.lamp({0, 0, -0.1}, 1);
}

/// Cans along a rail.
void spots(Kit& k, int variant) {
  const double x = k.w / 2;
  k.spoken(k.style.metal);
  if (variant == 0) {
    k.box(k.style.metal, {-x, -0.02, k.h - 0.03}, {x, 0.02, k.h});
    for (const double at : {-0.75 * x, 0.0, 0.75 * x}) {
      k.cylinder(k.style.metal, {at, 0, 0}, 0.045, 0.035, k.h - 0.03, 12);
      k.cylinder(k.style.glow, {at, 0, -0.004}, 0.04, 0.04, 0.006, 12);
    }
  } else {
    k.box(k.style.white, {-x, -k.d / 2, 0.01}, {x, k.d / 2, k.h});
    k.box(k.style.glow, {-x + 0.02, -k.d / 2 + 0.02, 0}, {x - 0.02, k.d / 2 - 0.02, 0.012});
  }
  k.lamp({0, 0, -0.1}, 1);
}

/// A shade on a pole, on three legs, an arc.
void floor_lamp(Kit& k, int variant) {
  const double r = k.w / 2;
  k.spoken(variant == 1 ? k.style.wood : k.style.metal);
  if (variant == 1) {
    for (int i = 0; i < 3; ++i) {
      const double a = 2 * std::numbers::pi * (i + 0.25) / 3;
      k.bar(k.style.wood, {(r - 0.02) * std::cos(a), (r - 0.02) * std::sin(a), 0.01},
            {0.02 * std::cos(a), 0.02 * std::sin(a), k.h - 0.3}, 0.016, 6);
    }
    drum(k, {0, 0, k.h - 0.32}, r * 0.95, r * 0.85, 0.3);
    k.lamp({0, 0, k.h + 0.08}, 0.9);
  } else if (variant == 0) {
    k.cylinder(k.style.metal, {0, 0, 0}, r * 0.8, r * 0.7, 0.03, 18);
    k.cylinder(k.style.metal, {0, 0, 0.03}, 0.014, 0.014, k.h - 0.3, 8);
    drum(k, {0, 0, k.h - 0.3}, r, r * 0.65, 0.28);
    k.lamp({0, 0, k.h + 0.08}, 0.9);
  } else {
    const double x = k.w / 2;
    k.cylinder(k.style.stone, {-x + 0.14, 0, 0}, 0.14, 0.14, 0.06, 18);
    Vec3d last{-x + 0.14, 0, 0.06};
    for (int i = 1; i <= 8; ++i) {
      const double a = std::numbers::pi * 0.5 * i / 8;
      const Vec3d next{-x + 0.14 + (k.w - 0.3) * (1 - std::cos(a)), 0,
                       0.06 + (k.h - 0.09) * std::sin(a)};
      k.bar(k.style.metal, last, next, 0.013, 6);
      last = next;
    }
    drum(k, {last.x, 0, k.h - 0.26}, 0.15, 0.09, 0.16);
    k.lamp({last.x, 0, k.h - 0.36}, 0.9);
  }
}

/// A ball foot, a slim one, a desk lamp with joints, a block.
void table_lamp(Kit& k, int variant) {
  const double r = k.w / 2;
  const looks::NamedMaterial& foot = variant == 0 ? k.style.accent : k.style.metal;
  k.spoken(foot);
  k.material.clear();
  if (variant == 2) {
    k.cylinder(k.style.black, {0, -r * 0.5, 0}, 0.08, 0.08, 0.02, 14);
    k.bar(k.style.black, {0, -r * 0.5, 0.02}, {0, -r * 0.9, k.h * 0.6}, 0.009, 6);
    k.bar(k.style.black, {0, -r * 0.9, k.h * 0.6}, {0, r * 0.3, k.h - 0.05}, 0.009, 6);
    const std::array<Profile, 3> head{{{0.07, 0}, {0.05, 0.06}, {0, 0.09}}};
    k.lathe(k.style.black, {0, r * 0.4, k.h - 0.1}, head, 12);
    k.cylinder(k.style.glow, {0, r * 0.4, k.h - 0.1}, 0.06, 0.06, 0.004, 12);
    k.lamp({0, r * 0.4, k.h - 0.2}, 0.25);
    return;
  }
  const double neck = k.h * 0.52;
  if (variant == 0) {
    const std::array<Profile, 7> ball{{{0, 0},
                                       {0.06, 0},
                                       {0.05, 0.02},
                                       {0.08, neck * 0.4},
                                       {0.06, neck * 0.75},
                                       {0.02, neck * 0.9},
                                       {0.012, neck + 0.05}}};
    k.lathe(foot, {0, 0, 0}, ball, 14);
  } else if (variant == 1) {
    k.cylinder(foot, {0, 0, 0}, 0.07, 0.06, 0.015, 14);
    k.cylinder(foot, {0, 0, 0.015}, 0.01, 0.01, neck + 0.03, 6);
  } else {
    k.box(k.style.wood, {-0.045, -0.045, 0}, {0.045, 0.045, neck + 0.02});
  }
  drum(k, {0, 0, neck}, r, r * 0.68, k.h - neck);
  k.lamp({0, 0, k.h + 0.07}, 0.45);
}

/// Half shells, candles on a plate.
void sconce(Kit& k, int variant) {
  const double y0 = -k.d / 2;
  k.spoken(k.style.metal);
  k.box(k.style.metal, {-0.04, y0, 0.02}, {0.04, y0 + 0.02, k.h * 0.7});
  k.bar(k.style.metal, {0, y0 + 0.02, 0.06}, {0, 0.02, 0.06}, 0.01, 6);
  if (variant == 0) {
    drum(k, {0, 0.02, 0.06}, 0.05, 0.075, k.h - 0.08);
    k.cylinder(k.style.metal, {0, 0.02, 0.05}, 0.05, 0.05, 0.012, 12);
  } else {
    k.sphere(k.style.glow, {0, 0.02, 0.13}, 0.06, 12);
  }
  k.lamp({0, 0.02, k.h + 0.06}, 0.35);
}

constexpr std::array kShapes{
    Shape{"ceiling lamp", kLighting, ceiling_lamp, 0, {0.42, 0.42, 0.11}},
    Shape{"ceiling lamp", kLighting, ceiling_lamp, 1, {0.46, 0.46, 0.17}},
    Shape{"ceiling lamp", kLighting, ceiling_lamp, 2, {0.50, 0.50, 0.26}},
    Shape{"hanging lamp", kLighting, pendant, 0, {0.36, 0.36, 0.85}, "lamp"},
    Shape{"hanging lamp", kLighting, pendant, 1, {0.30, 0.30, 0.85}, "lamp"},
    Shape{"hanging lamp", kLighting, pendant, 2, {0.48, 0.48, 0.85}, "lamp"},
    Shape{"chandelier", kLighting, chandelier, 0, {0.80, 0.80, 0.75}},
    Shape{"chandelier", kLighting, chandelier, 1, {0.76, 0.76, 0.70}},
    Shape{"spotlight", kLighting, spots, 0, {0.70, 0.10, 0.14}, "light fixture"},
    Shape{"ceiling light", kLighting, spots, 1, {0.90, 0.30, 0.07}},
    Shape{"floor lamp", kLighting, floor_lamp, 0, {0.40, 0.40, 1.55}},
    Shape{"floor lamp", kLighting, floor_lamp, 1, {0.48, 0.48, 1.50}},
    Shape{"floor lamp", kLighting, floor_lamp, 2, {0.95, 0.30, 1.80}},
    Shape{"table lamp", kLighting, table_lamp, 0, {0.28, 0.28, 0.46}},
    Shape{"table lamp", kLighting, table_lamp, 1, {0.26, 0.26, 0.50}},
    Shape{"table lamp", kLighting, table_lamp, 3, {0.24, 0.24, 0.42}},
    Shape{"desk lamp", kLighting, table_lamp, 2, {0.30, 0.30, 0.46}},
    Shape{"wall lamp", kLighting, sconce, 0, {0.16, 0.18, 0.24}},
    Shape{"wall lamp", kLighting, sconce, 1, {0.16, 0.18, 0.22}},
};

}  // namespace

std::span<const Shape> lamp_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
