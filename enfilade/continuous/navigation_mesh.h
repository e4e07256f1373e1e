/// \file  The floor of a building as a navigation mesh (Detour).
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/floor_polygons.h"

namespace enfilade::continuous {

/// A point of the floor.
struct FloorPoint {
  Vec3f point;                ///< world, metres
  std::uint32_t polygon = 0;  ///< of the navigation mesh that it lies on
  /// Where it was looked for. Habitat's paths and steps begin there; ours begin at `point`.
  Vec3f asked = {};
};

/// Search radius of nearest().
struct Reach {
  float aside = 0.5F;     ///< metres along x and y
  float above_below = 1;  ///< metres
};

/// End of one move along a straight line.
struct Walked {
  FloorPoint end;
  bool at_wall = false;  ///< it did not come to where the line ends
};

/// Behaviour of a body that hits a wall.
enum class Walls : std::uint8_t {
  kSlide,  ///< it slides to the nearest point that it can reach: VLN-CE on R2R
  kStop,   ///< it stops there: RxR-CE
};

/// Scratch memory of walk(). One thread at a time; any navigation mesh.
class Walker {
 public:
  Walker();
  ~Walker();
  Walker(Walker&&) noexcept;
  Walker& operator=(Walker&&) noexcept;

 private:
  friend class NavigationMesh;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The walkable floor of one building, for one body: convex polygons and their heights. Immutable:
/// any thread, shared by all users of the building. Results depend on arguments only.
class NavigationMesh {
 public:
  /// \throws InvalidInput for polygons that do not fit together (check_polygons())
  explicit NavigationMesh(mesh::FloorPolygons floor);
  ~NavigationMesh();
  NavigationMesh(const NavigationMesh&) = delete;
  NavigationMesh& operator=(const NavigationMesh&) = delete;

  const mesh::FloorPolygons& floor() const noexcept;
  std::size_t areas() const noexcept;      ///< connected parts, ranked as mesh::WalkableFloor's
  double area_m2(std::size_t area) const;  ///< seen from above. \pre area < areas()
  Vec3f corner(std::size_t corner) const;  ///< with its exact height. \pre it is one

  /// The point of the floor that is nearest to any point; none within reach: no value.
  std::optional<FloorPoint> nearest(Vec3f point, Reach reach = {}) const;
  /// The floor's height at a point that is over a polygon, or at its rim.
  float height(const FloorPoint& at) const;
  /// A point drawn uniformly, seen from above, from one connected part or from all.
  /// \pre area < areas()
  FloorPoint random_point(Rng& rng, std::optional<std::uint32_t> area = {}) const;
  /// Moves straight towards a point, whose height does not count. Allocates nothing.
  Walked walk(Walker& walker, const FloorPoint& from, Vec3f towards,
              Walls walls = Walls::kSlide) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Faults of polygons that cannot be a floor: indices out of range, one-sided neighbours, corners
/// in no order, heights of other polygons. `file` is the name in messages.
std::vector<Diagnostic> check_polygons(const mesh::FloorPolygons& floor, const std::string& file);

/// A file that load_navigation_mesh() reads back equal: a line of text with its type, the numbers
/// (little-endian), a checksum.
/// \throws FileError
void save_navigation_mesh(const mesh::FloorPolygons& floor, const std::filesystem::path& file);
/// \throws FileError; InvalidInput: `not-a-navigation-mesh`, `other-version`, `truncated`,
/// `damaged` (the checksum), and what check_polygons() finds
mesh::FloorPolygons load_navigation_mesh(const std::filesystem::path& file);
/// The same of a file in memory. \param name  for messages
mesh::FloorPolygons parse_navigation_mesh(std::span<const std::uint8_t> bytes,
                                          const std::string& name);

}  // namespace enfilade::continuous
