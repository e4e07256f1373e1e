/// \file  Ray tracing of a mesh (Embree).
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// A pixel of a tile of 8 x 8.
struct TilePlace {
  std::uint32_t x, y;
};
/// All of them in Z-order, so that few rays that follow each other lie in a small square.
inline constexpr auto kZOrder = [] {
  std::array<TilePlace, 64> order{};
  for (std::uint32_t k = 0; k < order.size(); ++k) {
    order[k] = {(k & 1U) | (k >> 1U & 2U) | (k >> 2U & 4U),
                (k >> 1U & 1U) | (k >> 2U & 2U) | (k >> 3U & 4U)};
  }
  return order;
}();

/// A half-line, or a piece of it.
struct Ray {
  Vec3f origin;
  Vec3f direction;  ///< not 0; its length is the unit of distances
  float near = 0;   ///< hits are searched in [near, far]
  float far = std::numeric_limits<float>::infinity();
};

/// Where a ray first met the mesh.
struct Hit {
  float distance = std::numeric_limits<float>::infinity();  ///< infinity: no hit
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  ///< point = (1 - u - v) corner0 + u corner1 + v corner2
  explicit operator bool() const { return distance < std::numeric_limits<float>::infinity(); }
};

/// Which surfaces block a ray in blocked().
enum class Blockers : std::uint8_t {
  kAll,
  kNotGlowing,  ///< all but emissive materials, such as a lamp's shade
};

/// A search tree over a mesh. Immutable; any thread may trace. Surfaces with cut-outs are
/// transparent where the alpha test fails. Shares ownership of the mesh.
class RayTracer {
 public:
  /// Builds the tree on all cores. \throws InvalidInput for what check() calls an error; Error with
  /// Embree's message if it fails (memory)
  explicit RayTracer(std::shared_ptr<const Mesh> mesh);
  ~RayTracer();
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  const Mesh& mesh() const noexcept;

  /// The first hit of each ray. Traces neighbouring rays in packets, in the calling thread.
  /// \pre hits.size() == rays.size()
  void trace(std::span<const Ray> rays, std::span<Hit> hits) const;
  Hit trace(const Ray& ray) const;
  /// 1 for each ray that is blocked within [near, far], else 0. \pre sizes are equal
  void blocked(std::span<const Ray> rays, std::span<std::uint8_t> out,
               Blockers blockers = Blockers::kAll) const;
  bool blocked(const Ray& ray) const;
  /// Whether the line between two points is free. Surfaces less than `slack` metres from either end
  /// are ignored.
  bool sees(Vec3f a, Vec3f b, float slack = 1e-3F) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::mesh
