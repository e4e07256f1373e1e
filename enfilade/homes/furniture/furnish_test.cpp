#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "enfilade/homes/furniture/furnish_room.h"
#include "enfilade/homes/furniture/shapes.h"

namespace enfilade::homes::furniture {
namespace EN_UNIT {

struct Workshop {
  mesh::Mesh mesh;
  mesh::MeshBuilder builder{mesh};
  std::vector<looks::RoomStyle> styles;
  std::vector<Obstacle> obstacles;
  std::vector<HomeThing> things;
  std::vector<mesh::Lamp> lamps;
  looks::HomeParts parts{builder, obstacles, things, lamps};

  explicit Workshop(const std::string& types = "b") {
    Plan plan;
    plan.seed = 5;
    for (const char type : types) plan.rooms.push_back({type, "room", 0, {0, 0, 4, 4}, 2.6});
    styles = looks::make_styles(plan, builder);
  }
};

/// Is a point in an obstacle that is `slack` larger on all sides?
bool inside(const Obstacle& o, Vec3d p, double slack) {
  const double c = std::cos(o.turned), s = std::sin(o.turned);
  const double dx = p.x - o.x, dy = p.y - o.y;
  return std::abs(c * dx + s * dy) < o.half_x + slack &&
         std::abs(-s * dx + c * dy) < o.half_y + slack && p.z > o.z0 - slack && p.z < o.z1 + slack;
}

TEST(Catalogue, HasThirtyCategoriesOfThreeShapesEach) {
  std::map<unsigned, unsigned> shapes;
  std::set<std::string> nouns;
  for (const FurnitureShape& shape : all_shapes()) {
    ++shapes[shape.category];
    nouns.emplace(shape.noun);
    EXPECT_GT(shape.category, 0U);
    EXPECT_LE(shape.category, 41U);
  }
  const auto enough = std::count_if(shapes.begin(), shapes.end(),
                                    [](const auto& entry) { return entry.second >= 3; });
  EXPECT_GE(enough, 30);
  EXPECT_GE(nouns.size(), 100U);
}

TEST(Shapes, AreSoundAndKeepToTheirSize) {
  Workshop shop;
  Rng rng(1);
  for (const FurnitureShape& shape : all_shapes()) {
    SCOPED_TRACE(std::string(shape.noun) + " " + std::to_string(shape.variant));
    const std::size_t first = shop.mesh.triangles.size();
    build_shape(shape, shape.size, {}, 0, shop.styles[0], rng, shop.parts);
    const std::size_t n = shop.mesh.triangles.size() - first;
    EXPECT_GE(n, 10U);
    EXPECT_LE(n, 2200U);
    for (std::size_t i = first; i < shop.mesh.triangles.size(); ++i) {
      const auto& t = shop.mesh.triangles[i];
      const Vec3d a = to_double(shop.mesh.positions[t[0]]),
                  b = to_double(shop.mesh.positions[t[1]]),
                  c = to_double(shop.mesh.positions[t[2]]);
      const Vec3d facing = cross(b - a, c - a);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d p = to_double(shop.mesh.positions[t[k]]),
                    normal = to_double(shop.mesh.normals[i][k]);
        ASSERT_NEAR(length(normal), 1, 1e-4);
        ASSERT_GT(dot(facing, normal), -1e-9);
        // Handles and trims may stand out by a finger.
        ASSERT_LE(std::abs(p.x), shape.size.w / 2 + 0.03);
        ASSERT_LE(std::abs(p.y), shape.size.d / 2 + 0.03);
        ASSERT_GE(p.z, -0.011);
        ASSERT_LE(p.z, shape.size.h + 0.035);
      }
    }
  }
  EXPECT_TRUE(mesh::check(shop.mesh, "shapes").empty());
}

TEST(Shapes, ObstaclesAndThingsHoldWhatTheyStandFor) {
  Workshop shop;
  Rng rng(2);
  for (const FurnitureShape& shape : all_shapes()) {
    SCOPED_TRACE(std::string(shape.noun) + " " + std::to_string(shape.variant));
    const std::size_t first = shop.mesh.positions.size();
    shop.obstacles.clear();
    build_shape(shape, shape.size, {{3, -2, 0}, 0.6}, 0, shop.styles[0], rng, shop.parts);
    const HomeThing& thing = shop.things.back();
    EXPECT_EQ(thing.noun, shape.noun);
    const bool touchable = shape.size.h > 0.065 && shape.size.d > 0.065;
    EXPECT_EQ(shop.obstacles.empty(), !touchable);
    for (std::size_t i = first; i < shop.mesh.positions.size(); ++i) {
      const Vec3d p = to_double(shop.mesh.positions[i]);
      ASSERT_TRUE(p.x >= thing.low.x && p.y >= thing.low.y && p.z >= thing.low.z &&
                  p.x <= thing.high.x && p.y <= thing.high.y && p.z <= thing.high.z);
      if (!touchable || p.z < 0.35 || p.z > 1.55) continue;
      ASSERT_TRUE(std::any_of(shop.obstacles.begin(), shop.obstacles.end(),
                              [&](const Obstacle& o) { return inside(o, p, 0.05); }));
    }
  }
}

constexpr std::string_view kTypes = "bblkdaateholmjcugwirnvfSCBDpyxzs";

/// A room of a random size with one to three doors and some windows.
looks::RoomSpace random_space(char type, Rng& rng) {
  looks::RoomSpace space;
  space.type = type;
  const auto between = [&](double a, double b) { return a + (b - a) * rng.uniform(); };
  const bool small = type == 't' || type == 'c' || type == 'a';
  const double w = small ? between(1.3, 3.2) : between(2.2, 8.0);
  const double d = type == 'h' ? between(1.1, 2.2) : small ? between(1.6, 3.4) : between(2.4, 7.0);
  space.floor = {between(-5, 5), between(-5, 5), 0, 0};
  space.floor.x1 = space.floor.x0 + w;
  space.floor.y1 = space.floor.y0 + d;
  space.floor_z = 3 * double(rng.below(2));
  space.ceiling_z = space.floor_z + between(2.35, 3.2);
  std::array<Side, 4> walls = kSides;
  rng.shuffle(std::span<Side>(walls));
  const std::size_t doors = 1 + rng.below(3);
  for (std::size_t i = 0; i < 4; ++i) {
    const Side wall = walls[i];
    const double from = space.floor.range(runs_along_x(wall)).first;
    const double size = runs_along_x(wall) ? w : d;
    if (i < doors) {
      const double at = from + between(0.1, size - 0.95);
      space.holes.push_back({wall, at, at + 0.85, 0, 2.1});
    } else if (rng.below(2) == 0) {
      const double wide = std::min(1.4, size - 0.4), at = from + (size - wide) / 2;
      space.holes.push_back({wall, at, at + wide, 0.9, 2.1});
    }
  }
  return space;
}

/// Boxes of what stands on the floor.
struct Standing {
  std::string noun;
  Rect box;
};
std::vector<Standing> standing(const looks::RoomSpace& space,
                               const std::vector<HomeThing>& things) {
  std::vector<Standing> found;
  for (const HomeThing& t : things) {
    if (t.low.z > space.floor_z + 0.06 || t.high.z < space.floor_z + 0.07) continue;
    found.push_back({t.noun, {t.low.x, t.low.y, t.high.x, t.high.y}});
  }
  return found;
}

double shared(const Rect& a, const Rect& b) {
  const double x = std::min(a.x1, b.x1) - std::max(a.x0, b.x0);
  const double y = std::min(a.y1, b.y1) - std::max(a.y0, b.y0);
  return std::min(x, y);
}

void expect_well_placed(const looks::RoomSpace& space, const Workshop& shop) {
  const auto boxes = standing(space, shop.things);
  std::vector<Rect> rects;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    rects.push_back(boxes[i].box);
    for (std::size_t k = 0; k < i; ++k) {
      // An L-shaped sofa has its table, a rod of clothes its shoes, between their parts. 2 x 3 cm:
      // handles and trims that stand out.
      const std::set<std::string> pair{boxes[i].noun, boxes[k].noun};
      if (pair.contains("corner sofa")) continue;
      EXPECT_LT(shared(boxes[i].box, boxes[k].box), 0.06) << boxes[i].noun << ", " << boxes[k].noun;
    }
  }
  for (const HomeThing& t : shop.things) {
    EXPECT_GE(t.low.x, space.floor.x0 - 0.02) << t.noun;
    EXPECT_GE(t.low.y, space.floor.y0 - 0.02) << t.noun;
    EXPECT_LE(t.high.x, space.floor.x1 + 0.02) << t.noun;
    EXPECT_LE(t.high.y, space.floor.y1 + 0.02) << t.noun;
    EXPECT_GE(t.low.z, space.floor_z - 0.02) << t.noun;
    EXPECT_LE(t.high.z, space.ceiling_z + 0.02) << t.noun;
    for (const auto& hole : space.holes) {
      if (!hole.is_door() || t.high.z < space.floor_z + 0.07 || t.low.z > space.floor_z + 1.9)
        continue;
      const Rect& f = space.floor;
      const std::array<Rect, 4> fronts{{{f.x1 - 0.8, hole.from, f.x1, hole.to},
                                        {hole.from, f.y1 - 0.8, hole.to, f.y1},
                                        {f.x0, hole.from, f.x0 + 0.8, hole.to},
                                        {hole.from, f.y0, hole.to, f.y0 + 0.8}}};
      EXPECT_LT(shared(fronts[index(hole.wall)], {t.low.x, t.low.y, t.high.x, t.high.y}), 0.03)
          << t.noun << " before a door";
    }
  }
}

