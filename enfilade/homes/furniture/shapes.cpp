#include "enfilade/homes/furniture/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "enfilade/core/check.h"

namespace enfilade::homes::furniture {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Bounds {
  Vec3d low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  void add(Vec3d p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  bool empty() const { return low.x > high.x; }
};

using Triangle = std::array<Vec3d, 3>;

/// The part of a polygon where sign * (its coordinate along `axis` - limit) <= 0.
void clip(std::vector<Vec3d>& polygon, double Vec3d::*axis, double limit, double sign) {
  std::vector<Vec3d> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a.*axis - limit), db = sign * (b.*axis - limit);
    if (da <= 0) out.push_back(a);
    if ((da <= 0) == (db <= 0)) continue;
    const double s = da / (da - db);
    out.push_back({a.x + (b.x - a.x) * s, a.y + (b.y - a.y) * s, a.z + (b.z - a.z) * s});
  }
  polygon = std::move(out);
}

/// Whether two strips beside each other have the same extent in y and z.
bool alike_across(const Bounds& a, const Bounds& b) {
  constexpr double kSame = 0.02;
  return std::abs(a.low.y - b.low.y) < kSame && std::abs(a.high.y - b.high.y) < kSame &&
         std::abs(a.low.z - b.low.z) < kSame && std::abs(a.high.z - b.high.z) < kSame;
}

/// Boxes around the polygons, one for each strip of 8 cm along x, so that the boxes follow round
/// things; strips that are alike are joined.
void add_strips(const std::vector<std::vector<Vec3d>>& layer, const Bounds& all,
                std::vector<Bounds>& boxes) {
  constexpr double kStrip = 0.08;
  const std::size_t first = boxes.size();
  const auto count =
      static_cast<std::size_t>(std::ceil(std::max(all.high.x - all.low.x, 1e-6) / kStrip));
  const double width = (all.high.x - all.low.x) / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    Bounds strip;
    for (std::vector<Vec3d> polygon : layer) {
      clip(polygon, &Vec3d::x, all.low.x + width * static_cast<double>(i), -1);
      clip(polygon, &Vec3d::x, all.low.x + width * static_cast<double>(i + 1), 1);
      for (const Vec3d p : polygon) strip.add(p);
    }
    if (strip.empty()) continue;
    if (boxes.size() > first && alike_across(boxes.back(), strip)) {
      boxes.back().add(strip.low);
      boxes.back().add(strip.high);
    } else {
      boxes.push_back(strip);
    }
  }
}

/// Boxes around the triangles: layers of 0.25 m, cut into strips.
std::vector<Bounds> layers(const std::vector<Triangle>& triangles) {
  constexpr double kLayer = 0.25;
  Bounds all;
  for (const Triangle& t : triangles) {
    for (const Vec3d p : t) all.add(p);
  }
  std::vector<Bounds> boxes;
  for (double z = all.low.z; z < all.high.z - 1e-9; z += kLayer) {
    std::vector<std::vector<Vec3d>> layer;
    Bounds extent;
    for (const Triangle& t : triangles) {
      std::vector<Vec3d> polygon(t.begin(), t.end());
      clip(polygon, &Vec3d::z, z, -1);
      clip(polygon, &Vec3d::z, z + kLayer, 1);
      if (polygon.empty()) continue;
      for (const Vec3d p : polygon) extent.add(p);
      layer.push_back(std::move(polygon));
    }
    if (!extent.empty()) add_strips(layer, extent, boxes);
  }
  return boxes;
}

/// Triangles of the mesh from `from` to `to`, in the placement's frame.
std::vector<Triangle> local_triangles(const mesh::Mesh& mesh, std::size_t from, std::size_t to,
                                      const mesh::Placement& at) {
  const mesh::Placement back{{}, -at.turned};
  std::vector<Triangle> out;
  for (std::size_t i = from; i < to; ++i) {
    Triangle t;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d p = to_double(mesh.positions[mesh.triangles[i][k]]);
      t[k] = back.to_world(p - at.position);
    }
    out.push_back(t);
  }
  return out;
}

