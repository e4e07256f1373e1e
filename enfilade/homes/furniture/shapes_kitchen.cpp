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

constexpr Shape kShapes[] = {
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
};

}  // namespace

std::span<const Shape> kitchen_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
