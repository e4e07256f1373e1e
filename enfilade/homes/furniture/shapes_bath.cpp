#include <algorithm>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

void faucet(Kit& k, double y, double z, double tall) {
  k.bar(k.style.metal, {0, y, z}, {0, y, z + tall}, 0.014, 8);
  k.bar(k.style.metal, {0, y, z + tall - 0.01}, {0, y + 0.14, z + tall - 0.03}, 0.012, 8);
  k.bar(k.style.metal, {-0.07, y, z + 0.04}, {0.07, y, z + 0.04}, 0.009, 6);
}

void pedestal(Kit& k, double x, double y) {
  k.lathe(k.main, {0, -y + 0.18, 0}, 14, 1, Ring{0, 0}, Ring{0.14, 0}, Ring{0.09, 0.1},
          Ring{0.08, 0.6}, Ring{0.12, 0.68});
  k.lathe(k.main, {0, 0.02, 0}, 20, (y - 0.02) / x, Ring{0, 0.62}, Ring{0.14, 0.64},
          Ring{x - 0.02, 0.80}, Ring{x, k.h - 0.27}, Ring{x - 0.05, k.h - 0.27}, Ring{0.12, 0.70},
          Ring{0, 0.69});
  k.soft(k.main, {-x * 0.8, -y, 0.7}, {x * 0.8, -y + 0.12, k.h - 0.25}, 0.03);
  faucet(k, -y + 0.07, k.h - 0.25, 0.2);
}

/// On a foot, on the wall, a bowl to stand on a cabinet, a trough, and 4: to hang in a worktop,
/// whose upper face is at h - 0.3.
void sink(Kit& k, double x, double y) {
  if (k.variant == 0) {
    pedestal(k, x, y);
  } else if (k.variant == 1) {
    k.hollow(k.main, {-x, -y, k.h - 0.36}, {x, y, k.h - 0.22}, 0.04, k.h - 0.33, 0.03);
    k.bar(k.style.metal, {0, -y + 0.1, k.h - 0.5}, {0, -y + 0.1, k.h - 0.36}, 0.02, 8);
    faucet(k, -y + 0.03, k.h - 0.22, 0.2);
  } else if (k.variant == 2) {
    const double r = x - 0.01;
    k.lathe(k.main, {0, y - r, 0}, 22, 1, Ring{0, 0}, Ring{r * 0.55, 0}, Ring{r * 0.9, 0.08},
            Ring{r, 0.14}, Ring{r - 0.02, 0.14}, Ring{r * 0.5, 0.03}, Ring{0, 0.02});
    faucet(k, -y + 0.04, 0, k.h - 0.02);
  } else if (k.variant == 3) {
    k.hollow(k.main, {-x, -y, 0.42}, {x, y, k.h - 0.2}, 0.04, 0.5, 0.04);
    k.legs(k.style.metal, 0.42, 0.02, 0.04);
    faucet(k, -y + 0.03, k.h - 0.2, 0.19);
  } else {
    const double top = k.h - 0.3;
    k.hollow(k.main, {-x, -y, 0}, {x, y, top + 0.004}, 0.03, 0.02, 0.02);
    faucet(k, -y + 0.014, top, 0.28);
  }
}

/// Doors, drawers, open with towels.
void bath_cabinet(Kit& k, double x, double y) {
  k.box(k.style.stone, {-x, -y, k.h - 0.035}, {x, y, k.h});
  if (k.variant == 2) {
    k.legs(k.main, k.h - 0.03, 0.025, 0.01);
    k.box(k.main, {-x + 0.02, -y + 0.02, 0.16}, {x - 0.02, y - 0.02, 0.18});
    k.box(k.main, {-x + 0.01, -y + 0.01, k.h - 0.17}, {x - 0.01, y - 0.01, k.h - 0.03});
    for (int i = 0; i < 3; ++i) {  // towels
      const double at = -y * 0.5 + i * 0.14;
      k.bar(k.style.linen, {-x + 0.14, at, 0.235}, {x - 0.14, at, 0.235}, 0.055, 10);
    }
    return;
  }
  k.box(k.style.black, {-x + 0.03, -y, 0}, {x - 0.03, y - 0.07, 0.1});
  k.box(k.main, {-x + 0.005, -y, 0.1}, {x - 0.005, y - 0.03, k.h - 0.035});
  k.fronts(k.main, {-x + 0.01, 0, 0.11}, {x - 0.01, 0, k.h - 0.045}, y - 0.018, 2,
           k.variant == 0 ? 1 : 2);
}

