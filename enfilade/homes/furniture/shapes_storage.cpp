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

constexpr Shape kShapes[] = {
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
};

}  // namespace

std::span<const Shape> storage_shapes() { return kShapes; }

}  // namespace enfilade::homes::furniture
