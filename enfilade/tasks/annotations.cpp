#include "enfilade/tasks/annotations.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <utility>

#include "enfilade/core/detail/json.h"

namespace enfilade::tasks {
namespace {

using json::Element;
using json::Faults;
using json::Path;

enum Wanted : std::size_t { kPathId, kScan, kHeading, kPath, kInstructions, kDistance, kFields };
constexpr std::array<json::Field, kFields> kWanted{
    {{"path_id"}, {"scan"}, {"heading"}, {"path"}, {"instructions"}, {"distance", false}}};
using Found = std::array<std::optional<Element>, kFields>;

PathAnnotation entry_of(Element element, const Path& path, Faults& faults) {
  PathAnnotation entry;
  Found found;
  if (!json::fields(element, kWanted, found, path, faults)) return entry;
  entry.path_id = json::integer(*found[kPathId], Path(path, "path_id"), faults).value_or(0);
  entry.scan = json::string(*found[kScan], Path(path, "scan"), faults).value_or("");
  entry.heading =
      Radians(json::number(*found[kHeading], Path(path, "heading"), faults).value_or(0));
  const Path viewpoints(path, "path");
  const std::size_t errors = faults.errors();
  entry.path = json::strings(*found[kPath], viewpoints, faults);
  if (entry.path.empty() && faults.errors() == errors) {
    faults.error(viewpoints, "empty-path", "no viewpoint; the start at least is expected");
  }
  entry.instructions = json::strings(*found[kInstructions], Path(path, "instructions"), faults);
  if (found[kDistance]) {
    const Path distance(path, "distance");
    entry.distance = json::number(*found[kDistance], distance, faults);
    if (entry.distance && *entry.distance < 0) {
      faults.error(distance, "bad-distance",
                   fmt::format("{} is no length in metres", *entry.distance));
    }
  }
  return entry;
}

Annotations read(const json::Document& document, std::string split) {
  Annotations result{std::move(split), document.name(), {}};
  Faults faults(document.name());
  const Path root;
  if (const auto entries = json::array(document.root(), root, faults)) {
    std::unordered_map<std::int64_t, std::size_t> places;  // of path ids, which name results
    for (const Element element : *entries) {
      const std::size_t i = result.paths.size();
      const std::size_t errors = faults.errors();
      result.paths.push_back(entry_of(element, Path(root, i), faults));
      if (faults.errors() != errors) continue;  // it has no id
      const auto [first, fresh] = places.emplace(result.paths.back().path_id, i);
      if (fresh) continue;
      faults.error(Path(Path(root, i), "path_id"), "repeated-path-id",
                   fmt::format("{} stands at $[{}] already", first->first, first->second));
    }
  }
  faults.throw_if_errors();
  return result;
}

std::string entry_json(const PathAnnotation& entry) {
  if (!std::isfinite(entry.heading.value) || !std::isfinite(entry.distance.value_or(0))) {
    throw ArgumentError(fmt::format("path {}: heading {} and distance {}, not finite numbers",
                                    entry.path_id, entry.heading.value,
                                    entry.distance.value_or(0)));
  }
  nlohmann::ordered_json fields{{"path_id", entry.path_id},
                                {"scan", entry.scan},
                                {"heading", entry.heading.value},
                                {"path", entry.path}};
  if (entry.distance) fields["distance"] = *entry.distance;
  fields["instructions"] = entry.instructions;
  try {
    return fields.dump();
  } catch (const nlohmann::json::type_error&) {
    throw ArgumentError(fmt::format("path {}: holds text that is not UTF-8", entry.path_id));
  }
}

// The viewpoints of one entry, without faulty ones, which are reported.
std::vector<ViewpointIndex> look_up_viewpoints(const PathAnnotation& entry,
                                               const graph::NavGraph& graph, const Path& path,
                                               Faults& faults) {
  std::vector<ViewpointIndex> viewpoints;
  std::optional<ViewpointIndex> last;
  for (std::size_t k = 0; k < entry.path.size(); ++k) {
    const Path place(path, k);
    const auto found = graph.find(entry.path[k]);
    if (!found) {
      faults.error(place, "unknown-viewpoint",
                   fmt::format("viewpoint {:?} is not one of the {} of scan {}", entry.path[k],
                               graph.size(), entry.scan));
    } else if (!graph.included(*found)) {
      faults.error(place, "excluded-viewpoint",
                   fmt::format("viewpoint {:?} of scan {} is excluded from its graph",
                               entry.path[k], entry.scan));
    } else if (last && graph.edge(*last, *found) == nullptr) {
      faults.error(place, "not-adjacent",
                   fmt::format("no edge leads from {:?} to {:?} in scan {}", entry.path[k - 1],
                               entry.path[k], entry.scan));
    }
    last = found && graph.included(*found) ? found : std::nullopt;
    if (last) viewpoints.push_back(*last);
  }
  return viewpoints;
}

std::vector<ReferencePath> look_up(const Annotations& annotations, const graph::GraphSet& graphs,
                                   Faults& faults) {
  std::vector<ReferencePath> paths;
  paths.reserve(annotations.paths.size());
  const Path root;
  for (const PathAnnotation& entry : annotations.paths) {
    const Path path(root, paths.size());
    ReferencePath& reference = paths.emplace_back();
    reference.path_id = entry.path_id;
    reference.heading = entry.heading;
    const auto scan = graphs.find(entry.scan);
    if (!scan) {
      faults.error(
          Path(path, "scan"), "unknown-scan",
          fmt::format("scan {:?} is not one of the {} with a graph", entry.scan, graphs.size()));
      continue;
    }
    reference.scan = *scan;
    reference.viewpoints =
        look_up_viewpoints(entry, graphs.graph(*scan), Path(path, "path"), faults);
  }
  return paths;
}

}  // namespace

Annotations load_annotations(const std::filesystem::path& file, std::string split) {
  return read(json::Document::load(file), std::move(split));
}

Annotations parse_annotations(std::string_view json, const std::string& file, std::string split) {
  return read(json::Document::parse(json, file), std::move(split));
}

std::string to_json(const Annotations& annotations) {
  std::string text = "[";
  for (const PathAnnotation& entry : annotations.paths) {
    text += text.size() == 1 ? "\n" : ",\n";
    text += entry_json(entry);
  }
  return text + "\n]\n";
}

std::string instruction_id(std::int64_t path_id, std::size_t k) {
  return fmt::format("{}_{}", path_id, k);
}

double length_of(const ReferencePath& path, const graph::NavGraph& graph) {
  double length = 0;
  for (std::size_t k = 1; k < path.viewpoints.size(); ++k) {
    length += graph.edge(path.viewpoints[k - 1], path.viewpoints[k])->length;
  }
  return length;
}

std::vector<ReferencePath> look_up_paths(const Annotations& annotations,
                                         const graph::GraphSet& graphs) {
  Faults faults(annotations.file);
  std::vector<ReferencePath> paths = look_up(annotations, graphs, faults);
  faults.throw_if_errors();
  return paths;
}

EpisodeSet make_episodes(const Annotations& annotations,
                         std::shared_ptr<const graph::GraphSet> graphs, Instructions instructions) {
  const std::size_t most = instructions == Instructions::kScored
                               ? kScoredInstructions
                               : std::numeric_limits<std::size_t>::max();
  EpisodeSet set{annotations.split, std::move(graphs), {}, {}};
  Faults faults(annotations.file);
  set.paths = look_up(annotations, *set.graphs, faults);
  const Path root;
  for (std::size_t i = 0; i < annotations.paths.size(); ++i) {
    const PathAnnotation& entry = annotations.paths[i];
    const std::size_t n = std::min(entry.instructions.size(), most);
    if (n == 0) {
      faults.error(Path(Path(root, i), "instructions"), "no-instruction",
                   fmt::format("path {} has none to follow", entry.path_id));
    }
    for (std::size_t k = 0; k < n; ++k) {
      set.episodes.push_back({instruction_id(entry.path_id, k), i, k, entry.instructions[k]});
    }
  }
  faults.throw_if_errors();
  return set;
}

}  // namespace enfilade::tasks