void medicine_cabinet(Kit& k, double x, double y) {
  k.box(k.main, {-x, -y, 0}, {x, y - 0.015, k.h});
  k.box(k.style.mirror, {-x + 0.005, y - 0.015, 0.005}, {-0.003, y - 0.005, k.h - 0.005});
  k.box(k.style.mirror, {0.003, y - 0.015, 0.005}, {x - 0.005, y - 0.005, k.h - 0.005});
}

void toilet_bowl(Kit& k, double y0, double foot) {
  const double r = k.w / 2 - 0.005, c = (y0 + k.d / 2) / 2;
  const double stretch = (k.d / 2 - y0) / 2 / r;
  k.lathe(k.style.white, {0, c, 0}, 20, stretch, Ring{0, foot}, Ring{r * 0.62, foot},
          Ring{r * 0.6, foot + 0.1}, Ring{r * 0.95, 0.36}, Ring{r, 0.40}, Ring{r * 0.70, 0.40},
          Ring{r * 0.5, 0.28}, Ring{0, 0.22});
  k.lathe(k.style.white, {0, c, 0}, 20, stretch, Ring{r * 0.64, 0.405}, Ring{r * 1.0, 0.405},
          Ring{r * 0.99, 0.43}, Ring{r * 0.66, 0.43}, Ring{r * 0.64, 0.405});
}

/// With a cistern and an open lid, boxy on the wall, a bidet.
void toilet(Kit& k, double x, double y) {
  if (k.variant == 1) {
    k.soft(k.main, {-x, -y, 0.1}, {x, y, 0.40}, 0.07);
    k.soft(k.main, {-x, -y + 0.06, 0.40}, {x, y, 0.43}, 0.014);
    k.box(k.main, {-x, -y, 0.4}, {x, -y + 0.04, k.h});
    k.box(k.style.metal, {-0.1, -y + 0.04, k.h - 0.14}, {0.1, -y + 0.05, k.h - 0.03});
    return;
  }
  toilet_bowl(k, -y + 0.17, 0);
  if (k.variant == 2) {
    k.soft(k.main, {-x, -y, 0.1}, {x, -y + 0.2, 0.41}, 0.04);
    faucet(k, -y + 0.08, 0.40, 0.13);
    return;
  }
  k.soft(k.main, {-x + 0.02, -y, 0.38}, {x - 0.02, -y + 0.18, k.h - 0.03}, 0.03);
  k.box(k.main, {-x + 0.01, -y, k.h - 0.03}, {x - 0.01, -y + 0.19, k.h});
  k.box(k.style.metal, {-0.03, -y + 0.07, k.h}, {0.03, -y + 0.12, k.h + 0.01});
  k.soft(k.main, {-x * 0.5, -y, 0}, {x * 0.5, -y + 0.3, 0.38}, 0.04);
  k.soft(k.main, {-x + 0.02, -y + 0.19, 0.42}, {x - 0.02, -y + 0.22, 0.76}, 0.012);
}

void shower_head(Kit& k, double y, double z) {
  k.bar(k.style.metal, {0, y, 1.0}, {0, y, z}, 0.012, 8);
  k.bar(k.style.metal, {0, y, z}, {0, y + 0.3, z + 0.02}, 0.011, 8);
  k.cylinder(k.style.metal, {0, y + 0.3, z - 0.01}, 0.11, 0.10, 0.02, 18);
  k.box(k.style.metal, {-0.1, y - 0.02, 0.98}, {0.1, y + 0.04, 1.04});
}

