#include "enfilade/service/browsing/site_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/gzip.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/house.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"

namespace enfilade::service::browsing {
namespace {

using nlohmann::ordered_json;

// The shortest digits of a float: a reader that parses them as a double and rounds gets the same
// float.
ordered_json number(float value) { return ordered_json::parse(fmt::format("{}", value)); }

ordered_json viewpoint_json(const graph::NavGraph& graph, ViewpointIndex v,
                            const scan::PanoramaSource* source) {
  const Vec3f position = graph.position(v);
  ordered_json one{{"id", graph.id(v)},
                   {"included", graph.included(v)},
                   {"position", {number(position.x), number(position.y), number(position.z)}},
                   {"height", number(graph.height(v))}};
  auto& neighbours = one["neighbours"] = ordered_json::array();
  for (const graph::Edge& edge : graph.edges(v)) neighbours.push_back(edge.target.value);
  auto& layers = one["layers"] = ordered_json::array();
  const auto pictured = source == nullptr ? std::nullopt : source->find(graph.id(v));
  if (!pictured) return one;
  one["rotation"] = source->poses()[pictured->at()].world_from_panorama.m;
  const scan::FaceSizes sizes = source->face_sizes(*pictured);
  for (const scan::Layer layer : {scan::Layer::kColour, scan::Layer::kDepth, scan::Layer::kClass}) {
    if (sizes[index(layer)] != 0) layers.push_back(to_string(layer));
  }
  return one;
}

/// Instructions of all splits of R2R, by scan.
std::map<std::string, std::size_t> count_instructions(const Site& site) {
  std::map<std::string, std::size_t> counts;
  for (const PublicSplit& split : site.splits()) {
    if (split.annotations.task != tasks::Task::kR2r) continue;
    for (const auto& path : split.annotations.paths) counts[path.scan] += path.instructions.size();
  }
  return counts;
}

namespace fs = std::filesystem;
using draw::UnderlayLine;

/// Millimetres are enough, and files of half the length.
double to_millimetre(double metres) { return std::round(metres * 1000) / 1000; }

constexpr std::array<std::pair<UnderlayLine::Kind, const char*>, 5> kKinds{
    {{UnderlayLine::Kind::kWall, "walls"},
     {UnderlayLine::Kind::kDoor, "doors"},
     {UnderlayLine::Kind::kWindow, "windows"},
     {UnderlayLine::Kind::kStairs, "stairs"},
     {UnderlayLine::Kind::kThing, "furniture"}}};

/// Lists of numbers, four a line, by kind: as `homes.json` has them.
ordered_json storey_json(double floor, const std::vector<UnderlayLine>& lines) {
  ordered_json out{{"floor", to_millimetre(floor)}};
  for (const auto& [kind, name] : kKinds) {
    auto& list = out[name] = ordered_json::array();
    for (const UnderlayLine& line : lines) {
      if (line.kind != kind) continue;
      for (const double x : {line.from.x, line.from.y, line.to.x, line.to.y}) {
        list.push_back(to_millimetre(x));
      }
    }
  }
  return out;
}

class PlanOfScan {
 public:
  PlanOfScan(const Site& site, ScanIndex scan)
      : site_(site), graph_(site.graphs().graph(scan)), storeys_(draw::find_storeys(graph_)) {
    lines_.resize(storeys_.size());
  }

  ordered_json read() {
    if (!storeys_.empty() && !read_home()) read_house();
    ordered_json out{{"storeys", ordered_json::array()}, {"rooms", rooms_}};
    for (std::size_t s = 0; s < storeys_.size(); ++s) {
      out["storeys"].push_back(storey_json(storeys_[s].floor, lines_[s]));
    }
    return out;
  }

 private:
  /// \param outline corners in order, x and y in turn  \param height metres; 0: unknown
  void add_room(std::string_view name, ordered_json outline, double floor, double height,
                const std::vector<std::string>& viewpoints) {
    auto inside = ordered_json::array();
    for (const std::string& id : viewpoints) {
      if (const auto v = graph_.find(id)) inside.push_back(v->value);
    }
    ordered_json room{{"name", name},
                      {"storey", draw::nearest_storey(storeys_, floor)},
                      {"floor", to_millimetre(floor)},
                      {"outline", std::move(outline)},
                      {"viewpoints", std::move(inside)}};
    if (height > 0) room["height"] = to_millimetre(height);
    rooms_.push_back(std::move(room));
  }

  static ordered_json corners(double x0, double y0, double x1, double y1) {
    return {to_millimetre(x0), to_millimetre(y0), to_millimetre(x1), to_millimetre(y0),
            to_millimetre(x1), to_millimetre(y1), to_millimetre(x0), to_millimetre(y1)};
  }

