#include <algorithm>

#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

constexpr auto kFronts = &Style::wood2;  ///< of all cabinets in a kitchen

/// A lower cabinet: doors, drawers, both; 3 is hollow at the top, for a sink to hang in.
void lower(Kit& k, double x, double y) {
  const double plinth = 0.1;
  k.box(k.style.black, {-x, -y, 0}, {x, y - 0.07, plinth});
  if (k.variant == 3) {
    k.box(k.main, {-x, -y, plinth}, {x, y - 0.02, k.h - 0.24});
    k.box(k.main, {-x, y - 0.03, k.h - 0.24}, {x, y - 0.018, k.h});
    k.pairs(k.main, {{{x - 0.02, -y, k.h - 0.24}, {x, y - 0.03, k.h}}});
  } else {
    k.box(k.main, {-x, -y, plinth}, {x, y - 0.018, k.h});
  }
  const unsigned doors = k.w > 0.65 ? 2 : 1;
  const double split = k.variant == 2 ? k.h - 0.18 : k.h;
  if (k.variant == 2) k.fronts(k.main, {-x, 0, split}, {x, 0, k.h}, y - 0.004, doors, 1);
  const bool drawers = k.variant == 1;
  k.fronts(k.main, {-x, 0, plinth}, {x, 0, split}, y - 0.004, drawers ? 1 : doors, drawers ? 3 : 1);
}

/// An upper cabinet: doors, open shelves with crockery.
void upper(Kit& k, double x, double y) {
  if (k.variant == 0) {
    k.box(k.main, {-x, -y, 0}, {x, y - 0.018, k.h});
    k.fronts(k.main, {-x, 0, 0}, {x, 0, k.h}, y - 0.004, k.w > 0.65 ? 2 : 1, 1);
    return;
  }
  k.pairs(k.main, {{{x - 0.02, -y, 0}, {x, y, k.h}}});
  k.box(k.main, {-x + 0.02, -y, 0}, {x - 0.02, -y + 0.015, k.h});
  for (const double z : {0.0, k.h / 2, k.h - 0.02}) {
    k.box(k.main, {-x + 0.02, -y + 0.015, z}, {x - 0.02, y - 0.02, z + 0.02});
  }
  for (const double z : {0.02, k.h / 2 + 0.02}) {
    for (double at = -x + 0.1; at < x - 0.06; at += 0.14) {
      const NamedMaterial& c = k.rng.below(2) == 0 ? k.style.white : k.style.paints[k.rng.below(3)];
      k.cylinder(c, {at, 0, z}, 0.035, 0.05, 0.06 + 0.12 * k.rng.uniform(), 8);
    }
  }
}

void tall_cabinet(Kit& k, double x, double y) {
  k.box(k.style.black, {-x, -y, 0}, {x, y - 0.07, 0.1});
  k.box(k.main, {-x, -y, 0.1}, {x, y - 0.018, k.h});
  k.fronts(k.main, {-x, 0, 0.1}, {x, 0, 1.3}, y - 0.004, 1, 1);
  k.fronts(k.main, {-x, 0, 1.3}, {x, 0, k.h}, y - 0.004, 1, 1);
}

/// Plain; with an edge at the wall; 2 has a hole for a sink, 0.5 x 0.4 m, at its middle.
void countertop(Kit& k, double x, double y) {
  const double top = 0.04;
  if (k.variant == 2) {
    k.pairs(k.main, {{{0.25, -y, 0}, {x, y, top}}});
    k.box(k.main, {-0.25, -y, 0}, {0.25, -0.2, top});
    k.box(k.main, {-0.25, 0.2, 0}, {0.25, y, top});
  } else {
    k.box(k.main, {-x, -y, 0}, {x, y, top});
  }
  if (k.variant != 0) k.box(k.main, {-x, -y, top}, {x, -y + 0.02, k.h});
}

