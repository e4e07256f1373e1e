#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

const looks::NamedMaterial& painting(Kit& k) {
  // This room's own come first.
  const std::size_t n = std::min<std::size_t>(k.style.pictures.size(), 4);
  return k.style.pictures[k.rng.below(n)];
}

void frame(Kit& k, const looks::NamedMaterial& m, double wide, double deep) {
  const double x = k.w / 2, y0 = -k.d / 2;
  k.box(m, {-x, y0, 0}, {x, y0 + deep, wide});
  k.box(m, {-x, y0, k.h - wide}, {x, y0 + deep, k.h});
  k.box(m, {-x, y0, wide}, {-x + wide, y0 + deep, k.h - wide});
  k.box(m, {x - wide, y0, wide}, {x, y0 + deep, k.h - wide});
}

/// In a wooden frame, on a wide white mat, bare canvas, a poster, a gilded frame.
void picture(Kit& k, int variant) {
  const double x = k.w / 2, y0 = -k.d / 2;
  const double border = std::array{0.04, 0.1, 0.0, 0.015, 0.07}[static_cast<std::size_t>(variant)];
  const double face = y0 + (variant == 2 ? k.d : variant == 3 ? 0.006 : 0.014);
  if (variant == 1) {
    frame(k, k.style.black, 0.02, k.d);
    k.box(k.style.white, {-x + 0.02, y0, 0.02}, {x - 0.02, y0 + 0.012, k.h - 0.02});
  } else if (variant == 2) {
    k.box(k.style.white, {-x, y0, 0}, {x, face - 0.001, k.h});
  } else if (variant == 3) {
    k.box(k.style.white, {-x, y0, 0}, {x, face - 0.002, k.h});
  } else {
    frame(k, variant == 4 ? k.style.metal : k.style.wood, border, k.d);
  }
  k.quad(painting(k), {x - border, face, border}, {-x + border, face, border},
         {-x + border, face, k.h - border}, {x - border, face, k.h - border});
}

/// A thin frame, round, arched, on the floor.
void mirror(Kit& k, int variant) {
  const double x = k.w / 2, y0 = -k.d / 2;
  k.spoken(k.style.metal);
  k.material.clear();
  if (variant == 1) {
    for (int i = 0; i < 28; ++i) {
      const double a = 2 * std::numbers::pi * i / 28, b = 2 * std::numbers::pi * (i + 1) / 28;
      const auto at = [&](double r, double angle, double y) {
        return Vec3d{r * std::cos(angle), y, k.h / 2 + r * std::sin(angle)};
      };
      k.quad(k.style.mirror, {0, y0 + 0.014, k.h / 2}, {0, y0 + 0.014, k.h / 2},
             at(x - 0.02, b, y0 + 0.014), at(x - 0.02, a, y0 + 0.014));
      k.quad(k.style.metal, at(x - 0.02, a, y0 + 0.02), at(x - 0.02, b, y0 + 0.02),
             at(x, b, y0 + 0.02), at(x, a, y0 + 0.02));
      k.quad(k.style.metal, at(x, a, y0 + 0.02), at(x, b, y0 + 0.02), at(x, b, y0), at(x, a, y0));
    }
    return;
  }
  if (variant == 3) {
    k.spoken(k.style.wood);
    const auto glass = y0 + 0.10;
    for (const double s : {-x + 0.03, x - 0.03}) {
      k.box(k.style.wood, {s - 0.03, glass - 0.02, 0}, {s + 0.03, glass + 0.02, k.h});
      k.bar(k.style.wood, {s, glass, k.h * 0.6}, {s, -y0 - 0.02, 0.015}, 0.015, 6);
    }
    k.box(k.style.wood, {-x, glass - 0.02, k.h - 0.05}, {x, glass + 0.02, k.h});
    k.box(k.style.wood, {-x, glass - 0.02, 0.08}, {x, glass + 0.02, 0.13});
    k.box(k.style.mirror, {-x + 0.05, glass - 0.01, 0.12}, {x - 0.05, glass + 0.012, k.h - 0.04});
    return;
  }
  const double edge = variant == 0 ? 0.025 : 0.06;
  const looks::NamedMaterial& m = variant == 0 ? k.style.metal : k.style.wood;
  k.spoken(m);
  frame(k, m, edge, k.d);
  k.box(k.style.mirror, {-x + edge, y0, edge}, {x - edge, y0 + 0.012, k.h - edge});
}

