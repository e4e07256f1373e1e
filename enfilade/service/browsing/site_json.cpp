#include "enfilade/service/browsing/site_json.h"

#include <fmt/format.h>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/draw/plan_underlay.h"
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

/// Names of the splits of benchmarks in continuous space. Their files are large, and read when they
/// are asked for.
ordered_json continuous_splits(const Site& site) {
  auto list = ordered_json::array();
  for (const tasks::Benchmark& benchmark : tasks::benchmarks()) {
    if (!benchmark.continuous()) continue;
    for (const std::string& split : site.data().splits(benchmark)) {
      list.push_back({{"split", split}, {"task", benchmark.name}, {"title", benchmark.title}});
    }
  }
  return list;
}

/// Millimetres are enough, and files of half the length.
double to_millimetre(double metres) { return std::round(metres * 1000) / 1000; }

/// Lists of numbers, four a line, by kind: as `homes.json` has them.
ordered_json storey_json(double floor, const std::vector<draw::UnderlayLine>& lines) {
  ordered_json out{{"floor", to_millimetre(floor)}};
  for (const auto& [name, kind] : draw::kUnderlayKinds) out[name] = draw::line_ends(lines, kind);
  return out;
}

ordered_json room_json(const homes::PlannedRoom& room) {
  auto outline = ordered_json::array(), inside = ordered_json::array();
  for (const Vec3f corner : room.outline) {
    outline.push_back(to_millimetre(corner.x));
    outline.push_back(to_millimetre(corner.y));
  }
  for (const ViewpointIndex v : room.viewpoints) inside.push_back(v.value);
  ordered_json out{{"name", room.name},
                   {"storey", room.storey},
                   {"floor", to_millimetre(room.floor)},
                   {"outline", std::move(outline)},
                   {"viewpoints", std::move(inside)}};
  if (room.height > 0) out["height"] = to_millimetre(room.height);
  return out;
}

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
  if (!task) out["continuous"] = continuous_splits(site);
  return out;
}

homes::BuildingPlan plan_of(const Site& site, ScanIndex scan) {
  try {
    return homes::read_building_plan(site.folder(), site.image_folders(),
                                     site.graphs().graph(scan));
  } catch (const FileError&) {  // a list of another version of Enfilade, which tells of no lines
    return {};
  }
}

ordered_json plan_json(const Site& site, ScanIndex scan) {
  const homes::BuildingPlan plan = plan_of(site, scan);
  ordered_json out{{"storeys", ordered_json::array()}, {"rooms", ordered_json::array()}};
  const auto storeys = draw::find_storeys(site.graphs().graph(scan));
  for (std::size_t s = 0; s < storeys.size(); ++s) {
    const auto& known = plan.underlay.storeys;
    out["storeys"].push_back(storey_json(
        storeys[s].floor, s < known.size() ? known[s].lines : std::vector<draw::UnderlayLine>{}));
  }
  for (const homes::PlannedRoom& room : plan.rooms) out["rooms"].push_back(room_json(room));
  return out;
}

}  // namespace enfilade::service::browsing
