#include <cmath>
#include <numbers>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

/// Open above and below; the light itself hangs below it, for what is inside casts no light out.
void drum(Kit& k, Vec3d foot, double r0, double r1, double tall) {
  k.lathe(k.style.shade, foot, 18, 1, Ring{r0, 0}, Ring{r1, tall});
}

/// A dish of glass, a drum, three globes.
void ceiling_lamp(Kit& k, double r, double) {
  if (k.variant == 0) {
    k.lathe(k.style.glow, {0, 0, 0}, 24, 1, Ring{0, 0}, Ring{r * 0.6, 0.02}, Ring{r * 0.95, 0.07},
            Ring{r, k.h}, Ring{0, k.h});
    k.cylinder(k.style.metal, {0, 0, k.h - 0.02}, r + 0.002, r + 0.002, 0.02, 24);
  } else if (k.variant == 1) {
    k.cylinder(k.main, {0, 0, 0}, r, r, k.h - 0.03, 22);
    k.cylinder(k.style.metal, {0, 0, k.h - 0.03}, 0.06, 0.06, 0.03, 12);
  } else {
    k.cylinder(k.style.metal, {0, 0, k.h - 0.03}, 0.09, 0.09, 0.03, 14);
    for (int i = 0; i < 3; ++i) {
      const double a = 2 * std::numbers::pi * i / 3;
      const double x = r * 0.68 * std::cos(a), y = r * 0.68 * std::sin(a);
      k.bar(k.style.metal, {0, 0, k.h - 0.03}, {x, y, 0.16}, 0.01, 6);
      k.sphere(k.style.glow, {x, y, 0.08}, r * 0.32, 12);
    }
  }
  k.lamp({0, 0, -0.09}, 1);
}

/// Hangs: a metal cone, a globe, a wide drum.
void pendant(Kit& k, double r, double) {
  k.bar(k.style.black, {0, 0, 0.2}, {0, 0, k.h}, 0.006, 4);
  k.cylinder(k.style.metal, {0, 0, k.h - 0.03}, 0.05, 0.05, 0.03, 12);
  if (k.variant == 0) {
    k.lathe(k.main, {0, 0, 0}, 20, 1, Ring{r, 0}, Ring{r * 0.8, 0.06}, Ring{0.05, 0.2},
            Ring{0.03, 0.26});
    k.sphere(k.style.glow, {0, 0, 0.06}, 0.05, 10);
  } else if (k.variant == 1) {
    k.sphere(k.main, {0, 0, r}, r, 16);
  } else {
    drum(k, {0, 0, 0}, r, r * 0.85, 0.24);
    k.sphere(k.style.glow, {0, 0, 0.1}, 0.06, 10);
    k.bar(k.style.metal, {-r * 0.85, 0, 0.23}, {r * 0.85, 0, 0.23}, 0.004, 4);
  }
  k.lamp({0, 0, -0.09}, 1);
}

void chandelier(Kit& k, double, double) {
  const double r = k.w / 2 - 0.06;
  const int arms = k.variant == 0 ? 6 : 5;
  k.bar(k.main, {0, 0, 0.1}, {0, 0, k.h}, 0.012, 6);
  k.sphere(k.main, {0, 0, 0.1}, 0.06, 10);
  k.cylinder(k.main, {0, 0, k.h - 0.03}, 0.06, 0.06, 0.03, 12);
  for (int i = 0; i < arms; ++i) {
    const double a = 2 * std::numbers::pi * i / arms, c = std::cos(a), s = std::sin(a);
    k.bar(k.main, {0, 0, 0.1}, {0.5 * r * c, 0.5 * r * s, 0.03}, 0.01, 6);
    k.bar(k.main, {0.5 * r * c, 0.5 * r * s, 0.03}, {r * c, r * s, 0.12}, 0.01, 6);
    if (k.variant == 0) {
      k.cylinder(k.style.white, {r * c, r * s, 0.11}, 0.014, 0.014, 0.08, 6);
      k.sphere(k.style.glow, {r * c, r * s, 0.21}, 0.03, 8);
    } else {
      drum(k, {r * c, r * s, 0.11}, 0.06, 0.035, 0.1);
    }
  }
  k.lamp({0, 0, -0.1}, 1);
}