/// On a foot, flat on the wall, a computer's.
void tv(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  k.colour = "black";
  const double front = variant == 1 ? y : 0.02,
               low = variant == 1 ? 0 : (variant == 0 ? 0.07 : 0.12);
  k.box(k.style.black, {-x, front - 0.04, low}, {x, front - 0.006, k.h});
  k.box(k.style.screen, {-x + 0.012, front - 0.006, low + 0.02}, {x - 0.012, front, k.h - 0.012});
  if (variant == 0) {
    for (const double s : {-x * 0.6, x * 0.6}) {
      k.box(k.style.black, {s - 0.015, -y, 0}, {s + 0.015, y, 0.015});
      k.box(k.style.black, {s - 0.012, -0.02, 0.015}, {s + 0.012, 0.0, 0.08});
    }
  } else if (variant == 2) {
    k.box(k.style.metal, {-0.12, -y, 0}, {0.12, y, 0.015});
    k.box(k.style.metal, {-0.025, -0.05, 0.015}, {0.025, -0.02, 0.3});
  }
}

/// A white board with pens, cork with notes, a flip chart on legs.
void board(Kit& k, int variant) {
  const double x = k.w / 2, y0 = -k.d / 2;
  if (variant == 2) {
    k.colour = "white";
    const double face = 0.02;
    for (const double s : {-x + 0.03, x - 0.03}) {
      k.bar(k.style.metal, {s, k.d / 2 - 0.02, 0}, {s * 0.6, face - 0.02, k.h - 0.02}, 0.015, 6);
    }
    k.bar(k.style.metal, {0, y0 + 0.02, 0}, {0, face - 0.03, k.h - 0.03}, 0.015, 6);
    k.box(k.style.white, {-x + 0.02, face, 0.85}, {x - 0.02, face + 0.02, k.h});
    k.box(k.style.paints[0], {-x * 0.6, face + 0.02, k.h - 0.3},
          {x * 0.2, face + 0.022, k.h - 0.26});
    k.box(k.style.paints[1], {-x * 0.6, face + 0.02, k.h - 0.5},
          {x * 0.5, face + 0.022, k.h - 0.47});
    return;
  }
  k.colour = variant == 0 ? "white" : "brown";
  frame(k, variant == 0 ? k.style.metal : k.style.wood, 0.025, k.d);
  k.box(variant == 0 ? k.style.white : k.style.pot, {-x + 0.02, y0, 0.02},
        {x - 0.02, y0 + 0.01, k.h - 0.02});
  const std::size_t marks = variant == 0 ? 6 : 10;
  for (std::size_t i = 0; i < marks; ++i) {
    const double cx = (k.rng.uniform() - 0.5) * (k.w - 0.4),
                 cz = 0.15 + k.rng.uniform() * (k.h - 0.35);
    const bool note = variant == 1;
    const double wide = note ? 0.09 : 0.15 + 0.2 * k.rng.uniform(), tall = note ? 0.11 : 0.012;
    const looks::NamedMaterial& m = note && i % 2 == 0 ? k.style.white : k.style.paints[i % 4];
    const double x0 = std::max(-x + 0.03, cx - wide / 2);
    k.box(m, {x0, y0 + 0.01, cz}, {std::min(x - 0.03, x0 + wide), y0 + 0.012, cz + tall});
  }
}

/// Cloth in folds, hanging from x0 to x1, z0 to z1.
void folds(Kit& k, const looks::NamedMaterial& m, double x0, double x1, double z0, double z1) {
  const int n = std::max(3, static_cast<int>((x1 - x0) / 0.07)) * 2;
  const double deep = k.d * 0.32, step = (x1 - x0) / n;
  const auto y = [&](int i) { return i % 2 == 0 ? -deep : deep; };
  for (int i = 0; i < n; ++i) {
    const double a = x0 + step * i, b = a + step;
    k.quad(m, {b, y(i + 1), z0}, {a, y(i), z0}, {a, y(i), z1}, {b, y(i + 1), z1});
  }
}

/// To the floor on both sides, on one side, a valance with short sides, 3: one of two halves.
void curtain(Kit& k, int variant) {
  const looks::NamedMaterial& m = k.style.accent;
  const double x = k.w / 2, rail = k.h - 0.03;
  k.spoken(m);
  k.bar(k.style.metal, {-x, 0, rail}, {x, 0, rail}, 0.014, 6);
  for (const double s : {-x + 0.01, x - 0.01}) k.sphere(k.style.metal, {s, 0, rail}, 0.025, 6);
  const double side = std::max(0.16, k.w * 0.14);
  k.part();
  folds(k, m, -x + 0.03, -x + 0.03 + (variant == 1 ? 1.5 * side : side), 0.02, rail);
  k.part();
  if (variant != 1) folds(k, m, x - 0.03 - side, x - 0.03, 0.02, rail);
  if (variant == 2) {
    k.part();
    folds(k, m, -x + 0.03 + side, x - 0.03 - side, rail - 0.3, rail);
  }
}

