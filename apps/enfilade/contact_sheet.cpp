// enfilade contact-sheet: every viewpoint of a scan, or a trajectory, as small pictures.
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/drawn_path.h"
#include "apps/enfilade/picture_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/draw/contact_sheet.h"

namespace enfilade::apps {
namespace {

struct SheetArguments {
  SceneOptions scene;
  std::string scan, output = "sheet.png", thumb = "200x150";
  PathOptions path;
  std::size_t columns = 0, headings = 1;
  double heading = 0, vfov = 60;
};

// What goes on the sheet. Viewpoints by id: a store's order need not be the data set's.
struct Shot {
  std::string viewpoint;
  Radians heading, elevation;
  std::string caption;
};
struct Plan {
  std::string scan, title;
  std::vector<Shot> shots;
  std::size_t columns = 0;
};

void validate(const SheetArguments& a) {
  validate(a.path, a.scan);
  constexpr std::uint32_t kLargest = 2048;  // three times as large is what is drawn
  const Size thumb = parse_size("--thumb", a.thumb);
  if (std::max(thumb.width, thumb.height) > kLargest) {
    throw UsageError(
        fmt::format("--thumb {}: at most {} pixels along an edge; enfilade render "
                    "draws large pictures",
                    a.thumb, kLargest));
  }
  if (!(a.vfov > 0 && a.vfov < 180)) {
    throw UsageError(
        fmt::format("--vfov {}: more than 0 and less than 180 degrees are allowed", a.vfov));
  }
}

// Enough of an id to name a viewpoint of a scan by.
std::string brief(const std::string& viewpoint) { return viewpoint.substr(0, 8); }

std::string looking(Radians heading, Radians elevation) {
  // Rounded first: 359.6 is north too.
  const long turned = std::lround(to_degrees(heading)) % 360;
  const long raised = std::lround(to_degrees(elevation));
  return fmt::format("heading {}{}", turned < 0 ? turned + 360 : turned,
                     raised == 0 ? std::string() : fmt::format(", {:+}", raised));
}

Plan plan_of_scan(const SheetArguments& a, const scan::PanoramaSource& source) {
  Plan plan{a.scan, a.scan, {}, a.columns};
  for (std::size_t i = 0; i < source.size(); ++i) {
    const scan::PanoramaPose& pose = source.poses()[i];
    if (!pose.included) continue;
    for (std::size_t k = 0; k < a.headings; ++k) {
      const Radians heading =
          degrees(a.heading + 360 * static_cast<double>(k) / static_cast<double>(a.headings));
      plan.shots.push_back(
          {pose.viewpoint, heading, Radians(0),
           fmt::format("{} {}\n{}", i, brief(pose.viewpoint), looking(heading, Radians(0)))});
    }
  }
  if (plan.columns == 0 && a.headings > 1) {
    // A viewpoint's headings beside each other, and as many viewpoints a row as make 4 : 3.
    const Size thumb = parse_size("--thumb", a.thumb);
    const double across =
        std::sqrt(static_cast<double>(plan.shots.size()) * 4 / 3 * thumb.height / thumb.width);
    plan.columns = a.headings * static_cast<std::size_t>(std::max(
                                    1L, std::lround(across / static_cast<double>(a.headings))));
  }
  return plan;
}

// Along a path, towards the next viewpoint; at the end as it was reached.
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

std::vector<Shot> shots_of_path(const graph::NavGraph& graph, const r2r::ReferencePath& path) {
  const auto& places = path.viewpoints;
  const std::vector<Radians> headings = ahead(graph, places, path.heading);
  std::vector<Shot> shots;
  const auto add = [&](std::size_t i, Radians heading, const std::string& what) {
    shots.push_back(
        {graph.id(places[i]), heading, Radians(0),
         fmt::format("{} {}\n{}", what, brief(graph.id(places[i])), looking(heading, Radians(0)))});
  };
  add(0, path.heading, "start");
  for (std::size_t i = 0; i < places.size() && places.size() > 1; ++i) {
    add(i, headings[i], i + 1 == places.size() ? "goal" : fmt::format("{}", i));
  }
  return shots;
}

std::vector<Shot> shots_of_trajectory(const graph::NavGraph& graph, const r2r::Trajectory& done,
                                      Radians start) {
  std::vector<ViewpointIndex> places;
  for (const r2r::TrajectoryPoint& point : done.points) places.push_back(point.viewpoint);
  // Files that give viewpoints only: looking where the agent went next.
  const bool unsaid = std::ranges::all_of(done.points, [](const r2r::TrajectoryPoint& point) {
    return point.heading == Radians(0) && point.elevation == Radians(0);
  });
  const std::vector<Radians> headings = ahead(graph, places, start);
  std::vector<Shot> shots;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Radians heading = unsaid ? headings[i] : done.points[i].heading;
    const Radians elevation = done.points[i].elevation;
    shots.push_back(
        {graph.id(places[i]), heading, elevation,
         fmt::format("{} {}\n{}", i, brief(graph.id(places[i])), looking(heading, elevation))});
  }
  return shots;
}

Plan plan_of_path(const SheetArguments& a) {
  const scan::DataRoot data = open_data(a.scene.data);
  const DrawnPath drawn =
      find_path(a.path, a.scan, data, graph::GraphSet::open(data.connectivity()));
  const graph::NavGraph& graph = drawn.graph();
  Plan plan{graph.scan(), drawn.title(), {}, a.columns};
  if (drawn.episode) plan.title += ": " + drawn.text();
  plan.shots = drawn.walk ? shots_of_trajectory(graph, *drawn.walk, drawn.path().heading)
                          : shots_of_path(graph, drawn.path());
  // One row for a path (R2R's have 5 to 7 viewpoints), rows of ten for an agent's long walk.
  constexpr std::size_t kLongestRow = 10;
  if (plan.columns == 0) plan.columns = std::min(plan.shots.size(), kLongestRow);
  return plan;
}

// Drawn three times as large and averaged: thumbnails show more of a panorama a pixel than its
// faces have texels, and would glitter.
constexpr std::uint32_t kOversampling = 3;

std::vector<draw::SheetPicture> draw_shots(const Plan& plan, const Scene& scene,
                                           const SheetArguments& a) {
  constexpr std::size_t kBatch = 16;
  const Size thumb = parse_size("--thumb", a.thumb);
  const Size size{thumb.width * kOversampling, thumb.height * kOversampling};
  const Camera camera{size.width, size.height, degrees(a.vfov)};
  const auto renderer = make_renderer(scene, a.scene);
  const std::vector<PictureFile> colour{{}};
  const Progress progress = progress_bar("drawing");
  std::vector<draw::SheetPicture> pictures;
  for (std::size_t begin = 0; begin < plan.shots.size(); begin += kBatch) {
    const auto shots =
        std::span(plan.shots).subspan(begin, std::min(kBatch, plan.shots.size() - begin));
    std::vector<render::View> views;
    for (const Shot& shot : shots) {
      const ViewpointIndex viewpoint = scene.source().at(shot.viewpoint);
      require_layers(scene.source(), viewpoint, colour);
      views.push_back({ScanIndex(), viewpoint, shot.heading, shot.elevation});
    }
    Drawn drawn;
    renderer->render(camera, views, outputs_into(drawn, colour, size, views.size()));
    for (std::size_t i = 0; i < shots.size(); ++i) {
      const image::Image8 large = rows_of(drawn.colour, i * size.height, size.height);
      pictures.push_back({image::shrink(large, thumb.width, thumb.height), shots[i].caption});
    }
    if (progress) progress(pictures.size(), plan.shots.size());
  }
  return pictures;
}

void draw_sheet(const SheetArguments& a) {
  validate(a);
  (void)picture_files({.file = a.output});  // refuses a name that is no picture's
  const bool trajectory = !a.path.split.empty();
  Plan plan = trajectory ? plan_of_path(a) : Plan{};
  const Scene scene = open_scene(a.scene, trajectory ? plan.scan : a.scan);
  if (!trajectory) plan = plan_of_scan(a, scene.source());
  if (plan.shots.empty()) {
    throw LookupError(fmt::format("scan {} includes no viewpoint", plan.scan));
  }
  const image::Image8 sheet = draw::contact_sheet(draw_shots(plan, scene, a),
                                                  {.columns = plan.columns, .title = plan.title});
  write_picture(a.output, encode(sheet, a.output));
}

}  // namespace

