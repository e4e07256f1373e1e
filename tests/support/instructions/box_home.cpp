#include "tests/support/instructions/box_home.h"

#include <algorithm>
#include <cmath>

#include "enfilade/mesh/mesh_builder.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::instructions::testing {
namespace {

using enum mesh::Mpcat40::Category;
constexpr double kEye = 1.5;

// One inner face of a room's wall, without its doors and arches.
void add_wall(mesh::MeshBuilder& builder, mesh::MaterialId paint, const Plan& plan,
              std::size_t room, bool along_x, bool far) {
  const PlanRoom& r = plan.rooms[room];
  const double z0 = plan.storeys[r.storey].floor, z1 = z0 + r.ceiling;
  const double line = along_x ? (far ? r.floor.y1 : r.floor.y0) : (far ? r.floor.x1 : r.floor.x0);
  double from = along_x ? r.floor.x0 : r.floor.y0;
  const double to = along_x ? r.floor.x1 : r.floor.y1;
  const auto piece = [&](double a, double b, double low, double high) {
    if (b - a < 1e-6 || high - low < 1e-6) return;
    const auto p = [&](double s, double z) {
      return along_x ? Vec3d{s, line, z} : Vec3d{line, s, z};
    };
    builder.quad(paint, p(a, low), p(b, low), p(b, high), p(a, high));
  };
  std::vector<Opening> holes;
  for (const Opening& o : plan.openings) {
    const bool ours = o.room0 == room || o.room1 == room;
    const bool hole = o.kind == OpeningKind::kDoor || o.kind == OpeningKind::kArch;
    if (ours && hole && o.along_x == along_x && std::abs(o.wall - line) < 0.3) holes.push_back(o);
  }
  std::ranges::sort(holes, {}, &Opening::from);
  for (const Opening& o : holes) {
    piece(from, o.from, z0, z1);
    piece(o.from, o.to, z0 + o.head, z1);
    from = o.to;
  }
  piece(from, to, z0, z1);
}

void add_flight(mesh::MeshBuilder& builder, mesh::MaterialId paint, const Plan& plan,
                const Stairs& s) {
  const double z = plan.storeys[s.storey].floor, height = plan.storeys[s.storey].height;
  const Rect& f = s.flight;
  for (unsigned k = 0; k < s.steps; ++k) {
    const double a = static_cast<double>(k) / s.steps, b = static_cast<double>(k + 1) / s.steps;
    const double top = z + height * b;
    Vec3d low{f.x0, f.y0, top - 0.2}, high{f.x1, f.y1, top};
    switch (s.climbs_towards) {
      case enfilade::Side::kPlusX:
        low.x = f.x0 + a * f.width(), high.x = f.x0 + b * f.width();
        break;
      case enfilade::Side::kPlusY:
        low.y = f.y0 + a * f.depth(), high.y = f.y0 + b * f.depth();
        break;
      case enfilade::Side::kMinusX:
        low.x = f.x1 - b * f.width(), high.x = f.x1 - a * f.width();
        break;
      case enfilade::Side::kMinusY:
        low.y = f.y1 - b * f.depth(), high.y = f.y1 - a * f.depth();
        break;
    }
    builder.box(paint, low, high);
  }
}

scan::ConnectivityEntry viewpoint(std::size_t i, Vec3d eye, double height) {
  scan::ConnectivityEntry entry;
  entry.id = "v" + std::to_string(i);
  entry.pose = {1, 0, 0, eye.x, 0, 0, 1, eye.y, 0, -1, 0, eye.z, 0, 0, 0, 1};
  entry.height = height;
  return entry;
}

// Edges where two rays, at the eyes and at the knees, get through.
graph::NavGraph connect(const std::vector<Vec3d>& eyes, const mesh::RayTracer& tracer,
                        const std::string& scan) {
  scan::Connectivity c{scan, scan + "_connectivity.json", {}};
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    c.entries.push_back(viewpoint(i, eyes[i], kEye));
    for (std::size_t k = 0; k < eyes.size(); ++k) {
      const Vec3d a = eyes[i], b = eyes[k];
      if (i == k || length(b - a) > 4) continue;
      const Vec3d down{0, 0, std::abs(a.z - b.z) > 0.3 ? 0.9 : 1.2};
      if (tracer.sees(to_float(a), to_float(b)) &&
          tracer.sees(to_float(a - down), to_float(b - down))) {
        c.entries[i].unobstructed.emplace_back(k);
      }
    }
    c.entries[i].visible = c.entries[i].unobstructed;
  }
  return graph::NavGraph(c);
}

