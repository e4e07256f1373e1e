/// \file  Walking distances over floor cells, and the rooms that narrow passages part. Internal.
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "enfilade/mesh/walkable.h"

namespace enfilade::graph::detail {

/// How far each cell is from the nearest of some cells, on foot.
class WalkingDistances {
 public:
  explicit WalkingDistances(const mesh::WalkableFloor& floor)
      : floor_(floor), metres_(floor.cells().size(), kFar) {}

  /// Adds one more cell; searches no further than `limit` metres.
  void add(std::uint32_t cell, double limit);
  double operator[](std::size_t cell) const { return metres_[cell]; }

  static constexpr double kFar = std::numeric_limits<double>::infinity();

 private:
  const mesh::WalkableFloor& floor_;
  std::vector<double> metres_;
};

/// The easiest path from any of `from` to any of `to`, cell by cell, ends included; it keeps away
/// from walls where there is room. Empty if there is none.
std::vector<std::uint32_t> find_way(const mesh::WalkableFloor& floor,
                                    const std::vector<std::uint32_t>& from,
                                    const std::vector<std::uint32_t>& to);

/// The pocket of each cell, numbered by their first cell. A pocket is large enough to be a room,
/// and only a passage narrower than 1.1 m joins it to the rest.
struct Pockets {
  std::vector<std::uint32_t> of;
  std::uint32_t count = 0;
};
Pockets find_pockets(const mesh::WalkableFloor& floor);

}  // namespace enfilade::graph::detail
