/// \file  Textures as rays see them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh::detail {

/// Where a point of a triangle, (1 - u - v) corner0 + u corner1 + v corner2, lies in its texture.
TexturePoint texture_point(const Mesh& mesh, std::uint32_t triangle, float u, float v);

/// Alpha in [0, 1] between the four texels around a point. \pre 4 channels
float alpha_at(const image::Image8& texture, TexturePoint at);

/// A texture and its halves, quarters, ... so that what is seen from afar does not flicker.
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
