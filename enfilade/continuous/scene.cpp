#include "enfilade/continuous/scene.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <string>
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

std::shared_ptr<const Scene> Scene::photographed(std::shared_ptr<const mesh::RayTracer> tracer,
                                                 Style style) {
  if (tracer == nullptr) throw ArgumentError("tracer: none");
  const bool habitat = style == Style::kHabitat;
  auto parts = std::make_unique<SceneParts>(
      std::move(tracer), habitat ? ToneTable::Curve::kDisplay : ToneTable::Curve::kPlain,
      SceneOptions().least_mirror);
  parts->habitat = habitat;
  return std::shared_ptr<const Scene>(new Scene(std::move(parts)));
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

mesh::SurfaceLight Scene::surface_light() const {
  if (!parts_->lit) throw ArgumentError("a photographed scene has no light");
  const auto at = [&surfaces = parts_->surfaces](std::span<const mesh::SurfacePoint> points,
                                                 std::span<Vec3f> radiance) {
    for (std::size_t k = 0; k < points.size(); ++k) {
      const auto& [triangle, u, v, back] = points[k];
      const pixels::Surface& surface = surfaces.all[triangle];
      const std::array<float, 3> weights{1 - u - v, u, v};
      const unsigned first = surface.first_corner;
      radiance[k] = pixels::light_at(
          surfaces.light.data(), surface, back ? surface.back : surface.front,
          {pixels::share(weights[(first + 1U) % 3]), pixels::share(weights[(first + 2U) % 3])});
    }
  };
  return {at, parts_->scale};
}

std::size_t Scene::bytes() const noexcept {
  const SceneParts& p = *parts_;
  return p.surfaces.all.capacity() * sizeof(pixels::Surface) + 4 * p.surfaces.light.capacity() +
         p.surfaces.textures.bytes() + p.tree.nodes.capacity() * sizeof(pixels::Tree::Node) +
         p.tree.bundles.capacity() * sizeof(pixels::Bundle) + sizeof(SceneParts);
}

namespace {

using pixels::SceneParts;
using pixels::Surface;
using pixels::ToneTable;

constexpr std::uint64_t kMagic = 0x315448474C4E45ULL;  // "ENLGHT1"
constexpr std::uint32_t kVersion = 1;

struct Head {
  std::uint64_t magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint32_t triangles = 0;
  std::uint64_t values = 0;
  std::uint64_t mesh = 0;  ///< fingerprint()
  float scale = 1;
  std::array<float, 9> sky{};  ///< zenith, horizon, ground; scaled
  float least_mirror = 0;
  std::uint32_t reserved = 0;
};
static_assert(sizeof(Head) == 80);
static_assert(std::endian::native == std::endian::little, "files are little-endian");

struct Grid {
  std::uint32_t front = 0, back = 0;
  std::uint16_t cells_u = 0, cells_v = 0;
};
static_assert(sizeof(Grid) == 12);

// Fingerprint of the light's inputs that are quick to hash: positions, triangles, materials'
// emission.
std::uint64_t fingerprint(const mesh::Mesh& mesh) {
  const std::uint64_t a = XXH3_64bits(mesh.positions.data(), mesh.positions.size() * sizeof(Vec3f));
  const std::uint64_t b =
      XXH3_64bits(mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh.triangles[0]));
  std::vector<std::uint64_t> all{a, b};
  for (const mesh::Material& material : mesh.materials) {
    all.push_back(XXH3_64bits(&material.emission, sizeof material.emission));
    all.push_back(XXH3_64bits(&material.colour, sizeof material.colour));
  }
  return XXH3_64bits(all.data(), all.size() * sizeof(all[0]));
}

void append(std::string& to, const void* from, std::size_t bytes) {
  to.append(static_cast<const char*>(from), bytes);
}

[[noreturn]] void fail(const std::filesystem::path& file, const char* code, std::string message) {
  refuse(file.string(), "", code, std::move(message));
}

Head read_head(const std::filesystem::path& file, const std::string& content) {
  Head head;
  if (content.size() < sizeof head + sizeof(std::uint64_t)) {
    fail(file, "truncated",
         fmt::format("{} bytes are too few for a scene's light", content.size()));
  }
  std::memcpy(&head, content.data(), sizeof head);
  if (head.magic != kMagic) fail(file, "not-light", "is not the light of a scene");
  if (head.version != kVersion) {
    fail(file, "version",
         fmt::format("is of version {}; this program reads {}", head.version, kVersion));
  }
  // All surfaces have two values in common; places are numbers of 31 bits.
  if (head.values < 2 || head.values >= std::uint64_t{1} << 31U) {
    fail(file, "bad-grid", fmt::format("has {} values of light, not 2 .. 2^31 - 1", head.values));
  }
  return head;
}

// Whether a side's values lie in the file's.
bool lies_within(std::uint32_t first, const Grid& grid, std::uint64_t values) {
  if (first <= pixels::Surfaces::kWhite) return true;
  return first + (grid.cells_u + std::uint64_t{1}) * (grid.cells_v + std::uint64_t{1}) <= values;
}

void read_body(const std::filesystem::path& file, const std::string& content, const Head& head,
               SceneParts& parts) {
  const std::uint64_t bytes = sizeof head + std::uint64_t{head.triangles} * sizeof(Grid);
  const std::uint64_t rest = content.size() - sizeof(std::uint64_t);
  if (head.values > content.size() || bytes + 4 * head.values != rest) {
    fail(file, "truncated",
         fmt::format("has {} bytes, but its head says {}", content.size(),
                     bytes + 4 * head.values + sizeof(std::uint64_t)));
  }
  std::uint64_t sum = 0;
  std::memcpy(&sum, content.data() + rest, sizeof sum);
  if (sum != XXH3_64bits(content.data(), rest)) fail(file, "checksum", "was changed or damaged");
  if (head.triangles != parts.surfaces.all.size() ||
      head.mesh != fingerprint(parts.tracer->mesh())) {
    fail(file, "other-mesh",
         fmt::format("is the light of another mesh, of {} triangles; this one has {}",
                     head.triangles, parts.surfaces.all.size()));
  }
  const char* from = content.data() + sizeof head;
  for (Surface& surface : parts.surfaces.all) {
    Grid grid;
    std::memcpy(&grid, from, sizeof grid);
    from += sizeof grid;
    if (!lies_within(grid.front, grid, head.values) || !lies_within(grid.back, grid, head.values)) {
      fail(file, "bad-grid", "has a triangle whose light is not in the file");
    }
    surface.front = grid.front;
    surface.back = grid.back;
    surface.cells_u = grid.cells_u;
    surface.cells_v = grid.cells_v;
  }
  parts.surfaces.light.resize(head.values);
  std::memcpy(parts.surfaces.light.data(), from, 4 * head.values);
}

}  // namespace

