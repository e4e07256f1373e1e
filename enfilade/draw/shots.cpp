#include "enfilade/draw/shots.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/draw/planned_goal.h"
#include "enfilade/render/pictures.h"

namespace enfilade::draw {
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