void add_obstacles(const Kit& kit, const mesh::Mesh& mesh, const mesh::Placement& at,
                   std::vector<Obstacle>& obstacles) {
  for (std::size_t i = 0; i < kit.parts.size(); ++i) {
    const std::size_t end = i + 1 < kit.parts.size() ? kit.parts[i + 1] : mesh.triangles.size();
    for (const Bounds& b : layers(local_triangles(mesh, kit.parts[i], end, at))) {
      const Vec3d middle = at.to_world({(b.low.x + b.high.x) / 2, (b.low.y + b.high.y) / 2, 0});
      obstacles.push_back({middle.x, middle.y, (b.high.x - b.low.x) / 2, (b.high.y - b.low.y) / 2,
                           at.turned, at.position.z + b.low.z, at.position.z + b.high.z});
    }
  }
}

}  // namespace

Kit::Kit(mesh::MeshBuilder& builder, const Style& room_style, Rng& random,
         const FurnitureShape& shape, FurnitureSize size)
    : style(room_style),
      rng(random),
      w(size.w),
      d(size.d),
      h(size.h),
      variant(shape.variant),
      main(shape.main != nullptr ? room_style.*shape.main : NamedMaterial{}),
      colour(main.colour),
      material(main.material),
      builder_(builder) {
  part();
}

void Kit::hollow(const NamedMaterial& m, Vec3d low, Vec3d high, double wall, double bottom,
                 double slope) {
  const auto ring = [](double x0, double x1, double y0, double y1, double z) {
    return std::array<Vec3d, 4>{{{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}}};
  };
  const auto outer0 = ring(low.x, high.x, low.y, high.y, low.z);
  const auto outer1 = ring(low.x, high.x, low.y, high.y, high.z);
  const auto inner1 = ring(low.x + wall, high.x - wall, low.y + wall, high.y - wall, high.z);
  const double in = wall + slope;
  const auto inner0 = ring(low.x + in, high.x - in, low.y + in, high.y - in, bottom);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t k = (i + 1) % 4;
    quad(m, outer0[i], outer0[k], outer1[k], outer1[i]);
    quad(m, outer1[i], outer1[k], inner1[k], inner1[i]);
    quad(m, inner1[i], inner1[k], inner0[k], inner0[i]);
  }
  quad(m, inner0[0], inner0[1], inner0[2], inner0[3]);
  quad(m, outer0[3], outer0[2], outer0[1], outer0[0]);
}

void Kit::legs(const NamedMaterial& m, double z, double half, double inset, bool round) {
  const double x = w / 2 - inset - half, y = d / 2 - inset - half;
  for (const double sx : {-x, x}) {
    for (const double sy : {-y, y}) {
      if (round) {
        cylinder(m, {sx, sy, 0}, half * 0.65, half, z, 8);
      } else {
        box(m, {sx - half, sy - half, 0}, {sx + half, sy + half, z});
      }
    }
  }
}

void Kit::pairs(const NamedMaterial& m, std::initializer_list<BlockCorners> blocks, double round) {
  const auto build = [&](Vec3d low, Vec3d high) {
    round > 0 ? soft(m, low, high, round) : box(m, low, high);
  };
  for (const auto& [low, high] : blocks) {
    build({-high.x, low.y, low.z}, {-low.x, high.y, high.z});
  }
  for (const auto& [low, high] : blocks) build(low, high);
}

void Kit::splayed_legs(const NamedMaterial& m, int count, double first, std::array<Ring, 2> ends,
                       double radius, unsigned sides) {
  const auto [foot, top] = ends;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * (i + first) / count;
    const double c = std::cos(angle), s = std::sin(angle);
    bar(m, {foot[0] * c, foot[0] * s, foot[1]}, {top[0] * c, top[0] * s, top[1]}, radius, sides);
  }
}

