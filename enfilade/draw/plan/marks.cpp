#include "enfilade/draw/plan/marks.h"

#include <cmath>

#include "enfilade/draw/markup.h"

#include "enfilade/geometry/angle.h"

namespace enfilade::draw::plan {

std::string circle(Point p, double radius, std::string_view attributes) {
  return fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {}/>\n", number(p.x), number(p.y),
                     number(radius), attributes);
}

std::string dot(Point p) {
  return circle(p, 3.4, "fill=\"#4b5563\" stroke=\"#fff\" stroke-width=\"1\"");
}

std::string isolated_mark(Point p) {
  return fmt::format(
      "<path d=\"M{}l8,8m0,-8l-8,8\" stroke=\"#4b5563\" stroke-width=\"2\" fill=\"none\"/>\n",
      pair(p - Point{4, 4}));
}

std::string excluded_mark(Point p) {
  return circle(p, 3, "fill=\"#fff\" stroke=\"#b3b8c0\" stroke-width=\"1.3\"");
}

std::string stairs_mark(Point p, bool up) {
  return fmt::format(
      "<g transform=\"translate({})\"><rect x=\"-7\" y=\"-7\" width=\"14\" height=\"14\" rx=\"4\" "
      "fill=\"#4b5563\" stroke=\"#fff\" stroke-width=\"1.2\"/><path d=\"{}\" fill=\"#fff\"/></g>\n",
      pair(p), up ? "M0,-4.4l4.4,7.6h-8.8z" : "M0,4.4l4.4,-7.6h-8.8z");
}

std::string start_mark(Point p) {
  return circle(p, 8.5,
                fmt::format("fill=\"{}\" stroke=\"#fff\" stroke-width=\"2\"", hex(kGreen))) +
         fmt::format("<path d=\"M{}l7,4l-7,4z\" fill=\"#fff\"/>\n", pair(p + Point{-2.6, -4}));
}

std::string goal_mark(Point p) {
  constexpr double kOuter = 10.5, kInner = 4.6;
  std::string path;
  for (int i = 0; i < 10; ++i) {
    const double radius = i % 2 == 0 ? kOuter : kInner;
    const double angle = i * kPi / 5;
    path += (i == 0 ? "M" : "L") + pair(p + radius * Point{std::sin(angle), -std::cos(angle)});
  }
  return fmt::format(
      "<path d=\"{}Z\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1.5\" "
      "stroke-linejoin=\"round\"/>\n",
      path, hex(kYellow), kInk);
}

std::string seen_mark(Point p) {
  return fmt::format(
      "<rect x=\"{}\" y=\"{}\" width=\"13\" height=\"13\" rx=\"2.5\" fill=\"{}\" stroke=\"{}\" "
      "stroke-width=\"1.5\"/>\n",
      number(p.x - 6.5), number(p.y - 6.5), hex(kYellow), kInk);
}

std::string turning_mark(Point p) {
  return fmt::format(
      "<path d=\"M{}l9,9l-9,9l-9,-9Z\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1.5\" "
      "stroke-linejoin=\"round\"/>\n",
      pair(p - Point{0, 9}), hex(kYellow), kInk);
}

std::string region_floor(Point p, double radius) {
  return circle(p, radius, fmt::format("fill=\"{}\" fill-opacity=\"0.55\"", hex(kYellow)));
}

std::string stop_mark(Point p, Colour colour) {
  return circle(p, 13, "fill=\"none\" stroke=\"#fff\" stroke-width=\"5\"") +
         circle(p, 13, fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"3\"", hex(colour)));
}

std::string line_sample(std::string_view attributes) {
  return fmt::format("<path d=\"M-14,0h28\" {}/>", attributes);
}

std::string text(Point p, std::string_view content, double size, const char* colour, bool bold,
                 Anchor anchor) {
  const char* anchors[] = {"", " text-anchor=\"middle\"", " text-anchor=\"end\""};
  return fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\"{}{}>{}</text>\n",
                     number(p.x), number(p.y), number(size), colour,
                     bold ? " font-weight=\"600\"" : "", anchors[static_cast<int>(anchor)],
                     escape(content));
}

}  // namespace enfilade::draw::plan
