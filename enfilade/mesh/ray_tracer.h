/// \file  Where rays meet a mesh (Embree).
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

struct Ray {
  Vec3f origin;
  Vec3f direction;  ///< any length but 0; distances are in its units
  float near = 0;   ///< [near, far]: where to look
  float far = std::numeric_limits<float>::infinity();
};

struct Hit {
  float distance = std::numeric_limits<float>::infinity();  ///< infinity: nothing was met
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  ///< point = (1 - u - v) corner0 + u corner1 + v corner2
  explicit operator bool() const { return distance < std::numeric_limits<float>::infinity(); }
};

/// What stops a ray in blocked().
enum class Blockers : std::uint8_t {
  kAll,
  kNotGlowing,  ///< materials with emission let rays through: a lamp's shade round its bulb
};

/// A search tree over a mesh. Immutable; any thread may trace. Surfaces with cut-outs let rays
/// through where there is nothing. Owns the mesh with others.
class RayTracer {
 public:
  /// Builds the tree on all cores. \throws InvalidInput for what check() calls an error; Error with
  /// Embree's words if it fails (memory)
  explicit RayTracer(std::shared_ptr<const Mesh> mesh);
  ~RayTracer();
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  const Mesh& mesh() const noexcept;
  const std::shared_ptr<const Mesh>& shared_mesh() const noexcept;

  /// The first surface that each ray meets; \pre hits.size() == rays.size(). Neighbouring rays that
  /// lie close together are traced in packets. On the calling thread.
  void trace(std::span<const Ray> rays, std::span<Hit> hits) const;
  Hit trace(const Ray& ray) const;
  /// 1 where anything lies on the ray within [near, far]. \pre sizes are equal
  void blocked(std::span<const Ray> rays, std::span<std::uint8_t> out,
               Blockers blockers = Blockers::kAll) const;
  bool blocked(const Ray& ray) const;
  /// Is the straight line between two points free? Surfaces less than `slack` metres from either
  /// end do not count.
  bool sees(Vec3f a, Vec3f b, float slack = 1e-3F) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::mesh
