#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

/// Sides, back and top of a cabinet without doors.
void carcass(Kit& k, double z0, double z1) {
  const double x = k.w / 2, y = k.d / 2;
  k.pairs(k.main, {{{x - 0.02, -y, z0}, {x, y, z1}}});
  k.box(k.main, {-x + 0.02, -y, z0}, {x - 0.02, -y + 0.012, z1});
  k.box(k.main, {-x, -y, z1 - 0.02}, {x, y, z1});
}

/// Doors or drawers all over the front from z0 to z1; y: of the front's middle.
void fronts(Kit& k, const NamedMaterial& m, double z0, double z1, double y, unsigned columns,
            unsigned rows, bool knobs = false) {
  k.fronts(m, {-k.w / 2 + 0.01, 0, z0}, {k.w / 2 - 0.01, 0, z1}, y, columns, rows, knobs);
}

/// Doors; drawers and doors; sliding fronts on legs.
void sideboard(Kit& k, double x, double y) {
  const double foot = k.variant == 2 ? 0.18 : 0.08;
  if (k.variant == 2) {
    k.legs(k.style.metal, foot, 0.014, 0.06);
  } else {
    k.box(k.style.black, {-x + 0.02, -y + 0.01, 0}, {x - 0.02, y - 0.05, foot});
  }
  k.box(k.main, {-x, -y, foot}, {x, y - 0.02, k.h});
  if (k.variant == 0) {
    fronts(k, k.main, foot + 0.01, k.h - 0.02, y - 0.008, 4, 1);
  } else if (k.variant == 1) {
    fronts(k, k.style.wood2, k.h - 0.2, k.h - 0.02, y - 0.008, 3, 1);
    fronts(k, k.main, foot + 0.01, k.h - 0.2, y - 0.008, 3, 1, true);
  } else {
    fronts(k, k.style.wood2, foot + 0.01, k.h - 0.02, y - 0.008, 3, 1);
  }
}

/// Things behind glass above doors.
void display_cabinet(Kit& k, double x, double y) {
  const double waist = 0.75;
  k.box(k.main, {-x, -y, 0}, {x, y - 0.02, waist});
  fronts(k, k.main, 0.05, waist - 0.02, y - 0.008, 2, 1, true);
  carcass(k, waist, k.h);
  for (double z = waist + 0.38; z < k.h - 0.2; z += 0.38) {
    k.box(k.style.glass, {-x + 0.02, -y + 0.012, z}, {x - 0.02, y - 0.03, z + 0.01});
  }
  for (double z = waist; z < k.h - 0.3; z += 0.38) {
    for (int i = 0; i < 4; ++i) {
      const double at = -x + 0.12 + i * (k.w - 0.24) / 3;
      // Drawn one by one: compilers evaluate arguments in different orders.
      const double tall = 0.1 + 0.1 * k.rng.uniform();
      const bool white = k.rng.below(2) == 0;
      const NamedMaterial& colour = white ? k.style.white : k.style.paints[k.rng.below(4)];
      k.cylinder(colour, {at, 0, z + 0.01}, 0.035, 0.05, tall, 8);
    }
  }
  for (const double s : {-x + 0.02, 0.0, x - 0.02}) {
    k.box(k.main, {s - 0.02, y - 0.02, waist}, {s + 0.02, y, k.h});
  }
}

void file_cabinet(Kit& k, double x, double y) {
  k.colour = "grey";
  k.material = "metal";
  k.box(k.style.metal, {-x, -y, 0}, {x, y - 0.02, k.h});
  fronts(k, k.style.white, 0.03, k.h - 0.01, y - 0.008, 1, k.h > 1 ? 4 : 3);
}

