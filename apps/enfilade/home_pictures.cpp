#include "apps/enfilade/home_pictures.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "apps/enfilade/picture_files.h"
#include "enfilade/draw/contact_sheet.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/plan.h"
#include "enfilade/r2r/annotations.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

constexpr Size kThumb{400, 300};
constexpr Size kPanorama{600, 300};
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

// All homes of a folder, drawn by one renderer.
class Artist {
 public:
  explicit Artist(const fs::path& homes)
      : data_(homes),
        graphs_(graph::GraphSet::open(data_.connectivity())),
        panoramas_(scan::PanoramaSet::open(data_.panoramas(), graphs_->scans())),
        faces_(std::make_shared<render::FaceCache>(panoramas_)),
        renderer_(render::make_renderer(faces_, {})) {}

  const scan::DataRoot& data() const { return data_; }
  const std::shared_ptr<const graph::GraphSet>& graphs() const { return graphs_; }

  image::Image8 look(const std::string& scan, Pose pose, Radians elevation = kDown) {
    Drawn drawn;
    const render::Outputs outputs = outputs_into(drawn, {{scan::Layer::kColour, ""}}, kThumb);
    const render::View view{panoramas_->at(scan), pose.viewpoint, pose.heading, elevation};
    renderer_->render({kThumb.width, kThumb.height, degrees(kVfov)}, {&view, 1}, outputs);
    return std::move(drawn.colour);
  }

  // All around, the middle looking along the pose; half as high as wide.
  image::Image8 look_around(const std::string& scan, Pose pose) {
    Drawn drawn;
    const render::Outputs outputs = outputs_into(drawn, {{scan::Layer::kColour, ""}}, kPanorama);
    const render::View view{panoramas_->at(scan), pose.viewpoint, pose.heading, {}};
    render::render_equirectangular(faces_, view, kPanorama.width, kPanorama.height, outputs);
    return std::move(drawn.colour);
  }

  // Where one sees most of a room, from the viewpoints in it.
  std::optional<Look> best_look(const std::string& scan, const homes::RoomEntry& room,
                                const Rect& floor) {
    const graph::NavGraph& graph = graphs_->graph(scan);
    constexpr std::size_t kHeadings = 12;
    std::optional<Look> best;
    for (const std::string& id : room.viewpoints) {
      const auto v = graph.find(id);
      if (!v) continue;
      for (std::size_t k = 0; k < kHeadings; ++k) {
        const Pose pose{*v, degrees(360.0 * static_cast<double>(k) / kHeadings)};
        const double worth = interest(scan, pose, floor);
        if (worth > (best ? best->worth : 0)) best = Look{pose, worth};
      }
    }
    return best;
  }

 private:
  // Many things of this room, and little of other rooms or right before one's eyes.
  double interest(const std::string& scan, Pose pose, const Rect& floor) {
    constexpr Size kSmall{64, 48};
    Drawn drawn;
    const render::Outputs outputs =
        outputs_into(drawn, {{scan::Layer::kDepth, ""}, {scan::Layer::kInstance, ""}}, kSmall);
    const render::View view{panoramas_->at(scan), pose.viewpoint, pose.heading, kDown};
    renderer_->render({kSmall.width, kSmall.height, degrees(kVfov)}, {&view, 1}, outputs);
    const Vec3f eye = graphs_->graph(scan).positions()[pose.viewpoint.at()];
    std::map<std::uint32_t, std::size_t> counts;
    double near = 0, inside = 0;
    for (std::size_t i = 0; i < drawn.depth.pixels.size(); ++i) {
      const double depth = drawn.depth.pixels[i] / double{scan::kDepthUnitsPerMetre};
      if (depth < 1.0) near += 1;
      if (!lies_on(floor, eye, pose.heading, kSmall, i, depth)) continue;
      ++counts[drawn.instances.pixels[i]];
      inside += 1;
    }
    double things = 0;
    for (const auto& [id, pixels] : counts) things += pixels >= 12 ? 1 : 0;
    const auto all = static_cast<double>(drawn.depth.pixels.size());
    return things * (1 - near / all) * (inside / all);
  }

  // Is what a pixel shows above this floor, or in the walls around it?
  static bool lies_on(const Rect& floor, Vec3f eye, Radians heading, Size size, std::size_t pixel,
                      double depth) {
    constexpr double kWall = 0.15;  // metres: pictures and windows are in or before the walls
    const double tangent = std::tan(degrees(kVfov).value / 2);
    const double height = size.height;
    const double right =
        tangent * (2.0 * static_cast<double>(pixel % size.width) + 1 - size.width) / height;
    const double up =
        tangent * (height - 2.0 * static_cast<double>(pixel / size.width) - 1) / height;
    const double ahead = std::cos(kDown.value) - up * std::sin(kDown.value);
    const double sine = std::sin(heading.value), cosine = std::cos(heading.value);
    const double x = eye.x + depth * (ahead * sine + right * cosine);
    const double y = eye.y + depth * (ahead * cosine - right * sine);
    return x > floor.x0 - kWall && x < floor.x1 + kWall && y > floor.y0 - kWall &&
           y < floor.y1 + kWall;
  }

