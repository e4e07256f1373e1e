#include "enfilade/draw/contact_sheet.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/draw/detail/bitmap_text.h"
#include "enfilade/draw/planned_goal.h"
#include "enfilade/image/codecs.h"
#include "enfilade/render/renderer.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::draw {
namespace {

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

// Where things are, in pixels.
struct Grid {
  std::size_t columns = 1, rows = 1;
  std::uint32_t width = 0, height = 0;  // of the largest picture
  std::uint32_t caption = 0;            // height below each
  std::uint32_t scale = 1, gap = 6, line = 0;
  std::vector<std::string> title;  // lines
  std::uint32_t title_scale = 1;   // twice that of captions if it fits a line

  std::uint64_t cell_width() const { return std::uint64_t{width} + gap; }
  std::uint64_t cell_height() const { return std::uint64_t{height} + caption + gap; }
  std::uint64_t sheet_width() const { return columns * cell_width() + gap; }
  std::uint64_t title_line() const {
    return std::uint64_t{detail::kLetterHeight + 4} * title_scale;
  }
  std::uint64_t title_height() const {
    return title.empty() ? 0 : title.size() * title_line() + gap;
  }
  std::uint64_t sheet_height() const { return title_height() + gap + rows * cell_height(); }

  void set_title(const std::string& text) {
    const auto inner = static_cast<std::uint32_t>(sheet_width() - 2 * gap);
    title_scale = detail::text_pixels(text, 2 * scale) <= inner ? 2 * scale : scale;
    title = detail::wrap_text(text, inner, title_scale);
  }
};

void check(const SheetPicture& one, std::size_t place) {
  if (one.picture.channels == 3 && !one.picture.pixels.empty()) return;
  throw ArgumentError(fmt::format("pictures[{}]: {} x {} with {} channels; 3 channels are expected",
                                  place, one.picture.width, one.picture.height,
                                  one.picture.channels));
}

Grid lay_out(std::span<const SheetPicture> pictures, const SheetOptions& options) {
  if (pictures.empty()) throw ArgumentError("pictures: none; one at least is expected");
  Grid grid;
  std::size_t lines = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    check(pictures[i], i);
    grid.width = std::max(grid.width, pictures[i].picture.width);
    grid.height = std::max(grid.height, pictures[i].picture.height);
    lines = std::max(lines, lines_of(pictures[i].caption).size());
  }
  grid.scale = std::clamp(grid.width / 320, 1U, 3U);
  grid.line = (detail::kLetterHeight + 2) * grid.scale;
  grid.caption = lines == 0 ? 0 : static_cast<std::uint32_t>(lines) * grid.line + 3 * grid.scale;
  const double n = static_cast<double>(pictures.size());
  const double square = std::sqrt(n * 4 / 3 * static_cast<double>(grid.cell_height()) /
                                  static_cast<double>(grid.cell_width()));
  grid.columns = std::clamp(
      options.columns > 0 ? options.columns : static_cast<std::size_t>(std::lround(square)),
      std::size_t{1}, pictures.size());
  grid.rows = (pictures.size() + grid.columns - 1) / grid.columns;
  grid.set_title(options.title);
  if (std::max(grid.sheet_width(), grid.sheet_height()) > image::kLongestEdge ||
      grid.sheet_width() * grid.sheet_height() > image::kMostPixels) {
    throw ArgumentError(fmt::format(
        "a sheet of {} x {} pixels for {} pictures: at most {} along an edge and {} in all are "
        "allowed; take smaller ones, or another number of columns",
        grid.sheet_width(), grid.sheet_height(), pictures.size(), image::kLongestEdge,
        image::kMostPixels));
  }
  return grid;
}

}  // namespace

image::Image8 contact_sheet(std::span<const SheetPicture> pictures, const SheetOptions& options) {
  const Grid grid = lay_out(pictures, options);
  image::Image8 sheet =
      detail::filled(static_cast<std::uint32_t>(grid.sheet_width()),
                     static_cast<std::uint32_t>(grid.sheet_height()), detail::kPaper);
  for (std::size_t i = 0; i < grid.title.size(); ++i) {
    const auto y = static_cast<std::uint32_t>(grid.gap + i * grid.title_line());
    detail::draw_text(sheet, grid.gap, y, grid.title[i], detail::kPictureInk, grid.title_scale);
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto x = static_cast<std::uint32_t>(grid.gap + i % grid.columns * grid.cell_width());
    auto y = static_cast<std::uint32_t>(grid.title_height() + grid.gap +
                                        i / grid.columns * grid.cell_height());
    detail::paste(sheet, pictures[i].picture, x, y);
    y += grid.height + 3 * grid.scale;
    for (const std::string_view line : lines_of(pictures[i].caption)) {
      detail::draw_text(sheet, x, y, detail::cut_text(line, grid.width, grid.scale),
                        detail::kPictureInk, grid.scale);
      y += grid.line;
    }
  }
  return sheet;
}