/// Full of books: tall, wide and low, cubes with things, leaning ladder.
void bookshelf(Kit& k, double x, double y) {
  if (k.variant == 3) {
    const double x0 = x - 0.02 - 0.02, x1 = x - 0.02 + 0.02;
    k.pairs(k.main,
            {{{x0, -y, 0}, {x1, -y + 0.05, k.h}}, {{x0, y - 0.05, 0}, {x1, y, k.h * 0.55}}});
  } else {
    carcass(k, 0, k.h);
    k.box(k.main, {-x + 0.02, -y + 0.012, 0}, {x - 0.02, y - 0.01, 0.06});
  }
  const auto shelves = static_cast<unsigned>(k.h / 0.36);
  const double step = (k.h - 0.08) / shelves;
  for (unsigned i = 0; i < shelves; ++i) {
    const double z = 0.06 + step * i;
    const double front = k.variant == 3 && z > k.h * 0.5 ? 0 : y - 0.01;
    const double deep = front + y - 0.05;
    const bool board = i > 0 || k.variant == 3;
    if (board) k.box(k.main, {-x + 0.02, -y + 0.012, z}, {x - 0.02, front, z + 0.02});
    const std::uint64_t what = k.rng.below(5);
    if (k.variant == 2) k.box(k.main, {-0.01, -y + 0.012, z}, {0.01, y - 0.01, z + step});
    if (what == 0 || (k.variant == 2 && what == 1)) {
      k.box(k.style.accent, {-x + 0.05, -y + 0.03, z + 0.02}, {-0.03, -y + 0.02 + deep, z + 0.22});
      k.cylinder(k.style.pot, {x * 0.5, (front - y) / 2, z + 0.02}, 0.04, 0.07, 0.18, 10);
    } else {
      const double end = what == 1 ? 0.1 : x - 0.03;
      k.books(-x + 0.03, end, -y + 0.02, z + 0.02, step - 0.04, deep);
      if (what == 1) k.sphere(k.style.metal, {x * 0.6, (front - y) / 2, z + 0.1}, 0.08, 10);
    }
  }
}

/// Metal posts with boxes.
void rack(Kit& k, double x, double y) {
  k.legs(k.main, k.h, 0.02, 0);
  for (double z = 0.12; z < k.h; z += 0.46) {
    k.box(k.main, {-x, -y, z}, {x, y, z + 0.025});
    if (z > k.h - 0.25) break;
    double at = -x + 0.05;
    while (at < x - 0.25) {
      const double wide = 0.2 + 0.15 * k.rng.uniform(), tall = 0.14 + 0.2 * k.rng.uniform();
      if (at + wide > x - 0.03) break;
      const NamedMaterial& c = k.style.paints[k.rng.below(k.style.paints.size())];
      if (k.rng.below(5) == 0) {
        k.cylinder(c, {at + wide / 2, 0, z + 0.025}, 0.09, 0.09, tall, 10);
      } else if (k.rng.below(6) != 0) {
        k.box(c, {at, -y + 0.06, z + 0.025}, {at + wide, y - 0.05, z + 0.025 + tall});
      }
      at += wide + 0.04;
    }
  }
}

/// A board or two on a wall with a few things.
void wall_shelf(Kit& k, double x, double y) {
  const int boards = k.variant == 0 ? 1 : 2;
  for (int i = 0; i < boards; ++i) {
    const double z = i * 0.34;
    k.box(k.main, {-x, -y, z}, {x, y, z + 0.03});
    k.books(-x + 0.05 + 0.3 * i, 0.1 + 0.2 * i, -y + 0.01, z + 0.03, 0.24, k.d - 0.03);
    k.cylinder(k.style.pot, {x * 0.6 * (i == 0 ? 1 : -1), 0, z + 0.03}, 0.04, 0.055, 0.1, 10);
  }
}

/// Swinging doors, sliding mirror doors, one with drawers.
void wardrobe(Kit& k, double x, double y) {
  k.box(k.style.black, {-x + 0.02, -y + 0.01, 0}, {x - 0.02, y - 0.06, 0.06});
  k.box(k.main, {-x, -y, 0.06}, {x, y - 0.025, k.h});
  if (k.variant == 0) {
    fronts(k, k.main, 0.07, k.h - 0.03, y - 0.012, k.w > 1.4 ? 4 : 2, 1);
  } else if (k.variant == 1) {
    k.box(k.main, {-x + 0.01, y - 0.02, 0.08}, {0, y - 0.004, k.h - 0.03});
    k.box(k.style.mirror, {0.01, y - 0.02, 0.08}, {x - 0.01, y - 0.008, k.h - 0.03});
    k.box(k.style.metal, {-0.012, y - 0.02, 0.08}, {0.012, y, k.h - 0.03});
  } else {
    fronts(k, k.main, 0.62, k.h - 0.03, y - 0.012, 2, 1, true);
    fronts(k, k.style.wood2, 0.07, 0.61, y - 0.012, 1, 2, true);
    k.box(k.main, {-x, -y, k.h - 0.05}, {x, y, k.h});
  }
}

