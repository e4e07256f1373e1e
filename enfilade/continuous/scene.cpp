#include "enfilade/continuous/scene.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "enfilade/continuous/pixels/scene_parts.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/tone.h"

namespace enfilade::continuous {

using pixels::SceneParts;
using pixels::ToneTable;

Scene::Scene(std::unique_ptr<SceneParts> parts) : parts_(std::move(parts)) {}
Scene::~Scene() = default;

std::shared_ptr<const Scene> Scene::photographed(std::shared_ptr<const mesh::RayTracer> tracer) {
  if (tracer == nullptr) throw ArgumentError("tracer: none");
  return std::shared_ptr<const Scene>(new Scene(std::make_unique<SceneParts>(
      std::move(tracer), ToneTable::Curve::kPlain, SceneOptions().least_mirror)));
}

std::shared_ptr<const Scene> Scene::lit(std::shared_ptr<const mesh::RayTracer> tracer,
                                        const mesh::LitMesh& light, const SceneOptions& options,
                                        const Progress& progress) {
  if (tracer == nullptr) throw ArgumentError("tracer: none");
  if (tracer.get() != &light.tracer()) throw ArgumentError("light: of another tracer");
  constexpr double kFinest = 0.005, kCoarsest = 10;
  if (!(options.light_spacing >= kFinest && options.light_spacing <= kCoarsest)) {
    throw ArgumentError(fmt::format("light_spacing: {}, not in [{}, {}] metres",
                                    options.light_spacing, kFinest, kCoarsest));
  }
  if (!std::isfinite(options.exposure)) {
    throw ArgumentError(fmt::format("exposure: {}, not finite", options.exposure));
  }
  if (!(options.least_mirror >= 0 && options.least_mirror <= 1)) {
    throw ArgumentError(fmt::format("least_mirror: {}, not in [0, 1]", options.least_mirror));
  }
  auto parts = std::make_unique<SceneParts>(std::move(tracer), ToneTable::Curve::kShoulder,
                                            options.least_mirror);
  parts->lit = true;
  parts->scale = image::kMidGrey<float> / light.key() * std::exp2(options.exposure);
  parts->sky = light.lights().sky;
  pixels::apply_scale(*parts);
  pixels::bake_light(light, options, progress, *parts);
  return std::shared_ptr<const Scene>(new Scene(std::move(parts)));
}

std::shared_ptr<const Scene> Scene::open(const std::filesystem::path& mesh_file,
                                         const mesh::ReadOptions& options) {
  auto tracer = std::make_shared<const mesh::RayTracer>(
      std::make_shared<const mesh::Mesh>(mesh::read_mesh(mesh_file, options).mesh));
  const std::filesystem::path light = light_file(mesh_file);
  return file_exists(light) ? load(std::move(tracer), light) : photographed(std::move(tracer));
}

std::filesystem::path light_file(const std::filesystem::path& mesh_file) {
  return std::filesystem::path(mesh_file).replace_extension(".light");
}

const mesh::RayTracer& Scene::tracer() const noexcept { return *parts_->tracer; }
bool Scene::is_lit() const noexcept { return parts_->lit; }

std::size_t Scene::bytes() const noexcept {
  const SceneParts& p = *parts_;
  return p.surfaces.all.capacity() * sizeof(pixels::Surface) + 4 * p.surfaces.light.capacity() +
         p.surfaces.textures.bytes() + p.tree.nodes.capacity() * sizeof(pixels::Tree::Node) +
         p.tree.bundles.capacity() * sizeof(pixels::Bundle) + sizeof(SceneParts);
}

}  // namespace enfilade::continuous
