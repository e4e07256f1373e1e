/// \file  Computes the light at the points of a light mesh.
#pragma once
#include <memory>
#include <vector>

#include "enfilade/mesh/light/light_mesh.h"
#include "enfilade/mesh/light/surfaces.h"
#include "enfilade/mesh/lighting.h"

namespace enfilade::mesh::light {

struct BakedLight {
  LightMesh mesh;
  /// Irradiance over pi by light point, without sunlight, for which rays are traced when drawing.
  std::vector<Vec3f> light;
  float key = 1;  ///< LitMesh::key()
};

/// \pre options are in range
BakedLight bake(const RayTracer& tracer, const Surfaces& surfaces, const Lights& lights,
                const BakeOptions& options, const Progress& progress);

}  // namespace enfilade::mesh::light
