#include "apps/enfilade/home_pictures.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "apps/enfilade/picture_files.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/dataset/views.h"
#include "enfilade/draw/contact_sheet.h"
#include "enfilade/render/renderer.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

constexpr Size kThumb{400, 300};
constexpr std::uint32_t kPanoramaWidth = 600;
constexpr double kVfov = 65;            // degrees
constexpr Radians kDown = degrees(-8);  // elevation: slightly down

struct Pose {
  std::string scan;
  ViewpointIndex viewpoint;
  Radians heading;
};

// The best view of a room.
struct Look {
  std::string room;  // its name
  Pose pose;
  double worth = 0;  // interest()
};

Camera camera_of(Size size) { return {size.width, size.height, degrees(kVfov)}; }

render::View view_of(const dataset::Dataset& data, const Pose& pose) {
  return {data.graphs()->at(pose.scan), pose.viewpoint, pose.heading, kDown};
}

image::Image8 picture_of(const dataset::Dataset& data, const Pose& pose) {
  return render_colour(data, view_of(data, pose), camera_of(kThumb));
}

// Whether the surface that a pixel shows is above this floor or in the walls around it.
// \param depth metres along the optical axis
bool lies_on(const Rect& floor, Vec3f eye, Radians heading, Size size, std::size_t pixel,
             double depth) {
  constexpr double kWall = 0.15;  // metres: pictures hang on walls, windows are in them
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

// How much a view shows of a room: the number of things in it, times the share of pixels that show
// this room, times the share of pixels that show nothing nearer than a metre.
double interest(render::Renderer& renderer, const render::View& view, Vec3f eye,
                const Rect& floor) {
  constexpr Size kSmall{64, 48};
  constexpr scan::LayerMask kLayers =
      scan::mask_of(scan::Layer::kDepth) | scan::mask_of(scan::Layer::kInstance);
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

// The most interesting of twelve views from each viewpoint in a room.
std::optional<Look> best_look(const dataset::Dataset& data, render::Renderer& renderer,
                              const std::string& scan, const homes::RoomEntry& room) {
  const graph::NavGraph& graph = data.graphs()->graph(scan);
  constexpr std::size_t kHeadings = 12;
  std::optional<Look> best;
  for (const std::string& id : room.viewpoints) {
    const auto v = graph.find(id);
    if (!v) continue;
    for (std::size_t k = 0; k < kHeadings; ++k) {
      const Pose pose{scan, *v, degrees(360.0 * static_cast<double>(k) / kHeadings)};
      const double worth = interest(renderer, view_of(data, pose), graph.position(*v), room.floor);
      if (worth > (best ? best->worth : 0)) best = Look{room.name, pose, worth};
    }
  }
  return best;
}

void write_sheet(const OutputFolder& out, const std::string& file,
                 const std::vector<draw::SheetPicture>& pictures, const std::string& title,
                 std::size_t columns = 0) {
  const auto sheet = draw::contact_sheet(pictures, {.columns = columns, .title = title});
  out.write(file, encode(sheet, file));
}

// The living room or its like, else the room with most viewpoints; null if there is no room.
const homes::RoomEntry* main_room(const homes::HomeEntry& home) {
  for (const char type : {'l', 'f', 'n', 'm', 'o', 'b'}) {
    for (const homes::RoomEntry& room : home.rooms) {
      if (room.type == type && !room.viewpoints.empty()) return &room;
    }
  }
  if (home.rooms.empty()) return nullptr;
  return &*std::ranges::max_element(
      home.rooms, {}, [](const homes::RoomEntry& room) { return room.viewpoints.size(); });
}

std::vector<draw::SheetPicture> views_of_homes(const dataset::Dataset& data,
                                               render::Renderer& renderer,
                                               const std::vector<homes::HomeEntry>& homes) {
  std::vector<draw::SheetPicture> pictures;
  for (const homes::HomeEntry& home : homes) {
    const homes::RoomEntry* room = main_room(home);
    const auto look = room != nullptr ? best_look(data, renderer, home.scan, *room) : std::nullopt;
    if (!look) continue;
    pictures.push_back({picture_of(data, look->pose),
                        fmt::format("{}, {}\n{}", home.scan, home.kind, look->room)});
  }
  return pictures;
}

// For each type of room, the best view of all rooms of that type.
std::map<char, Look> best_rooms(const dataset::Dataset& data, render::Renderer& renderer,
                                const std::vector<homes::HomeEntry>& homes) {
  std::map<char, Look> best;
  for (const homes::HomeEntry& home : homes) {
    for (const homes::RoomEntry& room : home.rooms) {
      const auto look = best_look(data, renderer, home.scan, room);
      if (look && look->worth > best[room.type].worth) best[room.type] = *look;
    }
  }
  return best;
}

// The views along the first path of val_unseen, in a pretty home if there is one. False if there is
// no path. \param pretty scans, ascending
bool draw_walk(const dataset::Dataset& data, const std::vector<std::string>& pretty,
               const OutputFolder& out, const std::string& file) {
  const tasks::EpisodeSet episodes = data.episodes("val_unseen");
  if (episodes.paths.empty()) return false;
  const auto shown = std::ranges::find_if(episodes.paths, [&](const tasks::ReferencePath& path) {
    return std::ranges::binary_search(pretty, data.graphs()->scans()[path.scan.at()]);
  });
  const tasks::ReferencePath& path =
      shown == episodes.paths.end() ? episodes.paths.front() : *shown;
  const graph::NavGraph& graph = data.graphs()->graph(path.scan);
  std::string title = fmt::format("{} (synthetic), path {}.", graph.scan(), path.path_id);
  for (const tasks::Episode& episode : episodes.episodes) {
    if (&episodes.path_of(episode) == &path) title += "  *  " + episode.text;
  }
  std::vector<draw::SheetPicture> pictures{
      {picture_of(data, {graph.scan(), path.viewpoints.front(), path.heading}), "start"}};
  Radians heading = path.heading;
  for (std::size_t i = 0; i < path.viewpoints.size(); ++i) {
    const bool last = i + 1 == path.viewpoints.size();
    if (!last) {
      if (const auto* edge = graph.edge(path.viewpoints[i], path.viewpoints[i + 1])) {
        heading = edge->heading;
      }
    }
    pictures.push_back({picture_of(data, {graph.scan(), path.viewpoints[i], heading}),
                        last ? "goal" : fmt::format("{}", i)});
  }
  write_sheet(out, file, pictures, title, 4);
  return true;
}

}  // namespace

homes::SetProgress set_bar(const std::string& what) {
  return [bar = progress_bar(what)](const std::string&, std::size_t done, std::size_t total) {
    if (bar) bar(done, total);
  };
}

std::vector<std::string> draw_homes(const fs::path& folder, const fs::path& output) {
  std::vector<homes::HomeEntry> homes = homes::read_home_list(folder);
  // In a set with homes of display quality, these: the others are for training.
  const std::vector<std::string> pretty = homes::pretty_homes(homes::read_home_options(folder));
  if (!pretty.empty()) {
    std::erase_if(homes, [&](const homes::HomeEntry& home) {
      return !std::ranges::binary_search(pretty, home.scan);
    });
  }
  for (homes::HomeEntry& home : homes) home = homes::completed(std::move(home), folder);
  const dataset::Dataset data(folder);
  const auto renderer = render::make_renderer(data.faces());  // one for hundreds of small views
  std::vector<std::string> files;
  const OutputFolder out(output);
  const auto sheet = [&](const char* name, const std::vector<draw::SheetPicture>& pictures,
                         const std::string& title) {
    if (pictures.empty()) return;
    write_sheet(out, name, pictures, title);
    files.emplace_back((output / name).string());
  };
  sheet("homes.png", views_of_homes(data, *renderer, homes),
        fmt::format("{} model homes (synthetic)", homes.size()));
  std::vector<draw::SheetPicture> views, panoramas;
  for (const auto& [type, look] : best_rooms(data, *renderer, homes)) {
    const std::string caption = look.room + "\n" + look.pose.scan;
    views.push_back({picture_of(data, look.pose), caption});
    panoramas.push_back({render_panorama(data, view_of(data, look.pose), kPanoramaWidth), caption});
  }
  sheet("rooms.png", views, "Rooms of model homes (synthetic)");
  sheet("panoramas.png", panoramas, "A panorama of each type of room (synthetic)");
  if (data.has_split("val_unseen") && draw_walk(data, pretty, out, "walk.png")) {
    files.emplace_back((output / "walk.png").string());
  }
  return files;
}

}  // namespace enfilade::apps