void pane(Kit& k, Vec3d low, Vec3d high) {
  k.box(k.style.glass, low, high);
  k.box(k.style.metal, {low.x - 0.004, low.y - 0.004, high.z},
        {high.x + 0.004, high.y + 0.004, high.z + 0.03});
}

/// A cubicle with its door ajar, a screen to walk round, a curtain half drawn.
void shower(Kit& k, double x, double y) {
  const double top = k.h - 0.05;
  k.hollow(k.style.white, {-x, -y, 0}, {x, y, 0.06}, 0.04, 0.035, 0.02);
  shower_head(k, -y + 0.03, std::min(2.05, k.h - 0.03));
  k.part();
  if (k.variant == 2) {
    k.bar(k.style.metal, {-x, y - 0.03, top}, {x, y - 0.03, top}, 0.012, 6);
    for (int i = 0; i < 9; ++i) {  // folds
      const double a = -x + 0.05 * i, b = a + 0.05;
      const double ya = y - 0.03 + (i % 2 == 0 ? 0.025 : -0.025), yb = 2 * (y - 0.03) - ya;
      k.quad(k.main, {a, ya, 0.12}, {b, yb, 0.12}, {b, yb, top}, {a, ya, top});
    }
    return;
  }
  pane(k, {x - 0.012, -y, 0.06}, {x, y, top});
  k.part();
  if (k.variant == 0) pane(k, {-x, y - 0.012, 0.06}, {0, y, top});
  k.box(k.style.metal, {-x, y - 0.02, top}, {x, y, k.h - 0.02});
}

/// Built in, oval on the floor, on claws.
void bathtub(Kit& k, double x, double y) {
  if (k.variant == 0) {
    k.hollow(k.main, {-x, -y, 0}, {x, y, k.h - 0.16}, 0.07, 0.14, 0.06);
    const double tap = -x + 0.035;
    k.bar(k.style.metal, {tap, -0.06, k.h - 0.12}, {-x + 0.18, -0.06, k.h - 0.1}, 0.014, 8);
    k.bar(k.style.metal, {tap, -0.06, k.h - 0.16}, {tap, -0.06, k.h - 0.02}, 0.014, 8);
    return;
  }
  const double foot = k.variant == 2 ? 0.12 : 0.0, top = k.h - 0.16, r = x;
  k.lathe(k.main, {0, 0, 0}, 24, y / x, Ring{0, foot}, Ring{r * 0.78, foot},
          Ring{r * 0.9, foot + 0.12}, Ring{r, top - 0.02}, Ring{r, top}, Ring{r * 0.95, top},
          Ring{r * 0.80, foot + 0.16}, Ring{0, foot + 0.08});
  if (k.variant == 2) {
    for (const double sx : {-x * 0.55, x * 0.55}) {
      for (const double sy : {-y * 0.55, y * 0.55}) {
        k.cylinder(k.style.metal, {sx, sy, 0}, 0.03, 0.05, 0.17, 8);
      }
    }
  }
  const double tap = -x * 0.3;
  k.bar(k.style.metal, {tap, -y + 0.02, 0}, {tap, -y + 0.02, k.h}, 0.016, 8);
  k.bar(k.style.metal, {tap, -y + 0.02, k.h - 0.02}, {tap, -y + 0.2, k.h - 0.03}, 0.014, 8);
}

void drape(Kit& k, const NamedMaterial& m, double x0, double x1, double z0, double z1) {
  k.soft(m, {x0, -k.d / 2 + 0.035, z0}, {x1, k.d / 2, z1}, 0.012);
}

