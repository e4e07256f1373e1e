/// \file  Queries on Habitat-Sim's floor: its PathFinder.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/continuous/habitat/nav_mesh.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::continuous::habitat {

/// All islands.
inline constexpr int kAnyIsland = -1;

/// The nearest wall.
struct Obstacle {
  Vec3f position, normal;  ///< 0 where none is within the radius, or the point is off the floor
  float distance = std::numeric_limits<float>::infinity();  ///< metres; the radius where none is
};

/// A shortest path. Without one: no points, and an infinite length.
struct Path {
  std::vector<Vec3f> points;                              ///< start, corners, end
  float length = std::numeric_limits<float>::infinity();  ///< metres
  bool found() const noexcept { return !points.empty(); }
};

/// Bounds of goals' distances, which later searches from nearby starts use: the state of Habitat's
/// MultiGoalShortestPath. They hold while the goals are the same.
struct GoalBounds {
  std::vector<float> least;  ///< metres; one a goal; empty: nothing is known
  Vec3f start;               ///< of the search before
};
/// The path to the nearest of several goals.
struct GoalPath {
  Path path;
  int goal = -1;  ///< which one; -1: none
};

/// A picture of the floor from above: row by row, a row for each step along z.
template <class T>
struct FloorMap {
  std::size_t rows = 0, columns = 0;
  std::vector<T> values;
};

/// Where a move from one point to another ends.
enum class Moves : std::uint8_t {
  kSlide,  ///< along walls
  kStop,   ///< at the first wall
};

/// Habitat's PathFinder: a navigation mesh and its queries. Every point is projected first: to the
/// nearest polygon within 2 m along x and z, 4 m along y. One thread at a time. Random points come
/// from the C library's generator, which the whole process shares, as in Habitat.
class PathFinder {
 public:
  explicit PathFinder(NavMesh mesh, Navigation navigation = Navigation::kLatest);
  ~PathFinder();
  PathFinder(PathFinder&&) noexcept;
  PathFinder& operator=(PathFinder&&) noexcept;

  const NavMesh& mesh() const noexcept;
  Navigation navigation() const noexcept;

  /// \name Islands: connected parts, in order of their first polygons
  /// @{
  std::size_t islands() const noexcept;
  int island(Vec3f point) const;                  ///< -1: the point is off the floor
  float island_radius(Vec3f point) const;         ///< metres; 0: the point is off the floor
  float island_radius(std::size_t island) const;  ///< \pre island < islands()
  float island_area(std::size_t island) const;    ///< m2. \pre island < islands()
  float area() const noexcept;                    ///< m2, of all
  /// @}

  /// The nearest point of the floor, or of one island of it. NaN: none within reach.
  Vec3f snap(Vec3f point, int island = kAnyIsland) const;
  /// Whether a point is on the floor: at most 1 cm aside, and `most_dy` metres above or below.
  bool is_navigable(Vec3f point, float most_dy = 0.5F) const;
  Obstacle closest_obstacle(Vec3f point, float radius = 2) const;

  /// Detour's path between two points as asked. Not always the shortest one.
  Path path(Vec3f start, Vec3f end) const;
  /// The path to the nearest goal. \param bounds  of earlier calls with the same goals; updated
  GoalPath path(Vec3f start, std::span<const Vec3f> goals, GoalBounds& bounds) const;

  /// Seeds the C library's generator: 0 and 1 are the same.
  static void seed(std::uint32_t seed) noexcept;
  /// A point drawn uniformly. NaN after `most_tries` failures.
  Vec3f random_point(int most_tries = 10, int island = kAnyIsland) const;
  /// The same within a circle, seen from above: other storeys count. NaN: none after `most_tries`.
  Vec3f random_point_near(Vec3f centre, float radius, int most_tries = 100,
                          int island = kAnyIsland) const;

  /// Where a body ends that moves from one point to another. Points of two islands: the start.
  Vec3f step(Vec3f from, Vec3f to, Moves moves) const;

  /// Corners of all triangles, three each, of all islands or one.
  std::vector<Vec3f> vertices(int island = kAnyIsland) const;
  /// Whether the floor is at a height; by all cores. \param eps  metres above or below it
  /// \throws ArgumentError for cells that are not positive, or a map of more than 2^28 cells
  FloorMap<std::uint8_t> topdown(float metres_per_pixel, float height, float eps = 0.5F) const;
  FloorMap<std::int32_t> topdown_islands(float metres_per_pixel, float height,
                                         float eps = 0.5F) const;  ///< -1: none

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::continuous::habitat
