/// \file  Texture lookup for rays: coordinates, alpha, filtering.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh::detail {

/// Texture coordinates of the point (1 - u - v) corner0 + u corner1 + v corner2 of a triangle.
TexturePoint texture_point(const Mesh& mesh, std::uint32_t triangle, float u, float v);

/// Linear value of an sRGB byte, from a table.
float linear_of(std::uint8_t byte);

/// Alpha in [0, 1], bilinear. \pre 4 channels
float alpha_at(const image::Image8& texture, TexturePoint at);

/// A mip map: a texture in halved sizes, against aliasing.
class TexturePyramid {
 public:
  TexturePyramid() = default;
  /// \pre 3 or 4 channels, at least a texel
  explicit TexturePyramid(const image::Image8& texture);

  bool empty() const noexcept { return levels_.empty(); }
  /// Linear colour, the mean over about `texels` texels of the texture across.
  Vec3f at(TexturePoint point, float texels) const;
  /// Linear.
  Vec3f mean() const noexcept { return mean_; }
  float width() const noexcept { return static_cast<float>(levels_.front().width); }
  float height() const noexcept { return static_cast<float>(levels_.front().height); }

 private:
  struct Level {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint32_t> texels;  ///< sRGB, R lowest
  };
  static Level half(const Level& whole);
  static Vec3f between(const Level& level, TexturePoint point);

  std::vector<Level> levels_;
  Vec3f mean_;
};

}  // namespace enfilade::mesh::detail
