#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

const NamedMaterial& painting(Kit& k) {
  // This room's own come first.
  const std::size_t n = std::min<std::size_t>(k.style.pictures.size(), 4);
  return k.style.pictures[k.rng.below(n)];
}

void frame(Kit& k, const NamedMaterial& m, double wide, double deep) {
  const double x = k.w / 2, y0 = -k.d / 2;
  k.box(m, {-x, y0, 0}, {x, y0 + deep, wide});
  k.box(m, {-x, y0, k.h - wide}, {x, y0 + deep, k.h});
  k.pairs(m, {{{x - wide, y0, wide}, {x, y0 + deep, k.h - wide}}});
}

/// In a wooden frame, on a wide white mat, bare canvas, a poster, a gilded frame.
void picture(Kit& k, double x, double y) {
  constexpr std::array kBorder{0.04, 0.1, 0.0, 0.015, 0.07};
  const double border = kBorder[static_cast<std::size_t>(k.variant)];
  const bool canvas = k.variant == 2, poster = k.variant == 3;
  const double face = -y + (canvas ? k.d : poster ? 0.006 : 0.014);
  if (k.variant == 1) {
    frame(k, k.style.black, 0.02, k.d);
    k.box(k.style.white, {-x + 0.02, -y, 0.02}, {x - 0.02, -y + 0.012, k.h - 0.02});
  } else if (canvas || poster) {
    k.box(k.style.white, {-x, -y, 0}, {x, face - (canvas ? 0.001 : 0.002), k.h});
  } else {
    frame(k, k.variant == 4 ? k.style.metal : k.style.wood, border, k.d);
  }
  k.quad(painting(k), {x - border, face, border}, {-x + border, face, border},
         {-x + border, face, k.h - border}, {x - border, face, k.h - border});
}

void round_mirror(Kit& k, double x, double y) {
  k.material.clear();
  constexpr int kPieces = 28;
  const double in = x - 0.02, glass = -y + 0.014, front = -y + 0.02;
  const auto at = [&](int i, double r, double depth) {
    const double angle = 2 * std::numbers::pi * i / kPieces;
    return Vec3d{r * std::cos(angle), depth, k.h / 2 + r * std::sin(angle)};
  };
  for (int a = 0; a < kPieces; ++a) {
    const int b = a + 1;
    const Vec3d middle{0, glass, k.h / 2};
    k.quad(k.style.mirror, middle, middle, at(b, in, glass), at(a, in, glass));
    k.quad(k.main, at(a, in, front), at(b, in, front), at(b, x, front), at(a, x, front));
    k.quad(k.main, at(a, x, front), at(b, x, front), at(b, x, -y), at(a, x, -y));
  }
}

void standing_mirror(Kit& k, double x, double y) {
  const double glass = -y + 0.10;
  for (const double s : {-x + 0.03, x - 0.03}) {
    k.box(k.main, {s - 0.03, glass - 0.02, 0}, {s + 0.03, glass + 0.02, k.h});
    k.bar(k.main, {s, glass, k.h * 0.6}, {s, y - 0.02, 0.015}, 0.015, 6);
  }
  k.box(k.main, {-x, glass - 0.02, k.h - 0.05}, {x, glass + 0.02, k.h});
  k.box(k.main, {-x, glass - 0.02, 0.08}, {x, glass + 0.02, 0.13});
  k.box(k.style.mirror, {-x + 0.05, glass - 0.01, 0.12}, {x - 0.05, glass + 0.012, k.h - 0.04});
}

/// In a thin frame, in a wide one.
void mirror(Kit& k, double x, double y) {
  const double edge = k.variant == 0 ? 0.025 : 0.06;
  frame(k, k.main, edge, k.d);
  k.box(k.style.mirror, {-x + edge, -y, edge}, {x - edge, -y + 0.012, k.h - edge});
}