/// Parts of the floor on which a body 0.66 m wide can move about (0.75 m less a finger's breadth
/// for trims that stand out, and less a cell). Another grid than the planner's.
class FloorParts {
 public:
  FloorParts(const Rect& floor, const std::vector<Rect>& standing)
      : floor_(floor),
        standing_(standing),
        nx_(static_cast<int>(floor.width() / kCell)),
        ny_(static_cast<int>(floor.depth() / kCell)),
        part_(static_cast<std::size_t>(nx_ * ny_), -1) {
    int parts = 0;
    for (int start = 0; start < nx_ * ny_; ++start) {
      if (fill(start % nx_, start / nx_, parts)) ++parts;
    }
  }
  static constexpr double kCell = 0.05, kRadius = 0.33;

  std::set<int> near(double x, double y, double reach) const {
    std::set<int> found;
    for (int i = 0; i < nx_ * ny_; ++i) {
      const int part = part_[static_cast<std::size_t>(i)];
      if (part >= 0 && std::hypot(x_of(i % nx_) - x, y_of(i / nx_) - y) < reach) found.insert(part);
    }
    return found;
  }

 private:
  double x_of(int i) const { return floor_.x0 + (i + 0.5) * kCell; }
  double y_of(int k) const { return floor_.y0 + (k + 0.5) * kCell; }
  bool is_free(int i, int k) const {
    const double x = x_of(i), y = y_of(k);
    const Rect& f = floor_;
    if (std::min({x - f.x0, f.x1 - x, y - f.y0, f.y1 - y}) < kRadius) return false;
    return std::none_of(standing_.begin(), standing_.end(), [&](const Rect& r) {
      const double dx = std::max({r.x0 - x, x - r.x1, 0.0});
      return std::hypot(dx, std::max({r.y0 - y, y - r.y1, 0.0})) < kRadius;
    });
  }
  bool fill(int i0, int k0, int number) {
    std::vector<std::pair<int, int>> open{{i0, k0}};
    bool any = false;
    while (!open.empty()) {
      const auto [i, k] = open.back();
      open.pop_back();
      if (i < 0 || k < 0 || i >= nx_ || k >= ny_) continue;
      const int cell = k * nx_ + i;
      int& part = part_[static_cast<std::size_t>(cell)];
      if (part >= 0 || !is_free(i, k)) continue;
      part = number;
      any = true;
      for (const auto& [a, b] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        open.emplace_back(i + a, k + b);
      }
    }
    return any;
  }

