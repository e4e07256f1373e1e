/// \file  Shortest ways on a floor: exact on the polygons of a navigation mesh.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/continuous/navigation_mesh.h"

namespace enfilade::continuous {

class Geodesics;

/// Distances to the nearest of some goals, from anywhere. Immutable: any thread; keeps what it
/// needs of the building alive. Queries allocate nothing.
class DistanceField {
 public:
  /// A straight way to begin with, and the whole length.
  struct Way {
    double metres = 0;
    Vec3f next;  ///< where the straight line ends: a goal, or a corner to go around
  };

  /// Metres to the nearest goal; +inf: there is no way.
  double distance(const FloorPoint& from) const;
  /// The beginning of the shortest path; no value if out of reach.
  std::optional<Way> way(const FloorPoint& from) const;

 private:
  friend class Geodesics;
  struct Impl;
  explicit DistanceField(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

/// Shortest paths of one building. A path is straight lines that bend at corners of the rim. Its
/// length is that of these lines in three dimensions, as Habitat measures it. All paths on the
/// polygons are considered, whereas Detour's own search takes the shortest chain of polygons'
/// middles, and shortens that. Corners of the rim count as the arcs that they stand for. Immutable:
/// any thread, shared by all users of the building.
class Geodesics {
 public:
  /// Finds the corners that see each other: milliseconds for a home, about 0.1 s for a large
  /// building.
  explicit Geodesics(std::shared_ptr<const NavigationMesh> mesh);

  const NavigationMesh& mesh() const noexcept;
  std::size_t bends() const noexcept;  ///< corners at which a shortest way can bend

  /// Metres; +inf: there is no way.
  double distance(const FloorPoint& a, const FloorPoint& b) const;
  /// The path, both ends included; no value if out of reach.
  std::optional<std::vector<Vec3f>> path(const FloorPoint& a, const FloorPoint& b) const;
  /// For many queries with the same goals. \throws ArgumentError for no goal
  DistanceField field(std::span<const FloorPoint> goals) const;
  DistanceField field(const FloorPoint& goal) const { return field(std::span(&goal, 1)); }

 private:
  friend class DistanceField;
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace enfilade::continuous
