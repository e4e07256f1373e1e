/// \file  Pictures of meshes from any place, drawn in batches.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/continuous/photographs.h"
#include "enfilade/continuous/scene.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/render/renderer.h"

namespace enfilade::continuous {

/// Place and direction of view.
struct MeshView {
  std::size_t building = 0;  ///< among the scenes
  Vec3d eye;                 ///< metres, world frame; within 10,000 km of the origin
  Radians heading;
  Radians elevation;  ///< [-pi/2, pi/2], up positive
  Radians roll{};     ///< about the line of sight, clockwise as seen by the eye
};

/// What is drawn of a scene, metres along the optical axis. A surface nearer than `near` hides
/// nothing.
struct DepthRange {
  float near = 0, far = std::numeric_limits<float>::infinity();
};

/// How the surface that a pixel shows is found.
enum class Method : std::uint8_t {
  kRaster,  ///< triangles are drawn, near ones first, with vector instructions
  kRays,    ///< a ray a pixel (Embree); equirectangular pictures are always drawn so
  kPlain,   ///< as kRaster to the bit, one pixel after another: slow; the reference
};
constexpr std::array<std::string_view, 3> names_of(Method /*enum*/) {
  return {"raster", "rays", "plain"};
}

/// How pictures are drawn.
struct EyesConfig {
  Method method = Method::kRaster;
  int threads = 0;  ///< 0: all cores; does not change the pictures.
  /// By building: panoramas that give a pixel its colour if they show its point; empty, or null for
  /// a building: the mesh's own colours.
  std::vector<std::shared_ptr<const Photographs>> photographs = {};
};

/// Source of colours.
enum class Appearance : std::uint8_t {
  kMesh,       ///< the mesh
  kPanoramas,  ///< EyesConfig::photographs, and the mesh where none sees
};
constexpr std::array<std::string_view, 2> names_of(Appearance /*enum*/) {
  return {"mesh", "panoramas"};
}

/// Draws batches of views of some buildings. Depth, class and instance are those at the pixel's
/// middle, and so is colour, of textures averaged over the pixel. May be used by one thread at a
/// time; several may be used at once, also of the same scenes.
class Eyes {
 public:
  /// \throws ArgumentError for no scene, a null one, threads below 0, or photographs of another
  /// number of buildings or of another scene
  explicit Eyes(std::vector<std::shared_ptr<const Scene>> buildings, const EyesConfig& config = {});
  ~Eyes();
  Eyes(const Eyes&) = delete;
  Eyes& operator=(const Eyes&) = delete;

  /// Fills the outputs. The same view gives the same bytes in any batch, with any number of
  /// threads. Agents with several cameras call it once for each. Allocates nothing after the first
  /// call with the camera and the batch size. With several threads, oneTBB still allocates its
  /// tasks. Arguments are checked before anything is drawn.
  /// \throws ArgumentError for an invalid camera or one above 8192 pixels, a stream, or outputs as
  /// render::validate()
  /// \throws ArgumentError naming the position of a view with an unknown building, or numbers that
  /// are not finite or out of range
  /// \throws ArgumentError unless 0 <= range.near < range.far
  /// \throws as Photographs::load_all()
  void render(const Camera& camera, std::span<const MeshView> views, const render::Outputs& outputs,
              const DepthRange& range = {});
  /// The same for equirectangular pictures (height, width). The middle column is at the view's
  /// heading, the middle row at the horizon, the top row up; elevation and roll are ignored. Depth
  /// is along the ray in any measure.
  void render_equirectangular(std::uint32_t width, std::uint32_t height,
                              std::span<const MeshView> views, const render::Outputs& outputs);

  /// "raster (AVX3, 2 threads)"
  std::string description() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Opens the scene of a building. Its users say from which threads they call it.
using SceneSource = std::function<std::shared_ptr<const Scene>(const std::string& scan)>;

/// Eyes per building, made at first use: those of the buildings used last are kept. One thread at a
/// time.
class EyesCache {
 public:
  /// \param most  buildings, up to 60 MB each; 0: all
  EyesCache(SceneSource scene_of, int threads, std::size_t most = 0);

  /// The only building of these eyes is `scan`. Valid until the next call.
  /// \throws as the source; ArgumentError for a null scene
  Eyes& of(const std::string& scan);
  /// Forgets the buildings used longest ago down to `most`, up to one of those in use.
  /// \param in_use  has contains(scan)
  template <class Scans>
  void keep(std::size_t most, const Scans& in_use) {
    while (known_.size() > most && !in_use.contains(known_.back().scan)) known_.pop_back();
  }

 private:
  struct Known {
    Known(std::string name, std::shared_ptr<const Scene> scene, int threads);
    std::string scan;
    Eyes eyes;
  };
  SceneSource scene_of_;
  int threads_;
  std::size_t most_;
  std::list<Known> known_;  // the last one first
};

}  // namespace enfilade::continuous
