/// \file  A rectangle with sides along the axes.
#pragma once

namespace enfilade {

/// [x0, x1] x [y0, y1], metres.
struct Rect {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double width() const { return x1 - x0; }
  double depth() const { return y1 - y0; }
  double area() const { return width() * depth(); }
  /// Whether the point lies in it or on its sides.
  bool contains(double x, double y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
};

}  // namespace enfilade
