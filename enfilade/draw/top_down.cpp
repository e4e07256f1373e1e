#include "enfilade/draw/top_down.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "enfilade/core/errors.h"
#include "enfilade/draw/markup.h"

namespace enfilade::draw {

namespace {

using mesh::FloorPolygon;
using mesh::FloorPolygons;

constexpr double kBin = 0.25;                 // metres of height
constexpr double kLeastApart = 1.8;           // metres between storeys
constexpr double kLeastAreaShare = 1.0 / 12;  // of the floor, at one height
constexpr double kMargin = 24, kHead = 30, kTextLine = 18, kFoot = 58;  // pixels
constexpr double kUsualPixels = 1000;

Vec3d corner_of(const FloorPolygons& floor, const FloorPolygon& polygon, std::size_t k) {
  const mesh::PolygonCorner& c = floor.corners[polygon.corners[k]];
  return {floor.low.x + floor.cell * c[0], floor.low.y + floor.cell * c[1],
          floor.low.z + floor.level * c[2]};
}

double area_of(const FloorPolygons& floor, const FloorPolygon& polygon) {
  const Vec3d a = corner_of(floor, polygon, 0);
  double twice = 0;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    twice += cross(corner_of(floor, polygon, k - 1) - a, corner_of(floor, polygon, k) - a).z;
  }
  return std::abs(twice) / 2;
}

double height_of(const FloorPolygons& floor, const FloorPolygon& polygon) {
  double sum = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) sum += corner_of(floor, polygon, k).z;
  return sum / static_cast<double>(polygon.size());
}

std::size_t nearest_level(const std::vector<double>& levels, double z) {
  std::size_t best = 0;
  for (std::size_t l = 1; l < levels.size(); ++l) {
    if (std::abs(levels[l] - z) < std::abs(levels[best] - z)) best = l;
  }
  return best;
}

// From light to dark as time passes.
struct Hue {
  std::array<int, 3> light, dark;

  std::string at(double late) const {
    const auto part = [&](std::size_t c) {
      return static_cast<int>(std::lround(light[c] + late * (dark[c] - light[c])));
    };
    return fmt::format("rgb({},{},{})", part(0), part(1), part(2));
  }
};

// Blue, green, purple and grey, which also differ in brightness at the end.
const Hue& hue_of(std::size_t agent) {
  static const std::array<Hue, 4> kHues{{{{90, 150, 230}, {10, 40, 110}},
                                         {{110, 200, 150}, {0, 100, 60}},
                                         {{200, 150, 220}, {110, 20, 120}},
                                         {{170, 170, 170}, {40, 40, 40}}}};
  return kHues[agent % kHues.size()];
}

void check_line(const WalkedLine& line) {
  if (line.points.empty()) throw ArgumentError("lines: one without a point");
  for (const Vec3d p : line.points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      throw ArgumentError("lines: a point that is not finite");
    }
  }
}

// Words a line, so that a note is as wide as the picture.
std::vector<std::string> wrapped(const std::string& text, double pixels) {
  const auto most = static_cast<std::size_t>(std::max(20.0, pixels / 7));
  std::vector<std::string> lines;
  std::string line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (!line.empty() && line.size() + 1 + word.size() > most) {
      lines.push_back(std::move(line));
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    at = end + 1;
  }
  if (!line.empty()) lines.push_back(std::move(line));
  return lines;
}

class Map {
 public:
  Map(const FloorPolygons& floor, const std::vector<WalkedLine>& lines,
      const TopDownOptions& options)
      : floor_(floor), lines_(lines), options_(options), levels_(find_floor_levels(floor)) {
    low_ = {std::numeric_limits<double>::max(), std::numeric_limits<double>::max(), 0};
    high_ = -low_;
    for (const FloorPolygon& p : floor.polygons) {
      for (std::size_t k = 0; k < p.size(); ++k) include(corner_of(floor, p, k));
    }
    for (const WalkedLine& line : lines) {
      for (const Vec3d p : line.points) include(p);
    }
    const double across = high_.x - low_.x, tall = high_.y - low_.y;
    scale_ = std::clamp(kUsualPixels / std::max(across, tall), 4.0, 120.0);
    panel_width_ = across * scale_;
    panel_height_ = tall * scale_;
    width_ = std::max(2 * kMargin + panel_width_, 420.0);
    note_ = wrapped(options.note, width_ - 2 * kMargin);
    top_ = kMargin + (options.title.empty() ? 0 : kHead) +
           kTextLine * static_cast<double>(note_.size());
  }

