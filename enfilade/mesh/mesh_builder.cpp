#include "enfilade/mesh/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"

namespace enfilade::mesh {
namespace {

Vec3d unit(Vec3d a) {
  const double size = length(a);
  return size > 0 ? 1 / size * a : Vec3d{0, 0, 1};
}

/// cos and sin, exact for quarter turns: most furniture is aligned with the axes, and its sides
/// must be so exactly.
std::array<double, 2> cos_sin(double angle) {
  const auto clean = [](double x) {
    if (std::abs(x) < 1e-12) return 0.0;
    return std::abs(std::abs(x) - 1) < 1e-12 ? (x > 0 ? 1.0 : -1.0) : x;
  };
  return {clean(std::cos(angle)), clean(std::sin(angle))};
}

Vec3d turned(Vec3d v, double angle) {
  const auto [c, s] = cos_sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y, v.z};
}

std::array<double, 2> on_circle(unsigned i, unsigned sides) {
  return cos_sin(2 * kPi * (i % sides) / sides);
}

/// The corner of a soft box that looks to `side` (-1 or 1 along each axis), as the corner of its
/// face across `axis`.
Vec3d soft_corner(Vec3d low, Vec3d high, double round, std::array<int, 3> side, unsigned axis) {
  const auto at = [&](double lo, double hi, int s, bool face) {
    const double cut = face ? 0 : round;
    return s < 0 ? lo + cut : hi - cut;
  };
  return {at(low.x, high.x, side[0], axis == 0), at(low.y, high.y, side[1], axis == 1),
          at(low.z, high.z, side[2], axis == 2)};
}
/// Sides a, b, c along `axis` and the two that follow it.
std::array<int, 3> turned_sides(unsigned axis, int a, int b, int c) {
  std::array<int, 3> sides{};
  sides[axis] = a;
  sides[(axis + 1) % 3] = b;
  sides[(axis + 2) % 3] = c;
  return sides;
}
Vec3d axis_normal(unsigned axis, int side) {
  return {axis == 0 ? double(side) : 0, axis == 1 ? double(side) : 0, axis == 2 ? double(side) : 0};
}

}  // namespace

Vec3d Placement::to_world(Vec3d local) const { return position + mesh::turned(local, turned); }

MaterialId MeshBuilder::add_material(Material material, double texture_size) {
  if (!(texture_size >= 0) || !std::isfinite(texture_size)) {
    throw ArgumentError("texture_size of material \"" + material.name + "\" must be >= 0");
  }
  texture_sizes_.resize(mesh_.materials.size(), 1);
  texture_sizes_.push_back(texture_size);
  mesh_.materials.push_back(std::move(material));
  return {static_cast<std::uint32_t>(mesh_.materials.size() - 1)};
}

std::uint32_t MeshBuilder::begin_object(std::string name, std::uint16_t category,
                                        std::int32_t region, const Placement& placement) {
  object_ = static_cast<std::uint32_t>(mesh_.objects.size());
  mesh_.objects.push_back({std::move(name), category, region});
  placement_ = placement;
  vertices_.clear();
  return object_;
}

std::uint32_t MeshBuilder::vertex(Vec3d local) {
  Vec3f p = to_float(placement_.to_world(local));
  // -0 becomes 0, so that equal positions have equal keys.
  const std::array<float, 3> key{p.x + 0.0F, p.y + 0.0F, p.z + 0.0F};
  const auto [at, fresh] =
      vertices_.try_emplace(key, static_cast<std::uint32_t>(mesh_.positions.size()));
  if (fresh) mesh_.positions.push_back(p);
  return at->second;
}

void MeshBuilder::face(MaterialId material, const Corner& a, const Corner& b, const Corner& c) {
  if (length(cross(b.position - a.position, c.position - a.position)) < 1e-12) return;
  const std::array<std::uint32_t, 3> at{vertex(a.position), vertex(b.position), vertex(c.position)};
  if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) return;
  const double size = texture_size(material);
  const double scale = size > 0 ? 1 / size : 1;
  std::array<TexturePoint, 3> points;
  std::array<Vec3f, 3> normals;
  const std::array<const Corner*, 3> corners{&a, &b, &c};
  for (std::size_t i = 0; i < 3; ++i) {
    points[i] = {static_cast<float>(corners[i]->u * scale),
                 static_cast<float>(corners[i]->v * scale)};
    normals[i] = to_float(unit(mesh::turned(corners[i]->normal, placement_.turned)));
  }
  mesh_.triangles.push_back(at);
  mesh_.triangle_material.push_back(material.value);
  mesh_.triangle_object.push_back(object_);
  mesh_.texture_points.push_back(points);
  mesh_.normals.push_back(normals);
}

void MeshBuilder::patch(MaterialId material, const std::array<Corner, 4>& corners) {
  face(material, corners[0], corners[1], corners[2]);
  face(material, corners[0], corners[2], corners[3]);
}

