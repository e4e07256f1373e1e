/// \file  Movement over the floor: distances, rooms that narrow passages part, and straight ways.
/// Internal.
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "enfilade/graph/build.h"

namespace enfilade::graph::detail {

/// How far each cell is from the nearest of some cells, on foot.
class WalkingDistances {
 public:
  explicit WalkingDistances(const mesh::WalkableFloor& floor)
      : floor_(floor), metres_(floor.cells().size(), kFar) {}

  /// Adds one more cell; searches no further than `limit` metres. Takes time for these cells alone.
  void add(std::uint32_t cell, double limit);
  double operator[](std::size_t cell) const { return metres_[cell]; }
  /// The cells that are not at kFar, in the order found.
  const std::vector<std::uint32_t>& reached() const noexcept { return reached_; }
  /// Removes all cells, in time for those that were reached.
  void clear();

  static constexpr double kFar = std::numeric_limits<double>::infinity();

 private:
  const mesh::WalkableFloor& floor_;
  std::vector<double> metres_;
  std::vector<std::uint32_t> reached_;
};

/// Finds paths on one floor. A search takes time for the cells that it visits alone.
class WaySearch {
 public:
  explicit WaySearch(const mesh::WalkableFloor& floor)
      : floor_(floor),
        cost_(floor.cells().size(), WalkingDistances::kFar),
        before_(cost_.size()),
        goal_(cost_.size(), 0) {}

  /// The easiest path from any of `from` to any of `to`, cell by cell, ends included; it keeps away
  /// from walls where there is room. Empty if there is none.
  std::vector<std::uint32_t> find(const std::vector<std::uint32_t>& from,
                                  const std::vector<std::uint32_t>& to);

 private:
  std::vector<std::uint32_t> search(const std::vector<std::uint32_t>& from);
  void set(std::uint32_t cell, double cost, std::uint32_t before);

  const mesh::WalkableFloor& floor_;
  std::vector<double> cost_;
  std::vector<std::uint32_t> before_;
  std::vector<char> goal_;
  std::vector<std::uint32_t> visited_;  // cells whose cost is set
};

/// The pocket of each cell, numbered by their first cell. A pocket is large enough to be a room,
/// and only a passage narrower than 1.1 m joins it to the rest.
struct Pockets {
  std::vector<std::uint32_t> of;
  std::uint32_t count = 0;
};
Pockets find_pockets(const mesh::WalkableFloor& floor);

/// Whether a body can move straight from one viewpoint to another, in one mesh. Any thread.
class Passage {
 public:
  /// \throws ArgumentError for options out of range
  Passage(const mesh::RayTracer& tracer, const mesh::WalkableFloor& floor,
          const EdgeOptions& options);

  /// The edge rule: near enough, visible, floor all the way, and room for the body.
  bool is_free(const PlacedViewpoint& a, const PlacedViewpoint& b) const;
  bool in_sight(const PlacedViewpoint& a, const PlacedViewpoint& b) const;

 private:
  std::vector<Vec3d> floor_profile(Vec3d a, Vec3d b) const;
  bool has_room(const std::vector<Vec3d>& way) const;

  const mesh::RayTracer& tracer_;
  const mesh::WalkableFloor& floor_;
  EdgeOptions options_;
};

}  // namespace enfilade::graph::detail
