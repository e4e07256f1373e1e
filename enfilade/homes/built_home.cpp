#include "enfilade/homes/built_home.h"

#include <utility>

#include "enfilade/graph/build.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::homes {
namespace {

mesh::Mesh inside_of(const mesh::Mesh& whole) {
  mesh::Mesh inside;
  inside.positions = whole.positions;
  inside.materials.resize(1);
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    const std::uint32_t object = whole.triangle_object[t];
    if (object == mesh::kNoObject || whole.objects[object].region < 0) continue;
    inside.triangles.push_back(whole.triangles[t]);
    inside.triangle_material.push_back(0);
  }
  return inside;
}

}  // namespace

BuiltHome build_home(const PlanOptions& options, Surfaces surfaces) {
  BuiltHome built{make_home(options, surfaces), nullptr};
  built.tracer =
      std::make_shared<mesh::RayTracer>(std::make_shared<const mesh::Mesh>(built.home.mesh));
  return built;
}

scan::Connectivity build_graph(const BuiltHome& built, const std::string& scan, int threads) {
  const mesh::WalkableFloor floor(inside_of(built.home.mesh));
  auto viewpoints = graph::place_viewpoints(*built.tracer, floor);
  // Beds and tables are floor to a mesh, but nobody gets there.
  std::erase_if(viewpoints, [&](const graph::PlacedViewpoint& v) {
    const auto cell = floor.below(to_float(v.eye));
    return !cell || floor.cells()[*cell].area != 0;
  });
  return graph::connect_viewpoints(*built.tracer, floor, viewpoints, scan, {}, threads);
}

}  // namespace enfilade::homes
