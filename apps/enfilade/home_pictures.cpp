#include "apps/enfilade/home_pictures.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "apps/enfilade/picture_files.h"
#include "enfilade/dataset/views.h"
#include "enfilade/draw/contact_sheet.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/plan.h"
#include "enfilade/render/pictures.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

constexpr Size kThumb{400, 300};
constexpr std::uint32_t kPanoramaWidth = 600;
constexpr double kVfov = 65;            // degrees
constexpr Radians kDown = degrees(-8);  // as people look across a room

struct Pose {
  ViewpointIndex viewpoint;
  Radians heading;
};

struct Look {
  Pose pose;
  double worth = 0;
};

Camera camera_of(Size size) { return {size.width, size.height, degrees(kVfov)}; }

render::View view_of(const dataset::Dataset& data, const std::string& scan, Pose pose,
                     Radians elevation = kDown) {
  return {data.graphs()->at(scan), pose.viewpoint, pose.heading, elevation};
}

image::Image8 picture_of(const dataset::Dataset& data, const std::string& scan, Pose pose) {
  return render_colour(data, view_of(data, scan, pose), camera_of(kThumb));
}

// Is what a pixel shows above this floor, or in the walls around it?
bool lies_on(const Rect& floor, Vec3f eye, Radians heading, Size size, std::size_t pixel,
             double depth) {
  constexpr double kWall = 0.15;  // metres: pictures and windows are in or before the walls
  const double tangent = std::tan(degrees(kVfov).value / 2);
  const double height = size.height;
  const double right =
      tangent * (2.0 * static_cast<double>(pixel % size.width) + 1 - size.width) / height;
  const double up = tangent * (height - 2.0 * static_cast<double>(pixel / size.width) - 1) / height;
  const double ahead = std::cos(kDown.value) - up * std::sin(kDown.value);
  const double sine = std::sin(heading.value), cosine = std::cos(heading.value);
  const double x = eye.x + depth * (ahead * sine + right * cosine);
  const double y = eye.y + depth * (ahead * cosine - right * sine);
  return x > floor.x0 - kWall && x < floor.x1 + kWall && y > floor.y0 - kWall &&
         y < floor.y1 + kWall;
}

// Many things of this room, and little of other rooms or right before one's eyes.
double interest(render::Renderer& renderer, const render::View& view, Vec3f eye,
                const Rect& floor) {
  constexpr Size kSmall{64, 48};
  constexpr auto kLayers = static_cast<scan::LayerMask>(1U << index(scan::Layer::kDepth) |
                                                        1U << index(scan::Layer::kInstance));
  render::Pictures drawn;
  renderer.render(camera_of(kSmall), {&view, 1},
                  outputs_into(drawn, kLayers, kSmall.width, kSmall.height));
  std::map<std::uint32_t, std::size_t> counts;
  double near = 0, inside = 0;
  for (std::size_t i = 0; i < drawn.depth.pixels.size(); ++i) {
    const double depth = drawn.depth.pixels[i] / scan::kDepthUnitsPerMetre;
    if (depth < 1.0) near += 1;
    if (!lies_on(floor, eye, view.heading, kSmall, i, depth)) continue;
    ++counts[drawn.instances.pixels[i]];
    inside += 1;
  }
  double things = 0;
  for (const auto& [id, pixels] : counts) things += pixels >= 12 ? 1 : 0;
  const auto all = static_cast<double>(drawn.depth.pixels.size());
  return things * (1 - near / all) * (inside / all);
}

// Where one sees most of a room, from the viewpoints in it.
std::optional<Look> best_look(const dataset::Dataset& data, const std::string& scan,
                              const homes::RoomEntry& room, const Rect& floor) {
  const graph::NavGraph& graph = data.graphs()->graph(scan);
  const auto renderer =
      render::make_renderer(data.faces());  // hundreds of small views: one for all
  constexpr std::size_t kHeadings = 12;
  std::optional<Look> best;
  for (const std::string& id : room.viewpoints) {
    const auto v = graph.find(id);
    if (!v) continue;
    for (std::size_t k = 0; k < kHeadings; ++k) {
      const Pose pose{*v, degrees(360.0 * static_cast<double>(k) / kHeadings)};
      const double worth =
          interest(*renderer, view_of(data, scan, pose), graph.position(*v), floor);
      if (worth > (best ? best->worth : 0)) best = Look{pose, worth};
    }
  }
  return best;
}

void write_sheet(const fs::path& file, const std::vector<draw::SheetPicture>& pictures,
                 const std::string& title, std::size_t columns = 0) {
  draw::SheetOptions options;
  options.title = title;
  options.columns = columns;
  write_output(file.string(), encode(draw::contact_sheet(pictures, options), file.string()));
}