  std::string draw() {
    const double legend = kTextLine * static_cast<double>(lines_.size());
    const double height =
        top_ + static_cast<double>(levels_.size()) * (panel_height_ + kHead) + kFoot + legend;
    text_ = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
        "width=\"{0:.0f}\" "
        "height=\"{1:.0f}\" font-family=\"sans-serif\" font-size=\"13\">\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"#fbfaf8\"/>\n",
        width_, height);
    draw_head();
    for (std::size_t l = 0; l < levels_.size(); ++l) draw_panel(l);
    draw_foot(top_ + static_cast<double>(levels_.size()) * (panel_height_ + kHead) + 20);
    return text_ + "</svg>\n";
  }

 private:
  void include(Vec3d p) {
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y), 0};
    high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y), 0};
  }

  double x(Vec3d p) const { return kMargin + (p.x - low_.x) * scale_; }
  double y(Vec3d p, std::size_t level) const {
    return top_ + static_cast<double>(level) * (panel_height_ + kHead) + kHead +
           (high_.y - p.y) * scale_;
  }

  void draw_head() {
    double at = kMargin;
    if (!options_.title.empty()) {
      text_ += fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"18\" fill=\"#222\">{}</text>\n",
                           kMargin, at + 12, escape(options_.title));
      at += kHead;
    }
    for (const std::string& line : note_) {
      text_ += fmt::format("<text x=\"{}\" y=\"{}\" fill=\"#444\">{}</text>\n", kMargin, at + 6,
                           escape(line));
      at += kTextLine;
    }
  }

  void draw_panel(std::size_t level) {
    if (levels_.size() > 1) {
      text_ += fmt::format("<text x=\"{}\" y=\"{:.0f}\" fill=\"#666\">floor at {:.2f} m</text>\n",
                           kMargin, y({0, high_.y, 0}, level) - 10, levels_[level]);
    }
    text_ += "<g fill=\"#dcd6c9\" stroke=\"#dcd6c9\" stroke-width=\"0.5\">\n";
    for (const FloorPolygon& p : floor_.polygons) {
      if (nearest_level(levels_, height_of(floor_, p)) != level) continue;
      text_ += "<polygon points=\"";
      for (std::size_t k = 0; k < p.size(); ++k) {
        const Vec3d c = corner_of(floor_, p, k);
        text_ += fmt::format("{:.1f},{:.1f} ", x(c), y(c, level));
      }
      text_ += "\"/>\n";
    }
    text_ += "</g>\n";
    for (const WalkedLine& line : lines_) {
      if (line.role == PathRole::kReference) draw_reference(line, level);
    }
    std::size_t agents = 0;
    for (const WalkedLine& line : lines_) {
      if (line.role == PathRole::kAgent) draw_agent(line, hue_of(agents++), level);
    }
  }

  bool on(Vec3d p, std::size_t level) const { return nearest_level(levels_, p.z) == level; }

  void segment(Vec3d a, Vec3d b, std::size_t level, const std::string& style) {
    text_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n",
                         x(a), y(a, level), x(b), y(b, level), style);
  }

  void draw_reference(const WalkedLine& line, std::size_t level) {
    for (std::size_t k = 1; k < line.points.size(); ++k) {
      if (!on(line.points[k - 1], level) && !on(line.points[k], level)) continue;
      segment(line.points[k - 1], line.points[k], level,
              "stroke=\"#e8a33d\" stroke-width=\"9\" stroke-linecap=\"round\" opacity=\"0.55\"");
    }
    const Vec3d end = line.points.back();
    if (!on(end, level)) return;
    text_ += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"none\" stroke=\"#b8721b\" "
        "stroke-dasharray=\"5 4\"/>\n<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"6\" "
        "fill=\"#b8721b\"/>\n",
        x(end), y(end, level), options_.success_distance * scale_, x(end), y(end, level));
  }

  void draw_agent(const WalkedLine& line, const Hue& hue, std::size_t level) {
    const std::size_t n = line.points.size();
    for (std::size_t k = 1; k < n; ++k) {
      if (!on(line.points[k - 1], level) && !on(line.points[k], level)) continue;
      const double late = static_cast<double>(k) / static_cast<double>(n);
      segment(
          line.points[k - 1], line.points[k], level,
          fmt::format("stroke=\"{}\" stroke-width=\"2.5\" stroke-linecap=\"round\"", hue.at(late)));
    }
    if (on(line.points.front(), level)) {
      text_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>\n",
                           x(line.points.front()), y(line.points.front(), level), hue.at(0));
    }
    if (on(line.points.back(), level)) {
      text_ += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"7\" fill=\"none\" stroke=\"{}\" "
          "stroke-width=\"2.5\"/>\n",
          x(line.points.back()), y(line.points.back(), level), hue.at(1));
    }
  }

  void draw_foot(double at) {
    const double metres = scale_ * 5 < width_ / 2 ? 5 : 1;
    text_ += fmt::format(
        "<line x1=\"{0}\" y1=\"{1:.0f}\" x2=\"{2:.1f}\" y2=\"{1:.0f}\" stroke=\"#444\" "
        "stroke-width=\"2\"/>\n<text x=\"{3:.1f}\" y=\"{4:.0f}\" fill=\"#444\">{5:.0f} m</text>\n",
        kMargin, at, kMargin + metres * scale_, kMargin + metres * scale_ + 8, at + 4, metres);
    std::size_t agents = 0;
    for (const WalkedLine& line : lines_) {
      at += kTextLine;
      const bool reference = line.role == PathRole::kReference;
      text_ += fmt::format(
          "<line x1=\"{0}\" y1=\"{1:.0f}\" x2=\"{2}\" y2=\"{1:.0f}\" stroke=\"{3}\" "
          "stroke-width=\"{4}\"/>\n<text x=\"{5}\" y=\"{6:.0f}\" fill=\"#222\">{7}</text>\n",
          kMargin, at, kMargin + 28, reference ? "#e8a33d" : hue_of(agents++).at(0.6),
          reference ? 9 : 2.5, kMargin + 38, at + 4,
          escape(!line.label.empty() ? line.label
                 : reference         ? "reference path"
                                     : "agent"));
    }
  }

  const FloorPolygons& floor_;
  const std::vector<WalkedLine>& lines_;
  const TopDownOptions& options_;
  std::vector<double> levels_;
  Vec3d low_, high_;
  double scale_ = 1, panel_width_ = 0, panel_height_ = 0, width_ = 0, top_ = 0;
  std::vector<std::string> note_;
  std::string text_;
};

}  // namespace

