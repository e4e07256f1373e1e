#include "enfilade/homes/building_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/house.h"

namespace enfilade::homes {
namespace {

namespace fs = std::filesystem;
using draw::UnderlayLine;

// What Matterport3D's letters of regions stand for.
std::string_view region_name(char label) {
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

// The kind of an object's lines; no value for what is part of the building or hangs on it, and for
// beams, which lie above one's head.
std::optional<UnderlayLine::Kind> kind_of(std::string_view category) {
  constexpr std::array<std::string_view, 13> kNoFurniture{
      "void",   "wall",     "floor", "picture", "curtain", "ceiling",  "mirror",
      "column", "lighting", "beam",  "blinds",  "misc",    "unlabeled"};
  if (std::ranges::find(kNoFurniture, category) != kNoFurniture.end()) return std::nullopt;
  return category == "door"     ? UnderlayLine::Kind::kDoor
         : category == "window" ? UnderlayLine::Kind::kWindow
         : category == "stairs" ? UnderlayLine::Kind::kStairs
                                : UnderlayLine::Kind::kThing;
}

class PlanReader {
 public:
  explicit PlanReader(const graph::NavGraph& graph)
      : graph_(graph), storeys_(draw::find_storeys(graph)) {
    plan_.underlay.storeys.resize(storeys_.size());
  }

  BuildingPlan read(const fs::path& data, std::span<const fs::path> images) {
    if (!storeys_.empty() && !read_home(data)) read_house(images);
    for (const PlannedRoom& room : plan_.rooms) name_room(room);
    return std::move(plan_);
  }

 private:
  void add_room(std::string_view name, std::vector<Vec3f> outline, double floor, double height,
                const std::vector<std::string>& viewpoints) {
    PlannedRoom room{std::string(name),
                     draw::nearest_storey(storeys_, floor),
                     floor,
                     height,
                     std::move(outline),
                     {}};
    for (const std::string& id : viewpoints) {
      if (const auto v = graph_.find(id)) room.viewpoints.push_back(*v);
    }
    plan_.rooms.push_back(std::move(room));
  }

  // In the middle of the box around it.
  void name_room(const PlannedRoom& room) {
    if (room.name.empty() || room.outline.empty()) return;
    Vec3f low = room.outline.front(), high = low;
    for (const Vec3f corner : room.outline) {
      low = {std::min(low.x, corner.x), std::min(low.y, corner.y), low.z};
      high = {std::max(high.x, corner.x), std::max(high.y, corner.y), high.z};
    }
    plan_.underlay.storeys[room.storey].texts.push_back({0.5F * (low + high), room.name});
  }

  // Whether the folder is of synthetic homes, and this building one of them.
  bool read_home(const fs::path& data) {
    if (!file_exists(data / "homes.json")) return false;
    std::vector<HomeEntry> homes = read_home_list(data);
    const auto found = std::ranges::find(homes, graph_.scan(), &HomeEntry::scan);
    if (found == homes.end()) return false;
    // The graph was changed since and has another number of storeys: the lines are drawn again.
    if (found->lines.storeys.size() != storeys_.size()) found->lines = {};
    HomeEntry home = completed(std::move(*found), data);
    for (const RoomEntry& room : home.rooms) {
      const auto corner = [&room](double x, double y) {
        return to_float(Vec3d{x, y, room.elevation});
      };
      const Rect& r = room.floor;
      add_room(room.name,
               {corner(r.x0, r.y0), corner(r.x1, r.y0), corner(r.x1, r.y1), corner(r.x0, r.y1)},
               room.elevation, 0, room.viewpoints);
    }
    // They are of the graph in the folder, which may not be this one.
    if (home.lines.storeys.size() == storeys_.size()) plan_.underlay = std::move(home.lines);
    return true;
  }

  void read_house(std::span<const fs::path> images) {
    for (const fs::path& folder : images) {
      const fs::path file = find_text_file(folder / graph_.scan() / "house_segmentations" /
                                           (graph_.scan() + ".house"));
      if (!file_exists(file)) continue;
      const mesh::House house = mesh::parse_house(read_text_file(file), file.string());
      for (std::size_t r = 0; r < house.regions.size(); ++r) add_region(house, r);
      for (const mesh::HouseObject& object : house.objects) add_object(house, object);
      return;
    }
  }

  void add_region(const mesh::House& house, std::size_t r) {
    const mesh::HouseRegion& region = house.regions[r];
    const mesh::HouseBox& box = region.box;
    const double floor = box.low.z;
    std::vector<Vec3f> ring;
    for (const mesh::HouseVertex& vertex : house.vertices) {
      const auto surface = static_cast<std::size_t>(vertex.surface);
      if (vertex.surface < 0 || house.surfaces[surface].label != 'F') continue;
      if (house.surfaces[surface].region != static_cast<std::int32_t>(r)) continue;
      ring.push_back(to_float(vertex.position));
    }
    if (ring.size() < 3) {
      ring.clear();
      for (const auto& [x, y] :
           {std::pair{box.low.x, box.low.y}, std::pair{box.high.x, box.low.y},
            std::pair{box.high.x, box.high.y}, std::pair{box.low.x, box.high.y}}) {
        ring.push_back(to_float(Vec3d{x, y, floor}));
      }
    }
    add_ring(UnderlayLine::Kind::kWall, floor, ring);
    std::vector<std::string> viewpoints;
    for (const mesh::HousePanorama& panorama : house.panoramas) {
      if (panorama.region == static_cast<std::int32_t>(r)) viewpoints.push_back(panorama.name);
    }
    const double height = region.height > 0 ? region.height : box.high.z - floor;
    add_room(region_name(region.label), std::move(ring), floor, height, viewpoints);
  }

  void add_object(const mesh::House& house, const mesh::HouseObject& object) {
    if (object.category < 0) return;
    const auto kind =
        kind_of(house.categories[static_cast<std::size_t>(object.category)].mpcat40_name);
    if (!kind) return;
    // The box seen from above: of its three half edges, the two that lie flattest.
    const Vec3d up = cross(object.axis0, object.axis1);
    const std::array<Vec3d, 3> edges{object.radii.x * object.axis0, object.radii.y * object.axis1,
                                     object.radii.z * up};
    const std::array<double, 3> steepness{std::abs(object.axis0.z), std::abs(object.axis1.z),
                                          std::abs(up.z)};
    const auto upright =
        static_cast<std::size_t>(std::ranges::max_element(steepness) - steepness.begin());
    const Vec3d a = edges[(upright + 1) % 3], b = edges[(upright + 2) % 3], at = object.position;
    // Above half a storey, an object's middle is nearer to the floor above than to its own.
    const double floor = object.region < 0
                             ? at.z - std::abs(edges[upright].z)
                             : house.regions[static_cast<std::size_t>(object.region)].box.low.z;
    add_ring(
        *kind, floor,
        {to_float(at + a + b), to_float(at + a - b), to_float(at - a - b), to_float(at - a + b)});
  }

  void add_ring(UnderlayLine::Kind kind, double floor, const std::vector<Vec3f>& ring) {
    std::vector<UnderlayLine>& lines =
        plan_.underlay.storeys[draw::nearest_storey(storeys_, floor)].lines;
    for (std::size_t k = 0; k < ring.size(); ++k) {
      lines.push_back({kind, ring[k], ring[(k + 1) % ring.size()]});
    }
  }

  const graph::NavGraph& graph_;
  std::vector<draw::GraphStorey> storeys_;
  BuildingPlan plan_;
};

}  // namespace

const draw::PlanUnderlay* BuildingPlan::drawn() const noexcept {
  const bool any = std::ranges::any_of(
      underlay.storeys, [](const draw::UnderlayStorey& storey) { return !storey.lines.empty(); });
  return any ? &underlay : nullptr;
}

BuildingPlan read_building_plan(const fs::path& data, std::span<const fs::path> images,
                                const graph::NavGraph& graph) {
  return PlanReader(graph).read(data, images);
}

}  // namespace enfilade::homes