/// Low, for a screen to stand on: doors, open, on legs.
void tv_stand(Kit& k, double x, double y) {
  if (k.variant == 1) {
    carcass(k, 0, k.h);
    k.box(k.main, {-x, -y, 0.03}, {x, y, 0.05});
    k.box(k.main, {-0.01, -y, 0.05}, {0.01, y - 0.01, k.h});
    k.box(k.style.black, {-x * 0.8, -y + 0.05, 0.05}, {-x * 0.3, y - 0.05, 0.12});
    k.books(x * 0.2, x * 0.8, -y + 0.04, 0.05, k.h - 0.1, 0.2);
    return;
  }
  const double foot = k.variant == 0 ? 0.04 : 0.15;
  if (k.variant == 2) k.legs(k.style.wood, foot, 0.02, 0.05, true);
  k.box(k.main, {-x, -y, foot}, {x, y - 0.02, k.h});
  if (k.variant == 0) k.box(k.style.black, {-x + 0.03, -y, 0}, {x - 0.03, y - 0.06, foot});
  fronts(k, k.variant == 0 ? k.main : k.style.wood, foot + 0.01, k.h - 0.01, y - 0.008, 3, 1);
}

void apron(Kit& k, const NamedMaterial& m, double inset, double top, double tall) {
  const double x = k.w / 2 - inset, y = k.d / 2 - inset;
  for (const double s : {-1.0, 1.0}) {
    k.box(m, {-x, s * y - 0.012, top - tall}, {x, s * y + 0.012, top});
    k.box(m, {s * x - 0.012, -y, top - tall}, {s * x + 0.012, y, top});
  }
}

/// Four legs, trestle, round on a column, glass on metal; any height.
void table(Kit& k, double x, double y) {
  const NamedMaterial& m = k.main;
  const double top = k.h - 0.035;
  if (k.variant == 0) {
    k.box(m, {-x, -y, top}, {x, y, k.h});
    apron(k, m, 0.06, top, 0.08 * (k.h > 0.6 ? 1 : 0.6));
    k.legs(m, top, 0.032, 0.025);
  } else if (k.variant == 1) {
    k.box(m, {-x, -y, top}, {x, y, k.h});
    const double at = x - 0.22;
    k.pairs(m, {{{at - 0.04, -y * 0.8, 0}, {at + 0.04, y * 0.8, 0.06}},
                {{at - 0.03, -0.12, 0.05}, {at + 0.03, 0.12, top}},
                {{at - 0.04, -y * 0.75, top - 0.06}, {at + 0.04, y * 0.75, top}}});
    k.box(m, {-x + 0.22, -0.025, k.h * 0.3}, {x - 0.22, 0.025, k.h * 0.3 + 0.09});
  } else if (k.variant == 2) {
    k.cylinder(m, {0, 0, top}, x, x, 0.035, 28);
    k.lathe(m, {0, 0, 0}, 16, 1, Ring{0, 0}, Ring{x * 0.55, 0}, Ring{x * 0.5, 0.04},
            Ring{0.07, 0.12}, Ring{0.05, k.h * 0.5}, Ring{0.1, top}, Ring{0, top});
  } else {
    k.box(m, {-x, -y, k.h - 0.015}, {x, y, k.h});
    k.legs(k.style.metal, k.h - 0.015, 0.018, 0.03);
    apron(k, k.style.metal, 0.045, k.h - 0.015, 0.03);
  }
}