/// On a foot, flat on the wall, a computer's.
void tv(Kit& k, double x, double y) {
  const double front = k.variant == 1 ? y : 0.02;
  const double low = k.variant == 1 ? 0 : (k.variant == 0 ? 0.07 : 0.12);
  k.box(k.main, {-x, front - 0.04, low}, {x, front - 0.006, k.h});
  k.box(k.style.screen, {-x + 0.012, front - 0.006, low + 0.02}, {x - 0.012, front, k.h - 0.012});
  if (k.variant == 0) {
    const double at = x * 0.6;
    k.pairs(k.main, {{{at - 0.015, -y, 0}, {at + 0.015, y, 0.015}},
                     {{at - 0.012, -0.02, 0.015}, {at + 0.012, 0.0, 0.08}}});
  } else if (k.variant == 2) {
    k.box(k.style.metal, {-0.12, -y, 0}, {0.12, y, 0.015});
    k.box(k.style.metal, {-0.025, -0.05, 0.015}, {0.025, -0.02, 0.3});
  }
}

void flip_chart(Kit& k, double x, double y) {
  const double face = 0.02, ink = face + 0.02;
  for (const double s : {-x + 0.03, x - 0.03}) {
    k.bar(k.style.metal, {s, y - 0.02, 0}, {s * 0.6, face - 0.02, k.h - 0.02}, 0.015, 6);
  }
  k.bar(k.style.metal, {0, -y + 0.02, 0}, {0, face - 0.03, k.h - 0.03}, 0.015, 6);
  k.box(k.main, {-x + 0.02, face, 0.85}, {x - 0.02, face + 0.02, k.h});
  k.box(k.style.paints[0], {-x * 0.6, ink, k.h - 0.3}, {x * 0.2, face + 0.022, k.h - 0.26});
  k.box(k.style.paints[1], {-x * 0.6, ink, k.h - 0.5}, {x * 0.5, face + 0.022, k.h - 0.47});
}

/// White with writing, cork with notes.
void board(Kit& k, double x, double y) {
  const bool note = k.variant == 1;
  if (note) k.colour = "brown";
  frame(k, note ? k.style.wood : k.style.metal, 0.025, k.d);
  const NamedMaterial& face = note ? k.style.pot : k.style.white;
  k.box(face, {-x + 0.02, -y, 0.02}, {x - 0.02, -y + 0.01, k.h - 0.02});
  const std::size_t marks = note ? 10 : 6;
  for (std::size_t i = 0; i < marks; ++i) {
    const double cx = (k.rng.uniform() - 0.5) * (k.w - 0.4);
    const double cz = 0.15 + k.rng.uniform() * (k.h - 0.35);
    const double wide = note ? 0.09 : 0.15 + 0.2 * k.rng.uniform(), tall = note ? 0.11 : 0.012;
    const NamedMaterial& m = note && i % 2 == 0 ? k.style.white : k.style.paints[i % 4];
    const double x0 = std::max(-x + 0.03, cx - wide / 2);
    k.box(m, {x0, -y + 0.01, cz}, {std::min(x - 0.03, x0 + wide), -y + 0.012, cz + tall});
  }
}

/// Cloth in folds, hanging from x0 to x1, z0 to z1.
void folds(Kit& k, double x0, double x1, double z0, double z1) {
  const int n = std::max(3, static_cast<int>((x1 - x0) / 0.07)) * 2;
  const double deep = k.d * 0.32, step = (x1 - x0) / n;
  const auto y = [&](int i) { return i % 2 == 0 ? -deep : deep; };
  for (int i = 0; i < n; ++i) {
    const double a = x0 + step * i, b = a + step;
    k.quad(k.main, {b, y(i + 1), z0}, {a, y(i), z0}, {a, y(i), z1}, {b, y(i + 1), z1});
  }
}

/// To the floor on both sides, on one side, on both sides below a valance.
void curtain(Kit& k, double x, double) {
  const double rail = k.h - 0.03;
  k.bar(k.style.metal, {-x, 0, rail}, {x, 0, rail}, 0.014, 6);
  for (const double s : {-x + 0.01, x - 0.01}) k.sphere(k.style.metal, {s, 0, rail}, 0.025, 6);
  const double side = std::max(0.16, k.w * 0.14);
  k.part();
  folds(k, -x + 0.03, -x + 0.03 + (k.variant == 1 ? 1.5 * side : side), 0.02, rail);
  k.part();
  if (k.variant != 1) folds(k, x - 0.03 - side, x - 0.03, 0.02, rail);
  if (k.variant == 2) {
    k.part();
    folds(k, -x + 0.03 + side, x - 0.03 - side, rail - 0.3, rail);
  }
}