  /// Whether the folder is of model homes, and this scan one of them.
  bool read_home() {
    if (!fs::exists(site_.folder() / "homes.json")) return false;
    const std::vector<homes::HomeEntry> homes = homes::read_home_list(site_.folder());
    const auto home = std::ranges::find(homes, graph_.scan(), &homes::HomeEntry::scan);
    if (home == homes.end()) return false;
    for (const homes::RoomEntry& room : home->rooms) {
      const Rect& floor = room.floor;
      if (floor.width() <= 0) continue;  // a list of an earlier version has no outlines
      add_room(room.name, corners(floor.x0, floor.y0, floor.x1, floor.y1), room.elevation, 0,
               room.viewpoints);
    }
    // Corrections may have changed the graph, and with it what counts as a storey.
    if (home->lines.storeys.size() == storeys_.size()) {
      for (std::size_t s = 0; s < storeys_.size(); ++s) lines_[s] = home->lines.storeys[s].lines;
    }
    return true;
  }

  std::optional<fs::path> house_file() const {
    for (const fs::path& folder : site_.image_folders()) {
      const fs::path file = find_text_file(folder / graph_.scan() / "house_segmentations" /
                                           (graph_.scan() + ".house"));
      if (fs::exists(file)) return file;
    }
    return std::nullopt;
  }

  void read_house() {
    const auto file = house_file();
    if (!file) return;
    const mesh::House house = mesh::parse_house(read_text_file(*file), file->string());
    for (std::size_t r = 0; r < house.regions.size(); ++r) add_region(house, r);
    for (const mesh::HouseObject& object : house.objects) add_object(house, object);
  }

  void add_region(const mesh::House& house, std::size_t r) {
    const mesh::HouseRegion& region = house.regions[r];
    const double floor = region.box.low.z;
    auto outline = ordered_json::array();
    std::vector<Vec3f> ring;
    for (const mesh::HouseVertex& vertex : house.vertices) {
      const auto surface = static_cast<std::size_t>(vertex.surface);
      if (vertex.surface < 0 || house.surfaces[surface].label != 'F') continue;
      if (house.surfaces[surface].region != static_cast<std::int32_t>(r)) continue;
      ring.push_back(to_float(vertex.position));
    }
    const mesh::HouseBox& box = region.box;
    if (ring.size() < 3) {
      ring.clear();
      for (const auto& [x, y] :
           {std::pair{box.low.x, box.low.y}, std::pair{box.high.x, box.low.y},
            std::pair{box.high.x, box.high.y}, std::pair{box.low.x, box.high.y}})
        ring.push_back(to_float(Vec3d{x, y, floor}));
    }
    for (const Vec3f corner : ring) {
      outline.push_back(to_millimetre(corner.x));
      outline.push_back(to_millimetre(corner.y));
    }
    add_ring(UnderlayLine::Kind::kWall, floor, ring);
    std::vector<std::string> viewpoints;
    for (const mesh::HousePanorama& panorama : house.panoramas) {
      if (panorama.region == static_cast<std::int32_t>(r)) viewpoints.push_back(panorama.name);
    }
    const double height = region.height > 0 ? region.height : box.high.z - floor;
    add_room(region_name(region.label), std::move(outline), floor, height, viewpoints);
  }

  void add_object(const mesh::House& house, const mesh::HouseObject& object) {
    if (object.category < 0) return;
    const std::string& name =
        house.categories[static_cast<std::size_t>(object.category)].mpcat40_name;
    // What is part of the building or hangs on it is no furniture, and beams lie above one's head.
    constexpr std::array<std::string_view, 13> kNoFurniture{
        "void",   "wall",     "floor", "picture", "curtain", "ceiling",  "mirror",
        "column", "lighting", "beam",  "blinds",  "misc",    "unlabeled"};
    if (std::ranges::find(kNoFurniture, name) != kNoFurniture.end()) return;
    const auto kind = name == "door"     ? UnderlayLine::Kind::kDoor
                      : name == "window" ? UnderlayLine::Kind::kWindow
                      : name == "stairs" ? UnderlayLine::Kind::kStairs
                                         : UnderlayLine::Kind::kThing;
    // The box seen from above: of its three half edges, the two that lie flattest.
    const Vec3d up = cross(object.axis0, object.axis1);
    std::array<Vec3d, 3> edges{object.radii.x * object.axis0, object.radii.y * object.axis1,
                               object.radii.z * up};
    std::array<double, 3> steepness{std::abs(object.axis0.z), std::abs(object.axis1.z),
                                    std::abs(up.z)};
    const auto upright =
        static_cast<std::size_t>(std::ranges::max_element(steepness) - steepness.begin());
    const Vec3d a = edges[(upright + 1) % 3], b = edges[(upright + 2) % 3], at = object.position;
    const std::vector<Vec3f> ring{to_float(at + a + b), to_float(at + a - b), to_float(at - a - b),
                                  to_float(at - a + b)};
    add_ring(kind, at.z, ring);
  }

