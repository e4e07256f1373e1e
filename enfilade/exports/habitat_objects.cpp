#include "enfilade/exports/habitat_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/exports/detail/habitat_points.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::exports {
namespace {

using mesh::Mpcat40;
using ObjectJson = nlohmann::ordered_json;

// ObjectNav's categories on Matterport3D, in the order of their task ids, which begin at 0.
constexpr std::array<Mpcat40::Category, 21> kTaskCategories{
    Mpcat40::kChair,   Mpcat40::kTable,     Mpcat40::kPicture,      Mpcat40::kCabinet,
    Mpcat40::kCushion, Mpcat40::kSofa,      Mpcat40::kBed,          Mpcat40::kChestOfDrawers,
    Mpcat40::kPlant,   Mpcat40::kSink,      Mpcat40::kToilet,       Mpcat40::kStool,
    Mpcat40::kTowel,   Mpcat40::kTvMonitor, Mpcat40::kShower,       Mpcat40::kBathtub,
    Mpcat40::kCounter, Mpcat40::kFireplace, Mpcat40::kGymEquipment, Mpcat40::kSeating,
    Mpcat40::kClothes};

constexpr float kStep = 0.25F;                  // metres between places around an object
constexpr float kBeside = 1;                    // metres from its box at most
constexpr double kWellSeen = 0.05;              // least intersection over union
constexpr double kLeastWay = 1, kMostWay = 30;  // metres from a start to the nearest view
constexpr std::size_t kTriesPerEpisode = 50;

// A coarse image of ObjectNav's camera, 640 x 480 with hfov 79 degrees, and its middle.
constexpr std::size_t kWide = 32, kHigh = 24;
constexpr float kHalfWidth = 0.82433639F;  // tangent of 39.5 degrees
constexpr float kHalfHeight = kHalfWidth * kHigh / kWide;
constexpr bool in_middle(std::size_t row, std::size_t column) {
  return row >= kHigh / 4 && row < kHigh - kHigh / 4 && column >= kWide / 4 &&
         column < kWide - kWide / 4;
}

Vec3f of_length_1(Vec3f v) { return (1 / length(v)) * v; }

// Intersection over union of an object's pixels and the image's middle, seen from `eye`.
double iou_from(Vec3f eye, Vec3f middle, std::uint32_t object, const mesh::RayTracer& tracer) {
  const Vec3f ahead = middle - eye;
  if (std::hypot(ahead.x, ahead.y) < 1e-3F) return 0;  // straight above or below
  const Vec3f front = of_length_1(ahead), right = of_length_1(cross(front, Vec3f{0, 0, 1}));
  const Vec3f up = cross(right, front);
  std::array<mesh::Ray, kWide * kHigh> rays;
  std::array<mesh::Hit, kWide * kHigh> hits;
  for (std::size_t row = 0; row < kHigh; ++row) {
    for (std::size_t column = 0; column < kWide; ++column) {
      const float x = (2 * static_cast<float>(column) + 1) / kWide - 1;
      const float y = 1 - (2 * static_cast<float>(row) + 1) / kHigh;
      rays[row * kWide + column] = {eye, front + (x * kHalfWidth) * right + (y * kHalfHeight) * up,
                                    0};
    }
  }
  tracer.trace(rays, hits);
  std::size_t both = 0, either = 0;
  for (std::size_t k = 0; k < hits.size(); ++k) {
    const bool seen = hits[k] && object_of(tracer.mesh(), hits[k].triangle) == object;
    const bool middle_one = in_middle(k / kWide, k % kWide);
    both += seen && middle_one ? 1 : 0;
    either += seen || middle_one ? 1 : 0;
  }
  return static_cast<double>(both) / static_cast<double>(either);
}

// A box of the .house file, whose axes are those of the world.
struct PlaneBox {
  float x0, y0, x1, y1;
  float beside(Vec3f p) const {
    return std::hypot(std::max({x0 - p.x, p.x - x1, 0.0F}), std::max({y0 - p.y, p.y - y1, 0.0F}));
  }
};

class ObjectFinder {
 public:
  ObjectFinder(const HabitatIsland& island, const HabitatIsland& own, const mesh::RayTracer& tracer,
               const mesh::House& house)
      : island_(island), own_(own), tracer_(tracer), house_(house) {}