namespace {

// The first characters of an id, enough to identify a viewpoint of a scan.
std::string brief(const std::string& viewpoint) { return viewpoint.substr(0, 8); }

Shot shot(const std::string& name, const std::string& viewpoint, Radians heading,
          Radians elevation = Radians(0)) {
  // Rounded first: 359.6 is north too.
  const long turned = std::lround(to_degrees(heading)) % 360;
  const long raised = std::lround(to_degrees(elevation));
  return {
      viewpoint, heading, elevation,
      fmt::format("{} {}\nheading {}{}", name, brief(viewpoint), turned < 0 ? turned + 360 : turned,
                  raised == 0 ? std::string() : fmt::format(", {:+}", raised))};
}

// Headings along a path: towards the next viewpoint; at the end as on arrival.
std::vector<Radians> ahead(const graph::NavGraph& graph, std::span<const ViewpointIndex> path,
                           Radians start) {
  std::vector<Radians> headings;
  Radians heading = start;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i + 1 < path.size()) {
      const graph::Edge* edge = graph.edge(path[i], path[i + 1]);
      if (edge != nullptr) heading = edge->heading;
    }
    headings.push_back(heading);
  }
  return headings;
}

}  // namespace

std::vector<Shot> shots_of_scan(const scan::PanoramaSource& source, std::size_t headings,
                                Radians first) {
  std::vector<Shot> shots;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const scan::PanoramaPose& pose = source.poses()[i];
    for (std::size_t k = 0; k < headings && pose.included; ++k) {
      const double turn = 360 * static_cast<double>(k) / static_cast<double>(headings);
      shots.push_back(
          shot(fmt::format("{}", i), pose.viewpoint, degrees(to_degrees(first) + turn)));
    }
  }
  return shots;
}

std::vector<Shot> shots_of_path(const graph::NavGraph& graph, const tasks::ReferencePath& path) {
  const auto& places = path.viewpoints;
  const std::vector<Radians> headings = ahead(graph, places, path.heading);
  std::vector<Shot> shots{shot("start", graph.id(places[0]), path.heading)};
  for (std::size_t i = 0; i < places.size() && places.size() > 1; ++i) {
    const std::string name = i + 1 == places.size() ? "goal" : fmt::format("{}", i);
    shots.push_back(shot(name, graph.id(places[i]), headings[i]));
  }
  return shots;
}

std::vector<Shot> shots_of_trajectory(const graph::NavGraph& graph,
                                      const tasks::Trajectory& trajectory, Radians start) {
  const auto& points = trajectory.points;
  std::vector<ViewpointIndex> places;
  for (const tasks::TrajectoryPoint& point : points) places.push_back(point.viewpoint);
  const bool unsaid = std::ranges::all_of(points, [](const tasks::TrajectoryPoint& point) {
    return point.heading == Radians(0) && point.elevation == Radians(0);
  });
  const std::vector<Radians> headings = ahead(graph, places, start);
  std::vector<Shot> shots;
  for (std::size_t i = 0; i < places.size(); ++i) {
    shots.push_back(shot(fmt::format("{}", i), graph.id(places[i]),
                         unsaid ? headings[i] : points[i].heading, points[i].elevation));
  }
  return shots;
}

void outline_goal(std::vector<Shot>& shots, const graph::NavGraph& graph, const tasks::Goal& goal,
                  const tasks::ObjectBoxes* objects) {
  for (Shot& one : shots) {
    const auto viewpoint = graph.find(one.viewpoint);
    if (!viewpoint) continue;
    one.outlines = goal_outlines(graph, goal, *viewpoint, objects,
                                 tasks::Direction{one.heading, one.elevation});
  }
}

std::optional<Shot> shot_of_goal(const graph::NavGraph& graph, const tasks::ReferencePath& path,
                                 const tasks::ObjectBoxes* objects) {
  std::vector<ViewpointIndex> places{path.viewpoints.back()};
  if (const auto goal = planned_goal(path)) {
    places.insert(places.end(), goal->viewpoints.begin(), goal->viewpoints.end());
  }
  for (const ViewpointIndex v : places) {
    std::vector<Outline> outlines = goal_outlines(graph, path.goal, v, objects);
    if (outlines.empty()) continue;
    const tasks::Direction at = centre_of(outlines.front());
    Shot found = shot("object", graph.id(v), at.heading, at.elevation);
    found.outlines = std::move(outlines);
    return found;
  }
  return std::nullopt;
}

std::vector<SheetPicture> draw_shots(render::Renderer& renderer, ScanIndex scan,
                                     const scan::PanoramaSource& source,
                                     std::span<const Shot> shots, const Camera& camera,
                                     const Progress& progress) {
  constexpr std::uint32_t kOversampling = 3;
  constexpr std::size_t kBatch = 16;
  const Camera large{camera.width * kOversampling, camera.height * kOversampling,
                     camera.vertical_field_of_view};
  std::vector<SheetPicture> pictures;
  while (pictures.size() < shots.size()) {
    const auto batch =
        shots.subspan(pictures.size()).first(std::min(kBatch, shots.size() - pictures.size()));
    std::vector<render::View> views;
    for (const Shot& one : batch) {
      views.push_back({scan, source.at(one.viewpoint), one.heading, one.elevation});
    }
    render::Pictures drawn;
    renderer.render(large, views,
                    outputs_into(drawn, 1 << index(scan::Layer::kColour), large.width, large.height,
                                 views.size()));
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const image::Image8 picture = image::rows(drawn.colour, i * large.height, large.height);
      pictures.push_back({image::shrink(picture, camera.width, camera.height), batch[i].caption});
      for (const Outline& outline : batch[i].outlines) {
        draw_outline(pictures.back().picture, outline, {batch[i].heading, batch[i].elevation},
                     camera.vertical_field_of_view);
      }
    }
    if (progress) progress(pictures.size(), shots.size());
  }
  return pictures;
}

}  // namespace enfilade::draw