/// With a shelf below, round on three legs, stone on metal.
void coffee_table(Kit& k, double x, double y) {
  const NamedMaterial& m = k.main;
  if (k.variant == 0) {
    k.box(m, {-x, -y, k.h - 0.035}, {x, y, k.h});
    k.legs(m, k.h - 0.03, 0.028, 0.01);
    k.box(m, {-x + 0.03, -y + 0.03, 0.12}, {x - 0.03, y - 0.03, 0.14});
    k.box(k.style.paints[0], {-0.3, -0.12, 0.14}, {-0.06, 0.1, 0.17});
    k.box(k.style.paints[1], {-0.28, -0.1, 0.17}, {-0.07, 0.08, 0.195});
  } else if (k.variant == 1) {
    k.cylinder(m, {0, 0, k.h - 0.04}, x, x, 0.04, 26);
    k.splayed_legs(m, 3, 0, {{{0.8 * x, 0.015}, {0.5 * x, k.h - 0.03}}}, 0.022, 8);
  } else {
    k.box(m, {-x, -y, k.h - 0.03}, {x, y, k.h});
    const double x0 = x - 0.1 - 0.02, x1 = x - 0.1 + 0.02, leg = y - 0.07, top = k.h - 0.03;
    k.pairs(k.style.metal, {{{x0, -y + 0.05, 0}, {x1, y - 0.05, 0.03}},
                            {{x0, -leg - 0.02, 0.03}, {x1, -leg + 0.02, top}},
                            {{x0, leg - 0.02, 0.03}, {x1, leg + 0.02, top}}});
  }
}

/// Drawers on one side, panels, metal frame. People sit at the front.
void desk(Kit& k, double x, double y) {
  k.box(k.main, {-x, -y, k.h - 0.03}, {x, y, k.h});
  if (k.variant == 2) {
    const double x0 = x - 0.05 - 0.02, x1 = x - 0.05 + 0.02, top = k.h - 0.03;
    k.pairs(k.style.metal, {{{x0, -y + 0.04, 0}, {x1, y - 0.04, 0.03}},
                            {{x0, -0.03, 0.03}, {x1, 0.03, top}},
                            {{x0, -y + 0.04, k.h - 0.06}, {x1, y - 0.04, top}}});
    return;
  }
  k.box(k.main, {-x + 0.02, -y + 0.03, 0.25}, {x - 0.02, -y + 0.05, k.h - 0.03});
  k.box(k.main, {-x, -y, 0}, {-x + 0.03, y, k.h - 0.03});
  if (k.variant == 1) return k.box(k.main, {x - 0.03, -y, 0}, {x, y, k.h - 0.03});
  k.box(k.main, {x - 0.42, -y + 0.02, 0.03}, {x, y - 0.03, k.h - 0.03});
  k.fronts(k.style.wood2, {x - 0.42, 0, 0.04}, {x, 0, k.h - 0.04}, y - 0.018, 1, 3);
}

/// For halls and behind sofas: legs, half-moon with drawers, metal.
void console(Kit& k, double x, double y) {
  const NamedMaterial& legs = k.variant == 2 ? k.style.metal : k.main;
  const NamedMaterial& shelf = k.variant == 2 ? k.style.glass : k.main;
  const double x0 = x - 0.02, x1 = x - 0.03;
  k.box(k.main, {-x, -y, k.h - 0.03}, {x, y, k.h});
  k.legs(legs, k.h - 0.03, 0.02, 0.015, k.variant == 1);
  if (k.variant != 1) return k.box(shelf, {-x0, -y + 0.01, 0.18}, {x0, y - 0.01, 0.2});
  k.box(k.main, {-x0, -y + 0.01, k.h - 0.2}, {x0, y - 0.03, k.h - 0.02});
  k.fronts(k.style.wood2, {-x1, 0, k.h - 0.19}, {x1, 0, k.h - 0.04}, y - 0.016, 2, 1, true);
}

