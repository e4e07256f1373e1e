#include "enfilade/mesh/light/surfaces.h"

#include <cmath>

#include "enfilade/mesh/detail/vector.h"

namespace enfilade::mesh::light {

using namespace detail;

namespace {

// The square root of the triangle's area in texels over that in space.
float texels_per_metre(const Mesh& mesh, std::uint32_t triangle, const TexturePyramid& texture,
                       float area) {
  const auto& [a, b, c] = mesh.texture_points[triangle];
  const float u1 = (b.u - a.u) * texture.width(), v1 = (b.v - a.v) * texture.height();
  const float u2 = (c.u - a.u) * texture.width(), v2 = (c.v - a.v) * texture.height();
  return area > 0 ? std::sqrt(0.5F * std::abs(u1 * v2 - u2 * v1) / area) : 0;
}

}  // namespace

Surfaces::Surfaces(const Mesh& mesh) : mesh_(mesh) {
  bool textured = false;
  for (const Material& material : mesh.materials) {
    const bool has = !material.texture.pixels.empty() && !mesh.texture_points.empty();
    textures_.push_back(has ? TexturePyramid(material.texture) : TexturePyramid());
    textured = textured || has;
  }
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  normals_.reserve(count);
  if (textured) texels_per_metre_.resize(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    const auto& corners = mesh.triangles[t];
    const Vec3f a = mesh.positions[corners[0]];
    const Vec3f across = cross(mesh.positions[corners[1]] - a, mesh.positions[corners[2]] - a);
    normals_.push_back(unit(across));
    const TexturePyramid& texture = textures_[mesh.triangle_material[t]];
    if (!texture.empty()) {
      texels_per_metre_[t] = texels_per_metre(mesh, t, texture, 0.5F * length(across));
    }
  }
}

Vec3f Surfaces::normal(std::uint32_t triangle, float u, float v) const {
  const Vec3f geometric = normals_[triangle];
  if (mesh_.normals.empty()) return geometric;
  const auto& [a, b, c] = mesh_.normals[triangle];
  const Vec3f n = unit((1 - u - v) * a + u * b + v * c, geometric);
  return dot(n, geometric) < 0 ? -n : n;
}

Vec3f Surfaces::position(std::uint32_t triangle, float u, float v) const {
  const auto& corners = mesh_.triangles[triangle];
  return (1 - u - v) * mesh_.positions[corners[0]] + u * mesh_.positions[corners[1]] +
         v * mesh_.positions[corners[2]];
}

Vec3f Surfaces::vertex_colour(std::uint32_t triangle, float u, float v) const {
  const auto& corners = mesh_.triangles[triangle];
  return (1 - u - v) * mesh_.colours[corners[0]] + u * mesh_.colours[corners[1]] +
         v * mesh_.colours[corners[2]];
}

Vec3f Surfaces::colour(std::uint32_t triangle, float u, float v, float footprint) const {
  const std::uint32_t material = mesh_.triangle_material[triangle];
  Vec3f colour = mesh_.materials[material].colour;
  if (!mesh_.colours.empty()) colour = colour * vertex_colour(triangle, u, v);
  const TexturePyramid& texture = textures_[material];
  if (texture.empty()) return colour;
  return colour *
         texture.at(texture_point(mesh_, triangle, u, v), footprint * texels_per_metre_[triangle]);
}

Vec3f Surfaces::mean_colour(std::uint32_t triangle) const {
  const std::uint32_t id = mesh_.triangle_material[triangle];
  const Material& material = mesh_.materials[id];
  Vec3f colour = material.colour;
  if (!mesh_.colours.empty()) colour = colour * vertex_colour(triangle, 1.0F / 3, 1.0F / 3);
  if (!textures_[id].empty()) colour = colour * textures_[id].mean();
  return mix(colour, {1, 1, 1}, material.mirror);
}

}  // namespace enfilade::mesh::light
