/// \file  Light sources of a mesh, and the light on its surfaces, computed once for all pictures.
/// It may be kept in the colours of corners, for viewers that compute no light.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::mesh {

/// The sky. Radiances are relative: 1 is about a white sheet in a well-lit room.
struct Sky {
  Vec3f zenith{3.0F, 4.0F, 5.5F};
  Vec3f horizon{5.0F, 5.2F, 5.4F};
  Vec3f ground{1.2F, 1.1F, 1.0F};  ///< below the horizon where there is no mesh
};
/// Light from one direction.
struct Sun {
  Vec3f towards{0.4F, -0.5F, 0.76F};  ///< direction from the ground to the sun, any length
  Vec3f irradiance;                   ///< on a surface facing it; 0: no sun
  /// Radians: half the angle that its disc fills, at most 0.5. LitMesh::look() gives shadows soft
  /// edges by it; 0: sharp ones.
  float radius = 0;
};
/// A spherical light source, invisible itself. Give the lamp's shade an emission: emissive surfaces
/// do not block the light of lamps.
struct Lamp {
  Vec3f position;
  Vec3f power;          ///< irradiance at a distance of 1 m
  float radius = 0.1F;  ///< metres; softness of its shadows
};
/// An opening to the sky that is sampled explicitly: corner and edges of a parallelogram. Reduces
/// noise, adds no light: the same sky shines through the mesh's holes without it.
struct Portal {
  Vec3f corner, edge0, edge1;
};

/// Radiance of the sky in a direction. \param towards of length 1
Vec3f sky_radiance(const Sky& sky, Vec3f towards);

/// All that lights a scene.
struct Lights {
  Sky sky;
  Sun sun;
  std::vector<Lamp> lamps;
  std::vector<Portal> portals;
  /// Radiance of ambient light, which is weaker near surfaces. For rooms that would be dark.
  Vec3f ambient;
};

/// How finely light is computed.
struct BakeOptions {
  double spacing = 0.3;     ///< metres between points at which light is computed; > 0
  float detail = 1.0F / 6;  ///< smallest spacing at shadow edges, as a share of `spacing`; (0, 1]
  std::uint32_t rays = 64;  ///< from a point, for all bounces
  std::uint32_t bounces = 2;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all cores
};

/// Into how many parts the sun's disc is divided for soft shadows.
inline constexpr std::size_t kSunParts = 16;

/// A point of a triangle, on one of its sides.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  ///< as Hit's
  bool back = false;   ///< the side from which its corners are clockwise
};

/// A mesh with its light. Indirect light and lamps are computed at points on all surfaces and
/// interpolated; sunlight by one shadow ray for each point seen. Immutable; any thread. The number
/// of threads does not change the result.
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
  /// Radiance that arrives at each ray's origin: of the lit surface, one reflection in mirrors, or
  /// the sky. Shadow rays go to kSunParts parts of the sun's disc in turn, four to its four
  /// quarters. So the mean over neighbouring rays has soft edges. In these edges, a ray's result
  /// depends on its place in `rays`.
  /// \pre sizes are equal
  /// \param spread angle between neighbouring rays, radians: textures are averaged over it
  void look(std::span<const Ray> rays, std::span<Vec3f> radiance, float spread = 0) const;
  /// look() along rays whose hits are known. \pre sizes are equal
  void look(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3f> radiance,
            float spread = 0) const;
  /// The light on points of surfaces, sunlight included: irradiance / pi, that is the radiance
  /// which a white matt surface has there. The sun is a point, whatever its radius. \pre sizes are
  /// equal
  void light(std::span<const SurfacePoint> points, std::span<Vec3f> radiance) const;
  /// Luminance that pictures of this mesh should show as mid-grey: the median of indoor surfaces
  /// without ceilings (of all surfaces if none is indoors).
  float key() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Light for meshes without light sources: a soft sky, ambient light (closed rooms would be dark),
/// no sun, and the mesh's emissive surfaces.
Lights studio_lights(const Mesh& mesh);

/// How finely light is kept.
struct VertexLightOptions {
  double least_edge = 0.12;  ///< metres: shorter edges are not cut; > 0
  double most_edge = 1.5;    ///< metres: longer ones in rooms are cut; >= least_edge.
  /// An edge is cut if the light at its middle differs from its ends' mean by more than this share
  /// of a screen's range. (0, 1]
  float tolerance = 0.04F;
  std::size_t most_triangles = 250'000;  ///< at this number no edge is cut any more
  int threads = 0;                       ///< 0: all cores; does not change the result
};

/// A mesh without light sources that looks lit. Its `colours` are the light on the front of each
/// surface times LitMesh's exposure. So texture times colour is the linear radiance that
/// image::shoulder() takes.
///
/// Triangles are cut at middles of edges until light can be interpolated between corners. An edge
/// that two triangles share is cut in both or in none. Surfaces that shine have a colour of their
/// own and no texture. Mirrors are grey, as their image depends on the position of the eye. There
/// are two objects: 0 "building", and 1 "surroundings", the surfaces that belong to no room. A mesh
/// without rooms is all building. In the surroundings, edges below four times `most_edge` are not
/// cut. There are no normals. Deterministic.
/// \throws ArgumentError for options out of range
Mesh with_vertex_light(const LitMesh& light, const VertexLightOptions& options = {});

/// The light on a mesh, from wherever it is kept.
struct SurfaceLight {
  /// LitMesh::light() times `exposure`. Spans have equal sizes. Called by several threads at once.
  std::function<void(std::span<const SurfacePoint>, std::span<Vec3f>)> at;
  float exposure = 1;  ///< of surfaces that shine, too; light of 0.18 times 1 / it is mid-grey
};
/// The same of a mesh with that light. \throws ArgumentError also without SurfaceLight::at
Mesh with_vertex_light(const Mesh& mesh, const SurfaceLight& light,
                       const VertexLightOptions& options = {});

}  // namespace enfilade::mesh
