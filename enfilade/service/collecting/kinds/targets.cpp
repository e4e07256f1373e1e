#include "enfilade/service/collecting/kinds/targets.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <ranges>
#include <set>
#include <utility>
#include <variant>

#include "enfilade/draw/outlines.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::service::collecting::kinds {
namespace {

using nlohmann::ordered_json;

// Slack of a product of sines: edges are included in spite of rounding.
constexpr double kSlack = 1e-9;

double area_of(const std::array<std::int32_t, 4>& box) {
  return static_cast<double>(box[2]) * static_cast<double>(box[3]);
}

/// Those of them that can be walked to, sorted, each once.
std::vector<std::string> in_graph(std::vector<std::string> viewpoints,
                                  const graph::NavGraph& graph) {
  std::erase_if(viewpoints, [&graph](const std::string& id) {
    const auto v = graph.find(id);
    return !v || !graph.included(*v);
  });
  std::ranges::sort(viewpoints);
  viewpoints.erase(std::unique(viewpoints.begin(), viewpoints.end()), viewpoints.end());
  return viewpoints;
}

/// \param viewpoints the searched ones
Outlines outlines_of(const tasks::ObjectBoxes& objects, const std::string& scan,
                     const std::vector<std::string>& viewpoints, std::int64_t object) {
  Outlines outlines;
  for (const std::string& viewpoint : viewpoints) {
    for (const tasks::ViewedObject& one : objects.at(scan, viewpoint)) {
      if (one.id != object || !one.visible()) continue;
      std::vector<std::pair<double, Outline>> found;
      for (std::size_t k = 0; k < one.views.size(); ++k) {
        found.emplace_back(-area_of(one.boxes[k]), outline_of(one.views[k], one.boxes[k]));
      }
      std::ranges::stable_sort(found, {}, &std::pair<double, Outline>::first);
      auto& list = outlines[viewpoint];
      for (auto& [size, outline] : found) list.push_back(outline);
    }
  }
  return outlines;
}

}  // namespace

Outline outline_of(std::uint8_t view, const std::array<std::int32_t, 4>& box) {
  const std::vector<Vec3d> rim = draw::outline_of_box(view, box).rim;
  Outline corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    corners[k] = draw::direction_of(rim[k * rim.size() / corners.size()]);
  }
  return corners;
}

bool contains(const Outline& outline, const tasks::Direction& direction) {
  const Vec3d point = draw::unit_vector(direction);
  Vec3d middle;
  for (const tasks::Direction& corner : outline) middle += draw::unit_vector(corner);
  if (dot(point, middle) <= 0) return false;  // behind one's back
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Vec3d edge =
        cross(draw::unit_vector(outline[k]), draw::unit_vector(outline[(k + 1) % outline.size()]));
    if (dot(edge, point) * dot(edge, middle) < -kSlack) return false;
  }
  return true;
}

std::string outlines_json(const Outlines& outlines) {
  ordered_json out = ordered_json::object();
  for (const auto& [viewpoint, list] : outlines) {
    auto& entry = out[viewpoint] = ordered_json::array();
    for (const Outline& outline : list) {
      auto corners = ordered_json::array();
      for (const tasks::Direction& corner : outline) {
        const double heading = detail::rounded(corner.heading.value);  // 2 pi is north, as 0 is
        corners.push_back(
            {heading < 2 * kPi ? heading : 0, detail::rounded(corner.elevation.value)});
      }
      entry.push_back(std::move(corners));
    }
  }
  return out.dump();
}

Outlines parse_outlines(const std::string& json) {
  Outlines outlines;
  if (json.empty()) return outlines;
  const auto read = ordered_json::parse(json);
  for (const auto& [viewpoint, list] : read.items()) {
    for (const auto& corners : list) {
      Outline outline;
      for (std::size_t k = 0; k < outline.size(); ++k) {
        outline[k] = {Radians(corners.at(k).at(0).get<double>()),
                      Radians(corners.at(k).at(1).get<double>())};
      }
      outlines[viewpoint].push_back(outline);
    }
  }
  return outlines;
}

std::optional<std::int64_t> object_at(const tasks::ObjectBoxes& objects, const std::string& scan,
                                      const std::string& viewpoint,
                                      const tasks::Direction& direction) {
  std::optional<std::int64_t> found;
  double least = std::numeric_limits<double>::infinity();
  for (const tasks::ViewedObject& one : objects.at(scan, viewpoint)) {
    for (std::size_t k = 0; k < one.views.size(); ++k) {
      const double area = area_of(one.boxes[k]);
      if (area >= least || !contains(outline_of(one.views[k], one.boxes[k]), direction)) continue;
      least = area;
      found = one.id;
    }
  }
  return found;
}

