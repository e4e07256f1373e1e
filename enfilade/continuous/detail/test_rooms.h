/// \file  Rooms whose pictures can be computed by hand, for tests.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include "enfilade/continuous/scene.h"
#include "enfilade/core/rng.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::continuous::detail {

inline constexpr Vec3f kRoomLow{-2.5F, -1.5F, 0}, kRoomHigh{3.5F, 2.5F, 2.75F};

inline std::uint32_t add_material(mesh::Mesh& mesh, Vec3f colour) {
  mesh::Material made;
  made.colour = colour;
  mesh.materials.push_back(made);
  return static_cast<std::uint32_t>(mesh.materials.size() - 1);
}

/// A parallelogram that faces cross(u, v), an object of its own.
inline void add_side(mesh::Mesh& mesh, std::uint32_t material, std::uint16_t category, Vec3f corner,
                     Vec3f u, Vec3f v) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3f p : {corner, corner + u, corner + u + v, corner + v})
    mesh.positions.push_back(p);
  mesh.objects.push_back({"side", category, 0});
  const mesh::TexturePoint a{0, 0}, b{length(u), 0}, c{length(u), length(v)}, d{0, length(v)};
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  mesh.texture_points.push_back({a, b, c});
  mesh.texture_points.push_back({a, c, d});
  for (int i = 0; i < 2; ++i) {
    mesh.triangle_material.push_back(material);
    mesh.triangle_object.push_back(static_cast<std::uint32_t>(mesh.objects.size() - 1));
  }
}

/// An empty room: side k is object k with category 10 + k. Sides: -x, x, -y, y, floor, ceiling.
inline mesh::Mesh empty_room(Vec3f low = kRoomLow, Vec3f high = kRoomHigh) {
  mesh::Mesh mesh;
  const Vec3f x{high.x - low.x, 0, 0}, y{0, high.y - low.y, 0}, z{0, 0, high.z - low.z};
  const std::uint32_t grey = add_material(mesh, {0.5F, 0.5F, 0.5F});
  add_side(mesh, grey, 10, low, y, z);
  add_side(mesh, grey, 11, high, -z, -y);
  add_side(mesh, grey, 12, low, z, x);
  add_side(mesh, grey, 13, high, -x, -z);
  add_side(mesh, grey, 14, low, x, y);
  add_side(mesh, grey, 15, high, -y, -x);
  return mesh;
}

/// Where a ray from inside meets the empty room: its side, and how many lengths of `way` away.
struct Met {
  std::size_t side = 0;
  double distance = std::numeric_limits<double>::infinity();
};
inline Met side_met(Vec3d eye, Vec3d way) {
  const std::array<double, 3> from{eye.x, eye.y, eye.z}, to{way.x, way.y, way.z};
  const std::array<double, 3> low{kRoomLow.x, kRoomLow.y, kRoomLow.z};
  const std::array<double, 3> high{kRoomHigh.x, kRoomHigh.y, kRoomHigh.z};
  Met met;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (to[axis] == 0) continue;
    const bool up = to[axis] > 0;
    const double t = ((up ? high[axis] : low[axis]) - from[axis]) / to[axis];
    if (t < met.distance) met = {2 * axis + (up ? 1U : 0U), t};
  }
  return met;
}

inline std::shared_ptr<const mesh::RayTracer> tracer_of(mesh::Mesh mesh) {
  return std::make_shared<const mesh::RayTracer>(
      std::make_shared<const mesh::Mesh>(std::move(mesh)));
}

inline double within(Rng& rng, double low, double high) {
  return low + rng.uniform() * (high - low);
}
/// A place in the empty room, at least `margin` from its sides.
inline Vec3d place_in_room(Rng& rng, double margin = 0.05) {
  return {within(rng, kRoomLow.x + margin, kRoomHigh.x - margin),
          within(rng, kRoomLow.y + margin, kRoomHigh.y - margin),
          within(rng, kRoomLow.z + margin, kRoomHigh.z - margin)};
}