void meeting_table(Kit& k, double x, double y) {
  k.box(k.main, {-x, -y, k.h - 0.04}, {x, y, k.h});
  const int blocks = k.w > 3 ? 3 : 2;
  for (int i = 0; i < blocks; ++i) {
    const double at = -x * 0.7 + 1.4 * x * i / (blocks - 1);
    if (k.variant == 0) {
      k.box(k.style.wood2, {at - 0.09, -y * 0.6, 0}, {at + 0.09, y * 0.6, k.h - 0.04});
    } else {
      k.box(k.style.metal, {at - 0.04, -y * 0.8, 0}, {at + 0.04, y * 0.8, 0.04});
      k.box(k.style.metal, {at - 0.05, -0.05, 0.04}, {at + 0.05, 0.05, k.h - 0.04});
    }
  }
  k.box(k.style.black, {-0.16, -0.06, k.h}, {0.16, 0.06, k.h + 0.012});
}

void pool_table(Kit& k, double x, double y) {
  const NamedMaterial& m = k.style.wood;

  k.legs(m, 0.5, 0.07, 0.05);
  k.box(m, {-x, -y, 0.48}, {x, y, k.h - 0.06});
  k.box(k.main, {-x + 0.08, -y + 0.08, k.h - 0.06}, {x - 0.08, y - 0.08, k.h - 0.035});
  for (const double s : {-1.0, 1.0}) {
    const double sy = s * (y - 0.05), sx = s * (x - 0.05);
    k.box(m, {-x, sy - 0.05, k.h - 0.06}, {x, sy + 0.05, k.h});
    k.box(m, {sx - 0.05, -y + 0.1, k.h - 0.06}, {sx + 0.05, y - 0.1, k.h});
  }
  for (std::size_t i = 0; i < 9; ++i) {
    const double bx = (k.rng.uniform() - 0.5) * (k.w - 0.4);
    const double by = (k.rng.uniform() - 0.5) * (k.d - 0.4);
    const NamedMaterial& colour = i == 0 ? k.style.white : k.style.paints[i % 8];
    k.sphere(colour, {bx, by, k.h - 0.007}, 0.028, 8);
  }
  k.bar(k.style.wood2, {-x * 0.5, -y * 0.3, k.h - 0.02}, {x * 0.25, y * 0.4, k.h + 0.02}, 0.01, 6);
}

void ping_pong(Kit& k, double x, double y) {
  const double top = k.h - 0.14;  // the net's height
  k.colour = "blue";
  k.box(k.style.screen, {-x, -y, top - 0.03}, {x, y, top});
  for (const double s : {-1.0, 1.0}) {
    k.box(k.style.white, {-x, s * y * 0.98 - 0.01, top}, {x, s * y * 0.98 + 0.01, top + 0.002});
    const double x0 = s * x * 0.6 - 0.02, x1 = s * x * 0.6 + 0.02;
    k.box(k.style.metal, {x0, -y * 0.8, 0}, {x1, -y * 0.8 + 0.04, top});
    k.box(k.style.metal, {x0, y * 0.8 - 0.04, 0}, {x1, y * 0.8, top});
  }
  k.box(k.style.white, {-0.006, -y, top}, {0.006, y, top + 0.14});
}

void work_bench(Kit& k, double x, double y) {
  const double top = k.h - 0.24;  // below its tools
  k.box(k.main, {-x, -y, top - 0.06}, {x, y, top});
  k.legs(k.main, top - 0.06, 0.045, 0.02);
  k.box(k.main, {-x + 0.04, -y + 0.03, 0.2}, {x - 0.04, y - 0.03, 0.23});
  k.box(k.style.paints[0], {-x + 0.2, -y + 0.1, top}, {-x + 0.62, -y + 0.32, top + 0.2});
  k.box(k.style.metal, {-x + 0.36, -y + 0.19, top + 0.2}, {-x + 0.46, -y + 0.22, top + 0.23});
  k.box(k.style.metal, {x - 0.3, y - 0.16, top}, {x - 0.16, y - 0.02, top + 0.13});
  k.box(k.style.paints[2], {-0.2, -0.2, 0.23}, {0.2, 0.15, 0.5});
}