Opening opening(OpeningKind kind, std::size_t room0, std::size_t room1, bool along_x, double wall,
                double from, double to) {
  Opening o;
  o.kind = kind;
  o.room0 = room0;
  o.room1 = room1;
  o.along_x = along_x;
  o.wall = wall;
  o.from = from;
  o.to = to;
  o.leaf = kind == OpeningKind::kDoor ? 90 : 0;
  return o;
}

}  // namespace

Home box_home(const Plan& plan, const std::vector<BoxThing>& things) {
  Home home;
  home.plan = plan;
  mesh::MeshBuilder builder(home.mesh);
  const mesh::MaterialId paint = builder.add_material({});
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    const auto region = static_cast<std::int32_t>(i);
    builder.begin_object("wall", kWall, region);
    for (const bool along_x : {true, false}) {
      for (const bool far : {false, true}) add_wall(builder, paint, plan, i, along_x, far);
    }
    const PlanRoom& r = plan.rooms[i];
    if (r.type == 's' && r.storey > 0) continue;
    const double z = plan.storeys[r.storey].floor;
    builder.begin_object("floor", kFloor, region);
    builder.box(paint, {r.floor.x0 - 0.1, r.floor.y0 - 0.1, z - 0.1},
                {r.floor.x1 + 0.1, r.floor.y1 + 0.1, z});
  }
  for (const Stairs& s : plan.stairs) {
    builder.begin_object("stairs", kStairs, static_cast<std::int32_t>(s.room_below));
    add_flight(builder, paint, plan, s);
  }
  for (const BoxThing& t : things) {
    const std::uint32_t object =
        builder.begin_object(t.noun, kFurniture, static_cast<std::int32_t>(t.room));
    builder.box(paint, t.low, t.high);
    home.things.push_back({object, t.noun, t.colour, t.material, t.room, t.low, t.high});
  }
  return home;
}

Plan small_plan() {
  using K = OpeningKind;
  Plan plan;
  plan.storeys = {{0, 3}, {3, 3}};
  plan.rooms = {{'h', "hallway", 0, {0, 0, 10, 2}, 2.6},
                {'k', "kitchen", 0, {0, 2.12, 4, 7}, 2.6},
                {'l', "living room", 0, {4.12, 2.12, 10, 7}, 2.6},
                {'b', "bedroom", 0, {0, -5, 5, -0.12}, 2.6},
                {'o', "office", 0, {5.12, -5, 10, -0.12}, 2.6},
                {'s', "stairs", 0, {10.12, 0, 12.12, 7}, 3},
                {'s', "stairs", 1, {10.12, 0, 12.12, 7}, 2.6},
                {'h', "landing", 1, {5, 4, 10, 7}, 2.6},
                {'a', "bathroom", 1, {5, 0, 10, 3.88}, 2.6}};
  plan.openings = {opening(K::kDoor, 0, 1, true, 2.06, 1.5, 2.4),
                   opening(K::kDoor, 0, 2, true, 2.06, 7, 7.9),
                   opening(K::kArch, 1, 2, false, 4.06, 4, 6),
                   opening(K::kDoor, 3, 0, true, -0.06, 3.5, 4.4),
                   opening(K::kDoor, 4, 0, true, -0.06, 8, 8.9),
                   opening(K::kArch, 0, 5, false, 10.06, 0.3, 1.7),
                   opening(K::kArch, 7, 6, false, 10.06, 5.6, 6.9),
                   opening(K::kDoor, 8, 7, true, 3.94, 7, 7.9)};
  plan.stairs = {{0, 5, 6, {10.2, 1.6, 12.0, 5.6}, enfilade::Side::kPlusY, 16}};
  plan.outline = {-0.25, -5.25, 12.5, 7.25};
  return plan;
}