  std::optional<ObjectGoal> find(std::size_t object) const {
    const mesh::HouseObject& o = house_.objects[object];
    if (o.category < 0 || o.region < 0) return std::nullopt;
    const mesh::HouseCategory& category = house_.categories[static_cast<std::size_t>(o.category)];
    if (std::ranges::find(kTaskCategories, category.mpcat40_index) == kTaskCategories.end()) {
      return std::nullopt;
    }
    const std::string& name = tracer_.mesh().objects[object].name;
    ObjectGoal goal{object, name, category.mpcat40_name, to_float(o.position), views_of(object)};
    if (goal.views.empty()) return std::nullopt;
    return goal;
  }

  /// The point of own floor at a point that is on both.
  std::optional<Vec3f> on_both(Vec3f point) const {
    const auto at = detail::on_island(own_, point);
    return at && detail::on_island(island_, *at) ? at : std::nullopt;
  }

 private:
  std::vector<ObjectView> views_of(std::size_t object) const {
    const mesh::HouseObject& o = house_.objects[object];
    const Vec3f middle = to_float(o.position), half = to_float(o.radii);
    const PlaneBox box{middle.x - half.x, middle.y - half.y, middle.x + half.x, middle.y + half.y};
    const auto floor =
        static_cast<float>(house_.regions[static_cast<std::size_t>(o.region)].box.low.z);
    std::vector<ObjectView> views;
    const auto steps = [](float from, float to) {
      return static_cast<std::size_t>((to - from) / kStep) + 1;
    };
    const float x0 = box.x0 - kBeside, y0 = box.y0 - kBeside;
    for (std::size_t i = 0; i < steps(x0, box.x1 + kBeside); ++i) {
      for (std::size_t k = 0; k < steps(y0, box.y1 + kBeside); ++k) {
        const Vec3f place{x0 + static_cast<float>(i) * kStep, y0 + static_cast<float>(k) * kStep,
                          floor};
        if (box.beside(place) > kBeside) continue;
        if (const auto at = on_both(place)) add_view(*at, middle, object, views);
      }
    }
    std::ranges::stable_sort(views, std::ranges::greater{}, &ObjectView::iou);
    return views;
  }

  void add_view(Vec3f at, Vec3f middle, std::size_t object, std::vector<ObjectView>& views) const {
    const Vec3f eye{at.x, at.y, at.z + static_cast<float>(kObjectNavBody.height)};
    const double iou = iou_from(eye, middle, static_cast<std::uint32_t>(object), tracer_);
    if (iou < kWellSeen) return;
    const Radians heading(
        std::atan2(static_cast<double>(middle.x - at.x), static_cast<double>(middle.y - at.y)));
    views.push_back({at, tasks::StartRotation::of(heading), iou});
  }

  const HabitatIsland& island_;
  const HabitatIsland& own_;
  const mesh::RayTracer& tracer_;
  const mesh::House& house_;
};

// The views of all objects of a category, and whose they are.
struct CategoryViews {
  std::string_view category;
  std::vector<Vec3f> at;
  std::vector<std::size_t> object;
};
std::vector<CategoryViews> by_category(const std::vector<ObjectGoal>& goals) {
  std::vector<CategoryViews> all;
  for (const ObjectGoal& goal : goals) {
    auto found = std::ranges::find(all, std::string_view(goal.category), &CategoryViews::category);
    if (found == all.end()) found = all.insert(all.end(), {goal.category, {}, {}});
    for (const ObjectView& view : goal.views) {
      found->at.push_back(view.at);
      found->object.push_back(goal.object);
    }
  }
  return all;
}

std::string goals_key(const std::string& scan, std::string_view category) {
  return fmt::format("{}.glb_{}", scan, category);
}

ObjectJson json_of_goal(const ObjectGoal& goal) {
  ObjectJson views = ObjectJson::array();
  for (const ObjectView& view : goal.views) {
    views.push_back({{"agent_state",
                      {{"position", detail::habitat_point(view.at)},
                       {"rotation", detail::habitat_rotation(view.rotation)}}},
                     {"iou", view.iou}});
  }
  return {{"position", detail::habitat_point(goal.middle)},
          {"radius", nullptr},
          {"object_id", goal.object},
          {"object_name", goal.name},
          {"object_category", goal.category},
          {"view_points", std::move(views)}};
}

ObjectJson json_of_episode(const ObjectGoalEpisode& e, const std::string& scan, std::size_t id) {
  return {{"episode_id", fmt::to_string(id)},
          {"scene_id", tasks::scene_of_scan(scan, "mp3d")},
          {"start_position", detail::habitat_point(e.start)},
          {"start_rotation", detail::habitat_rotation(e.rotation)},
          {"info",
           {{"geodesic_distance", e.geodesic_distance},
            {"euclidean_distance", e.euclidean_distance},
            {"closest_goal_object_id", e.closest}}},
          {"goals", ObjectJson::array()},
          {"object_category", e.category}};
}

}  // namespace