void treadmill(Kit& k, double x, double y) {
  k.box(k.style.steel, {-x, -y, 0.02}, {x, y, 0.14});
  k.box(k.main, {-x + 0.1, -y + 0.25, 0.14}, {x - 0.1, y - 0.02, 0.15});
  for (const double s : {-x + 0.04, x - 0.04}) {
    k.bar(k.style.steel, {s, -y + 0.35, 0.14}, {s, -y + 0.1, k.h - 0.2}, 0.03, 8);
    k.bar(k.main, {s, -y + 0.1, k.h - 0.28}, {s, -y + 0.6, k.h - 0.34}, 0.02, 8);
  }
  k.box(k.main, {-x, -y, k.h - 0.25}, {x, -y + 0.16, k.h - 0.08});
  k.box(k.style.screen, {-0.16, -y + 0.1, k.h - 0.12}, {0.16, -y + 0.13, k.h});
}

void bike(Kit& k, double x, double y) {
  k.material.clear();
  for (const double s : {-y + 0.05, y - 0.05}) {
    k.box(k.style.black, {-x, s - 0.04, 0}, {x, s + 0.04, 0.06});
  }
  k.box(k.style.steel, {-0.03, -y + 0.05, 0.03}, {0.03, y - 0.05, 0.1});
  k.bar(k.main, {-0.06, -y + 0.3, 0.36}, {0.06, -y + 0.3, 0.36}, 0.26, 20);
  k.bar(k.style.steel, {0, -y + 0.35, 0.5}, {0, -y + 0.22, k.h - 0.06}, 0.03, 8);
  k.bar(k.style.black, {-0.24, -y + 0.26, k.h - 0.05}, {0.24, -y + 0.26, k.h - 0.05}, 0.018, 8);
  k.box(k.style.screen, {-0.1, -y + 0.16, k.h - 0.08}, {0.1, -y + 0.2, k.h});
  k.bar(k.style.steel, {0, 0.1, 0.1}, {0, 0.24, 0.86}, 0.03, 8);
  k.soft(k.style.black, {-0.12, 0.1, 0.84}, {0.12, 0.38, 0.92}, 0.035);
  k.bar(k.style.steel, {-0.16, 0.02, 0.28}, {0.16, 0.02, 0.34}, 0.02, 6);
}

void weight_bench(Kit& k, double x, double y) {
  for (const double at : {-y + 0.3, y - 0.12}) {
    k.box(k.style.steel, {-0.22, at - 0.03, 0}, {0.22, at + 0.03, 0.05});
    k.box(k.style.steel, {-0.03, at - 0.03, 0.05}, {0.03, at + 0.03, 0.42});
  }
  k.soft(k.main, {-0.15, -y + 0.1, 0.40}, {0.15, y, 0.48}, 0.03);
  const double x0 = 0.42 - 0.03, x1 = 0.42 + 0.03;
  k.pairs(k.style.steel, {{{x0, -y + 0.08, 0}, {x1, -y + 0.14, k.h - 0.14}},
                          {{x0, -y + 0.05, 0}, {x1, -y + 0.5, 0.05}}});
  const double z = k.h - 0.2, by = -y + 0.22;
  k.bar(k.style.steel, {-x, by, z}, {x, by, z}, 0.014, 8);
  for (const double s : {-x + 0.08, x - 0.08}) {
    k.bar(k.main, {s - 0.03, by, z}, {s + 0.03, by, z}, 0.19, 18);
    k.bar(k.style.accent, {s - 0.05, by, z}, {s + 0.05, by, z}, 0.12, 16);
  }
}

void dumbbells(Kit& k, double x, double y) {
  const double x0 = x - 0.03 - 0.03, x1 = x - 0.03 + 0.03;
  k.pairs(k.style.steel, {{{x0, -y, 0}, {x1, y, 0.05}}, {{x0, -y, 0.05}, {x1, -y + 0.06, k.h}}});
  const double mid = (-y + 0.04 + y * 0.7) / 2;
  for (int row = 0; row < 3; ++row) {
    const double z = 0.12 + row * (k.h - 0.3) / 2, r = 0.07 - 0.012 * row;
    k.box(k.style.steel, {-x, -y + 0.04, z - 0.02}, {x, y * 0.7, z});
    for (double at = -x + 0.14; at < x - 0.1; at += 0.24) {
      k.bar(k.style.steel, {at - 0.06, mid, z + r}, {at + 0.06, mid, z + r}, 0.014, 6);
      k.bar(k.main, {at - 0.09, mid, z + r}, {at - 0.04, mid, z + r}, r, 8);
      k.bar(k.main, {at + 0.04, mid, z + r}, {at + 0.09, mid, z + r}, r, 8);
    }
  }
}