Home small_home() {
  return box_home(small_plan(),
                  {{"bench", "white", "wooden", 0, {5, 1.6, 0}, {6.4, 2, 0.5}},
                   {"painting", "red", "painted", 0, {4.5, -0.02, 1.2}, {5.5, 0, 1.9}},
                   {"fridge", "silver", "metal", 1, {0, 6.3, 0}, {0.7, 7, 1.9}},
                   {"stove", "black", "metal", 1, {1, 6.4, 0}, {1.6, 7, 0.9}},
                   {"sofa", "green", "fabric", 2, {6, 6, 0}, {8, 6.9, 0.8}},
                   {"armchair", "brown", "leather", 2, {4.4, 2.2, 0}, {5.2, 3, 0.8}},
                   {"armchair", "red", "fabric", 2, {9.1, 4, 0}, {9.9, 4.8, 0.8}},
                   {"coffee table", "brown", "wooden", 2, {6.4, 4.9, 0}, {7.5, 5.5, 0.4}},
                   {"bed", "dark blue", "fabric", 3, {0.2, -4.8, 0}, {1.8, -2.8, 0.6}},
                   {"wardrobe", "white", "wooden", 3, {4.4, -4, 0}, {5, -2.4, 2}},
                   {"nightstand", "brown", "wooden", 3, {1.9, -4.9, 0}, {2.3, -4.5, 0.5}},
                   {"desk", "brown", "wooden", 4, {6, -4.9, 0}, {7.4, -4.2, 0.75}},
                   {"office chair", "black", "leather", 4, {6.5, -4.1, 0}, {7, -3.6, 0.9}},
                   {"bookshelf", "white", "wooden", 4, {9.6, -4, 0}, {10, -2.5, 2}},
                   {"plant", "green", "", 7, {5.2, 6.4, 3}, {5.7, 6.9, 4.2}},
                   {"bathtub", "white", "", 8, {5.1, 0.1, 3}, {6.8, 0.9, 3.6}},
                   {"sink", "white", "", 8, {9.5, 1.5, 3.7}, {10, 2.1, 3.9}}});
}

graph::NavGraph small_graph(const mesh::RayTracer& tracer) {
  return grid_graph(small_plan(), tracer, "small");
}

graph::NavGraph grid_graph(const Plan& plan, const mesh::RayTracer& tracer,
                           const std::string& scan) {
  std::vector<Vec3d> eyes;
  const auto add = [&](Vec3d p) {
    const bool near = std::ranges::any_of(eyes, [&](Vec3d e) { return length(e - p) < 1.1; });
    const bool free = tracer.sees(to_float(p), to_float({p.x, p.y, p.z - kEye + 0.05}), 0);
    if (!near && free) eyes.push_back(p);
  };
  for (const Opening& o : plan.openings) {
    if (o.kind == OpeningKind::kWindow || o.kind == OpeningKind::kEntrance || !o.room1) continue;
    const double z = plan.storeys[plan.rooms[o.room0].storey].floor + kEye, m = (o.from + o.to) / 2;
    for (const double side : {-0.8, 0.8}) {
      add(o.along_x ? Vec3d{m, o.wall + side, z} : Vec3d{o.wall + side, m, z});
    }
  }
  for (const Stairs& s : plan.stairs) {
    const Rect& f = s.flight;
    const double z = plan.storeys[s.storey].floor + kEye, h = plan.storeys[s.storey].height;
    const bool x = faces_x(s.climbs_towards);
    const double up = is_high(s.climbs_towards) ? 1 : -1;
    const Vec3d d = x ? Vec3d{up, 0, 0} : Vec3d{0, up, 0};
    const Vec3d centre{(f.x0 + f.x1) / 2, (f.y0 + f.y1) / 2, 0};
    const double half = f.length(x) / 2;
    for (const double k : {-1.0, 0.0, 1.0}) {
      const double out = k * (half + 0.6);
      eyes.push_back({centre.x + d.x * out, centre.y + d.y * out, z + h * (k + 1) / 2});
    }
  }
  for (const PlanRoom& r : plan.rooms) {
    if (r.type == 's') continue;
    const double z = plan.storeys[r.storey].floor + kEye;
    for (double x = r.floor.x0 + 0.8; x < r.floor.x1 - 0.6; x += 1.9) {
      for (double y = r.floor.y0 + 0.8; y < r.floor.y1 - 0.6; y += 1.9) add({x, y, z});
    }
  }
  return connect(eyes, tracer, scan);
}

std::shared_ptr<mesh::RayTracer> tracer_of(const Home& home) {
  return std::make_shared<mesh::RayTracer>(std::make_shared<mesh::Mesh>(home.mesh));
}

}  // namespace enfilade::homes::instructions::testing
