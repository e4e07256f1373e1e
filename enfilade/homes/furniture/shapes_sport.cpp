#include "enfilade/homes/furniture/shapes.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::furniture {
namespace {

using enum mesh::Mpcat40::Category;

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

constexpr Shape kShapes[] = {
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

std::span<const Shape> sport_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