// The place of the room that people spend their days in, else of that with most viewpoints.
std::optional<std::size_t> main_room(const homes::HomeEntry& home) {
  const auto& rooms = home.rooms;
  for (const char type : {'l', 'f', 'n', 'm', 'o', 'b'}) {
    for (std::size_t r = 0; r < rooms.size(); ++r) {
      if (rooms[r].type == type && !rooms[r].viewpoints.empty()) return r;
    }
  }
  if (rooms.empty()) return std::nullopt;
  const auto most = std::ranges::max_element(
      rooms, {}, [](const homes::RoomEntry& room) { return room.viewpoints.size(); });
  return static_cast<std::size_t>(most - rooms.begin());
}

std::vector<draw::SheetPicture> views_of_homes(const dataset::Dataset& data,
                                               const std::vector<homes::HomeEntry>& homes) {
  std::vector<draw::SheetPicture> pictures;
  for (const homes::HomeEntry& home : homes) {
    const auto room = main_room(home);
    if (!room) continue;
    const homes::Plan plan = homes::make_plan(home.plan);
    const auto look = best_look(data, home.scan, home.rooms[*room], plan.rooms.at(*room).floor);
    if (!look) continue;
    pictures.push_back({picture_of(data, home.scan, look->pose),
                        fmt::format("{}, {}\n{}", home.scan, home.kind, home.rooms[*room].name)});
  }
  return pictures;
}

struct RoomLook {
  std::string scan, name;
  Look look;
};

// Of each type of room the one, in any home, of which one sees most.
std::map<char, RoomLook> best_rooms(const dataset::Dataset& data,
                                    const std::vector<homes::HomeEntry>& homes) {
  std::map<char, RoomLook> best;
  for (const homes::HomeEntry& home : homes) {
    const homes::Plan plan = homes::make_plan(home.plan);
    for (std::size_t r = 0; r < home.rooms.size(); ++r) {
      const homes::RoomEntry& room = home.rooms[r];
      const auto look = best_look(data, home.scan, room, plan.rooms.at(r).floor);
      if (!look) continue;
      const auto known = best.find(room.type);
      if (known != best.end() && known->second.look.worth >= look->worth) continue;
      best[room.type] = {home.scan, room.name, *look};
    }
  }
  return best;
}

// What one sees along a path.
bool draw_walk(const dataset::Dataset& data, const fs::path& file) {
  const r2r::EpisodeSet episodes = data.episodes("val_unseen");
  if (episodes.paths.empty()) return false;
  const r2r::ReferencePath& path = episodes.paths.front();
  const graph::NavGraph& graph = data.graphs()->graph(path.scan);
  std::string title = fmt::format("{} (synthetic), path {}.", graph.scan(), path.path_id);
  for (const r2r::Episode& episode : episodes.episodes) {
    if (&episodes.path_of(episode) == &path) title += "  *  " + episode.text;
  }
  std::vector<draw::SheetPicture> pictures{
      {picture_of(data, graph.scan(), {path.viewpoints.front(), path.heading}), "start"}};
  Radians heading = path.heading;
  for (std::size_t i = 0; i < path.viewpoints.size(); ++i) {
    const bool last = i + 1 == path.viewpoints.size();
    if (!last) {
      if (const auto* edge = graph.edge(path.viewpoints[i], path.viewpoints[i + 1])) {
        heading = edge->heading;
      }
    }
    pictures.push_back({picture_of(data, graph.scan(), {path.viewpoints[i], heading}),
                        last ? "goal" : fmt::format("{}", i)});
  }
  write_sheet(file, pictures, title, 4);
  return true;
}

}  // namespace

std::vector<std::string> draw_homes(const fs::path& folder, const fs::path& output) {
  const auto homes = homes::read_home_list(folder);
  const dataset::Dataset data(folder);
  std::vector<std::string> files;
  const auto sheet = [&](const char* name, const std::vector<draw::SheetPicture>& pictures,
                         const std::string& title) {
    if (pictures.empty()) return;
    write_sheet(output / name, pictures, title);
    files.emplace_back((output / name).string());
  };
  sheet("homes.png", views_of_homes(data, homes),
        fmt::format("{} model homes (synthetic)", homes.size()));
  std::vector<draw::SheetPicture> views, panoramas;
  for (const auto& [type, room] : best_rooms(data, homes)) {
    const std::string caption = room.name + "\n" + room.scan;
    views.push_back({picture_of(data, room.scan, room.look.pose), caption});
    panoramas.push_back(
        {render_panorama(data, view_of(data, room.scan, room.look.pose), kPanoramaWidth), caption});
  }
  sheet("rooms.png", views, "Rooms of model homes (synthetic)");
  sheet("panoramas.png", panoramas, "A panorama of each type of room (synthetic)");
  if (data.has_split("val_unseen") && draw_walk(data, output / "walk.png")) {
    files.emplace_back((output / "walk.png").string());
  }
  return files;
}

}  // namespace enfilade::apps
