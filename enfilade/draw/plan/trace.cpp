#include "enfilade/draw/plan/trace.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "enfilade/draw/markup.h"
#include "enfilade/geometry/angle.h"

namespace enfilade::draw::plan {
namespace {

constexpr double kCorner = 11;       // pixels of a step's end that are rounded
constexpr double kArrow = 5.5;       // half the length of an arrowhead
constexpr double kShortArrow = 16;   // steps of fewer pixels get none
constexpr double kWidestLanes = 22;  // pixels that all uses of an edge share on one side

// A step on the sheet, moved to its side and cut short where another one joins it.
struct Stroke {
  Point start, end;    // of the straight part
  Point node;          // the viewpoint at the end
  Point along, right;  // unit vectors; zero for a step straight up or down
  double side = 0;
  double time = 0;  // 0 .. 1, first to last step of the path
  bool between = false;
  bool joined = false;  // the next stroke goes on from here
};

std::vector<Stroke> strokes(const StoreyPlan& plan, const Panel& panel,
                            const std::vector<Step>& steps) {
  std::vector<Stroke> found;
  bool touched = false;  // the step before was drawn here too
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto& [from, to, side] = steps[i];
    const bool touches = plan.touches(panel.storey, from, to);
    if (touches) {
      Stroke s;
      const Point a = panel.at(plan.graph.position(from));
      s.node = panel.at(plan.graph.position(to));
      const double length = std::hypot(s.node.x - a.x, s.node.y - a.y);
      if (length > 0.5) s.along = (1 / length) * (s.node - a);
      s.right = {-s.along.y, s.along.x};
      s.side = side;
      const double cut = std::min(kCorner, 0.35 * length);
      const bool goes_on = i + 1 < steps.size() && plan.touches(panel.storey, to, steps[i + 1].to);
      s.start = a + side * s.right + (touched ? cut : 0) * s.along;
      s.end = s.node + side * s.right - (goes_on ? cut : 0) * s.along;
      s.time =
          steps.size() < 2 ? 1 : static_cast<double>(i) / static_cast<double>(steps.size() - 1);
      s.between = plan.between_storeys(from, to);
      s.joined = goes_on;
      found.push_back(s);
    }
    touched = touches;
  }
  return found;
}

// The straight part, and the bend that leads to the next stroke.
std::string outline(const std::vector<Stroke>& strokes, std::size_t i) {
  const Stroke& s = strokes[i];
  std::string path = "M" + pair(s.start) + "L" + pair(s.end);
  if (!s.joined) return path;
  const Stroke& next = strokes[i + 1];
  const double straightness = s.along.x * next.along.x + s.along.y * next.along.y;
  if (straightness < -0.9) {  // about turn: a loop whose outer end is 3 pixels past the viewpoint
    const double back = (s.node.x - s.end.x) * s.along.x + (s.node.y - s.end.y) * s.along.y;
    const Point beyond = (4.0 / 3) * (back + 3) * s.along;
    return path + "C" + pair(s.end + beyond) + " " + pair(next.start + beyond) + " " +
           pair(next.start);
  }
  const Point corner = s.node + 0.5 * (s.side * s.right + next.side * next.right);
  return path + "Q" + pair(corner) + " " + pair(next.start);
}

std::string arrow(const Stroke& s, Colour colour) {
  const double length = std::hypot(s.end.x - s.start.x, s.end.y - s.start.y);
  if (length < kShortArrow) return "";
  const Point middle = 0.5 * (s.start + s.end) + 0.5 * kArrow * s.along;
  return fmt::format("<path d=\"M{}L{}L{}Z\" fill=\"{}\" stroke=\"#fff\" stroke-width=\"0.8\"/>\n",
                     pair(middle + kArrow * s.along),
                     pair(middle - kArrow * s.along + kArrow * s.right),
                     pair(middle - kArrow * s.along - kArrow * s.right), hex(colour));
}

}  // namespace

std::string hex(Colour c) { return fmt::format("#{:02x}{:02x}{:02x}", c.red, c.green, c.blue); }

Colour mix(Colour a, Colour b, double share) {
  const auto blend = [share](int from, int to) {
    return static_cast<int>(std::lround(from + share * (to - from)));
  };
  return {blend(a.red, b.red), blend(a.green, b.green), blend(a.blue, b.blue)};
}

std::vector<std::vector<Step>> lanes(const std::vector<std::vector<ViewpointIndex>>& paths,
                                     double spacing) {
  std::map<std::pair<ViewpointIndex, ViewpointIndex>, int> uses;  // of an edge, either way
  std::vector<std::vector<Step>> found(paths.size());
  for (std::size_t p = 0; p < paths.size(); ++p) {
    for (std::size_t i = 1; i < paths[p].size(); ++i) {
      const ViewpointIndex from = paths[p][i - 1], to = paths[p][i];
      if (from == to) continue;
      ++uses[std::minmax(from, to)];
      found[p].push_back({from, to, 0});
    }
  }
  std::map<std::pair<ViewpointIndex, ViewpointIndex>, int> before;  // the same way
  for (auto& steps : found) {
    for (auto& [from, to, side] : steps) {
      const int lane = before[{from, to}]++;
      const int all = uses[std::minmax(from, to)];
      if (all > 1) side = (lane + 0.5) * std::min(spacing, kWidestLanes / all);
    }
  }
  return found;
}

std::string draw_band(const StoreyPlan& plan, const Panel& panel, const std::vector<Step>& steps,
                      Colour colour) {
  const std::vector<Stroke> all = strokes(plan, panel, steps);
  if (all.empty()) return "";
  // The group is translucent, not its strokes, so that overlaps do not get darker.
  std::string out = fmt::format(
      "<g fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\" "
      "stroke-linejoin=\"round\" opacity=\"0.4\">\n",
      hex(colour), kBandWidth);
  for (std::size_t i = 0; i < all.size(); ++i) {
    append(out, "<path d=\"{}\"/>\n", outline(all, i));
  }
  return out + "</g>\n";
}

std::string draw_line(const StoreyPlan& plan, const Panel& panel, const std::vector<Step>& steps,
                      Colour colour) {
  const std::vector<Stroke> all = strokes(plan, panel, steps);
  if (all.empty()) return "";
  std::string casing, lines, arrows;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::string path = outline(all, i);
    const Colour shade = all[i].time < 0.5
                             ? mix(mix(colour, {255, 255, 255}, 0.4), colour, 2 * all[i].time)
                             : mix(colour, {0, 0, 0}, 0.6 * (all[i].time - 0.5));
    append(casing, "<path d=\"{}\"/>\n", path);
    append(lines, "<path d=\"{}\" stroke=\"{}\"{}/>\n", path, hex(shade),
           all[i].between ? " stroke-dasharray=\"6 5\" stroke-linecap=\"butt\"" : "");
    arrows += arrow(all[i], shade);
  }
  return fmt::format(
      "<g fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n"
      "<g stroke=\"#fff\" stroke-width=\"{}\">\n{}</g>\n<g stroke-width=\"{}\">\n{}</g>\n</g>\n{}",
      kLineWidth + 2, casing, kLineWidth, lines, arrows);
}

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