std::vector<Vec3d> walked_points(std::span<const Vec3f> positions) {
  std::vector<Vec3d> points;
  for (const Vec3f& p : positions) {
    if (points.empty() || points.back() != to_double(p)) points.push_back(to_double(p));
  }
  return points;
}

std::vector<double> find_floor_levels(const FloorPolygons& floor) {
  if (floor.polygons.empty()) throw ArgumentError("floor: has no polygon");
  const auto bins = static_cast<std::size_t>((floor.high.z - floor.low.z) / kBin) + 2;
  std::vector<double> areas(bins, 0);
  double all = 0;
  for (const FloorPolygon& p : floor.polygons) {
    const double area = area_of(floor, p);
    const double bin = (height_of(floor, p) - floor.low.z) / kBin;
    areas[std::min(bins - 1, static_cast<std::size_t>(std::max(0.0, bin + 0.5)))] += area;
    all += area;
  }
  std::vector<double> levels;
  while (true) {
    std::size_t best = bins;
    for (std::size_t b = 0; b < bins; ++b) {
      const double z = floor.low.z + kBin * static_cast<double>(b);
      const bool apart = std::ranges::all_of(
          levels, [&](double level) { return std::abs(level - z) >= kLeastApart; });
      if (apart && (best == bins || areas[b] > areas[best])) best = b;
    }
    if (best == bins || (!levels.empty() && areas[best] < kLeastAreaShare * all)) break;
    levels.push_back(floor.low.z + kBin * static_cast<double>(best));
  }
  std::ranges::sort(levels);
  return levels;
}

std::string top_down_svg(const FloorPolygons& floor, const std::vector<WalkedLine>& lines,
                         const TopDownOptions& options) {
  for (const WalkedLine& line : lines) check_line(line);
  check_range("success_distance", options.success_distance, 0, 1e6);
  return Map(floor, lines, options).draw();
}

}  // namespace enfilade::draw
