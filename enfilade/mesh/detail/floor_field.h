/// \file  The walkable cells of a mesh in Recast's heightfields. Both the floor's cells and its
/// polygons are made from them.
#pragma once
#include <Recast.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "enfilade/mesh/walkable.h"

namespace enfilade::mesh::detail {

using CompactField = std::unique_ptr<rcCompactHeightfield, void (*)(rcCompactHeightfield*)>;

/// No span.
inline constexpr std::uint32_t kNoSpan = std::numeric_limits<std::uint32_t>::max();

/// \throws ArgumentError for options out of range; InvalidInput for what check() calls an error
void check_walkable_input(const Mesh& mesh, const WalkableOptions& options);

/// \throws ArgumentError for more columns or levels than Recast counts
FloorLattice make_lattice(const Mesh& mesh, const WalkableOptions& options);

/// The least cells of `options`, or larger, of which a mesh is not too many columns.
double fitting_cell(const Mesh& mesh, const WalkableOptions& options);

/// Levels that one step of the body climbs.
int climb_of(const WalkableOptions& options, const FloorLattice& lattice);
/// Levels of the body's height.
int headroom_of(const WalkableOptions& options, const FloorLattice& lattice);

/// Spans with their columns, and the steps between them. Walkable are those where the body's centre
/// may be.
class FloorField {
 public:
  /// \param covered which spans have something above them
  FloorField(CompactField spans, std::vector<bool> covered, const FloorLattice& lattice)
      : field_(std::move(spans)), covered_(std::move(covered)), lattice_(lattice) {
    column_.resize(static_cast<std::size_t>(field_->spanCount));
    for (int c = 0; c < field_->width * field_->height; ++c) {
      const std::uint32_t first = field_->cells[c].index, count = field_->cells[c].count;
      std::fill_n(column_.begin() + first, count, c);
    }
  }

  rcCompactHeightfield& recast() { return *field_; }
  /// Removes the span from the floor.
  void close(std::uint32_t span) { field_->areas[span] = RC_NULL_AREA; }
  /// Removes the cells where the body would touch an obstacle, as Recast measures distances: along
  /// rows and diagonals of cells, to whole cells.
  /// \throws InvalidInput (`no-floor`) if none is left; Error if memory is short
  void erode(const WalkableOptions& options);
  /// The same with straight distances to the middles of the cells that are not floor.
  void erode_straight(const WalkableOptions& options);
  /// Distances to the rim, for cell(). \throws Error if memory is short
  void measure_distances();

  std::uint32_t spans() const { return static_cast<std::uint32_t>(field_->spanCount); }
  bool walkable(std::uint32_t span) const { return field_->areas[span] != RC_NULL_AREA; }
  int column(std::uint32_t span) const { return column_[span]; }
  bool covered(std::uint32_t span) const { return covered_[span]; }

  // The span that one step in a direction leads to, if the body may be there.
  std::uint32_t step(std::uint32_t span, int direction) const {
    const int layer = rcGetCon(field_->spans[span], direction);
    if (layer == RC_NOT_CONNECTED) return kNoSpan;
    const int column =
        column_[span] + rcGetDirOffsetX(direction) + rcGetDirOffsetY(direction) * field_->width;
    const std::uint32_t next = field_->cells[column].index + static_cast<std::uint32_t>(layer);
    return walkable(next) ? next : kNoSpan;
  }

  // Visits up to 8: straight ones, and diagonal ones that two straight ones lead to in any order.
  template <class Visit>
  void each_neighbour(std::uint32_t span, const Visit& visit) const {
    for (int d = 0; d < 4; ++d) {
      const std::uint32_t straight = step(span, d);
      if (straight == kNoSpan) continue;
      visit(straight);
      const std::uint32_t corner = step(straight, (d + 1) & 3);
      const std::uint32_t other = step(span, (d + 1) & 3);
      if (corner != kNoSpan && other != kNoSpan && step(other, d) == corner) visit(corner);
    }
  }

  FloorCell cell(std::uint32_t span) const {
    const int x = column_[span] % field_->width, y = column_[span] / field_->width;
    const auto middle = [this](float low, int place) {
      return static_cast<float>(low + (place + 0.5) * lattice_.cell);
    };
    FloorCell cell;
    cell.position = {
        middle(lattice_.box.low.x, x), middle(lattice_.box.low.y, y),
        static_cast<float>(lattice_.box.low.z + field_->spans[span].y * lattice_.level)};
    // Recast's distances are in half cells from the rim's middle, which is half a cell inside.
    cell.covered = covered_[span];
    cell.clearance = static_cast<float>(0.5 * (field_->dist[span] + 1) * lattice_.cell);
    return cell;
  }

 private:
  void require_room(double radius) const;

  CompactField field_;
  std::vector<bool> covered_;
  FloorLattice lattice_;
  std::vector<int> column_;
};

/// Before erosion. \throws InvalidInput (`no-floor`) with the reason; ArgumentError for too many
/// spans; Error if memory is short
FloorField make_field(const Mesh& mesh, const WalkableOptions& options,
                      const FloorLattice& lattice);

/// The rank of the connected part of each span, as WalkableFloor ranks them; kNoSpan where it is
/// left out. \throws InvalidInput (`no-floor`) if all are
std::vector<std::uint32_t> rank_spans(const FloorField& field, const WalkableOptions& options);

}  // namespace enfilade::mesh::detail
