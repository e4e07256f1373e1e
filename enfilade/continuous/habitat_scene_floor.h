/// \file  The floor that Habitat-Sim has of a building, in our world frame: for files that
/// Habitat's programs open.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/continuous/navigation_mesh.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::continuous {

/// One of several goals.
struct NearestGoal {
  std::size_t goal = 0;  ///< its place in their list
  double distance = 0;   ///< length of the path to it, metres
};

/// Habitat's navigation mesh of a scene, as Habitat-Sim v0.3.3 makes it: the state behind published
/// results of VLN-CE. Connected parts are called islands, as there. Points are in our world frame
/// (metres, z up), and have the bits of Habitat's. One thread at a time.
/// navigation_mesh.h has the exact floor, and docs/continuous.md the differences.
class HabitatSceneFloor {
 public:
  /// Makes it, in seconds.
  /// \param mesh  as read from the scene's file: the order of its triangles counts
  /// \param up  of the file
  /// \param body  kRoomToRoomBody has Habitat's default settings
  /// \throws InvalidInput `no-floor`; ArgumentError for a body that Habitat's settings do not allow
  static HabitatSceneFloor of_mesh(const mesh::Mesh& mesh, mesh::UpAxis up, const mesh::Body& body);
  /// \param bytes  of a `.navmesh` file  \param name  for messages
  /// \throws InvalidInput for other bytes
  static HabitatSceneFloor of_file(std::span<const std::uint8_t> bytes, const std::string& name);
  ~HabitatSceneFloor();
  HabitatSceneFloor(HabitatSceneFloor&&) noexcept;
  HabitatSceneFloor& operator=(HabitatSceneFloor&&) noexcept;

  /// The bytes of Habitat's `.navmesh` file.
  std::string file() const;

  std::size_t islands() const noexcept;
  /// The island that most of the points lie on; those on none do not count. No value if all do.
  std::optional<int> island_of(std::span<const Vec3f> points) const;
  /// The point of an island nearest to any point; none within reach: no value.
  /// \pre 0 <= island < islands()
  std::optional<Vec3f> nearest(Vec3f point, int island, Reach reach) const;
  /// Length of Habitat's shortest path, metres; +inf: there is none.
  double distance(Vec3f start, Vec3f end) const;
  /// The nearest of several goals, by Habitat's search. No value if none can be reached.
  std::optional<NearestGoal> nearest_goal(Vec3f start, std::span<const Vec3f> goals) const;
  /// The triangles of an island, counter-clockwise or not. \pre 0 <= island < islands()
  std::vector<std::array<Vec3f, 3>> triangles(int island) const;

 private:
  struct Impl;
  explicit HabitatSceneFloor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::continuous