  scan::DataRoot data_;
  std::shared_ptr<const graph::GraphSet> graphs_;
  std::shared_ptr<const scan::PanoramaSet> panoramas_;
  std::shared_ptr<render::FaceCache> faces_;
  std::unique_ptr<render::Renderer> renderer_;
};

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

std::vector<draw::SheetPicture> views_of_homes(Artist& artist,
                                               const std::vector<homes::HomeEntry>& homes) {
  std::vector<draw::SheetPicture> pictures;
  for (const homes::HomeEntry& home : homes) {
    const auto room = main_room(home);
    if (!room) continue;
    const homes::Plan plan = homes::make_plan(home.plan);
    const auto look = artist.best_look(home.scan, home.rooms[*room], plan.rooms.at(*room).floor);
    if (!look) continue;
    pictures.push_back({artist.look(home.scan, look->pose),
                        fmt::format("{}, {}\n{}", home.scan, home.kind, home.rooms[*room].name)});
  }
  return pictures;
}

struct RoomLook {
  std::string scan, name;
  Look look;
};

// Of each type of room the one, in any home, of which one sees most.
std::map<char, RoomLook> best_rooms(Artist& artist, const std::vector<homes::HomeEntry>& homes) {
  std::map<char, RoomLook> best;
  for (const homes::HomeEntry& home : homes) {
    const homes::Plan plan = homes::make_plan(home.plan);
    for (std::size_t r = 0; r < home.rooms.size(); ++r) {
      const homes::RoomEntry& room = home.rooms[r];
      const auto look = artist.best_look(home.scan, room, plan.rooms.at(r).floor);
      if (!look) continue;
      const auto known = best.find(room.type);
      if (known != best.end() && known->second.look.worth >= look->worth) continue;
      best[room.type] = {home.scan, room.name, *look};
    }
  }
  return best;
}

// What one sees along a path.
bool draw_walk(Artist& artist, const fs::path& file) {
  const auto episodes = r2r::make_episodes(
      r2r::load_annotations(artist.data().annotations("val_unseen"), "val_unseen"),
      artist.graphs());
  if (episodes.paths.empty()) return false;
  const r2r::ReferencePath& path = episodes.paths.front();
  const graph::NavGraph& graph = artist.graphs()->graph(path.scan);
  std::string title = fmt::format("{} (synthetic), path {}.", graph.scan(), path.path_id);
  for (const r2r::Episode& episode : episodes.episodes) {
    if (&episodes.path_of(episode) == &path) title += "  *  " + episode.text;
  }
  std::vector<draw::SheetPicture> pictures{
      {artist.look(graph.scan(), {path.viewpoints.front(), path.heading}), "start"}};
  Radians heading = path.heading;
  for (std::size_t i = 0; i < path.viewpoints.size(); ++i) {
    const bool last = i + 1 == path.viewpoints.size();
    if (!last) {
      if (const auto* edge = graph.edge(path.viewpoints[i], path.viewpoints[i + 1])) {
        heading = edge->heading;
      }
    }
    pictures.push_back({artist.look(graph.scan(), {path.viewpoints[i], heading}),
                        last ? "goal" : fmt::format("{}", i)});
  }
  write_sheet(file, pictures, title, 4);
  return true;
}

}  // namespace

std::vector<std::string> draw_homes(const fs::path& folder, const fs::path& output) {
  const auto homes = homes::read_home_list(folder);
  Artist artist(folder);
  std::vector<std::string> files;
  const auto sheet = [&](const char* name, const std::vector<draw::SheetPicture>& pictures,
                         const std::string& title) {
    if (pictures.empty()) return;
    write_sheet(output / name, pictures, title);
    files.emplace_back((output / name).string());
  };
  sheet("homes.png", views_of_homes(artist, homes),
        fmt::format("{} model homes (synthetic)", homes.size()));
  std::vector<draw::SheetPicture> views, panoramas;
  for (const auto& [type, room] : best_rooms(artist, homes)) {
    const std::string caption = room.name + "\n" + room.scan;
    views.push_back({artist.look(room.scan, room.look.pose), caption});
    panoramas.push_back({artist.look_around(room.scan, room.look.pose), caption});
  }
  sheet("rooms.png", views, "Rooms of model homes (synthetic)");
  sheet("panoramas.png", panoramas, "A panorama of each type of room (synthetic)");
  std::error_code code;
  if (fs::exists(folder / "r2r" / "R2R_val_unseen.json", code) &&
      draw_walk(artist, output / "walk.png")) {
    files.emplace_back((output / "walk.png").string());
  }
  return files;
}

}  // namespace enfilade::apps