void Kit::fronts(const NamedMaterial& m, Vec3d low, Vec3d high, double y, unsigned columns,
                 unsigned rows, bool knobs) {
  constexpr double kGap = 0.006, kProud = 0.014;
  const double cw = (high.x - low.x) / columns, rh = (high.z - low.z) / rows;
  for (unsigned i = 0; i < columns; ++i) {
    for (unsigned k = 0; k < rows; ++k) {
      const double x0 = low.x + cw * i + kGap, x1 = low.x + cw * (i + 1) - kGap;
      const double z0 = low.z + rh * k + kGap, z1 = low.z + rh * (k + 1) - kGap;
      box(m, {x0, y - kProud, z0}, {x1, y, z1});
      const bool drawer = cw > 1.1 * rh;
      const bool left = i % 2 == 0;  // pairs of doors open from the middle
      const double mx = drawer || columns == 1 ? (drawer ? (x0 + x1) / 2 : x1 - 0.05)
                                               : (left ? x1 - 0.04 : x0 + 0.04);
      const double mz = drawer ? (z0 + z1) / 2 : (z0 > 1.2 ? z0 + 0.12 : std::min(z1 - 0.12, 1.05));
      if (knobs) {
        sphere(style.metal, {mx, y + 0.004, mz}, 0.014, 6);
      } else if (drawer) {
        const double half = std::min(0.08, cw / 4);
        box(style.metal, {mx - half, y, mz - 0.008}, {mx + half, y + 0.018, mz + 0.008});
      } else {
        box(style.metal, {mx - 0.008, y, mz - 0.08}, {mx + 0.008, y + 0.018, mz + 0.08});
      }
    }
  }
}

void Kit::books(double x0, double x1, double y, double z, double tall, double deep) {
  double x = x0;
  while (x < x1 - 0.05) {
    const double thick = std::min(0.03 + 0.05 * rng.uniform(), x1 - x);
    const double high = tall * (0.66 + 0.3 * rng.uniform());
    const NamedMaterial& cover = style.paints[rng.below(style.paints.size())];
    box(cover, {x, y, z}, {x + thick - 0.002, y + deep * (0.75 + 0.2 * rng.uniform()), z + high});
    x += thick;
    if (rng.below(9) == 0) x += 0.06 + 0.1 * rng.uniform();
  }
}

const std::vector<FurnitureShape>& all_shapes() {
  static const std::vector<FurnitureShape> kShapes = [] {
    std::vector<FurnitureShape> all;
    for (const auto table :
         {seat_shapes(), storage_shapes(), wet_shapes(), wall_shapes(), decor_shapes()}) {
      all.insert(all.end(), table.begin(), table.end());
    }
    return all;
  }();
  return kShapes;
}

std::vector<const FurnitureShape*> shapes_of(std::string_view noun) {
  std::vector<const FurnitureShape*> found;
  for (const FurnitureShape& shape : all_shapes()) {
    if (shape.noun == noun) found.push_back(&shape);
  }
  EN_CHECK(!found.empty());
  return found;
}

const FurnitureShape& shape_of(std::string_view noun, std::size_t which) {
  return *shapes_of(noun).at(which);
}

void build_shape(const FurnitureShape& shape, FurnitureSize size, const mesh::Placement& at,
                 std::size_t room, const Style& style, Rng& rng, looks::HomeParts& parts,
                 double power) {
  // Thinner things on walls or on the floor are no obstacles.
  constexpr double kThin = 0.065;
  const auto object =
      parts.builder.begin_object(std::string(shape.raw.empty() ? shape.noun : shape.raw),
                                 shape.category, static_cast<std::int32_t>(room), at);
  Kit kit(parts.builder, style, rng, shape, size);
  kit.power = power;
  const std::size_t first = kit.parts[0];
  shape.build(kit, size.w / 2, size.d / 2);
  const mesh::Mesh& mesh = parts.builder.mesh();
  if (size.h > kThin && size.d > kThin) add_obstacles(kit, mesh, at, parts.obstacles);
  Bounds box;
  for (std::size_t i = first; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) box.add(to_double(mesh.positions[v]));
  }
  EN_CHECK(!box.empty());
  parts.things.push_back(
      {object, std::string(shape.noun), kit.colour, kit.material, room, box.low, box.high});
  for (const Kit::LampSpot& lamp : kit.lamps) {
    const auto light = static_cast<float>(lamp.power);
    parts.lamps.push_back(
        {to_float(at.to_world(lamp.local)), {light, 0.88F * light, 0.72F * light}, 0.06F});
  }
}

}  // namespace enfilade::homes::furniture
