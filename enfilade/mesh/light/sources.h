/// \file  Light sources that are sampled explicitly: lamps, portals, emissive surfaces.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/mesh/lighting.h"

namespace enfilade::mesh::light {

/// A surface point that receives light.
struct Receiver {
  Vec3f position, normal;  ///< the normal has length 1
};

/// One light, sampled at a few points. These are the same for all receivers, so that their error is
/// smooth over a surface; random points would give noise.
class LightSource {
 public:
  LightSource(const Lamp& lamp);
  LightSource(const Portal& portal, const Sky& sky);
  /// Emissive triangles. \param radiance emitted on both sides
  LightSource(const Mesh& mesh, std::span<const std::uint32_t> triangles, Vec3f radiance);

  /// Whether it is far enough from a receiver, for its size, to be sampled at a few points. Else
  /// its light is found by rays in all directions. Always true for lamps.
  bool aimed_at(Vec3f from) const;
  /// False if it gives less than `least` irradiance or is behind the receiver.
  bool reaches(const Receiver& receiver, float least) const;

  /// Distance from its bounding sphere; >= 0.
  float distance(Vec3f from) const;

  struct Aim {
    Ray ray;           ///< to one of its points
    Vec3f irradiance;  ///< at the receiver, if the ray is not blocked
  };
  std::size_t points() const noexcept { return points_.size(); }
  /// If the first few samples are all blocked, the others are assumed to be.
  std::size_t first_few() const noexcept { return first_few_; }
  Aim aim(const Receiver& receiver, std::size_t point) const;
  Blockers blockers() const noexcept {
    return kind_ == Kind::kLamp ? Blockers::kNotGlowing : Blockers::kAll;
  }
  /// Whether a ray to the sky passes through this portal; false for other kinds.
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
