/// \file  A rectangle with sides along the axes, and its four sides.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace enfilade {

/// A side of a Rect, named by the direction that it faces outwards.
enum class Side : std::uint8_t { kPlusX, kPlusY, kMinusX, kMinusY };

/// All sides, counter-clockwise from +x as seen from above.
inline constexpr std::array kSides{Side::kPlusX, Side::kPlusY, Side::kMinusX, Side::kMinusY};

/// Its place in kSides.
constexpr std::size_t index(Side side) { return static_cast<std::size_t>(side); }
/// The side across the rectangle.
constexpr Side opposite(Side side) { return kSides[(index(side) + 2) % kSides.size()]; }
/// Whether the side faces +x or -x.
constexpr bool faces_x(Side side) { return side == Side::kPlusX || side == Side::kMinusX; }
/// Whether the side runs along x, that is, faces +y or -y.
constexpr bool runs_along_x(Side side) { return !faces_x(side); }
/// Whether the side faces +x or +y, so that it has the higher coordinate.
constexpr bool is_high(Side side) { return side == Side::kPlusX || side == Side::kPlusY; }

/// [x0, x1] x [y0, y1], metres; in the world frame where nothing else is said.
struct Rect {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double width() const { return x1 - x0; }           ///< along x, metres
  double depth() const { return y1 - y0; }           ///< along y, metres
  double area() const { return width() * depth(); }  ///< m2
  /// Whether the point lies in it or on its sides.
  bool contains(double x, double y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
  /// Where the side is: x of a side that faces +x or -x, y of the others.
  double at(Side side) const { return std::array{x1, y1, x0, y0}[index(side)]; }
  /// Its ends along x, {x0, x1}, or along y, {y0, y1}.
  std::pair<double, double> range(bool along_x) const {
    return along_x ? std::pair{x0, x1} : std::pair{y0, y1};
  }
  /// Its length along x or along y, metres.
  double length(bool along_x) const { return along_x ? width() : depth(); }
};

/// The rectangle that spans [u0, u1] along x (`along_x`) or y, and [n0, n1] along the other axis.
constexpr Rect laid_rect(bool along_x, double u0, double u1, double n0, double n1) {
  return along_x ? Rect{u0, n0, u1, n1} : Rect{n0, u0, n1, u1};
}

}  // namespace enfilade