  Rect floor_;
  const std::vector<Rect>& standing_;
  int nx_, ny_;
  std::vector<int> part_;
};

/// Is one part at each door, and near the room's middle?
bool doors_are_joined(const looks::RoomSpace& space, const std::vector<Rect>& standing) {
  const Rect& f = space.floor;
  const FloorParts parts(f, standing);
  const double reach = std::max(1.0, 0.6 * std::min(f.width(), f.depth()));
  std::set<int> common = parts.near((f.x0 + f.x1) / 2, (f.y0 + f.y1) / 2, reach);
  for (const auto& hole : space.holes) {
    if (!hole.is_door()) continue;
    const double m = (hole.from + hole.to) / 2, in = FloorParts::kRadius + 0.1;
    const std::array<std::pair<double, double>, 4> entry{
        {{f.x1 - in, m}, {m, f.y1 - in}, {f.x0 + in, m}, {m, f.y0 + in}}};
    const auto here =
        parts.near(entry[index(hole.wall)].first, entry[index(hole.wall)].second, 0.25);
    std::set<int> both;
    std::set_intersection(common.begin(), common.end(), here.begin(), here.end(),
                          std::inserter(both, both.end()));
    common = both;
  }
  return !common.empty();
}

TEST(Furnish, KeepsWaysOpenAndPiecesApartInFiveHundredRooms) {
  std::set<unsigned> categories;
  std::size_t rooms = 0, triangles = 0;
  double area = 0;
  Workshop shop(std::string{kTypes});
  const mesh::Mesh bare = shop.mesh;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const char type = kTypes[seed % kTypes.size()];
    SCOPED_TRACE(std::string("type ") + type + ", seed " + std::to_string(seed));
    Rng rng(seed, 1);
    const looks::RoomSpace space = random_space(type, rng);
    const bool possible = doors_are_joined(space, {});
    shop.mesh.triangles.clear();
    shop.things.clear();
    shop.obstacles.clear();
    shop.lamps.clear();
    furnish(space, shop.styles[seed % kTypes.size()], rng, shop.parts);
    expect_well_placed(space, shop);
    std::vector<Rect> rects;
    for (const Standing& s : standing(space, shop.things)) rects.push_back(s.box);
    if (possible) {
      EXPECT_TRUE(doors_are_joined(space, rects));
    }
    for (const HomeThing& t : shop.things) categories.insert(shop.mesh.objects[t.object].category);
    triangles += shop.mesh.triangles.size();
    area += space.floor.area();
    ++rooms;
    EXPECT_FALSE(shop.lamps.empty());
  }
  EXPECT_GE(categories.size(), 30U);
  // 60,000 triangles for 100 m2, on average over all kinds of rooms.
  EXPECT_LT(double(triangles) / area, 600) << rooms;
}