void ball(Kit& k, double, double) {
  k.material.clear();
  k.sphere(k.main, {0, 0, k.h / 2}, k.h / 2, 20);
}

void mat(Kit& k, double x, double y) {
  k.material.clear();
  k.box(k.main, {-x, -y, 0}, {x, y, k.h});
}

void rower(Kit& k, double x, double y) {
  k.box(k.main, {-0.04, -y + 0.3, 0.2}, {0.04, y, 0.28});
  k.bar(k.style.black, {-0.1, -y + 0.3, 0.32}, {0.1, -y + 0.3, 0.32}, 0.28, 18);
  k.soft(k.style.black, {-0.16, 0.1, 0.30}, {0.16, 0.38, 0.37}, 0.03);
  for (const double at : {-y + 0.3, y - 0.06}) {
    k.box(k.style.black, {-x, at - 0.04, 0}, {x, at + 0.04, 0.05});
    k.box(k.main, {-0.03, at - 0.03, 0.05}, {0.03, at + 0.03, 0.22});
  }
  k.bar(k.main, {0, -y + 0.3, 0.5}, {0, -y + 0.42, k.h - 0.04}, 0.02, 6);
  k.box(k.style.screen, {-0.1, -y + 0.4, k.h - 0.18}, {0.1, -y + 0.43, k.h});
}

