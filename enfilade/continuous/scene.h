/// \file  One building as eyes see it: its surfaces with their colours and light.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

#include "enfilade/core/progress.h"
#include "enfilade/mesh/lighting.h"
#include "enfilade/mesh/read_mesh.h"

namespace enfilade::continuous {

namespace pixels {
struct SceneParts;
}

/// How a mesh without light is drawn.
enum class Style : std::uint8_t {
  /// A material's factor is linear, as glTF has it: it multiplies linear light.
  kPlain,
  /// As Habitat-Sim without lights. A factor multiplies the texture's bytes, so 0.5 is shown as
  /// 128, not as 188. Materials neither shine nor reflect. Textures are averaged as bytes over the
  /// longer side of the pixel on them, as OpenGL does. Triangles are drawn from their front alone,
  /// double-sided materials too; rays still meet their backs.
  kHabitat,
};
constexpr std::array<std::string_view, 2> names_of(Style /*enum*/) { return {"plain", "habitat"}; }

/// How finely light is kept.
struct SceneOptions {
  double light_spacing = 0.05;  ///< metres between values on surfaces, [0.005, 10]
  float exposure = 0;           ///< stops, added to the mesh's own (LitMesh::key()).
  /// Materials that reflect a smaller share are matt and a little whiter instead: a reflection
  /// costs a ray and a second lookup. [0, 1]; 0: all reflect.
  float least_mirror = 0.3F;
  int threads = 0;  ///< 0: all cores; does not change the result
};

/// All that pictures of a building need. Immutable: any number of eyes and threads share one. Takes
/// about 500 bytes a triangle, and 4 for each value of light.
class Scene {
 public:
  /// A photographed mesh: textures and colours are shown unchanged, and black where there is no
  /// surface.
  /// \throws ArgumentError for a null tracer
  static std::shared_ptr<const Scene> photographed(std::shared_ptr<const mesh::RayTracer> tracer,
                                                   Style style = Style::kPlain);
  /// A mesh with light, sun and sky. The light is computed here for points of a grid on each
  /// surface, and interpolated between them.
  /// \param light of the same tracer
  /// \throws ArgumentError for options out of range, a null tracer, or another mesh's light
  static std::shared_ptr<const Scene> lit(std::shared_ptr<const mesh::RayTracer> tracer,
                                          const mesh::LitMesh& light,
                                          const SceneOptions& options = {},
                                          const Progress& progress = {});
  /// A lit scene with light written by save().
  /// \throws FileError naming the file
  /// \throws InvalidInput if it is not such a file, is of another version or mesh, truncated or
  /// changed
  static std::shared_ptr<const Scene> load(std::shared_ptr<const mesh::RayTracer> tracer,
                                           const std::filesystem::path& file);
  /// Writes the light, so that it need not be computed again. \throws FileError; ArgumentError for
  /// a photographed scene, which has none
  void save(const std::filesystem::path& file) const;

  /// The scene of a mesh file, read by mesh::read_mesh(). Lit if its light was saved beside it
  /// (light_file()), photographed if not.
  /// \throws as read_mesh(), RayTracer, load()
  static std::shared_ptr<const Scene> open(const std::filesystem::path& mesh_file,
                                           const mesh::ReadOptions& options = {});

  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  const mesh::RayTracer& tracer() const noexcept;
  /// The light of a lit scene, for mesh::with_vertex_light() of its mesh. To be used while this
  /// lives. \throws ArgumentError for a photographed scene, which has none
  mesh::SurfaceLight surface_light() const;
  /// Memory beside the tracer's, bytes.
  std::size_t bytes() const noexcept;

  /// For this library.
  const pixels::SceneParts& parts() const noexcept { return *parts_; }

 private:
  explicit Scene(std::unique_ptr<pixels::SceneParts> parts);
  std::unique_ptr<pixels::SceneParts> parts_;
};

/// Where the light of a mesh file is saved: beside it, "home0001.glb" -> "home0001.light".
std::filesystem::path light_file(const std::filesystem::path& mesh_file);

}  // namespace enfilade::continuous
