/// \file  Light in a mesh: what is computed once, before pictures are taken.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::mesh {

/// Radiances are relative: 1 is about a white sheet in a well-lit room.
struct Sky {
  Vec3f zenith{3.0F, 4.0F, 5.5F};
  Vec3f horizon{5.0F, 5.2F, 5.4F};
  Vec3f ground{1.2F, 1.1F, 1.0F};  ///< seen below the horizon where no mesh is
};
struct Sun {
  Vec3f towards{0.4F, -0.5F, 0.76F};  ///< direction from the ground to the sun, any length
  Vec3f irradiance;                   ///< on a surface facing it; 0: no sun
};
/// A glowing ball that casts light and is not itself seen (give the lamp's shade an emission:
/// surfaces that glow do not stop the light of lamps).
struct Lamp {
  Vec3f position;
  Vec3f power;          ///< irradiance that it gives at 1 m
  float radius = 0.1F;  ///< metres; how soft its shadows are
};
/// An opening through which the sky shines in, sampled on purpose: corner and edges of a
/// parallelogram. Only for speed and less noise: the light through it is that of the sky as seen
/// through the mesh's holes, so it may be left out.
struct Portal {
  Vec3f corner, edge0, edge1;
};

struct Lights {
  Sky sky;
  Sun sun;
  std::vector<Lamp> lamps;
  std::vector<Portal> portals;
  /// Radiance of light that comes from no source: of air that glows, so that it is fainter where
  /// surfaces are near. For rooms that would be dark.
  Vec3f ambient;
};

struct BakeOptions {
  double spacing = 0.3;     ///< metres between points at which light is computed; > 0
  float detail = 1.0F / 6;  ///< part of spacing down to which shadows' edges are followed; (0, 1]
  std::uint32_t rays = 64;  ///< from a point, for all bounces
  std::uint32_t bounces = 2;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all cores
};

/// A mesh with its light: indirect light and lamps at points spread over all surfaces, interpolated
/// between; the sun's by a ray for each point that is looked at. Immutable; any thread. The same
/// arguments give the same light on any number of threads.
class LitMesh {
 public:
  /// \throws ArgumentError for options out of range
  LitMesh(std::shared_ptr<const RayTracer> tracer, Lights lights, const BakeOptions& options = {},
          const Progress& progress = {});
  ~LitMesh();
  LitMesh(const LitMesh&) = delete;
  LitMesh& operator=(const LitMesh&) = delete;

  const RayTracer& tracer() const noexcept;
  const Mesh& mesh() const noexcept { return tracer().mesh(); }
  const Lights& lights() const noexcept;
  /// Radiance that comes to each ray's origin against its direction: the surface's colour under its
  /// light, one reflection in mirrors, the sky where nothing is met. \pre sizes are equal
  /// \param spread radians between neighbouring rays: textures are averaged over what lies between
  void look(std::span<const Ray> rays, std::span<Vec3f> radiance, float spread = 0) const;
  /// look() along rays of which it is known what they meet. \pre sizes are equal
  void look(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3f> radiance,
            float spread = 0) const;
  /// Linear value that pictures of this mesh should show as middle grey: the median luminance of
  /// surfaces indoors but for ceilings (of all surfaces if none is indoors).
  float key() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Light for meshes that come with none: a soft sky in every direction, from within too (closed
/// rooms would be dark), no sun, and the mesh's own emissive surfaces.
Lights studio_lights(const Mesh& mesh);

}  // namespace enfilade::mesh