constexpr FurnitureShape kStorage[] = {
    {"sideboard", kCabinet, sideboard, 0, {1.60, 0.44, 0.80}, &Style::wood, "cabinet"},
    {"sideboard", kCabinet, sideboard, 1, {1.50, 0.46, 0.88}, &Style::wood, "cabinet"},
    {"sideboard", kCabinet, sideboard, 2, {1.55, 0.42, 0.75}, &Style::wood, "cabinet"},
    {"display cabinet", kCabinet, display_cabinet, 0, {0.95, 0.42, 1.90}, &Style::wood},
    {"file cabinet", kCabinet, file_cabinet, 0, {0.46, 0.58, 1.30}, nullptr},
    {"file cabinet", kCabinet, file_cabinet, 0, {0.42, 0.55, 0.70}, nullptr},
    {"cupboard", kCabinet, wardrobe, 2, {0.90, 0.45, 1.75}, &Style::wood},
    {"bookshelf", kShelving, bookshelf, 0, {0.90, 0.32, 1.95}, &Style::wood},
    {"bookshelf", kShelving, bookshelf, 1, {1.40, 0.34, 0.90}, &Style::wood},
    {"bookshelf", kShelving, bookshelf, 2, {0.85, 0.36, 1.50}, &Style::wood},
    {"bookshelf", kShelving, bookshelf, 3, {0.72, 0.38, 1.80}, &Style::wood},
    {"storage shelf", kShelving, rack, 0, {1.20, 0.45, 1.85}, &Style::metal, "storage shelving"},
    {"storage shelf", kShelving, rack, 1, {1.00, 0.42, 1.60}, &Style::wood2, "storage shelving"},
    {"shelf", kShelving, wall_shelf, 0, {0.90, 0.22, 0.30}, &Style::wood},
    {"shelf", kShelving, wall_shelf, 1, {0.80, 0.22, 0.62}, &Style::wood},
    {"wardrobe", kFurniture, wardrobe, 0, {1.60, 0.62, 2.10}, &Style::wood},
    {"wardrobe", kFurniture, wardrobe, 1, {1.70, 0.64, 2.15}, &Style::wood},
    {"wardrobe", kFurniture, wardrobe, 2, {1.10, 0.60, 2.00}, &Style::wood},
    {"tv stand", kFurniture, tv_stand, 0, {1.60, 0.42, 0.50}, &Style::wood2},
    {"tv stand", kFurniture, tv_stand, 1, {1.50, 0.40, 0.46}, &Style::wood2},
    {"tv stand", kFurniture, tv_stand, 2, {1.45, 0.42, 0.52}, &Style::wood2},
    {"dining table", kTable, table, 0, {1.70, 0.92, 0.75}, &Style::wood},
    {"dining table", kTable, table, 1, {1.85, 0.95, 0.76}, &Style::wood},
    {"dining table", kTable, table, 3, {1.60, 0.90, 0.74}, &Style::glass},
    {"round table", kTable, table, 2, {1.15, 1.15, 0.75}, &Style::wood},
    {"kitchen table", kTable, table, 0, {1.10, 0.75, 0.75}, &Style::wood},
    {"kitchen table", kTable, table, 2, {0.95, 0.95, 0.75}, &Style::wood},
    {"side table", kTable, table, 0, {0.48, 0.48, 0.55}, &Style::wood},
    {"side table", kTable, table, 2, {0.48, 0.48, 0.56}, &Style::wood},
    {"side table", kTable, table, 3, {0.45, 0.45, 0.52}, &Style::glass},
    {"coffee table", kTable, coffee_table, 0, {1.10, 0.60, 0.42}, &Style::wood},
    {"coffee table", kTable, coffee_table, 1, {0.85, 0.85, 0.40}, &Style::wood},
    {"coffee table", kTable, coffee_table, 2, {1.05, 0.62, 0.38}, &Style::stone},
    {"coffee table", kTable, table, 3, {1.05, 0.60, 0.40}, &Style::glass},
    {"desk", kTable, desk, 0, {1.40, 0.68, 0.75}, &Style::wood},
    {"desk", kTable, desk, 1, {1.25, 0.62, 0.74}, &Style::wood},
    {"desk", kTable, desk, 2, {1.50, 0.72, 0.73}, &Style::wood},
    {"console table", kTable, console, 0, {1.05, 0.34, 0.80}, &Style::wood, "entry table"},
    {"console table", kTable, console, 1, {1.10, 0.36, 0.82}, &Style::wood, "entry table"},
    {"console table", kTable, console, 2, {1.00, 0.32, 0.78}, &Style::wood, "entry table"},
    {"conference table", kTable, meeting_table, 0, {2.80, 1.15, 0.75}, &Style::wood},
    {"conference table", kTable, meeting_table, 1, {2.80, 1.15, 0.75}, &Style::wood},
    {"pool table", kTable, pool_table, 0, {2.30, 1.30, 0.82}, &Style::leaf},
    {"ping pong table", kTable, ping_pong, 0, {2.60, 1.45, 0.90}, nullptr},
    {"patio table", kTable, table, 0, {1.20, 0.80, 0.73}, &Style::wood, "table"},
    {"patio table", kTable, table, 2, {0.90, 0.90, 0.73}, &Style::wood, "table"},
    {"work bench", kTable, work_bench, 0, {1.60, 0.62, 1.14}, &Style::wood2},
    {"treadmill", kGymEquipment, treadmill, 0, {0.80, 1.75, 1.40}, &Style::black},
    {"exercise bike", kGymEquipment, bike, 0, {0.52, 1.10, 1.20}, &Style::accent},
    {"weight bench", kGymEquipment, weight_bench, 0, {1.40, 1.35, 1.10}, &Style::black},
    {"dumbbells", kGymEquipment, dumbbells, 0, {1.20, 0.50, 0.85}, &Style::black},
    {"exercise ball", kGymEquipment, ball, 0, {0.62, 0.62, 0.62}, &Style::accent},
    {"exercise mat", kGymEquipment, mat, 0, {0.62, 1.75, 0.015}, &Style::accent},
    {"rowing machine",
     kGymEquipment,
     rower,
     0,
     {0.5, 2.1, 0.85},
     &Style::steel,
     "exercise machine"},
};

}  // namespace

std::span<const FurnitureShape> storage_shapes() { return kStorage; }

}  // namespace enfilade::homes::furniture
