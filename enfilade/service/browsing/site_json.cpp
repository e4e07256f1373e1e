#include "enfilade/service/browsing/site_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "enfilade/draw/floor_plan.h"
#include "enfilade/service/browsing/episode_json.h"
#include "enfilade/service/browsing/roaming.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/instruction_ids.h"

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

bool contains(std::string_view text, std::string_view wanted) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return !std::ranges::search(text, wanted, {}, lower, lower).empty() || wanted.empty();
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
  for (const draw::Storey& storey : draw::find_storeys(graph)) {
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

ordered_json episodes_json(const Site& site, const PublicSplit& split,
                           const EpisodeFilter& filter) {
  std::int64_t matching = 0;
  auto list = ordered_json::array();
  for (const tasks::PathAnnotation& path : split.annotations.paths) {
    if (!filter.scan.empty() && path.scan != filter.scan) continue;
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      if (!contains(path.instructions[k], filter.words)) continue;
      if (!filter.id.empty() && tasks::instruction_id(path, k) != filter.id) continue;
      const bool on_page = matching >= filter.offset && matching < filter.offset + filter.limit;
      if (on_page) {
        list.push_back(filter.id.empty() ? brief_episode_json(path, k)
                                         : whole_episode_json(site, split, path, k));
      }
      ++matching;
    }
  }
  return {{"split", split.annotations.split},
          {"task", tasks::benchmark(split.annotations.task).name},
          {"goals_hidden", split.goals_hidden},
          {"matching", matching},
          {"episodes", list}};
}

}  // namespace enfilade::service::browsing
