/// \file  The part of the floor in view from a point of it, as if rims were walls. Triangular
/// expansion (Bungiu et al., "Efficient computation of visibility polygons", 2014) over the convex
/// polygons of a navigation mesh.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/continuous/navigation_mesh.h"

namespace enfilade::continuous::detail {

/// A point seen from above; the height does not count.
struct Flat {
  double x = 0, y = 0;

  friend constexpr Flat operator-(Flat a, Flat b) { return {a.x - b.x, a.y - b.y}; }
};
constexpr double turn(Flat a, Flat b) { return a.x * b.y - a.y * b.x; }
inline double norm(Flat a) { return std::hypot(a.x, a.y); }
constexpr Flat flat(Vec3f p) { return {p.x, p.y}; }

/// The polygons in metres, all counter-clockwise, and which polygons each corner belongs to.
class FlatFloor {
 public:
  static constexpr std::uint32_t kRim = 0xffffffffU;
  struct PolygonSide {
    std::uint32_t corner = 0;     ///< where it begins
    std::uint32_t beyond = kRim;  ///< the polygon there
  };

  explicit FlatFloor(const NavigationMesh& mesh);

  std::size_t polygons() const { return first_side_.size() - 1; }
  std::span<const PolygonSide> sides(std::uint32_t polygon) const {
    return std::span(sides_).subspan(first_side_[polygon],
                                     first_side_[polygon + 1] - first_side_[polygon]);
  }
  std::span<const Vec3d> corners() const { return corners_; }  ///< with heights
  Flat corner(std::uint32_t c) const { return {corners_[c].x, corners_[c].y}; }
  /// The polygons that have a corner. Ascending.
  std::span<const std::uint32_t> around(std::uint32_t corner) const {
    return std::span(around_).subspan(first_around_[corner],
                                      first_around_[corner + 1] - first_around_[corner]);
  }

 private:
  std::vector<Vec3d> corners_;
  std::vector<PolygonSide> sides_;
  std::vector<std::uint32_t> first_side_, around_, first_around_;
};

/// The directions in which a polygon is seen: between two points of the side it is seen through,
/// relative to the eye, clockwise first. Everything, in the eye's own polygon.
struct Cone {
  Flat right, left;
  bool everything = false;

  /// Whether a point, relative to the eye, is in it, or less than kSlack metres aside.
  bool holds(Flat to) const {
    return everything ||
           (turn(right, to) >= -kSlack * norm(right) && turn(to, left) >= -kSlack * norm(left));
  }
  /// Points on a rim are seen along it, in spite of rounding to single precision.
  static constexpr double kSlack = 1e-4;
};

/// Whether a point is on the border between a and b, or less than Cone::kSlack from it.
inline bool on_side(Flat point, Flat a, Flat b) {
  const Flat along = b - a, to = point - a;
  const double length = norm(along);
  const double share = (to.x * along.x + to.y * along.y) / (length * length);
  const double nearest = std::clamp(share, 0.0, 1.0);
  return norm({to.x - nearest * along.x, to.y - nearest * along.y}) <= Cone::kSlack;
}

/// Calls visit(polygon, cone) for each polygon that is seen, with the directions in which it is. A
/// polygon that is seen on both sides of a hole, or that the eye is on the border of, is visited
/// more than once.
template <class Visit>
class FloorSight {
 public:
  FloorSight(const FlatFloor& floor, Flat eye, const Visit& visit)
      : floor_(floor), eye_(eye), visit_(visit) {}

  /// From a point of a polygon, which may be on its border.
  void look_from(std::uint32_t polygon) {
    look_here(polygon);
    const auto sides = floor_.sides(polygon);
    for (std::size_t k = 0; k < sides.size(); ++k) {
      const Flat a = floor_.corner(sides[k].corner);
      const Flat b = floor_.corner(sides[k + 1 == sides.size() ? 0 : k + 1].corner);
      if (norm(a - eye_) <= Cone::kSlack) {
        for (const std::uint32_t other : floor_.around(sides[k].corner)) {
          if (other != polygon) look_here(other);
        }
      } else if (sides[k].beyond != kRim && norm(b - eye_) > Cone::kSlack && on_side(eye_, a, b)) {
        look_here(sides[k].beyond);
      }
    }
  }
  /// From a corner of the floor.
  void look_around(std::uint32_t corner) {
    for (const std::uint32_t polygon : floor_.around(corner)) look_here(polygon);
  }

 private:
  static constexpr std::uint32_t kRim = FlatFloor::kRim;

  void look_here(std::uint32_t polygon) {
    visit_(polygon, Cone{.right = {}, .left = {}, .everything = true});
    const auto sides = floor_.sides(polygon);
    for (std::size_t k = 0; k < sides.size(); ++k) {
      if (sides[k].beyond == kRim) continue;
      const FlatFloor::PolygonSide& next = sides[k + 1 == sides.size() ? 0 : k + 1];
      const Flat right = floor_.corner(sides[k].corner) - eye_;
      const Flat left = floor_.corner(next.corner) - eye_;
      if (turn(right, left) > 0) look_through(sides[k].beyond, polygon, next.corner, right, left);
    }
  }

  // Through the side that ends at `entered` in the polygon `from`, where it begins in this one.
  void look_through(std::uint32_t polygon, std::uint32_t from, std::uint32_t entered, Flat right,
                    Flat left) {
    visit_(polygon, Cone{right, left});
    const auto sides = floor_.sides(polygon);
    for (std::size_t k = 0; k < sides.size(); ++k) {
      const FlatFloor::PolygonSide& side = sides[k];
      if (side.beyond == kRim || (side.beyond == from && side.corner == entered)) continue;
      const FlatFloor::PolygonSide& next = sides[k + 1 == sides.size() ? 0 : k + 1];
      const Flat a = floor_.corner(side.corner) - eye_, b = floor_.corner(next.corner) - eye_;
      const Flat narrow_right = turn(right, a) > 0 ? a : right;
      const Flat narrow_left = turn(b, left) > 0 ? b : left;
      if (turn(narrow_right, narrow_left) > 0 && turn(a, b) > 0) {
        look_through(side.beyond, polygon, next.corner, narrow_right, narrow_left);
      }
    }
  }

  const FlatFloor& floor_;
  Flat eye_;
  const Visit& visit_;
};

}  // namespace enfilade::continuous::detail