/// Cans along a rail, a flat panel.
void spots(Kit& k, double x, double y) {
  if (k.variant == 0) {
    k.box(k.main, {-x, -0.02, k.h - 0.03}, {x, 0.02, k.h});
    for (const double at : {-0.75 * x, 0.0, 0.75 * x}) {
      k.cylinder(k.main, {at, 0, 0}, 0.045, 0.035, k.h - 0.03, 12);
      k.cylinder(k.style.glow, {at, 0, -0.004}, 0.04, 0.04, 0.006, 12);
    }
  } else {
    k.box(k.style.white, {-x, -y, 0.01}, {x, y, k.h});
    k.box(k.style.glow, {-x + 0.02, -y + 0.02, 0}, {x - 0.02, y - 0.02, 0.012});
  }
  k.lamp({0, 0, -0.1}, 1);
}

/// A shade on a pole, on three legs, an arc.
void floor_lamp(Kit& k, double r, double) {
  if (k.variant == 1) {
    k.splayed_legs(k.main, 3, 0.25, {{{r - 0.02, 0.01}, {0.02, k.h - 0.3}}}, 0.016);
    drum(k, {0, 0, k.h - 0.32}, r * 0.95, r * 0.85, 0.3);
    k.lamp({0, 0, k.h + 0.08}, 0.9);
  } else if (k.variant == 0) {
    k.cylinder(k.style.metal, {0, 0, 0}, r * 0.8, r * 0.7, 0.03, 18);
    k.cylinder(k.style.metal, {0, 0, 0.03}, 0.014, 0.014, k.h - 0.3, 8);
    drum(k, {0, 0, k.h - 0.3}, r, r * 0.65, 0.28);
    k.lamp({0, 0, k.h + 0.08}, 0.9);
  } else {
    const double foot = -r + 0.14;
    k.cylinder(k.style.stone, {foot, 0, 0}, 0.14, 0.14, 0.06, 18);
    Vec3d last{foot, 0, 0.06};
    for (int i = 1; i <= 8; ++i) {
      const double a = std::numbers::pi * 0.5 * i / 8, reach = (k.w - 0.3) * (1 - std::cos(a));
      const Vec3d next{foot + reach, 0, 0.06 + (k.h - 0.09) * std::sin(a)};
      k.bar(k.style.metal, last, next, 0.013, 6);
      last = next;
    }
    drum(k, {last.x, 0, k.h - 0.26}, 0.15, 0.09, 0.16);
    k.lamp({last.x, 0, k.h - 0.36}, 0.9);
  }
}

/// On a ball, on a slim foot, a desk lamp with joints, on a block.
void table_lamp(Kit& k, double r, double) {
  k.material.clear();
  if (k.variant == 2) {
    k.cylinder(k.style.black, {0, -r * 0.5, 0}, 0.08, 0.08, 0.02, 14);
    k.bar(k.style.black, {0, -r * 0.5, 0.02}, {0, -r * 0.9, k.h * 0.6}, 0.009, 6);
    k.bar(k.style.black, {0, -r * 0.9, k.h * 0.6}, {0, r * 0.3, k.h - 0.05}, 0.009, 6);
    k.lathe(k.style.black, {0, r * 0.4, k.h - 0.1}, 12, 1, Ring{0.07, 0}, Ring{0.05, 0.06},
            Ring{0, 0.09});
    k.cylinder(k.style.glow, {0, r * 0.4, k.h - 0.1}, 0.06, 0.06, 0.004, 12);
    k.lamp({0, r * 0.4, k.h - 0.2}, 0.25);
    return;
  }
  const double neck = k.h * 0.52;
  if (k.variant == 0) {
    k.lathe(k.main, {0, 0, 0}, 14, 1, Ring{0, 0}, Ring{0.06, 0}, Ring{0.05, 0.02},
            Ring{0.08, neck * 0.4}, Ring{0.06, neck * 0.75}, Ring{0.02, neck * 0.9},
            Ring{0.012, neck + 0.05});
  } else if (k.variant == 1) {
    k.cylinder(k.main, {0, 0, 0}, 0.07, 0.06, 0.015, 14);
    k.cylinder(k.main, {0, 0, 0.015}, 0.01, 0.01, neck + 0.03, 6);
  } else {
    k.box(k.style.wood, {-0.045, -0.045, 0}, {0.045, 0.045, neck + 0.02});
  }
  drum(k, {0, 0, neck}, r, r * 0.68, k.h - neck);
  k.lamp({0, 0, k.h + 0.07}, 0.45);
}