/// Texture points of a flat face: u horizontal, to the right as seen from the front; v down.
void MeshBuilder::project(MaterialId material, std::span<Corner> corners, Vec3d normal) const {
  if (texture_size(material) > 0) {
    const bool level = std::abs(normal.z) > 0.9;
    const Vec3d right = level ? Vec3d{1, 0, 0} : unit(cross({0, 0, 1}, normal));
    const Vec3d up = cross(normal, right);
    for (Corner& c : corners) {
      c.u = dot(c.position, right);
      c.v = -dot(c.position, up);
    }
    return;
  }
  constexpr std::array<std::array<double, 2>, 4> kOnce{{{0, 1}, {1, 1}, {1, 0}, {0, 0}}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i].u = kOnce[i][0];
    corners[i].v = kOnce[i][1];
  }
}

void MeshBuilder::quad(MaterialId material, Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
  const Vec3d n = unit(cross(c - a, d - b));
  std::array<Corner, 4> corners{{{a, n}, {b, n}, {c, n}, {d, n}}};
  project(material, corners, n);
  patch(material, corners);
}

void MeshBuilder::triangle(MaterialId material, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d n = unit(cross(b - a, c - a));
  std::array<Corner, 3> corners{{{a, n}, {b, n}, {c, n}}};
  project(material, corners, n);
  face(material, corners[0], corners[1], corners[2]);
}

void MeshBuilder::box(MaterialId material, Vec3d low, Vec3d high, bool bottom) {
  const auto [x0, y0, z0] = low;
  const auto [x1, y1, z1] = high;
  quad(material, {x0, y0, z0}, {x1, y0, z0}, {x1, y0, z1}, {x0, y0, z1});
  quad(material, {x1, y0, z0}, {x1, y1, z0}, {x1, y1, z1}, {x1, y0, z1});
  quad(material, {x1, y1, z0}, {x0, y1, z0}, {x0, y1, z1}, {x1, y1, z1});
  quad(material, {x0, y1, z0}, {x0, y0, z0}, {x0, y0, z1}, {x0, y1, z1});
  quad(material, {x0, y0, z1}, {x1, y0, z1}, {x1, y1, z1}, {x0, y1, z1});
  if (bottom) quad(material, {x0, y1, z0}, {x1, y1, z0}, {x1, y0, z0}, {x0, y0, z0});
}