/// Doors below; open shelves; a slab on two blocks.
void island(Kit& k, double x, double y) {
  const double under = k.h - 0.05;
  k.box(k.main, {-x, -y, under}, {x, y, k.h});
  const NamedMaterial& m = k.style.wood2;
  if (k.variant == 0) {
    k.box(m, {-x + 0.04, -y + 0.28, 0}, {x - 0.04, y - 0.04, under});
    k.fronts(m, {-x + 0.05, 0, 0.1}, {x - 0.05, 0, under}, y - 0.02, 3, 1);
  } else if (k.variant == 1) {
    for (const double s : {-x + 0.05, 0.0, x - 0.05}) {
      k.box(m, {s - 0.03, -y + 0.05, 0}, {s + 0.03, y - 0.05, under});
    }
    for (const double z : {0.1, 0.46}) {
      k.box(m, {-x + 0.05, -y + 0.05, z}, {x - 0.05, y - 0.05, z + 0.03});
      for (int i = 0; i < 3; ++i) {
        const Vec3d foot{-x * 0.7 + i * 0.28, 0, z + 0.03};
        k.cylinder(k.style.paints[k.rng.below(5)], foot, 0.08, 0.1, 0.16, 10);
      }
    }
  } else {
    k.pairs(k.main, {{{x - 0.03 - 0.03, -y, 0}, {x - 0.03 + 0.03, y, under}}});
    k.box(k.style.wood, {-x + 0.06, -y + 0.3, 0.02}, {x - 0.06, y - 0.05, under});
  }
}

/// A reception desk: panels in front, a ledge above.
void reception(Kit& k, double x, double y) {
  k.box(k.main, {-x, y - 0.12, 0}, {x, y - 0.05, k.h - 0.04});
  k.box(k.style.stone, {-x, y - 0.32, k.h - 0.04}, {x, y, k.h});
  k.pairs(k.main, {{{x - 0.03 - 0.03, -y, 0}, {x - 0.03 + 0.03, y - 0.12, 0.75}}});
  k.box(k.style.wood2, {-x, -y, 0.72}, {x, y - 0.12, 0.75});
  const int battens = k.variant == 0 ? 0 : 12;
  for (int i = 0; i < battens; ++i) {
    const double at = -x + 0.06 + i * (k.w - 0.12) / (battens - 1);
    k.box(k.style.wood2, {at - 0.02, y - 0.05, 0.08}, {at + 0.02, y - 0.03, k.h - 0.08});
  }
}

/// Two doors one above the other; side by side; small.
void refrigerator(Kit& k, double x, double y) {
  const double front = y - 0.05;
  k.box(k.style.black, {-x + 0.02, -y, 0}, {x - 0.02, front - 0.03, 0.05});
  k.box(k.main, {-x, -y, 0.05}, {x, front - 0.01, k.h});
  const auto door = [&](double x0, double x1, double z0, double z1, bool left) {
    k.box(k.main, {x0 + 0.004, front - 0.01, z0}, {x1 - 0.004, front + 0.02, z1});
    const double at = left ? x0 + 0.05 : x1 - 0.05;
    k.box(k.style.steel, {at - 0.012, front + 0.02, z0 + 0.1 * (z1 - z0)},
          {at + 0.012, y, z0 + 0.65 * (z1 - z0)});
  };
  if (k.variant == 1) {
    door(-x, 0, 0.06, k.h - 0.01, false);
    door(0, x, 0.06, k.h - 0.01, true);
    k.box(k.style.black, {-x + 0.12, front + 0.02, 1.0}, {-0.12, front + 0.024, 1.35});
  } else {
    const double split = k.h > 1.2 ? 0.7 : 0.06;
    if (split > 0.1) door(-x, x, 0.06, split - 0.005, true);
    door(-x, x, split, k.h - 0.01, true);
  }
}

