/// \file  Lights that are aimed at: lamps, portals to the sky, glowing things.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/mesh/lighting.h"

namespace enfilade::mesh::light {

/// Radiance of the sky. \param towards of length 1
Vec3f sky_radiance(const Sky& sky, Vec3f towards);

/// A surface point that receives light.
struct Receiver {
  Vec3f position, normal;  ///< the normal has length 1
};

/// One light, seen as a few points. All receivers aim at the same points, so that the error of so
/// few is smooth over a surface, where chance would make it speckled.
class LightSource {
 public:
  LightSource(const Lamp& lamp);
  LightSource(const Portal& portal, const Sky& sky);
  /// Triangles that glow. \param radiance what they send out, on both sides
  LightSource(const Mesh& mesh, std::span<const std::uint32_t> triangles, Vec3f radiance);

  /// Is it far enough from a receiver, for its size, that a few points stand for it? Else what it
  /// sends is found by rays in all directions. Lamps always are.
  bool aimed_at(Vec3f from) const;
  /// Could it matter? No: less than `least` irradiance, or behind the receiver.
  bool reaches(const Receiver& receiver, float least) const;

  /// From a ball round it; >= 0.
  float distance(Vec3f from) const;

  struct Aim {
    Ray ray;           ///< to one of its points
    Vec3f irradiance;  ///< that reaches the receiver if nothing lies on the ray
  };
  std::size_t points() const noexcept { return points_.size(); }
  /// If all of the first few are blocked, the rest is taken to be.
  std::size_t first_few() const noexcept { return first_few_; }
  Aim aim(const Receiver& receiver, std::size_t point) const;
  Blockers blockers() const noexcept {
    return kind_ == Kind::kLamp ? Blockers::kNotGlowing : Blockers::kAll;
  }
  /// Does a ray to the sky leave through this portal? Never for other kinds.
  bool crossed_by(Vec3f origin, Vec3f direction) const;

 private:
  enum class Kind : std::uint8_t { kLamp, kPortal, kGlow };
  struct Point {
    Vec3f position, normal;
    float area = 0;
  };

  Kind kind_;
  Vec3f middle_;
  float radius_ = 0;  ///< of a ball round it all
  Vec3f strength_;    ///< lamp: irradiance at 1 m; glow: radiance
  float most_ = 0;    ///< luminance of irradiance at 1 m, at most
  Portal portal_;
  Sky sky_;
  std::vector<Point> points_;
  std::size_t first_few_ = 0;
};

}  // namespace enfilade::mesh::light