void MeshBuilder::soft_box(MaterialId material, Vec3d low, Vec3d high, double round) {
  const Vec3d size = high - low;
  const double r = std::min(round, 0.49 * std::min({size.x, size.y, size.z}));
  const auto corner = [&](std::array<int, 3> side, unsigned axis) {
    return Corner{soft_corner(low, high, r, side, axis), axis_normal(axis, side[axis])};
  };
  const auto add = [&](std::array<Corner, 4> c, unsigned n = 4) {
    Vec3d out = unit(cross(c[1].position - c[0].position, c[2].position - c[0].position));
    const Vec3d meant = c[0].normal + c[1].normal + c[2].normal;
    if (dot(out, meant) < 0) {
      std::reverse(c.begin(), c.begin() + n);
      out = -out;
    }
    project(material, std::span(c).first(n), out);
    face(material, c[0], c[1], c[2]);
    if (n == 4) face(material, c[0], c[2], c[3]);
  };
  for (unsigned axis = 0; axis < 3; ++axis) {
    const unsigned p = (axis + 1) % 3, q = (axis + 2) % 3;
    const auto sides = [axis](int a, int b, int c) { return turned_sides(axis, a, b, c); };
    for (const int s : {-1, 1}) {
      add({corner(sides(s, -1, -1), axis), corner(sides(s, 1, -1), axis),
           corner(sides(s, 1, 1), axis), corner(sides(s, -1, 1), axis)});
      for (const int t : {-1, 1}) {  // the edge along `axis` between the faces p = s and q = t
        add({corner(sides(-1, s, t), p), corner(sides(1, s, t), p), corner(sides(1, s, t), q),
             corner(sides(-1, s, t), q)});
      }
    }
  }
  for (int i = 0; i < 8; ++i) {
    const std::array<int, 3> s{(i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1};
    const Corner last = corner(s, 2);
    add({corner(s, 0), corner(s, 1), last, last}, 3);
  }
}

void MeshBuilder::disc(MaterialId material, Vec3d middle, Vec3d axis_u, Vec3d axis_v, Vec3d normal,
                       unsigned sides) {
  const bool once = texture_size(material) == 0;
  const double ru = length(axis_u), rv = length(axis_v);
  const auto corner = [&](double c, double s) {
    const double u = once ? 0.5 + c / 2 : c * ru, v = once ? 0.5 - s / 2 : -s * rv;
    return Corner{middle + c * axis_u + s * axis_v, normal, u, v};
  };
  const bool right = dot(cross(axis_u, axis_v), normal) > 0;
  for (unsigned i = 0; i < sides; ++i) {
    const auto [c0, s0] = on_circle(i, sides);
    const auto [c1, s1] = on_circle(i + 1, sides);
    const Corner a = corner(c0, s0), b = corner(c1, s1);
    face(material, corner(0, 0), right ? a : b, right ? b : a);
  }
}

void MeshBuilder::mantle(MaterialId material, Vec3d foot, std::array<double, 2> low,
                         std::array<double, 2> high, std::array<std::array<double, 2>, 2> normals,
                         std::array<double, 2> v, unsigned sides, double stretch) {
  const double widest = std::max(low[0], high[0]);
  const double around = texture_size(material) == 0 ? 1 : 2 * kPi * widest;
  const auto corner = [&](unsigned i, std::array<double, 2> at, std::array<double, 2> n,
                          double along) {
    const auto [c, s] = on_circle(i, sides);
    return Corner{foot + Vec3d{at[0] * c, at[0] * s * stretch, at[1]},
                  {n[0] * c, n[0] * s / stretch, n[1]},
                  around * i / sides,
                  along};
  };
  for (unsigned i = 0; i < sides; ++i) {
    patch(material, {corner(i, low, normals[0], v[0]), corner(i + 1, low, normals[0], v[0]),
                     corner(i + 1, high, normals[1], v[1]), corner(i, high, normals[1], v[1])});
  }
}

void MeshBuilder::cylinder(MaterialId material, Vec3d foot, double radius0, double radius1,
                           double height, unsigned sides) {
  const std::array<std::array<double, 2>, 4> profile{
      {{0, 0}, {radius0, 0}, {radius1, height}, {0, height}}};
  lathe(material, foot, profile, sides);
}

void MeshBuilder::lathe(MaterialId material, Vec3d foot,
                        std::span<const std::array<double, 2>> profile, unsigned sides,
                        double stretch) {
  if (profile.size() < 2) return;
  const std::size_t n = profile.size() - 1;
  std::vector<std::array<double, 2>> normals(n);
  std::vector<double> along(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const double dr = profile[i + 1][0] - profile[i][0], dz = profile[i + 1][1] - profile[i][1];
    const double size = std::sqrt(dr * dr + dz * dz);
    normals[i] = size > 0 ? std::array{dz / size, -dr / size} : std::array{0.0, 1.0};
    along[i + 1] = along[i] + size;
  }
  const auto joined = [&](std::size_t a, std::size_t b) {  // a's normal at its joint with b
    constexpr double kCosCrease = 0.64;                    // of 50 degrees
    const double cosine = normals[a][0] * normals[b][0] + normals[a][1] * normals[b][1];
    if (cosine < kCosCrease) return normals[a];
    return std::array{normals[a][0] + normals[b][0], normals[a][1] + normals[b][1]};
  };
  const double whole = texture_size(material) == 0 && along[n] > 0 ? along[n] : 1;
  for (std::size_t i = 0; i < n; ++i) {
    const auto first = i > 0 ? joined(i, i - 1) : normals[i];
    const auto second = i + 1 < n ? joined(i, i + 1) : normals[i];
    const double top = texture_size(material) == 0 ? 1 : 0;
    mantle(material, foot, profile[i], profile[i + 1], {first, second},
           {top - along[i] / whole, top - along[i + 1] / whole}, sides, stretch);
  }
}

void MeshBuilder::sphere(MaterialId material, Vec3d middle, double radius, unsigned sides) {
  const unsigned rings = std::max(3U, sides / 2);
  std::vector<std::array<double, 2>> profile(rings + 1);
  for (unsigned i = 0; i <= rings; ++i) {
    const auto [c, s] = cos_sin(kPi * i / rings);
    profile[i] = {radius * s, -radius * c};
  }
  lathe(material, middle, profile, sides);
}

void MeshBuilder::bar(MaterialId material, Vec3d a, Vec3d b, double radius, unsigned sides) {
  const Vec3d along = unit(b - a);
  const Vec3d u = unit(cross(along, std::abs(along.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}));
  const Vec3d v = cross(along, u);
  const double size = length(b - a);
  const bool once = texture_size(material) == 0;
  const auto corner = [&](unsigned i, Vec3d end, double at) {
    const auto [c, s] = on_circle(i, sides);
    const Vec3d n = c * u + s * v;
    const double round = double(i) / sides;
    return Corner{end + radius * n, n, once ? round : at,
                  once ? 1 - at / size : -round * 2 * kPi * radius};
  };
  for (unsigned i = 0; i < sides; ++i) {
    patch(material,
          {corner(i, a, 0), corner(i + 1, a, 0), corner(i + 1, b, size), corner(i, b, size)});
  }
  disc(material, a, radius * u, radius * v, -along, sides);
  disc(material, b, radius * u, radius * v, along, sides);
}

}  // namespace enfilade::mesh
