#include "apps/enfilade/home_pictures.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "apps/enfilade/picture_files.h"
#include "enfilade/draw/contact_sheet.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/mesh/house.h"
#include "enfilade/r2r/annotations.h"
#include "enfilade/synth/home_set.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

constexpr Size kThumb{400, 300};
constexpr double kVfov = 65;  // degrees

struct Pose {
  ViewpointIndex viewpoint;
  Radians heading;
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

  image::Image8 look(const std::string& scan, Pose pose, Radians elevation = degrees(-8)) {
    Drawn drawn;
    const render::Outputs outputs = outputs_into(drawn, {{scan::Layer::kColour, ""}}, kThumb);
    const render::View view{panoramas_->at(scan), pose.viewpoint, pose.heading, elevation};
    renderer_->render({kThumb.width, kThumb.height, degrees(kVfov)}, {&view, 1}, outputs);
    return std::move(drawn.colour);
  }

  // Where one looks across a room: of the viewpoints in it, and the ways to their neighbours and
  // between them, that with the most to see at a middle distance.
  std::optional<Pose> best_view(const std::string& scan, const synth::RoomEntry& room) {
    const graph::NavGraph& graph = graphs_->graph(scan);
    constexpr std::size_t kHeadings = 12;
    std::optional<Pose> best;
    double most = 0;
    for (const std::string& id : room.viewpoints) {
      const auto v = graph.find(id);
      if (!v) continue;
      for (std::size_t k = 0; k < kHeadings; ++k) {
        const Pose pose{*v, degrees(360.0 * static_cast<double>(k) / kHeadings)};
        const double seen = interest(scan, pose);
        if (seen <= most) continue;
        most = seen;
        best = pose;
      }
    }
    return best;
  }

 private:
  // Many things, none of them right before one's eyes.
  double interest(const std::string& scan, Pose pose) {
    constexpr Size kSmall{64, 48};
    Drawn drawn;
    const render::Outputs outputs =
        outputs_into(drawn, {{scan::Layer::kDepth, ""}, {scan::Layer::kInstance, ""}}, kSmall);
    const render::View view{panoramas_->at(scan), pose.viewpoint, pose.heading, degrees(-8)};
    renderer_->render({kSmall.width, kSmall.height, degrees(kVfov)}, {&view, 1}, outputs);
    std::map<std::uint32_t, std::size_t> counts;
    double near = 0;
    for (std::size_t i = 0; i < drawn.depth.pixels.size(); ++i) {
      ++counts[drawn.instances.pixels[i]];
      if (drawn.depth.pixels[i] < 1.0 * scan::kDepthUnitsPerMetre) near += 1;
    }
    double things = 0;
    for (const auto& [id, pixels] : counts) things += pixels >= 12 ? 1 : 0;
    return things * (1 - near / static_cast<double>(drawn.depth.pixels.size()));
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

// The room that people spend their days in, else the one with most viewpoints.
const synth::RoomEntry* main_room(const synth::HomeEntry& home) {
  for (const char type : {'l', 'f', 'n', 'm', 'o', 'b'}) {
    for (const synth::RoomEntry& room : home.rooms) {
      if (room.type == type && !room.viewpoints.empty()) return &room;
    }
  }
  const auto most = std::ranges::max_element(
      home.rooms, {}, [](const synth::RoomEntry& room) { return room.viewpoints.size(); });
  return most == home.rooms.end() ? nullptr : &*most;
}

std::vector<draw::SheetPicture> views_of_homes(Artist& artist,
                                               const std::vector<synth::HomeEntry>& homes) {
  std::vector<draw::SheetPicture> pictures;
  for (const synth::HomeEntry& home : homes) {
    const synth::RoomEntry* room = main_room(home);
    const auto pose = room == nullptr ? std::nullopt : artist.best_view(home.scan, *room);
    if (!pose) continue;
    pictures.push_back({artist.look(home.scan, *pose),
                        fmt::format("{}, {}\n{}", home.scan, home.kind, room->name)});
  }
  return pictures;
}

std::vector<draw::SheetPicture> views_of_rooms(Artist& artist,
                                               const std::vector<synth::HomeEntry>& homes) {
  std::vector<draw::SheetPicture> pictures;
  std::set<char> shown;
  for (const synth::HomeEntry& home : homes) {
    for (const synth::RoomEntry& room : home.rooms) {
      if (shown.contains(room.type)) continue;
      const auto pose = artist.best_view(home.scan, room);
      if (!pose) continue;
      shown.insert(room.type);
      pictures.push_back({artist.look(home.scan, *pose), room.name + "\n" + home.scan});
    }
  }
  return pictures;
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
  const auto homes = synth::read_home_list(folder);
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
  sheet("rooms.png", views_of_rooms(artist, homes), "Rooms of model homes (synthetic)");
  std::error_code code;
  if (fs::exists(folder / "r2r" / "R2R_val_unseen.json", code) &&
      draw_walk(artist, output / "walk.png")) {
    files.emplace_back((output / "walk.png").string());
  }
  return files;
}

}  // namespace enfilade::apps
