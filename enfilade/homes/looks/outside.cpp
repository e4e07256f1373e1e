#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "enfilade/core/rng.h"
#include "enfilade/homes/looks/architecture.h"
#include "enfilade/homes/plan/draws.h"

namespace enfilade::homes::looks {
namespace {

constexpr std::int32_t kOutside = -1;
constexpr double kFar = 70;  // metres to the end of the lawn

mesh::MaterialId plain(BuildingSite& site, const char* name, Vec3f colour) {
  mesh::Material m;
  m.name = name;
  m.colour = colour;
  return site.parts.builder.add_material(std::move(m));
}

Vec3f varied(Rng& rng, Vec3f c) {
  const auto vary = [&](float x) { return x * static_cast<float>(plan::draw(rng, 0.8, 1.2)); };
  return {vary(c.x), vary(c.y), vary(c.z)};
}

// Height of the ground: houses and offices stand on it; flats and hotel floors are storeys above.
double ground_height(const Plan& plan, Rng& rng) {
  const bool up = plan.kind == HomeKind::kFlat || plan.kind == HomeKind::kHotelFloor;
  return up ? -plan::snap(plan::draw(rng, 2.9, 8.7)) : -0.15;
}

void build_facade(BuildingSite& site, mesh::MaterialId material, double ground) {
  const Plan& plan = site.plan;
  const Rect& out = plan.outline;
  site.parts.builder.begin_object("facade", Mpcat40::kWall, kOutside);
  for (const Side side : kSides) {
    const bool along_x = runs_along_x(side);
    const double n = out.at(side);
    const auto [u0, u1] = out.range(along_x);
    upright(site, material, side, n, u0, u1, ground, plan.storeys[0].floor);
    for (unsigned s = 0; s < plan.storeys.size(); ++s) {
      std::vector<const Opening*> holes;
      for (const Opening& o : plan.openings) {
        const bool here = !o.room1 && plan.rooms[o.room0].storey == s && o.along_x == along_x;
        if (here && std::abs(o.wall - n) < plan.outer_wall) holes.push_back(&o);
      }
      std::sort(holes.begin(), holes.end(),
                [](const Opening* a, const Opening* b) { return a->from < b->from; });
      const double z = plan.storeys[s].floor, top = z + plan.storeys[s].height;
      double at = u0;
      for (const Opening* o : holes) {
        upright(site, material, side, n, at, o->from, z, top);
        upright(site, material, side, n, o->from, o->to, z, z + o->sill);
        upright(site, material, side, n, o->from, o->to, z + o->head, top);
        at = o->to;
      }
      upright(site, material, side, n, at, u1, z, top);
    }
  }
}

void build_roof(BuildingSite& site, mesh::MaterialId material) {
  const Rect& out = site.plan.outline;
  const PlanStorey& last = site.plan.storeys.back();
  const double z = last.floor + last.height;
  constexpr double kEaves = 0.3, kThick = 0.25;
  site.parts.builder.begin_object("roof", Mpcat40::kCeiling, kOutside);
  site.parts.builder.box(material, {out.x0 - kEaves, out.y0 - kEaves, z},
                         {out.x1 + kEaves, out.y1 + kEaves, z + kThick});
}

void build_ground(BuildingSite& site, Rng& rng, double ground) {
  mesh::MeshBuilder& b = site.parts.builder;
  const Rect& out = site.plan.outline;
  const mesh::MaterialId grass = plain(site, "grass", varied(rng, {0.11F, 0.22F, 0.06F}));
  const mesh::MaterialId paving = plain(site, "paving", varied(rng, {0.36F, 0.34F, 0.31F}));
  constexpr double kPath = 1.2;
  const Rect paved{out.x0 - kPath, out.y0 - kPath, out.x1 + kPath, out.y1 + kPath};
  const Rect lawn{out.x0 - kFar, out.y0 - kFar, out.x1 + kFar, out.y1 + kFar};
  b.begin_object("lawn", Mpcat40::kMisc, kOutside);
  for (const Rect& r : around(lawn, &paved)) level(site, grass, r, ground, true);
  b.begin_object("paving", Mpcat40::kMisc, kOutside);
  for (const Rect& r : around(paved, &out)) level(site, paving, r, ground, true);
}

void build_hedge(BuildingSite& site, Rng& rng, double ground) {
  const mesh::MaterialId green = plain(site, "hedge", varied(rng, {0.06F, 0.15F, 0.04F}));
  const Rect& out = site.plan.outline;
  const double away = plan::draw(rng, 5, 9), height = plan::draw(rng, 1.0, 1.7);
  const Rect in{out.x0 - away, out.y0 - away, out.x1 + away, out.y1 + away};
  constexpr double kThick = 0.6;
  site.parts.builder.begin_object("hedge", Mpcat40::kPlant, kOutside);
  for (const Side side : kSides) {
    const bool along_x = runs_along_x(side);
    const double n = in.at(side) - (is_high(side) ? 0 : kThick);
    const double u0 = along_x ? in.x0 : in.y0 - kThick, u1 = along_x ? in.x1 : in.y1 + kThick;
    wall_box(site, along_x, green, {u0, u1, n, n + kThick, ground, ground + height});
  }
}

// A point around the building, `least` to `most` metres outside the circle around its outline.
Vec3d somewhere(const Plan& plan, Rng& rng, double angle, double least, double most) {
  const double rx = plan.outline.width() / 2, ry = plan.outline.depth() / 2;
  const double reach = std::hypot(rx, ry) + plan::draw(rng, least, most);
  const double mx = (plan.outline.x0 + plan.outline.x1) / 2;
  const double my = (plan.outline.y0 + plan.outline.y1) / 2;
  return {mx + reach * std::cos(angle), my + reach * std::sin(angle), 0};
}

void build_trees(BuildingSite& site, Rng& rng, double ground) {
  mesh::MeshBuilder& b = site.parts.builder;
  const mesh::MaterialId bark = plain(site, "bark", {0.10F, 0.07F, 0.05F});
  const std::array leaves{plain(site, "leaves", varied(rng, {0.09F, 0.20F, 0.05F})),
                          plain(site, "leaves", varied(rng, {0.13F, 0.21F, 0.05F}))};
  constexpr int kTrees = 9;
  for (int i = 0; i < kTrees; ++i) {
    const double angle = 2 * std::numbers::pi * (i + rng.uniform()) / kTrees;
    const Vec3d at = somewhere(site.plan, rng, angle, 4, 16);
    const double trunk = plan::draw(rng, 1.4, 2.4), crown = plan::draw(rng, 1.3, 2.4);
    b.begin_object("tree", Mpcat40::kPlant, kOutside, {{at.x, at.y, ground}, 0});
    b.cylinder(bark, {0, 0, 0}, 0.17, 0.12, trunk + 0.4 * crown, 6);
    const mesh::MaterialId leaf = leaves[i % 2 == 0 ? 0 : 1];
    if (plan::chance(rng, 0.35)) {
      b.cylinder(leaf, {0, 0, trunk * 0.6}, crown * 0.8, 0.05, crown * 2.6, 9);
    } else {
      b.sphere(leaf, {0, 0, trunk + crown * 0.8}, crown, 9);
      b.sphere(leaf, {crown * 0.6, crown * 0.2, trunk + crown * 0.5}, crown * 0.65, 7);
    }
  }
}

void build_neighbours(BuildingSite& site, Rng& rng, double ground) {
  mesh::MeshBuilder& b = site.parts.builder;
  constexpr std::array<Vec3f, 5> kWalls{{{0.62F, 0.55F, 0.45F},
                                         {0.55F, 0.28F, 0.20F},
                                         {0.66F, 0.64F, 0.60F},
                                         {0.45F, 0.50F, 0.56F},
                                         {0.60F, 0.50F, 0.30F}}};
  const mesh::MaterialId roof = plain(site, "tiles", varied(rng, {0.28F, 0.12F, 0.09F}));
  const mesh::MaterialId pane = plain(site, "dark glass", {0.05F, 0.07F, 0.10F});
  constexpr int kHouses = 9;
  for (int i = 0; i < kHouses; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.6 * rng.uniform()) / kHouses;
    const Vec3d at = somewhere(site.plan, rng, angle, 18, 34);
    const double w = plan::draw(rng, 4, 7), d = plan::draw(rng, 3.5, 5),
                 h = plan::draw(rng, 3, 8.5);
    const mesh::MaterialId wall =
        plain(site, "neighbour", varied(rng, kWalls[rng.below(kWalls.size())]));
    b.begin_object("house", Mpcat40::kMisc, kOutside, {{at.x, at.y, ground}, angle});
    b.box(wall, {-d, -w, 0}, {d, w, h});
    for (const int side : {-1, 1}) {  // two slopes and two gables
      const double e = side * (d + 0.4);
      const Vec3d p{e, -w - 0.4, h - 0.1}, q{e, w + 0.4, h - 0.1}, r{0, w + 0.4, h + 2.4},
          s{0, -w - 0.4, h + 2.4};
      side > 0 ? b.quad(roof, p, q, r, s) : b.quad(roof, q, p, s, r);
      const double g = side * w;
      side > 0 ? b.triangle(wall, {d, g, h}, {-d, g, h}, {0, g, h + 2.3})
               : b.triangle(wall, {-d, g, h}, {d, g, h}, {0, g, h + 2.3});
    }
    for (double z = 0.9; z + 1.5 < h; z += 2.8) {  // windows on the side that faces the home
      for (double y = -w + 1; y + 1.2 < w; y += 2.4) {
        b.box(pane, {-d - 0.03, y, z}, {-d + 0.1, y + 1.1, z + 1.3});
      }
    }
  }
}

}  // namespace

void build_outside(BuildingSite& site) {
  Rng rng(site.plan.seed, stream_of("outside", 7));
  const double ground = ground_height(site.plan, rng);
  constexpr std::array<Vec3f, 4> kFacades{
      {{0.70F, 0.66F, 0.58F}, {0.50F, 0.27F, 0.20F}, {0.74F, 0.74F, 0.72F}, {0.62F, 0.58F, 0.40F}}};
  build_facade(site, plain(site, "facade", kFacades[rng.below(kFacades.size())]), ground);
  build_roof(site, plain(site, "roof", {0.25F, 0.24F, 0.24F}));
  build_ground(site, rng, ground);
  build_hedge(site, rng, ground);
  build_trees(site, rng, ground);
  build_neighbours(site, rng, ground);
}

}  // namespace enfilade::homes::looks
