/// \file  Pieces of SVG for floor plans.
#pragma once
#include <fmt/format.h>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace enfilade::draw::plan {

/// A point on the sheet, or a vector: pixels, y down.
struct Point {
  double x = 0, y = 0;

  friend constexpr Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
  friend constexpr Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
  friend constexpr Point operator*(double k, Point a) { return {k * a.x, k * a.y}; }
};

/// "12.3,45": coordinates to a tenth of a pixel.
std::string pair(Point p);
std::string number(double value);

/// Estimated width of a text in sans-serif at `size` pixels, on the large side, as the font is the
/// viewer's.
double text_width(std::string_view text, double size);

/// Lines of at most `width` pixels (as text_width() has it), broken at blanks; longer words stay
/// whole. Empty text: no line.
std::vector<std::string> wrap(std::string_view text, double size, double width);

template <class... Args>
void append(std::string& out, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
}

}  // namespace enfilade::draw::plan