/// Slats, a roll half way down, folded cloth.
void blinds(Kit& k, double x, double y) {
  if (k.variant == 0) {
    k.box(k.main, {-x, -y, k.h - 0.05}, {x, y, k.h});
    for (double z = 0.02; z < k.h - 0.07; z += 0.05) {
      k.box(k.main, {-x + 0.01, -y, z}, {x - 0.01, y, z + 0.006});
    }
  } else if (k.variant == 1) {
    k.bar(k.style.metal, {-x, 0, k.h - 0.025}, {x, 0, k.h - 0.025}, 0.022, 8);
    k.box(k.main, {-x + 0.01, -0.002, 0.02}, {x - 0.01, 0.002, k.h - 0.03});
    k.box(k.main, {-x + 0.01, -0.01, 0}, {x - 0.01, 0.01, 0.02});
  } else {
    constexpr int kFolds = 4;
    for (int i = 0; i < kFolds; ++i) {
      const double z = k.h * i / kFolds, front = y - 0.012 * i / kFolds;
      k.soft(k.main, {-x, -y, z}, {x, front, z + k.h / kFolds * 0.98}, 0.015);
    }
  }
}

void clock(Kit& k, double r, double y) {
  k.bar(k.main, {0, -y, r}, {0, -y + 0.03, r}, r, 22);
  k.bar(k.style.white, {0, -y + 0.03, r}, {0, -y + 0.034, r}, r * 0.88, 22);
  k.bar(k.style.black, {0, -y + 0.038, r}, {0.05 * r, -y + 0.038, r * 1.6}, 0.006, 4);
  k.bar(k.style.black, {0, -y + 0.038, r}, {0.5 * r, -y + 0.038, r * 1.1}, 0.006, 4);
}

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

constexpr FurnitureShape kOnWalls[] = {
    {"picture", kPicture, picture, 0, {0.80, 0.03, 0.60}, nullptr},
    {"picture", kPicture, picture, 1, {0.62, 0.03, 0.50}, nullptr},
    {"picture", kPicture, picture, 3, {0.70, 0.015, 0.95}, nullptr, "poster"},
    {"painting", kPicture, picture, 2, {1.00, 0.04, 0.72}, nullptr},
    {"painting", kPicture, picture, 4, {0.95, 0.05, 0.74}, nullptr},
    {"mirror", kMirror, mirror, 0, {0.65, 0.03, 0.90}, &Style::metal},
    {"mirror", kMirror, round_mirror, 0, {0.70, 0.03, 0.70}, &Style::metal},
    {"mirror", kMirror, mirror, 1, {0.70, 0.04, 0.95}, &Style::wood},
    {"standing mirror", kMirror, standing_mirror, 0, {0.52, 0.40, 1.65}, &Style::wood, "mirror"},
    {"tv", kTvMonitor, tv, 0, {1.15, 0.22, 0.74}, &Style::black},
    {"wall tv", kTvMonitor, tv, 1, {1.25, 0.06, 0.72}, &Style::black, "tv"},
    {"monitor", kTvMonitor, tv, 2, {0.56, 0.20, 0.46}, &Style::black},
    {"whiteboard", kBoardPanel, board, 0, {1.60, 0.03, 1.00}, &Style::white, "board"},
    {"notice board", kBoardPanel, board, 1, {1.10, 0.03, 0.80}, nullptr, "board"},
    {"flip chart", kBoardPanel, flip_chart, 0, {0.72, 0.60, 1.75}, &Style::white, "board"},
    {"curtain", kCurtain, curtain, 0, {1.80, 0.12, 2.30}, &Style::accent},
    {"curtain", kCurtain, curtain, 1, {1.80, 0.12, 2.30}, &Style::accent},
    {"curtain", kCurtain, curtain, 2, {1.80, 0.12, 2.30}, &Style::accent},
    {"blinds", kBlinds, blinds, 0, {1.20, 0.05, 0.55}, &Style::white},
    {"blinds", kBlinds, blinds, 1, {1.20, 0.05, 0.50}, &Style::linen},
    {"blinds", kBlinds, blinds, 2, {1.20, 0.06, 0.45}, &Style::accent},
    {"clock", 39, clock, 0, {0.32, 0.045, 0.32}, &Style::black},
    {"clock", 39, clock, 1, {0.38, 0.045, 0.38}, &Style::wood},
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

std::span<const FurnitureShape> wall_shapes() { return kOnWalls; }

}  // namespace enfilade::homes::furniture