void add_contact_sheet(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "contact-sheet", "Draw every viewpoint of a scan, or a trajectory, as small pictures");
  const auto a = std::make_shared<SheetArguments>();
  add_scan_argument(verb, a->scan);
  verb.add_option("-o,--output", a->output, "PNG or JPEG file; - for standard output")
      ->capture_default_str()
      ->type_name("FILE");
  verb.add_option("--thumb", a->thumb, "Size of a picture, pixels")
      ->capture_default_str()
      ->type_name("WxH");
  verb.add_option("--columns", a->columns, "Pictures a row (default: what looks well)")
      ->check(whole_number(1))
      ->type_name("N");
  verb.add_option("--headings", a->headings, "Pictures of each viewpoint, all around")
      ->check(whole_number(1))
      ->capture_default_str()
      ->type_name("N");
  verb.add_option("--heading", a->heading, "Of the first of them, clockwise from north, degrees")
      ->check(finite_number(-1e6))
      ->capture_default_str()
      ->type_name("DEG");
  verb.add_option("--vfov", a->vfov, "Angle that a picture spans from top to bottom, degrees")
      ->check(finite_number())
      ->capture_default_str()
      ->type_name("DEG");
  add_path_options(verb, a->path, "draw the agent's trajectory for --instr instead");
  add_place_options(verb, a->scene);
  add_renderer_options(verb, a->scene);
  set_examples(verb, {"enfilade contact-sheet 17DRP5sb8fy -o sheet.jpg",
                      "enfilade contact-sheet 17DRP5sb8fy --headings 4 --thumb 320x240",
                      "enfilade contact-sheet --split val_seen --path 1683 -o strip.png",
                      "enfilade contact-sheet --split val_seen --instr 1683_0 --results "
                      "results.json -o strip.png"});
  verb.callback([a, &status] {
    draw_sheet(*a);
    status = kSuccess;
  });
}

}  // namespace enfilade::apps