/// A small shade, a globe.
void sconce(Kit& k, double, double y) {
  k.box(k.main, {-0.04, -y, 0.02}, {0.04, -y + 0.02, k.h * 0.7});
  k.bar(k.main, {0, -y + 0.02, 0.06}, {0, 0.02, 0.06}, 0.01, 6);
  if (k.variant == 0) {
    drum(k, {0, 0.02, 0.06}, 0.05, 0.075, k.h - 0.08);
    k.cylinder(k.main, {0, 0.02, 0.05}, 0.05, 0.05, 0.012, 12);
  } else {
    k.sphere(k.style.glow, {0, 0.02, 0.13}, 0.06, 12);
  }
  k.lamp({0, 0.02, k.h + 0.06}, 0.35);
}

constexpr Shape kShapes[] = {
    {"ceiling lamp", kLighting, ceiling_lamp, 0, {0.42, 0.42, 0.11}, &Style::white},
    {"ceiling lamp", kLighting, ceiling_lamp, 1, {0.46, 0.46, 0.17}, &Style::shade},
    {"ceiling lamp", kLighting, ceiling_lamp, 2, {0.50, 0.50, 0.26}, &Style::white},
    {"hanging lamp", kLighting, pendant, 0, {0.36, 0.36, 0.85}, &Style::metal, "lamp"},
    {"hanging lamp", kLighting, pendant, 1, {0.30, 0.30, 0.85}, &Style::glow, "lamp"},
    {"hanging lamp", kLighting, pendant, 2, {0.48, 0.48, 0.85}, &Style::shade, "lamp"},
    {"chandelier", kLighting, chandelier, 0, {0.80, 0.80, 0.75}, &Style::metal},
    {"chandelier", kLighting, chandelier, 1, {0.76, 0.76, 0.70}, &Style::metal},
    {"spotlight", kLighting, spots, 0, {0.70, 0.10, 0.14}, &Style::metal, "light fixture"},
    {"ceiling light", kLighting, spots, 1, {0.90, 0.30, 0.07}, &Style::metal},
    {"floor lamp", kLighting, floor_lamp, 0, {0.40, 0.40, 1.55}, &Style::metal},
    {"floor lamp", kLighting, floor_lamp, 1, {0.48, 0.48, 1.50}, &Style::wood},
    {"floor lamp", kLighting, floor_lamp, 2, {0.95, 0.30, 1.80}, &Style::metal},
    {"table lamp", kLighting, table_lamp, 0, {0.28, 0.28, 0.46}, &Style::accent},
    {"table lamp", kLighting, table_lamp, 1, {0.26, 0.26, 0.50}, &Style::metal},
    {"table lamp", kLighting, table_lamp, 3, {0.24, 0.24, 0.42}, &Style::metal},
    {"desk lamp", kLighting, table_lamp, 2, {0.30, 0.30, 0.46}, &Style::metal},
    {"wall lamp", kLighting, sconce, 0, {0.16, 0.18, 0.24}, &Style::metal},
    {"wall lamp", kLighting, sconce, 1, {0.16, 0.18, 0.22}, &Style::metal},
};

}  // namespace

std::span<const Shape> lamp_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