void Scene::save(const std::filesystem::path& file) const {
  const SceneParts& p = *parts_;
  if (!p.lit) throw ArgumentError("a photographed scene has no light to save");
  Head head;
  head.triangles = static_cast<std::uint32_t>(p.surfaces.all.size());
  head.values = p.surfaces.light.size();
  head.mesh = fingerprint(p.tracer->mesh());
  head.scale = p.scale;
  head.least_mirror = p.least_mirror;
  head.sky = std::bit_cast<std::array<float, 9>>(p.sky);
  std::string content;
  content.reserve(sizeof head + p.surfaces.all.size() * sizeof(Grid) + 4 * head.values + 8);
  append(content, &head, sizeof head);
  for (const Surface& s : p.surfaces.all) {
    const Grid grid{s.front, s.back, s.cells_u, s.cells_v};
    append(content, &grid, sizeof grid);
  }
  append(content, p.surfaces.light.data(), 4 * head.values);
  const std::uint64_t sum = XXH3_64bits(content.data(), content.size());
  append(content, &sum, sizeof sum);
  write_file_atomically(file, content);
}

std::shared_ptr<const Scene> Scene::load(std::shared_ptr<const mesh::RayTracer> tracer,
                                         const std::filesystem::path& file) {
  if (tracer == nullptr) throw ArgumentError("tracer: none");
  const std::string content = read_file(file);
  const Head head = read_head(file, content);
  auto parts = std::make_unique<SceneParts>(std::move(tracer), ToneTable::Curve::kShoulder,
                                            head.least_mirror);
  read_body(file, content, head, *parts);
  parts->lit = true;
  parts->scale = head.scale;
  pixels::apply_scale(*parts);  // of materials; the sky comes next
  parts->sky = std::bit_cast<mesh::Sky>(head.sky);
  return std::shared_ptr<const Scene>(new Scene(std::move(parts)));
}

}  // namespace enfilade::continuous