/// An oven below gas rings with a pot, or below glass.
void stove(Kit& k, double x, double y) {
  const double top = k.h - 0.17;  // below the pot
  k.box(k.main, {-x, -y, 0}, {x, y - 0.03, top - 0.01});
  k.box(k.style.black, {-x + 0.01, -y + 0.01, top - 0.01}, {x - 0.01, y - 0.04, top + 0.004});
  k.box(k.style.screen, {-x + 0.05, y - 0.03, 0.25}, {x - 0.05, y - 0.012, 0.66});
  k.bar(k.style.steel, {-x + 0.06, y - 0.012, 0.7}, {x - 0.06, y - 0.012, 0.7}, 0.012, 6);
  for (int i = 0; i < 5; ++i) {
    const double at = -x + 0.1 + i * (k.w - 0.2) / 4;
    k.box(k.style.black, {at - 0.018, y - 0.03, 0.79}, {at + 0.018, y - 0.01, 0.826});
  }
  const double ring = k.variant == 0 ? 0.02 : 0.003;
  for (const double sx : {-0.14, 0.14}) {
    for (const double sy : {-0.16, 0.10}) {
      k.cylinder(k.style.steel, {sx, sy, top + 0.004}, 0.085, 0.085, ring, 14);
    }
  }
  if (k.variant == 0) {  // a pot
    k.cylinder(k.style.steel, {0.14, -0.16, top + 0.024}, 0.1, 0.1, 0.13, 14);
    k.cylinder(k.style.black, {0.14, -0.16, top + 0.154}, 0.02, 0.015, 0.02, 8);
  }
}

/// A round door: washing machine (0), dryer (1); a flat one: dishwasher (2).
void machine(Kit& k, double x, double y) {
  const double front = y - 0.05;
  k.box(k.main, {-x, -y, 0.02}, {x, front, k.h});
  k.box(k.style.black, {-x + 0.03, -y + 0.03, 0}, {x - 0.03, front - 0.05, 0.03});
  k.box(k.style.screen, {-0.02, front, k.h - 0.1}, {x - 0.05, front + 0.006, k.h - 0.04});
  if (k.variant == 2) {
    const double handle = k.h - 0.19;
    k.box(k.main, {-x + 0.01, front, 0.08}, {x - 0.01, front + 0.015, k.h - 0.14});
    k.bar(k.main, {-x + 0.06, y - 0.02, handle}, {x - 0.06, y - 0.02, handle}, 0.012, 6);
    return;
  }
  const double z = k.h * 0.45, knob = k.h - 0.07;
  const NamedMaterial& window = k.variant == 1 ? k.main : k.style.screen;
  k.bar(k.style.steel, {0, front - 0.01, z}, {0, front + 0.03, z}, 0.2, 20);
  k.bar(window, {0, front - 0.01, z}, {0, front + 0.042, z}, 0.15, 20);
  k.box(k.main, {-x + 0.05, front, k.h - 0.12}, {-0.08, front + 0.01, k.h - 0.03});
  k.bar(k.style.steel, {-0.05, front, knob}, {-0.05, front + 0.02, knob}, 0.022, 10);
}

void microwave(Kit& k, double x, double y) {
  k.box(k.style.steel, {-x, -y, 0}, {x, y - 0.01, k.h});
  k.box(k.style.screen, {-x + 0.02, y - 0.01, 0.03}, {x - 0.12, y, k.h - 0.03});
  k.box(k.main, {x - 0.1, y - 0.01, 0.03}, {x - 0.02, y - 0.002, k.h - 0.03});
}

void coffee_maker(Kit& k, double x, double y) {
  k.box(k.main, {-x, -y, 0}, {x, y, 0.03});
  k.box(k.main, {-x, -y, 0.03}, {x, -y + 0.09, k.h});
  k.box(k.style.steel, {-x, -y + 0.09, k.h - 0.1}, {x, y, k.h});
  k.cylinder(k.style.screen, {0, y * 0.35, 0.03}, 0.055, 0.07, 0.12, 12);
}

void toaster(Kit& k, double x, double y) {
  k.soft(k.spoken(k.style.paints[0]), {-x, -y, 0.01}, {x, y, k.h}, 0.03);
  for (const double s : {-0.035, 0.035}) {
    k.box(k.style.black, {-x + 0.05, s - 0.012, k.h - 0.002}, {x - 0.05, s + 0.012, k.h + 0.002});
  }
}