/// One on a rail, two on a rail, a ladder of them, a stack.
void towel(Kit& k, double x, double y) {
  const NamedMaterial& m = k.spoken(k.rng.below(2) == 0 ? k.style.accent : k.style.linen);
  if (k.variant == 3) {
    for (int i = 0; i < 3; ++i) {
      const double z = i * k.h / 3;
      k.soft(i == 1 ? k.style.linen : m, {-x, -y, z}, {x, y, z + k.h / 3}, 0.02);
    }
    return;
  }
  if (k.variant == 2) {
    for (const double s : {-x + 0.015, x - 0.015}) {
      k.bar(k.style.metal, {s, -y + 0.03, 0}, {s, -y + 0.03, k.h}, 0.014, 6);
    }
    for (const double z : {0.2, 0.55, 0.9}) {
      k.bar(k.style.metal, {-x, -y + 0.03, z * k.h}, {x, -y + 0.03, z * k.h}, 0.01, 6);
    }
    drape(k, m, -x + 0.06, x - 0.06, 0.18 * k.h, 0.57 * k.h);
    drape(k, k.style.linen, -x + 0.06, x - 0.06, 0.62 * k.h, 0.92 * k.h);
    return;
  }
  k.bar(k.style.metal, {-x, -y + 0.05, k.h - 0.02}, {x, -y + 0.05, k.h - 0.02}, 0.01, 6);
  const double end = x - 0.01;
  k.pairs(k.style.metal, {{{end - 0.01, -y, k.h - 0.03}, {end + 0.01, -y + 0.05, k.h - 0.01}}});
  if (k.variant == 0) {
    drape(k, m, -x + 0.08, x - 0.08, 0, k.h);
  } else {
    drape(k, m, -x + 0.04, -0.02, 0, k.h);
    drape(k, k.style.linen, 0.02, x - 0.04, 0.12, k.h);
  }
}

constexpr Shape kShapes[] = {
    {"sink", kSink, sink, 0, {0.56, 0.46, 1.10}, &Style::white},
    {"sink", kSink, sink, 1, {0.58, 0.44, 1.08}, &Style::white},
    {"washbasin", kSink, sink, 2, {0.42, 0.44, 0.28}, &Style::white},
    {"utility sink", kSink, sink, 3, {0.58, 0.52, 1.05}, &Style::white, "sink"},
    {"kitchen sink", kSink, sink, 4, {0.49, 0.39, 0.50}, &Style::steel, "sink"},
    {"bathroom cabinet", kCabinet, bath_cabinet, 0, {0.85, 0.48, 0.82}, &Style::wood},
    {"bathroom cabinet", kCabinet, bath_cabinet, 1, {0.80, 0.48, 0.80}, &Style::wood},
    {"bathroom cabinet", kCabinet, bath_cabinet, 2, {0.85, 0.48, 0.82}, &Style::wood},
    {"medicine cabinet", kCabinet, medicine_cabinet, 0, {0.70, 0.14, 0.65}, &Style::white},
    {"toilet", kToilet, toilet, 0, {0.38, 0.68, 0.80}, &Style::white},
    {"toilet", kToilet, toilet, 1, {0.37, 0.56, 1.05}, &Style::white},
    {"bidet", kToilet, toilet, 2, {0.37, 0.58, 0.56}, &Style::white},
    {"shower", kShower, shower, 0, {0.90, 0.90, 2.10}, &Style::glass},
    {"shower", kShower, shower, 1, {1.10, 0.90, 2.10}, &Style::glass},
    {"shower", kShower, shower, 2, {0.90, 0.85, 2.10}, &Style::accent},
    {"bathtub", kBathtub, bathtub, 0, {1.70, 0.75, 0.74}, &Style::white},
    {"bathtub", kBathtub, bathtub, 1, {1.70, 0.80, 0.76}, &Style::white},
    {"bathtub", kBathtub, bathtub, 2, {1.65, 0.76, 0.78}, &Style::white},
    {"towel", kTowel, towel, 0, {0.55, 0.10, 0.60}, nullptr},
    {"towel", kTowel, towel, 1, {0.75, 0.10, 0.65}, nullptr},
    {"towel", kTowel, towel, 2, {0.52, 0.12, 1.30}, nullptr},
    {"towels", kTowel, towel, 3, {0.34, 0.24, 0.22}, nullptr},
};

}  // namespace

std::span<const Shape> bath_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