/// The room, full of triangles of all sizes and directions, some with one corner or edge in common.
inline mesh::Mesh cluttered_room(std::size_t triangles, std::uint64_t seed) {
  mesh::Mesh mesh = empty_room();
  Rng rng(seed);
  const std::uint32_t red = add_material(mesh, {0.8F, 0.2F, 0.1F});
  mesh.objects.push_back({"clutter", 39, 0});
  while (mesh.triangles.size() < triangles) {
    const double size = std::exp(within(rng, std::log(0.003), std::log(1.5)));
    const Vec3d middle = place_in_room(rng);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int k = 0; k < 4; ++k) {
      const Vec3d d{within(rng, -1, 1), within(rng, -1, 1), within(rng, -1, 1)};
      mesh.positions.push_back(to_float(middle + size * d));
    }
    for (const auto& corners :
         {std::array{first, first + 1, first + 2}, std::array{first, first + 2, first + 3}}) {
      mesh.triangles.push_back(corners);
      mesh.texture_points.push_back({});
      mesh.triangle_material.push_back(red);
      mesh.triangle_object.push_back(static_cast<std::uint32_t>(mesh.objects.size() - 1));
    }
  }
  return mesh;
}

/// The room with a window to the sun, a box, a striped floor, a lamp's shade and a mirror.
inline mesh::Mesh furnished_room() {
  mesh::Mesh mesh;
  const Vec3f x{6, 0, 0}, y{0, 4, 0}, z{0, 0, 2.75F};
  const std::uint32_t wall = add_material(mesh, {0.8F, 0.75F, 0.7F});
  const std::uint32_t floor = add_material(mesh, {0.9F, 0.9F, 0.9F});
  image::Image8 stripes(64, 64, 3);
  for (std::size_t i = 0; i < stripes.pixels.size(); ++i) {
    stripes.pixels[i] = static_cast<std::uint8_t>(90 + i / 3 % 64 / 8 * 20);
  }
  mesh.materials[floor].texture = std::move(stripes);
  const std::uint32_t glass = add_material(mesh, {0.9F, 0.9F, 0.9F});
  mesh.materials[glass].mirror = 0.85F;
  const std::uint32_t shade = add_material(mesh, {0.8F, 0.8F, 0.8F});
  mesh.materials[shade].emission = {3, 2.5F, 2};
  add_side(mesh, floor, 14, kRoomLow, x, y);
  add_side(mesh, wall, 15, kRoomHigh, -y, -x);
  add_side(mesh, wall, 11, kRoomHigh, -z, -y);
  add_side(mesh, wall, 13, kRoomHigh, -x, -z);
  add_side(mesh, wall, 12, kRoomLow, z, x);
  // The wall at -x has a window of 2 x 1.2 m.
  const auto piece = [&](float y0, float y1, float z0, float z1) {
    add_side(mesh, wall, 10, {kRoomLow.x, y0, z0}, {0, y1 - y0, 0}, {0, 0, z1 - z0});
  };
  piece(kRoomLow.y, -0.5F, 0, 2.75F);
  piece(1.5F, kRoomHigh.y, 0, 2.75F);
  piece(-0.5F, 1.5F, 0, 1);
  piece(-0.5F, 1.5F, 2.2F, 2.75F);
  const Vec3f box{1, -0.5F, 0};
  add_side(mesh, wall, 20, box + Vec3f{0, 0, 0.8F}, {1, 0, 0}, {0, 1, 0});
  add_side(mesh, wall, 20, box, {1, 0, 0}, {0, 0, 0.8F});
  add_side(mesh, wall, 20, box, {0, 0, 0.8F}, {0, 1, 0});
  add_side(mesh, wall, 20, box + Vec3f{1, 1, 0}, {-1, 0, 0}, {0, 0, 0.8F});
  add_side(mesh, wall, 20, box + Vec3f{1, 1, 0}, {0, 0, 0.8F}, {0, -1, 0});
  add_side(mesh, glass, 21, {3.45F, 0, 0.8F}, {0, 0, 1.2F}, {0, 1.2F, 0});
  add_side(mesh, shade, 22, {0, 1, 2.4F}, {0, 0.4F, 0}, {0.4F, 0, 0});
  return mesh;
}

/// That room with its light.
struct Lit {
  std::shared_ptr<const mesh::RayTracer> tracer = tracer_of(furnished_room());
  mesh::LitMesh light;
  std::shared_ptr<const Scene> scene;
  Lit() : light(tracer, lights(), options()), scene(Scene::lit(tracer, light)) {}

  static mesh::Lights lights() {
    mesh::Lights lights;
    lights.sun = {{-0.8F, 0.1F, 0.6F}, {14, 13, 11}};
    lights.lamps.push_back({{0.2F, 1.2F, 2.3F}, {1, 0.9F, 0.8F}, 0.05F});
    return lights;
  }
  static mesh::BakeOptions options() {
    mesh::BakeOptions options;
    options.rays = 32;
    return options;
  }
};
inline const Lit& lit() {
  static const Lit kLit;
  return kLit;
}

}  // namespace enfilade::continuous::detail
