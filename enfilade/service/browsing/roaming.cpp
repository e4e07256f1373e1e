#include "enfilade/service/browsing/site_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/continuous/scene.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/names.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/dataset/mesh_files.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/lit_home.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/tasks/benchmark.h"

namespace enfilade::service::browsing {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kMostMeshBytes = 192U << 20U;     // packed: about a hundred homes
constexpr std::size_t kMostEpisodeBytes = 256U << 20U;  // all splits of R2R-CE have 100 MB

const agents::ContinuousSetup& setup() { return agents::continuous_setup("r2r-ce"); }

fs::path floor_file(const Site& site, std::string_view scan) {
  return site.folder() / setup().navigation_folder() / continuous::navigation_mesh_name(scan);
}

std::vector<homes::HomeEntry> homes_of(const Site& site) {
  if (!file_exists(site.folder() / "homes.json")) return {};
  return homes::read_home_list(site.folder());
}

// A hundredth of a millimetre is less than a step of single precision in a large building.
using detail::rounded;

ordered_json point(Vec3d p) { return {rounded(p.x), rounded(p.y), rounded(p.z)}; }

constexpr std::size_t kMostGlb = std::size_t{1} << 32U;  // what the format can hold

Roaming::Packed packed(std::string file) {
  const std::string glb = gunzip(file, kMostGlb);
  return {std::make_shared<const std::string>(std::move(file)),
          fmt::format("{:016x}", stream_of(glb.data(), glb.size())), glb.size()};
}

/// A mesh that was kept; no value without one that can be read, which is then made again.
std::optional<Roaming::Packed> kept_mesh(const fs::path& file) {
  try {
    if (file_exists(file)) return packed(read_file(file));
  } catch (const Error&) {  // it is damaged, or was removed just now
  }
  return std::nullopt;
}

/// The light that `enfilade continuous --light` has kept; null without a file that can be used.
std::shared_ptr<const continuous::Scene> kept_light(
    const fs::path& file, const std::shared_ptr<const mesh::RayTracer>& tracer) {
  try {
    if (file_exists(file)) return continuous::Scene::load(tracer, file);
  } catch (const Error&) {  // of another home, or damaged
  }
  return nullptr;
}

std::string lit_home(const Site& site, const homes::HomeEntry& home) {
  const int threads = std::min(2, available_threads());  // others are to be served meanwhile
  const homes::BuiltHome built = homes::build_home(home.plan);
  const auto scene = kept_light(site.folder() / homes::home_light_file(home.scan), built.tracer);
  return scene == nullptr ? homes::packed_lit_home(built, threads)
                          : homes::packed_lit_home(built, scene->surface_light(), threads);
}

/// As it was kept, by `enfilade continuous --light` or an earlier server; else it is made, and kept
/// where the data set may be written.
Roaming::Packed mesh_of_home(const Site& site, const homes::HomeEntry& home) {
  const fs::path name = homes::lit_home_file(home);
  if (auto kept = kept_mesh(site.folder() / name)) return *kept;
  Roaming::Packed made = packed(lit_home(site, home));
  try {
    OutputFolder(site.folder()).write(name.generic_string(), *made.gzip);
  } catch (const FileError&) {  // not here: the next server makes it again
  }
  return made;
}

mesh::Mesh mesh_of_file(const dataset::MeshFile& found) {
  mesh::Mesh mesh = mesh::read_mesh(found.file, {.up = found.up}).mesh;
  mesh.triangle_object.clear();  // one object is drawn faster than a hundred
  mesh.objects.clear();
  mesh.normals.clear();
  return mesh;
}

ordered_json polygon_json(const mesh::FloorPolygons& floor, std::size_t p) {
  const mesh::FloorPolygon& polygon = floor.polygons[p];
  const mesh::PolygonHeights& heights = floor.heights[p];
  auto beyond = ordered_json::array(), points = ordered_json::array(),
       triangles = ordered_json::array();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const std::uint16_t other = polygon.beyond[k];
    beyond.push_back(other == mesh::FloorPolygon::kNone ? -1 : static_cast<int>(other));
  }
  for (std::uint32_t k = 0; k < heights.points; ++k) {
    const Vec3f at = floor.points[heights.first_point + k];
    for (const float x : {at.x, at.y, at.z}) points.push_back(rounded(x));
  }
  for (std::uint32_t k = 0; k < heights.triangles; ++k) {
    const auto& triangle = floor.triangles[heights.first_triangle + k];
    for (std::size_t corner = 0; corner < 3; ++corner) triangles.push_back(triangle.at(corner));
  }
  return {{"area", polygon.area},
          {"beyond", std::move(beyond)},
          {"points", std::move(points)},
          {"triangles", std::move(triangles)}};
}

