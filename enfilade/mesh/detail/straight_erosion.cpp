#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "enfilade/mesh/detail/floor_field.h"

namespace enfilade::mesh::detail {

namespace {

// Where the nearest cell that is not floor lies, in cells.
struct Offset {
  std::int16_t x = 0, y = 0;
  bool known = false;

  int squared() const { return known ? x * x + y * y : std::numeric_limits<int>::max(); }
};

// Recast's directions: west, north, east, south; a diagonal is one and the next.
constexpr std::array<int, 4> kX{-1, 0, 1, 0}, kY{0, 1, 0, -1};

// Passes on, from cell to cell, which one that is not floor is nearest: four sweeps (Danielsson
// 1980, "Euclidean distance mapping"), along the steps that the body can take. Off by a fraction of
// a cell at most.
class NearestWalls {
 public:
  explicit NearestWalls(const Field& field) : field_(field), offsets_(field.spans()) {
    for (std::uint32_t s = 0; s < field.spans(); ++s) {
      if (field.walkable(s)) start(s);
    }
    const std::uint32_t count = field.spans();
    // Spans are in the order of rows, and in a row from west to east.
    for (std::uint32_t s = 0; s < count; ++s) take(s, {0, 3}, {3, 3});
    for (std::uint32_t s = count; s-- > 0;) take(s, {2, 1}, {1, 0});
    for (std::uint32_t s = 0; s < count; ++s) take(s, {0, 3}, {3, 2});
    for (std::uint32_t s = count; s-- > 0;) take(s, {2, 1}, {0, 1});
  }

  double cells_away(std::uint32_t span) const {
    return std::sqrt(static_cast<double>(offsets_[span].squared()));
  }

 private:
  void start(std::uint32_t s) {
    for (int d = 0; d < 4; ++d) {
      const int e = (d + 1) & 3;
      const std::uint32_t next = field_.step(s, d);
      if (next == kNoSpan) {
        offer(s, {at(kX, d), at(kY, d), true});
      } else if (field_.step(next, e) == kNoSpan) {
        offer(s, {static_cast<std::int16_t>(at(kX, d) + at(kX, e)),
                  static_cast<std::int16_t>(at(kY, d) + at(kY, e)), true});
      }
    }
  }

  // From two straight neighbours, and from the diagonal ones that follow these directions.
  void take(std::uint32_t s, std::array<int, 2> straight, std::array<int, 2> diagonal) {
    if (!field_.walkable(s)) return;
    for (const int d : straight) take_from(s, field_.step(s, d), at(kX, d), at(kY, d));
    for (const int d : diagonal) {
      const int e = (d + 1) & 3;
      const std::uint32_t side = field_.step(s, d);
      if (side == kNoSpan) continue;
      take_from(s, field_.step(side, e), static_cast<std::int16_t>(at(kX, d) + at(kX, e)),
                static_cast<std::int16_t>(at(kY, d) + at(kY, e)));
    }
  }

  void take_from(std::uint32_t s, std::uint32_t other, std::int16_t x, std::int16_t y) {
    if (other == kNoSpan || !offsets_[other].known) return;
    offer(s, {static_cast<std::int16_t>(offsets_[other].x + x),
              static_cast<std::int16_t>(offsets_[other].y + y), true});
  }

  void offer(std::uint32_t s, Offset offset) {
    if (offset.squared() < offsets_[s].squared()) offsets_[s] = offset;
  }

  static std::int16_t at(const std::array<int, 4>& list, int d) {
    return static_cast<std::int16_t>(list[static_cast<std::size_t>(d)]);
  }

  const Field& field_;
  std::vector<Offset> offsets_;
};

}  // namespace

// What is in a cell, on average, begins at its middle: a thing is drawn into every cell that it
// touches.
void Field::erode_straight(const WalkableOptions& options) {
  const NearestWalls walls(*this);
  const double least = options.body.radius / options.cell;
  for (std::uint32_t s = 0; s < spans(); ++s) {
    if (walkable(s) && walls.cells_away(s) < least) close(s);
  }
  require_room(options.body.radius);
}

}  // namespace enfilade::mesh::detail
