#include "enfilade/service/collecting/kinds/targets.h"

#include <algorithm>
#include <set>
#include <utility>
#include <variant>

#include "enfilade/service/collecting/kinds/outlines.h"
#include "enfilade/tasks/files.h"

namespace enfilade::service::collecting::kinds {
namespace {

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

std::int64_t area_of(const tasks::ViewedObject& object) {
  std::int64_t most = 0;
  for (const auto& box : object.boxes) {
    most = std::max(most, std::int64_t{box[2]} * std::int64_t{box[3]});
  }
  return most;
}

std::optional<Target> target_of(const std::string& scan, const tasks::ViewedObject& object,
                                const KnownObjects& known) {
  Target target{object.id, category_of(object.name), {}, ""};
  target.region = in_graph(known.boxes->seen_from(scan, object.id), known.graphs.graph(scan));
  if (target.region.empty()) return std::nullopt;
  target.outlines = outlines_json(outlines_of(*known.boxes, scan, target.region, object.id));
  return target;
}

/// The object of that number, around any viewpoint that sees it.
std::optional<Target> named_target(const std::string& scan, std::int64_t object,
                                   const KnownObjects& known) {
  if (known.boxes == nullptr) return std::nullopt;
  for (const std::string& viewpoint : known.boxes->seen_from(scan, object)) {
    for (const tasks::ViewedObject& one : known.boxes->at(scan, viewpoint)) {
      if (one.id == object) return target_of(scan, one, known);
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<Target> targets_of(const tasks::PathAnnotation& path, const KnownObjects& known,
                               std::size_t most) {
  std::vector<Target> targets;
  if (const auto* region = std::get_if<tasks::NamedRegion>(&path.goal)) {
    Target target{std::nullopt, region->target,
                  in_graph(region->viewpoints, known.graphs.graph(path.scan)), ""};
    if (!target.region.empty()) targets.push_back(std::move(target));
    return targets;
  }
  if (const auto* object = std::get_if<tasks::NamedObject>(&path.goal)) {
    if (auto target = named_target(path.scan, object->id, known)) {
      targets.push_back(std::move(*target));
    }
    return targets;
  }
  if (known.boxes == nullptr) return targets;
  const auto around = known.boxes->at(path.scan, path.path.back());
  std::vector<tasks::ViewedObject> seen(around.begin(), around.end());
  std::erase_if(seen, [](const tasks::ViewedObject& one) { return !one.visible(); });
  std::ranges::stable_sort(seen, std::ranges::greater(), area_of);
  std::set<std::string> names;
  for (const tasks::ViewedObject& one : seen) {
    if (targets.size() == most) break;
    if (!names.insert(category_of(one.name)).second) continue;
    if (auto target = target_of(path.scan, one, known)) targets.push_back(std::move(*target));
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