/// Does it hang on a wall, as pictures and curtains do?
bool hangs(const HomeThing& thing) {
  static const std::set<std::string> kNouns{
      "picture",      "painting", "mirror",  "wall tv", "whiteboard", "notice board", "clock",
      "wall cabinet", "shelf",    "curtain", "blinds",  "wall lamp",  "range hood"};
  return kNouns.contains(thing.noun);
}

/// How far two boxes are in each other; negative: apart.
double shared(const HomeThing& a, const HomeThing& b) {
  return std::min({std::min(a.high.x, b.high.x) - std::max(a.low.x, b.low.x),
                   std::min(a.high.y, b.high.y) - std::max(a.low.y, b.low.y),
                   std::min(a.high.z, b.high.z) - std::max(a.low.z, b.low.z)});
}

/// A door or window as a thing as thick as a wall.
HomeThing hole_of(const looks::RoomSpace& space, const looks::RoomSpace::WallHole& hole) {
  const Rect& f = space.floor;
  const double deep = 0.1;
  const std::array<Rect, 4> boxes{{{f.x1 - deep, hole.from, f.x1 + deep, hole.to},
                                   {hole.from, f.y1 - deep, hole.to, f.y1 + deep},
                                   {f.x0 - deep, hole.from, f.x0 + deep, hole.to},
                                   {hole.from, f.y0 - deep, hole.to, f.y0 + deep}}};
  const Rect& box = boxes[index(hole.wall)];
  return {0,
          hole.is_door() ? "door" : "window",
          "",
          "",
          0,
          {box.x0, box.y0, space.floor_z + hole.sill},
          {box.x1, box.y1, space.floor_z + hole.head}};
}