std::optional<PathTarget> KnownObjects::target_of(const std::string& scan,
                                                  const tasks::ViewedObject& object) const {
  PathTarget target{object.id, tasks::spoken_name(object.name), {}, ""};
  target.region = in_graph(boxes_->seen_from(scan, object.id), graphs_.graph(scan));
  if (target.region.empty()) return std::nullopt;
  target.outlines = outlines_json(outlines_of(*boxes_, scan, target.region, object.id));
  return target;
}

/// The object of that number, around any viewpoint that sees it.
std::optional<PathTarget> KnownObjects::named_target(const std::string& scan,
                                                     std::int64_t object) const {
  if (boxes_ == nullptr) return std::nullopt;
  for (const std::string& viewpoint : boxes_->seen_from(scan, object)) {
    for (const tasks::ViewedObject& one : boxes_->at(scan, viewpoint)) {
      if (one.id == object) return target_of(scan, one);
    }
  }
  return std::nullopt;
}

const KnownObjects::Names& KnownObjects::single_names(const std::string& scan,
                                                      const std::string& viewpoint) {
  const auto room = rooms_ == nullptr ? std::nullopt : rooms_->find(scan, viewpoint);
  const auto [known, fresh] =
      single_names_.try_emplace({scan, room ? fmt::format("room {}", *room) : viewpoint});
  Names& names = known->second;
  if (!fresh) return names;
  std::map<std::string, std::set<std::int64_t>> objects;
  const auto look = [&](const std::string& from) {
    for (const tasks::ViewedObject& one : boxes_->at(scan, from)) {
      if (one.visible()) objects[tasks::spoken_name(one.name)].insert(one.id);
    }
  };
  look(viewpoint);
  const graph::NavGraph& graph = graphs_.graph(scan);
  for (std::size_t v = 0; room && v < graph.size(); ++v) {
    const std::string id(graph.id(ViewpointIndex(v)));
    if (rooms_->find(scan, id) == room) look(id);
  }
  for (const auto& [name, numbers] : objects) {
    if (numbers.size() == 1) names.insert(name);
  }
  return names;
}

std::vector<PathTarget> KnownObjects::targets_of(const tasks::PathAnnotation& path,
                                                 std::size_t most) {
  std::vector<PathTarget> targets;
  if (const auto* region = std::get_if<tasks::NamedRegion>(&path.goal)) {
    PathTarget target{std::nullopt, region->target,
                      in_graph(region->viewpoints, graphs_.graph(path.scan)), ""};
    if (!target.region.empty()) targets.push_back(std::move(target));
    return targets;
  }
  if (const auto* object = std::get_if<tasks::NamedObject>(&path.goal)) {
    if (auto target = named_target(path.scan, object->id)) targets.push_back(std::move(*target));
    return targets;
  }
  if (boxes_ == nullptr) return targets;
  const Names& names = single_names(path.scan, path.path.back());
  const auto around = boxes_->at(path.scan, path.path.back());
  std::vector<tasks::ViewedObject> seen(around.begin(), around.end());
  std::erase_if(seen, [&names](const tasks::ViewedObject& one) {
    return !one.visible() || !tasks::can_be_asked_for(one.name) ||
           !names.contains(tasks::spoken_name(one.name));
  });
  const auto shown_area = [](const tasks::ViewedObject& one) {
    return std::ranges::max(one.boxes | std::views::transform(area_of));
  };
  std::ranges::stable_sort(seen, std::ranges::greater(), shown_area);
  for (const tasks::ViewedObject& one : seen) {
    if (targets.size() == most) break;
    if (auto target = target_of(path.scan, one)) targets.push_back(std::move(*target));
  }
  return targets;
}

tasks::Annotations parse_any(std::string_view json, const std::string& file,
                             const std::string& split) {
  const auto task = tasks::find_task(json);
  if (task == tasks::Task::kReverie || task == tasks::Task::kCvdn) {
    return tasks::parse_annotations(json, file, split, *task);
  }
  return tasks::parse_annotations(json, file, split);
}

}  // namespace enfilade::service::collecting::kinds