/// Whether everybody may see the ends of R2R's or RxR's paths, from which the benchmark's split was
/// made. A continuous episode has the path of one of them.
bool shows_goals(const Site& site, const tasks::Benchmark& benchmark, const std::string& split) {
  const PublicSplit* on_graph = site.find_split(split, benchmark.task);
  return find_secret(site.phases(), split, benchmark) == nullptr &&
         (on_graph == nullptr || !on_graph->goals_hidden);
}

ordered_json episode_json(const tasks::ContinuousEpisode& episode, bool with_goal) {
  ordered_json out{
      {"id", tasks::text_of(episode.id)}, {"trajectory", tasks::text_of(episode.trajectory_id)},
      {"scan", episode.scan()},           {"instruction", episode.instruction.text},
      {"start", point(episode.start)},    {"heading", episode.start_heading().value}};
  if (episode.instruction.language) out["language"] = *episode.instruction.language;
  if (!with_goal) return out;
  if (episode.reference_path) {
    auto& path = out["path"] = ordered_json::array();
    for (const Vec3d p : *episode.reference_path) path.push_back(point(p));
  }
  if (episode.goals) {
    auto& goals = out["goals"] = ordered_json::array();
    for (const tasks::ContinuousGoal& goal : *episode.goals) {
      goals.push_back({{"position", point(goal.position)}, {"radius", goal.radius.value_or(3)}});
    }
  }
  if (episode.info && episode.info->geodesic_distance) {
    out["distance"] = *episode.info->geodesic_distance;
  }
  return out;
}

/// Names of files are made of splits: those that the site knows, or that data sets have.
bool is_split(const Site& site, const tasks::Benchmark& benchmark, const std::string& name) {
  return std::ranges::find(benchmark.splits, name) != benchmark.splits.end() ||
         std::ranges::any_of(site.phases(), [&name](const Phase& p) { return p.split == name; }) ||
         std::ranges::any_of(site.splits(), [&name](const PublicSplit& split) {
           return split.annotations.split == name;
         });
}

constexpr std::size_t kEpisodeBytes = 4096;  // texts, tokens, paths

}  // namespace

std::set<std::string, std::less<>> scans_to_roam(const Site& site) {
  std::set<std::string, std::less<>> homes, found;
  try {
    for (const homes::HomeEntry& home : homes_of(site)) homes.insert(home.scan);
  } catch (const Error&) {
    return found;  // a broken list: told where it is needed
  }
  for (const std::string& scan : site.graphs().scans()) {
    if (!file_exists(floor_file(site, scan))) continue;
    if (homes.contains(scan) || dataset::find_mesh_file(site.folder(), scan)) found.insert(scan);
  }
  return found;
}

Roaming::Roaming(std::shared_ptr<const Site> site, std::size_t most_unpacked)
    : site_(std::move(site)),
      most_unpacked_(most_unpacked),
      meshes_(kMostMeshBytes, [](const Packed& packed) { return packed.gzip->size(); }),
      episodes_(kMostEpisodeBytes, [](const Read& read) {
        return 1 + kEpisodeBytes * read.episodes->episodes.size();
      }) {}

Roaming::Packed Roaming::mesh(ScanIndex scan) {
  return meshes_.get(scan, [&] { return make_mesh(scan); });
}

Roaming::Packed Roaming::make_mesh(ScanIndex scan) {
  const std::scoped_lock lock(making_);
  const std::string name(site_->graphs().graph(scan).scan());
  const std::vector<homes::HomeEntry> homes = homes_of(*site_);
  const auto home = std::ranges::find(homes, name, &homes::HomeEntry::scan);
  if (home != homes.end()) return mesh_of_home(*site_, *home);
  if (const auto found = dataset::find_mesh_file(site_->folder(), name)) {
    return packed(mesh::to_packed_glb(mesh_of_file(*found)));
  }
  throw detail::Refusal(
      detail::Reason::kNotFound,
      fmt::format("no mesh of scan {0}: put it into the data set as meshes/{0}.glb", name));
}