/// Slats, a roll half way down, folded cloth.
void blinds(Kit& k, int variant) {
  const double x = k.w / 2, y = k.d / 2;
  if (variant == 0) {
    k.colour = "white";
    k.box(k.style.white, {-x, -y, k.h - 0.05}, {x, y, k.h});
    for (double z = 0.02; z < k.h - 0.07; z += 0.05) {
      k.box(k.style.white, {-x + 0.01, -y, z}, {x - 0.01, y, z + 0.006});
    }
    return;
  }
  k.spoken(variant == 1 ? k.style.linen : k.style.accent);
  if (variant == 1) {
    k.bar(k.style.metal, {-x, 0, k.h - 0.025}, {x, 0, k.h - 0.025}, 0.022, 8);
    k.box(k.style.linen, {-x + 0.01, -0.002, 0.02}, {x - 0.01, 0.002, k.h - 0.03});
    k.box(k.style.linen, {-x + 0.01, -0.01, 0}, {x - 0.01, 0.01, 0.02});
    return;
  }
  const int n = 4;
  for (int i = 0; i < n; ++i) {
    const double z = k.h * i / n;
    k.soft(k.style.accent, {-x, -y, z}, {x, y - 0.012 * i / n, z + k.h / n * 0.98}, 0.015);
  }
}

void clock(Kit& k, int variant) {
  const double y0 = -k.d / 2, r = k.w / 2;
  k.spoken(variant == 0 ? k.style.black : k.style.wood);
  const looks::NamedMaterial& rim = variant == 0 ? k.style.black : k.style.wood;
  k.bar(rim, {0, y0, r}, {0, y0 + 0.03, r}, r, 22);
  k.bar(k.style.white, {0, y0 + 0.03, r}, {0, y0 + 0.034, r}, r * 0.88, 22);
  k.bar(k.style.black, {0, y0 + 0.038, r}, {0.05 * r, y0 + 0.038, r * 1.6}, 0.006, 4);
  k.bar(k.style.black, {0, y0 + 0.038, r}, {0.5 * r, y0 + 0.038, r * 1.1}, 0.006, 4);
}

constexpr std::array kShapes{
    Shape{"picture", kPicture, picture, 0, {0.80, 0.03, 0.60}},
    Shape{"picture", kPicture, picture, 1, {0.62, 0.03, 0.50}},
    Shape{"picture", kPicture, picture, 3, {0.70, 0.015, 0.95}, "poster"},
    Shape{"painting", kPicture, picture, 2, {1.00, 0.04, 0.72}},
    Shape{"painting", kPicture, picture, 4, {0.95, 0.05, 0.74}},
    Shape{"mirror", kMirror, mirror, 0, {0.65, 0.03, 0.90}},
    Shape{"mirror", kMirror, mirror, 1, {0.70, 0.03, 0.70}},
    Shape{"mirror", kMirror, mirror, 2, {0.70, 0.04, 0.95}},
    Shape{"standing mirror", kMirror, mirror, 3, {0.52, 0.40, 1.65}, "mirror"},
    Shape{"tv", kTvMonitor, tv, 0, {1.15, 0.22, 0.74}},
    Shape{"wall tv", kTvMonitor, tv, 1, {1.25, 0.06, 0.72}, "tv"},
    Shape{"monitor", kTvMonitor, tv, 2, {0.56, 0.20, 0.46}},
    Shape{"whiteboard", kBoardPanel, board, 0, {1.60, 0.03, 1.00}, "board"},
    Shape{"notice board", kBoardPanel, board, 1, {1.10, 0.03, 0.80}, "board"},
    Shape{"flip chart", kBoardPanel, board, 2, {0.72, 0.60, 1.75}, "board"},
    Shape{"curtain", kCurtain, curtain, 0, {1.80, 0.12, 2.30}},
    Shape{"curtain", kCurtain, curtain, 1, {1.80, 0.12, 2.30}},
    Shape{"curtain", kCurtain, curtain, 2, {1.80, 0.12, 2.30}},
    Shape{"blinds", kBlinds, blinds, 0, {1.20, 0.05, 0.55}},
    Shape{"blinds", kBlinds, blinds, 1, {1.20, 0.05, 0.50}},
    Shape{"blinds", kBlinds, blinds, 2, {1.20, 0.06, 0.45}},
    Shape{"clock", 39, clock, 0, {0.32, 0.045, 0.32}},
    Shape{"clock", 39, clock, 1, {0.38, 0.045, 0.38}},
};

}  // namespace

std::span<const Shape> wall_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
