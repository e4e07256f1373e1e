#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

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

constexpr Shape kShapes[] = {
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
};

}  // namespace

std::span<const Shape> table_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