/// Above a stove.
void hood(Kit& k, double x, double y) {
  k.box(k.main, {-x, -y, 0}, {x, y, 0.07});
  const bool step = k.variant == 1;
  if (step) k.box(k.main, {-x + 0.1, -y, 0.07}, {x - 0.1, y - 0.12, 0.22});
  k.box(k.main, {-0.14, -y, step ? 0.22 : 0.07}, {0.14, -y + 0.26, k.h});
}

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

constexpr FurnitureShape kWet[] = {
    {"kitchen cabinet", kCabinet, lower, 0, {0.6, 0.6, 0.88}, kFronts, "kitchen lower cabinet"},
    {"kitchen cabinet", kCabinet, lower, 1, {0.6, 0.6, 0.88}, kFronts, "kitchen lower cabinet"},
    {"kitchen cabinet", kCabinet, lower, 2, {0.6, 0.6, 0.88}, kFronts, "kitchen lower cabinet"},
    {"sink cabinet", kCabinet, lower, 3, {0.6, 0.6, 0.88}, kFronts},
    {"wall cabinet", kCabinet, upper, 0, {0.6, 0.34, 0.70}, kFronts, "kitchen upper cabinet"},
    {"wall cabinet", kCabinet, upper, 1, {0.6, 0.30, 0.65}, kFronts, "kitchen upper cabinet"},
    {"tall cabinet", kCabinet, tall_cabinet, 0, {0.6, 0.6, 2.10}, kFronts, "kitchen cabinet"},
    {"countertop", kCounter, countertop, 0, {1.20, 0.62, 0.04}, &Style::stone},
    {"countertop", kCounter, countertop, 1, {1.20, 0.62, 0.14}, &Style::stone},
    {"countertop", kCounter, countertop, 2, {1.20, 0.62, 0.14}, &Style::stone},
    {"kitchen island", kCounter, island, 0, {1.60, 0.95, 0.92}, &Style::stone},
    {"kitchen island", kCounter, island, 1, {1.50, 0.80, 0.92}, &Style::stone},
    {"kitchen island", kCounter, island, 2, {1.70, 0.92, 0.92}, &Style::stone},
    {"counter", kCounter, reception, 0, {1.80, 0.70, 1.10}, &Style::wood},
    {"counter", kCounter, reception, 1, {2.00, 0.72, 1.10}, &Style::wood},
    {"refrigerator", kAppliances, refrigerator, 0, {0.62, 0.68, 1.80}, &Style::white},
    {"refrigerator", kAppliances, refrigerator, 1, {0.90, 0.72, 1.78}, &Style::steel},
    {"mini fridge", kAppliances, refrigerator, 0, {0.50, 0.52, 0.84}, &Style::white},
    {"stove", kAppliances, stove, 0, {0.60, 0.62, 1.08}, &Style::steel},
    {"stove", kAppliances, stove, 1, {0.60, 0.62, 1.08}, &Style::white},
    {"washing machine", kAppliances, machine, 0, {0.60, 0.62, 0.86}, &Style::white},
    {"clothes dryer", kAppliances, machine, 1, {0.60, 0.62, 0.86}, &Style::white},
    {"dishwasher", kAppliances, machine, 2, {0.60, 0.60, 0.88}, &Style::steel},
    {"microwave", kAppliances, microwave, 0, {0.48, 0.34, 0.28}, &Style::black},
    {"coffee maker", kAppliances, coffee_maker, 0, {0.18, 0.26, 0.34}, &Style::black},
    {"toaster", kAppliances, toaster, 0, {0.28, 0.17, 0.19}, nullptr},
    {"range hood", 39, hood, 0, {0.60, 0.48, 0.75}, &Style::steel},
    {"range hood", 39, hood, 1, {0.60, 0.48, 0.75}, &Style::steel},
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

std::span<const FurnitureShape> wet_shapes() { return kWet; }

}  // namespace enfilade::homes::furniture