std::shared_ptr<const std::string> Roaming::unpacked(const Packed& mesh) {
  const std::scoped_lock lock(unpacking_);
  std::erase_if(unpacked_, [](const auto& one) { return one.second.expired(); });
  std::size_t held = 0;
  for (const auto& [digest, weak] : unpacked_) {
    const auto sent = weak.lock();  // it may have ended since
    if (sent && digest == mesh.digest) return sent;
    if (sent) held += sent->size();
  }
  // One alone has room at any size: to make it took as much.
  if (held > 0 && held + mesh.bytes > most_unpacked_) return nullptr;
  const auto made = std::make_shared<const std::string>(gunzip(*mesh.gzip, mesh.bytes));
  unpacked_[mesh.digest] = made;
  return made;
}

ordered_json Roaming::floor_json(ScanIndex scan) const {
  const std::string name(site_->graphs().graph(scan).scan());
  const fs::path file = floor_file(*site_, name);
  if (!file_exists(file)) {
    throw detail::Refusal(
        detail::Reason::kNotFound,
        fmt::format("no navigation mesh of scan {}: `enfilade continuous DATA` makes those of a "
                    "data set's buildings that have a mesh",
                    name));
  }
  if (continuous::floor_kind_of(file) == continuous::FloorKind::kHabitat) {
    throw detail::Refusal(
        detail::Reason::kNotFound,
        fmt::format(
            "scan {} has Habitat's floor, on which browsers cannot walk: `enfilade continuous "
            "DATA` makes ours",
            name));
  }
  const mesh::FloorPolygons floor = continuous::load_navigation_mesh(file);
  const continuous::SimulatorConfig& walker = setup().simulator;
  ordered_json out{
      {"scan", name},
      {"body",
       {{"radius", floor.body.radius}, {"height", floor.body.height}, {"step", floor.body.step}}},
      {"walker",
       {{"eye", walker.eye_height},
        {"forward", walker.forward},
        {"turn", walker.turn.value},
        {"look", walker.look.value},
        {"most_elevation", walker.most_elevation.value}}}};
  auto& polygons = out["polygons"] = ordered_json::array();
  for (std::size_t p = 0; p < floor.polygons.size(); ++p) {
    polygons.push_back(polygon_json(floor, p));
  }
  return out;
}

ordered_json Roaming::episodes_json(const tasks::Benchmark& benchmark, const std::string& split,
                                    const EpisodeFilter& filter) {
  if (!is_split(*site_, benchmark, split)) {
    const std::vector<std::string> known = site_->data().splits(benchmark);
    throw detail::Refusal(
        detail::Reason::kNotFound,
        fmt::format("split: {} has no {}; {}", benchmark.title, quote(split),
                    known.empty() ? "the data set has none of its splits"
                                  : fmt::format("it has {}", fmt::join(known, ", "))));
  }
  const Read read = episodes_.get(fmt::format("{}/{}", benchmark.name, split), [&] {
    try {
      const auto found = site_->data().split(benchmark, split, {.experts = false}).continuous();
      return Read{found, site_->find_shared(goal_keys(*found, site_->graphs())).keys.tells()};
    } catch (const FileError&) {  // its message names folders of this machine
      throw detail::Refusal(
          detail::Reason::kNotFound,
          fmt::format("no episodes of {} {}: `enfilade continuous DATA --task {}` makes them",
                      benchmark.title, split, benchmark.name));
    }
  });
  const Episodes& episodes = read.episodes;
  const bool with_goals = !read.tells && shows_goals(*site_, benchmark, split);
  std::int64_t matching = 0;
  const bool hidden = !with_goals || goals_hidden(*episodes);
  auto list = ordered_json::array();
  for (const tasks::ContinuousEpisode& episode : episodes->episodes) {
    if (!filter.lists(episode.scan(), episode.instruction.text)) continue;
    if (!filter.id.empty() && tasks::text_of(episode.id) != filter.id) continue;
    if (!filter.trajectory.empty() && tasks::text_of(episode.trajectory_id) != filter.trajectory) {
      continue;
    }
    if (filter.shows(matching++)) list.push_back(episode_json(episode, with_goals));
  }
  return {{"split", split},         {"task", benchmark.name}, {"title", benchmark.title},
          {"goals_hidden", hidden}, {"matching", matching},   {"episodes", list}};
}

}  // namespace enfilade::service::browsing
