/// \file  Colours and normals of a mesh's triangles, for lighting.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/mesh/detail/textures.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh::light {

class Surfaces {
 public:
  /// \pre mesh passes check(), and outlives this
  explicit Surfaces(const Mesh& mesh);

  const Material& material(std::uint32_t triangle) const {
    return mesh_.materials[mesh_.triangle_material[triangle]];
  }
  /// Normal of the triangle's plane, on its front; length 1.
  Vec3f normal(std::uint32_t triangle) const { return normals_[triangle]; }
  /// Shading normal, on the front; length 1.
  Vec3f normal(std::uint32_t triangle, float u, float v) const;
  Vec3f position(std::uint32_t triangle, float u, float v) const;
  /// Diffuse reflectance, averaged over about `footprint` metres.
  Vec3f colour(std::uint32_t triangle, float u, float v, float footprint) const;
  /// Mean reflectance of the triangle; mirrors count as white.
  Vec3f mean_colour(std::uint32_t triangle) const;

 private:
  Vec3f vertex_colour(std::uint32_t triangle, float u, float v) const;

  const Mesh& mesh_;
  std::vector<detail::TexturePyramid> textures_;  ///< by material
  std::vector<Vec3f> normals_;
  std::vector<float> texels_per_metre_;  ///< by triangle; empty: no textures
};

}  // namespace enfilade::mesh::light
