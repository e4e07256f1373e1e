#include "enfilade/draw/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace enfilade::draw::plan {
namespace {

constexpr double kGap = 28;           // between panels, pixels
constexpr double kMargin = 1.4;       // around a storey, metres
constexpr double kWidest = 1400;      // of a row of panels, pixels
constexpr double kHighest = 1000;     // of all rows
constexpr double kLargestScale = 44;  // small buildings need no more
constexpr double kSmallestScale = 9;  // dots 2.25 m apart would touch

double floor_of(const graph::NavGraph& graph, ViewpointIndex v) {
  return static_cast<double>(graph.position(v).z) - graph.height(v);
}

// World bounds of what is drawn on a storey, and how wide its caption is.
struct Extent {
  double west = std::numeric_limits<double>::infinity();
  double east = -std::numeric_limits<double>::infinity();
  double south = std::numeric_limits<double>::infinity();
  double north = -std::numeric_limits<double>::infinity();
  double caption = 0;  // pixels

  void add(Vec3f p, double radius = kMargin) {
    west = std::min(west, p.x - radius);
    east = std::max(east, p.x + radius);
    south = std::min(south, p.y - radius);
    north = std::max(north, p.y + radius);
  }
};

std::vector<Extent> extents(const StoreyPlan& plan, const std::vector<Disc>& discs) {
  std::vector<Extent> found(plan.storeys.size());
  for (std::size_t i = 0; i < plan.graph.size(); ++i) {
    const std::size_t storey = plan.storey_of[i];
    if (storey != StoreyPlan::kNowhere) found[storey].add(plan.graph.position(ViewpointIndex(i)));
  }
  for (const PlanEdge& edge : plan.edges) {  // the far ends of stairs
    found[plan.storey_of[edge.a.at()]].add(plan.graph.position(edge.b));
    found[plan.storey_of[edge.b.at()]].add(plan.graph.position(edge.a));
  }
  for (const Disc& disc : discs) {
    const std::size_t storey = plan.storey_of[disc.centre.at()];
    if (storey == StoreyPlan::kNowhere) continue;
    found[storey].add(plan.graph.position(disc.centre), disc.radius + 0.2);
  }
  return found;
}

// Storeys of one row share north and south, so that places above each other are at the same height.
PanelLayout arrange_at(const std::vector<Extent>& extents, double scale) {
  PanelLayout layout{{}, scale, {}};
  Point cursor;
  std::size_t first = 0;
  const auto finish_row = [&](std::size_t end) {
    double north = -std::numeric_limits<double>::infinity(), south = -north;
    for (std::size_t s = first; s < end; ++s) {
      north = std::max(north, extents[s].north);
      south = std::min(south, extents[s].south);
    }
    for (std::size_t s = first; s < end; ++s) {
      layout.panels[s].north = north;
      layout.panels[s].size.y = kCaption + scale * (north - south);
    }
    layout.size.x = std::max(layout.size.x, cursor.x - kGap);
    cursor = {0, cursor.y + kCaption + scale * (north - south) + kGap};
    first = end;
  };
  for (std::size_t s = 0; s < extents.size(); ++s) {
    const double width = std::max(scale * (extents[s].east - extents[s].west), extents[s].caption);
    if (cursor.x > 0 && cursor.x + width > kWidest) finish_row(s);
    const double spare = width / scale - (extents[s].east - extents[s].west);
    layout.panels.push_back({s, cursor, {width, 0}, extents[s].west - spare / 2, 0, scale});
    cursor.x += width + kGap;
  }
  if (!extents.empty()) finish_row(extents.size());
  layout.size.y = std::max(0.0, cursor.y - kGap);
  return layout;
}

}  // namespace

StoreyPlan make_plan(const graph::NavGraph& graph, bool show_excluded) {
  StoreyPlan plan{graph, find_storeys(graph), {}, {}};
  plan.storey_of.assign(graph.size(), StoreyPlan::kNowhere);
  for (std::size_t s = 0; s < plan.storeys.size(); ++s) {
    for (const ViewpointIndex v : plan.storeys[s].viewpoints) plan.storey_of[v.at()] = s;
  }
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    if (graph.included(v) || !show_excluded) continue;
    if (plan.storeys.empty()) plan.storeys.push_back({floor_of(graph, v), {}});
    plan.storey_of[i] = nearest_storey(plan.storeys, floor_of(graph, v));
  }
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (const graph::Edge& edge : graph.edges(ViewpointIndex(i))) {
      const bool seen = edge.target.at() < i && graph.edge(edge.target, ViewpointIndex(i));
      if (!seen) plan.edges.push_back({ViewpointIndex(i), edge.target});
    }
  }
  return plan;
}

Point Panel::at(Vec3f world) const {
  return {corner.x + scale * (world.x - west), corner.y + kCaption + scale * (north - world.y)};
}

Caption caption(const StoreyPlan& plan, std::size_t storey) {
  const double tenths = std::round(plan.storeys[storey].floor * 10) / 10;
  const std::size_t n = plan.storeys[storey].viewpoints.size();
  return {fmt::format("Storey {}", storey + 1),
          fmt::format("floor at {}{:.1f} m, {} viewpoint{}", tenths < 0 ? "\u2212" : "",
                      std::abs(tenths), n, n == 1 ? "" : "s")};
}

PanelLayout arrange(const StoreyPlan& plan, const std::vector<Disc>& discs,
                    const PlanUnderlay* underlay, double pixels_per_metre) {
  constexpr double kRim = 0.3;  // metres around what the underlay has
  std::vector<Extent> bounds = extents(plan, discs);
  for (std::size_t s = 0; s < bounds.size(); ++s) {
    if (underlay != nullptr) {
      for (const UnderlayLine& line : underlay->storeys[s].lines) {
        bounds[s].add(line.from, kRim);
        bounds[s].add(line.to, kRim);
      }
    }
    const auto [name, facts] = caption(plan, s);
    bounds[s].caption = text_width(name, 13) + 10 + text_width(facts, 12);
  }
  if (pixels_per_metre > 0) return arrange_at(bounds, pixels_per_metre);
  double scale = kLargestScale;
  PanelLayout layout = arrange_at(bounds, scale);
  while ((layout.size.x > kWidest || layout.size.y > kHighest) && scale > kSmallestScale) {
    scale *= 0.97;
    layout = arrange_at(bounds, scale);
  }
  return layout;
}

std::string number(double value) {
  const double tenths = std::round(value * 10) / 10;
  return fmt::format("{}", tenths == 0 ? 0.0 : tenths);  // no "-0"
}

std::string pair(Point p) { return number(p.x) + "," + number(p.y); }

double text_width(std::string_view text, double size) {
  std::size_t characters = 0;
  for (const char c : text) characters += (static_cast<unsigned char>(c) & 0xc0U) != 0x80 ? 1 : 0;
  return 0.58 * size * static_cast<double>(characters);
}

std::vector<std::string> wrap(std::string_view text, double size, double width) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::vector<std::string> lines;
  for (std::size_t at = text.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    const std::string word(text.substr(at, end - at));
    if (lines.empty() || text_width(lines.back() + " " + word, size) > width) {
      lines.push_back(word);
    } else {
      lines.back() += " " + word;
    }
    at = text.find_first_not_of(kBlanks, end);
  }
  return lines;
}

}  // namespace enfilade::draw::plan