ObjectGoalScene draw_object_goals(const std::string& scan, const HabitatIsland& island,
                                  const HabitatIsland& own, const mesh::RayTracer& tracer,
                                  const mesh::House& house, const HabitatDraws& draws) {
  EN_CHECK_EQ(tracer.mesh().objects.size(), house.objects.size());
  const ObjectFinder finder(island, own, tracer, house);
  ObjectGoalScene scene{scan, {}, {}};
  for (std::size_t k = 0; k < house.objects.size(); ++k) {
    if (auto goal = finder.find(k)) scene.goals.push_back(std::move(*goal));
  }
  const std::vector<CategoryViews> categories = by_category(scene.goals);
  if (categories.empty()) return scene;
  Rng rng = detail::draws_of_scene(draws, scan, "objectnav");
  const detail::IslandDraw points(own);
  for (std::size_t tries = 0;
       tries < kTriesPerEpisode * draws.per_scene && scene.episodes.size() < draws.per_scene;
       ++tries) {
    const CategoryViews& wanted = categories[rng.below(categories.size())];
    const auto drawn = points.draw(rng);
    const auto start = drawn ? finder.on_both(*drawn) : std::nullopt;
    if (!start) continue;
    const auto nearest = own.floor.nearest_goal(*start, wanted.at);
    if (!nearest || nearest->distance < kLeastWay || nearest->distance > kMostWay) continue;
    scene.episodes.push_back(
        {std::string(wanted.category), *start, detail::draw_rotation(rng), nearest->distance,
         length(to_double(wanted.at[nearest->goal] - *start)), wanted.object[nearest->goal]});
  }
  return scene;
}

std::string object_goals_json(std::span<const ObjectGoalScene> scenes) {
  std::string text = R"({"episodes": [)";
  std::size_t id = 0;
  for (const ObjectGoalScene& scene : scenes) {
    for (const ObjectGoalEpisode& episode : scene.episodes) {
      text += id == 0 ? "\n" : ",\n";
      text += json_of_episode(episode, scene.scan, id++).dump();
    }
  }
  text += "],\n\"goals_by_category\": {";
  const char* before = "\n";
  for (const ObjectGoalScene& scene : scenes) {
    std::map<std::string, ObjectJson> goals;
    for (const ObjectGoal& goal : scene.goals) {
      ObjectJson& list = goals[goals_key(scene.scan, goal.category)];
      list.push_back(json_of_goal(goal));
    }
    for (const auto& [key, list] : goals) {
      text += before + ObjectJson(key).dump() + ": " + list.dump();
      before = ",\n";
    }
  }
  ObjectJson task_ids, class_ids;
  for (std::size_t k = 0; k < kTaskCategories.size(); ++k) {
    const std::string name(mesh::class_name(kTaskCategories[k]));
    task_ids[name] = k;
    class_ids[name] = static_cast<int>(kTaskCategories[k]);
  }
  return text + "},\n\"category_to_task_category_id\": " + task_ids.dump() +
         ",\n\"category_to_mp3d_category_id\": " + class_ids.dump() + "}\n";
}

}  // namespace enfilade::exports
