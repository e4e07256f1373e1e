#include "enfilade/homes/lit_home.h"

#include <fmt/format.h>

#include "enfilade/core/rng.h"
#include "enfilade/mesh/read_mesh.h"

namespace enfilade::homes {
namespace {

constexpr const char* kFolder = "light";
// Raised when the same options give another mesh, or other light on it.
constexpr int kVersion = 1;
constexpr double kSpacing = 0.5;  // metres between points of light, for corners

}  // namespace

std::filesystem::path home_light_file(std::string_view scan) {
  return std::filesystem::path(kFolder) / fmt::format("{}.light", scan);
}

std::filesystem::path lit_home_file(const HomeEntry& home) {
  const std::string made_from = fmt::format(
      "version {}, seed {}, {}, storeys {}, area {}, {} triangles", kVersion, home.plan.seed,
      home.kind, home.plan.storeys.value_or(0), home.plan.area, home.triangles);
  return std::filesystem::path(kFolder) /
         fmt::format("{}-{:016x}.glb.gz", home.scan, stream_of(made_from.data(), made_from.size()));
}

std::string packed_lit_home(const BuiltHome& built, const mesh::SurfaceLight& light, int threads) {
  return mesh::to_packed_glb(mesh::with_vertex_light(built.home.mesh, light, {.threads = threads}));
}

std::string packed_lit_home(const BuiltHome& built, int threads) {
  mesh::BakeOptions bake = bake_options(HomeLight::kFine, threads);
  bake.spacing = kSpacing;
  const mesh::LitMesh light(built.tracer, built.home.lights, bake);
  return mesh::to_packed_glb(mesh::with_vertex_light(light, {.threads = threads}));
}

}  // namespace enfilade::homes
