#include "enfilade/service/browsing/site_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/dataset/mesh_files.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/lighting.h"
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

mesh::Mesh lit_mesh(const homes::PlanOptions& plan) {
  const int threads = std::min(2, available_threads());  // others are to be served meanwhile
  const homes::BuiltHome built = homes::build_home(plan);
  mesh::BakeOptions bake = homes::bake_options(homes::HomeLight::kFine, threads);
  bake.spacing = 0.5;  // corners of triangles do not show more
  const mesh::LitMesh light(built.tracer, built.home.lights, bake);
  return mesh::with_vertex_light(light, {.threads = threads});
}

mesh::Mesh mesh_of_file(const dataset::MeshFile& found) {
  mesh::Mesh mesh = mesh::read_mesh(found.file, {.up = found.up}).mesh;
  mesh.triangle_object.clear();  // one object is drawn faster than a hundred
  mesh.objects.clear();
  mesh.normals.clear();
  return mesh;
}

/// Numbers whose last bits say nothing are packed into half the room.
void drop_last_bits(mesh::Mesh& mesh) {
  const auto round_to = [](float x, float steps) { return std::round(x * steps) / steps; };
  // Parts of a metre, of 1. Positions coarser than that open cracks between surfaces that meet.
  constexpr float kPosition = 65536, kTexture = 4096, kLight = 512;
  for (Vec3f& p : mesh.positions) {
    p = {round_to(p.x, kPosition), round_to(p.y, kPosition), round_to(p.z, kPosition)};
  }
  for (Vec3f& c : mesh.colours) {
    c = {round_to(c.x, kLight), round_to(c.y, kLight), round_to(c.z, kLight)};
  }
  for (auto& corners : mesh.texture_points) {
    for (mesh::TexturePoint& t : corners) t = {round_to(t.u, kTexture), round_to(t.v, kTexture)};
  }
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

/// Whether the ends of R2R's paths of that split are shown to everybody: a continuous episode has
/// the path of one of them.
bool shows_goals(const Site& site, const std::string& split) {
  const PublicSplit* r2r = site.find_split(split);
  return find_secret(site.phases(), split, *setup().benchmark) == nullptr &&
         (r2r == nullptr || !r2r->goals_hidden);
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
bool is_split(const Site& site, const std::string& name) {
  const auto usual = tasks::benchmark(tasks::Task::kR2r).splits;
  return std::ranges::find(usual, name) != usual.end() ||
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
  mesh::Mesh mesh;
  if (home != homes.end()) {
    mesh = lit_mesh(home->plan);
  } else if (const auto found = dataset::find_mesh_file(site_->folder(), name)) {
    mesh = mesh_of_file(*found);
  } else {
    throw detail::Refusal(
        detail::Reason::kNotFound,
        fmt::format("no mesh of scan {0}: put it into the data set as meshes/{0}.glb", name));
  }
  drop_last_bits(mesh);
  const std::string glb = mesh::to_glb(mesh);
  constexpr int kLevel = 6;
  return {std::make_shared<const std::string>(gzip(glb, kLevel)),
          fmt::format("{:016x}", stream_of(glb.data(), glb.size())), glb.size()};
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

ordered_json Roaming::episodes_json(const std::string& split, const EpisodeFilter& filter) {
  if (!is_split(*site_, split)) {
    throw detail::Refusal(detail::Reason::kNotFound, "no split of this name");
  }
  const Read read = episodes_.get(split, [&] {
    try {
      const auto found = dataset::Dataset(site_->folder())
                             .split(*setup().benchmark, split, {.experts = false})
                             .continuous();
      return Read{found, site_->find_shared(goal_keys(*found, site_->graphs())).keys.tells()};
    } catch (const FileError&) {  // its message names folders of this machine
      throw detail::Refusal(
          detail::Reason::kNotFound,
          fmt::format("no continuous episodes of {}: `enfilade continuous DATA` makes them",
                      split));
    }
  });
  const Episodes& episodes = read.episodes;
  const bool with_goals = !read.tells && shows_goals(*site_, split);
  std::int64_t matching = 0;
  const bool hidden = !with_goals || goals_hidden(*episodes);
  auto list = ordered_json::array();
  for (const tasks::ContinuousEpisode& episode : episodes->episodes) {
    if (!filter.scan.empty() && episode.scan() != filter.scan) continue;
    if (!filter.id.empty() && tasks::text_of(episode.id) != filter.id) continue;
    if (!filter.trajectory.empty() && tasks::text_of(episode.trajectory_id) != filter.trajectory) {
      continue;
    }
    if (filter.shows(matching++)) list.push_back(episode_json(episode, with_goals));
  }
  return {{"split", split}, {"goals_hidden", hidden}, {"matching", matching}, {"episodes", list}};
}

}  // namespace enfilade::service::browsing
