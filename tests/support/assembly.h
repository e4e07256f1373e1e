/// \file  A mesh put together from flat pieces.
#pragma once
#include <array>
#include <cstdint>

#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::tests {

/// Puts flat pieces together.
class Assembly {
 public:
  std::uint32_t material(Vec3f colour, Vec3f emission = {}, float mirror = 0) {
    mesh::Material made;
    made.colour = colour;
    made.emission = emission;
    made.mirror = mirror;
    mesh.materials.push_back(made);
    return static_cast<std::uint32_t>(mesh.materials.size() - 1);
  }
  void object(const char* name, std::uint16_t category) {
    mesh.objects.push_back({name, category, 0});
    object_ = static_cast<std::uint32_t>(mesh.objects.size() - 1);
  }
  /// A parallelogram that faces cross(u, v). Texture points are metres along u and v.
  void quad(std::uint32_t of, Vec3f corner, Vec3f u, Vec3f v) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3f p : {corner, corner + u, corner + u + v, corner + v}) {
      mesh.positions.push_back(p);
    }
    const mesh::TexturePoint a{0, 0}, b{length(u), 0}, c{length(u), length(v)}, d{0, length(v)};
    add(of, {first, first + 1, first + 2}, {a, b, c});
    add(of, {first, first + 2, first + 3}, {a, c, d});
  }
  void triangle(std::uint32_t of, Vec3f a, Vec3f b, Vec3f c) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3f p : {a, b, c}) mesh.positions.push_back(p);
    add(of, {first, first + 1, first + 2}, {});
  }
  /// Six sides that face out.
  void box(std::uint32_t of, Vec3f low, Vec3f high) { sides(of, low, high); }
  /// Six sides that face in.
  void hollow(std::uint32_t of, Vec3f low, Vec3f high) {
    // From the other end, each side turns over.
    sides(of, high, low);
  }

  mesh::Mesh mesh;

 private:
  void sides(std::uint32_t of, Vec3f low, Vec3f high) {
    const Vec3f x{high.x - low.x, 0, 0}, y{0, high.y - low.y, 0}, z{0, 0, high.z - low.z};
    quad(of, low, y, x);
    quad(of, low, x, z);
    quad(of, low, z, y);
    quad(of, high, {-x.x, 0, 0}, {0, -y.y, 0});
    quad(of, high, {0, 0, -z.z}, {-x.x, 0, 0});
    quad(of, high, {0, -y.y, 0}, {0, 0, -z.z});
  }
  void add(std::uint32_t of, std::array<std::uint32_t, 3> corners,
           std::array<mesh::TexturePoint, 3> points) {
    mesh.triangles.push_back(corners);
    mesh.triangle_material.push_back(of);
    mesh.triangle_object.push_back(object_);
    mesh.texture_points.push_back(points);
  }
  std::uint32_t object_ = mesh::kNoObject;
};

}  // namespace enfilade::tests