  void add_ring(UnderlayLine::Kind kind, double height, const std::vector<Vec3f>& ring) {
    std::vector<UnderlayLine>& lines = lines_[draw::nearest_storey(storeys_, height)];
    for (std::size_t k = 0; k < ring.size(); ++k) {
      lines.push_back({kind, ring[k], ring[(k + 1) % ring.size()]});
    }
  }

  /// What Matterport3D's letters of regions stand for.
  static std::string_view region_name(char label) {
    constexpr std::pair<char, std::string_view> kNames[]{
        {'a', "bathroom"},     {'b', "bedroom"},      {'c', "closet"},       {'d', "dining room"},
        {'e', "entrance"},     {'f', "family room"},  {'g', "garage"},       {'h', "hallway"},
        {'i', "library"},      {'j', "laundry room"}, {'k', "kitchen"},      {'l', "living room"},
        {'m', "meeting room"}, {'n', "lounge"},       {'o', "office"},       {'p', "porch"},
        {'r', "games room"},   {'s', "stairs"},       {'t', "toilet"},       {'u', "utility room"},
        {'v', "TV room"},      {'w', "gym"},          {'x', "outdoors"},     {'y', "balcony"},
        {'B', "bar"},          {'C', "classroom"},    {'D', "dining booth"}, {'S', "spa"}};
    const auto found = std::ranges::find(kNames, label, &std::pair<char, std::string_view>::first);
    return found == std::end(kNames) ? "" : found->second;
  }

  const Site& site_;
  const graph::NavGraph& graph_;
  std::vector<draw::GraphStorey> storeys_;
  std::vector<std::vector<UnderlayLine>> lines_;  // by storey
  ordered_json rooms_ = ordered_json::array();
};

}  // namespace

ordered_json scan_list_json(const Site& site) {
  auto list = ordered_json::array();
  auto instructions = count_instructions(site);
  const auto to_roam = scans_to_roam(site);
  for (std::size_t s = 0; s < site.graphs().size(); ++s) {
    const graph::NavGraph& graph = site.graphs().graph(ScanIndex(s));
    ordered_json one{{"scan", graph.scan()},
                     {"viewpoints", graph.included_count()},
                     {"edges", graph.edge_count() / 2},
                     {"storeys", draw::find_storeys(graph).size()},
                     {"instructions", instructions[std::string(graph.scan())]},
                     {"pictures", site.panoramas().find_source(ScanIndex(s)) != nullptr},
                     {"roam", to_roam.contains(graph.scan())}};
    if (const auto rooms = site.rooms(ScanIndex(s))) one["rooms"] = *rooms;
    list.push_back(std::move(one));
  }
  return {{"synthetic", site.synthetic()}, {"scans", list}};
}

ordered_json scan_json(const Site& site, ScanIndex scan) {
  const graph::NavGraph& graph = site.graphs().graph(scan);
  const scan::PanoramaSource* source = site.panoramas().find_source(scan);
  ordered_json out{{"scan", graph.scan()},
                   {"synthetic", site.synthetic()},
                   {"roam", scans_to_roam(site).contains(graph.scan())}};
  auto& storeys = out["storeys"] = ordered_json::array();
  for (const draw::GraphStorey& storey : draw::find_storeys(graph)) {
    auto& list = storeys.emplace_back(ordered_json{{"floor", storey.floor}})["viewpoints"] =
        ordered_json::array();
    for (const ViewpointIndex v : storey.viewpoints) list.push_back(v.value);
  }
  auto& viewpoints = out["viewpoints"] = ordered_json::array();
  for (std::size_t v = 0; v < graph.size(); ++v) {
    viewpoints.push_back(viewpoint_json(graph, ViewpointIndex(v), source));
  }
  return out;
}

ordered_json split_list_json(const Site& site, std::optional<tasks::Task> task) {
  auto list = ordered_json::array();
  for (const PublicSplit& split : site.splits()) {
    const tasks::Annotations& annotations = split.annotations;
    if (task && annotations.task != *task) continue;
    std::size_t instructions = 0;
    for (const auto& path : annotations.paths) instructions += path.instructions.size();
    list.push_back({{"split", annotations.split},
                    {"task", tasks::benchmark(annotations.task).name},
                    {"title", tasks::benchmark(annotations.task).title},
                    {"paths", annotations.paths.size()},
                    {"instructions", instructions},
                    {"goals_hidden", split.goals_hidden}});
  }
  ordered_json out;
  if (task) out["task"] = tasks::benchmark(*task).name;
  out["splits"] = list;
  return out;
}

ordered_json plan_json(const Site& site, ScanIndex scan) { return PlanOfScan(site, scan).read(); }

}  // namespace enfilade::service::browsing