TEST(Furnish, WhatHangsOnWallsMeetsNothingElse) {
  // Folds, frames and handles stand out of their boxes by a finger's breadth.
  constexpr double kTrim = 0.03;
  Workshop shop(std::string{kTypes});
  std::size_t hung = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    const char type = kTypes[seed % kTypes.size()];
    SCOPED_TRACE(std::string("type ") + type + ", seed " + std::to_string(seed));
    Rng rng(seed, 2);
    const looks::RoomSpace space = random_space(type, rng);
    shop.mesh.triangles.clear();
    shop.things.clear();
    furnish(space, shop.styles[seed % kTypes.size()], rng, shop.parts);
    for (const HomeThing& thing : shop.things) {
      if (!hangs(thing)) continue;
      ++hung;
      for (const HomeThing& other : shop.things) {
        if (&other == &thing) continue;
        EXPECT_LT(shared(thing, other), kTrim) << thing.noun << ", " << other.noun;
      }
      if (thing.noun == "curtain" || thing.noun == "blinds") continue;
      for (const auto& hole : space.holes) {
        const HomeThing opening = hole_of(space, hole);
        EXPECT_LT(shared(thing, opening), 0) << thing.noun << ", " << opening.noun;
      }
    }
  }
  EXPECT_GT(hung, 1000U);
}

TEST(Furnish, IsTheSameForTheSameSeedAndElseDiffers) {
  const auto build = [](std::uint64_t seed) {
    Workshop shop("b");
    Rng shape(7);
    const looks::RoomSpace space = random_space('l', shape);
    Rng rng(seed);
    furnish(space, shop.styles[0], rng, shop.parts);
    return shop.mesh.positions;
  };
  EXPECT_EQ(build(3), build(3));
  EXPECT_NE(build(3), build(4));
}

TEST(Furnish, GivesRoomsWhatTheirTypeNeeds) {
  const std::map<char, std::vector<std::string>> needs{{'b', {"bed"}},
                                                       {'a', {"toilet"}},
                                                       {'k', {"kitchen sink", "refrigerator"}},
                                                       {'l', {"coffee table"}},
                                                       {'o', {"desk", "office chair"}},
                                                       {'m', {"conference table", "whiteboard"}},
                                                       {'w', {"treadmill"}},
                                                       {'j', {"washing machine"}},
                                                       {'i', {"bookshelf"}}};
  Workshop shop;
  for (const auto& [type, nouns] : needs) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      SCOPED_TRACE(std::string("type ") + type + ", seed " + std::to_string(seed));
      shop.things.clear();
      looks::RoomSpace space;
      space.type = type;
      space.floor = {0, 0, 5.2, 4.4};
      space.holes = {{Side::kPlusX, 0.3, 1.15, 0, 2.1}, {Side::kPlusY, 1.5, 3.5, 0.9, 2.1}};
      Rng rng(seed);
      furnish(space, shop.styles[0], rng, shop.parts);
      for (const std::string& noun : nouns) {
        const bool has =
            std::any_of(shop.things.begin(), shop.things.end(), [&](const HomeThing& t) {
              return t.noun == noun || (noun == "bed" && t.noun.ends_with("bed"));
            });
        EXPECT_TRUE(has) << noun;
      }
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::furniture
