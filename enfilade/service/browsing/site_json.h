/// \file  Scans, splits and episodes as the viewer and the API show them to everybody; continuous
/// navigation of a building: its mesh, its floor, continuous episodes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <string_view>

#include "enfilade/homes/building_plan.h"
#include "enfilade/service/browsing/pieces.h"
#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::service::browsing {

/// All scans, with their numbers of viewpoints, edges, storeys, instructions and rooms.
nlohmann::ordered_json scan_list_json(const Site& site);
/// Storeys, viewpoints with their neighbours, and which pictures there are of each.
nlohmann::ordered_json scan_json(const Site& site, ScanIndex scan);

/// A scan's plan as homes::read_building_plan() finds it; empty if the data set's list is of
/// another version of Enfilade. \throws InvalidInput for a broken file
homes::BuildingPlan plan_of(const Site& site, ScanIndex scan);
/// Its rooms, walls and furniture; empty lists where nothing is known. World frame, metres.
/// \throws as plan_of()
nlohmann::ordered_json plan_json(const Site& site, ScanIndex scan);

/// Which episodes of a split. An empty text matches all.
struct EpisodeFilter {
  std::string scan;
  std::string words;       ///< part of the instruction, in any case
  std::string id;          ///< of the instruction: "12_0"; of a continuous episode
  std::string trajectory;  ///< of a continuous episode
  std::int64_t offset = 0, limit = 50;

  /// Whether an instruction of a scan is listed, by `scan` and `words` alone.
  bool lists(std::string_view of_scan, std::string_view instruction) const;

  /// Whether the page has the matching episode of that number.
  bool shows(std::int64_t match) const { return match >= offset && match < offset + limit; }
};

/// Those of a benchmark; without one, of all, and the names of those in continuous space.
nlohmann::ordered_json split_list_json(const Site& site, std::optional<tasks::Task> task);
/// A page of the episodes that match, and how many there are. With an id: all that is known of that
/// one, and its neighbours in the list of the filter's scan and words (episode_json.cpp).
/// \pre the split is one of the site's
nlohmann::ordered_json episodes_json(const Site& site, Pieces& pieces, const PublicSplit& split,
                                     const EpisodeFilter& filter);

/// The scans with continuous navigation: those with a mesh (synthetic homes make theirs from their
/// seeds) and with a navigation mesh in `navmesh/r2r-ce/`.
std::set<std::string, std::less<>> scans_to_roam(const Site& site);

/// Meshes, floors and episodes, made or read at the first request for one and kept. All functions
/// may be called from any thread.
class Roaming {
 public:
  /// \param most_unpacked bytes of all unpacked meshes that are being sent
  explicit Roaming(std::shared_ptr<const Site> site, std::size_t most_unpacked = kMostUnpacked);

  /// A file, packed as gzip does, a name of its content, and its size.
  struct Packed {
    std::shared_ptr<const std::string> gzip;
    std::string digest;
    std::size_t bytes = 0;  ///< unpacked
  };
  /// The building as GLB. A synthetic home has its light in the colours of its corners
  /// (mesh::with_vertex_light()). It is read if the data set has it (homes::lit_home_file()). Else
  /// at most two threads make it, one building at a time, in some seconds. With the light that
  /// `enfilade continuous --light` kept it takes a second. It is kept where the data set may be
  /// written. A mesh file has its own textures.
  /// \throws Refusal kNotFound, with the remedy, if there is no mesh; as mesh::read_mesh()
  Packed mesh(ScanIndex scan);
  /// The same unpacked: one at a time, and the same bytes for all that are sending them. Null if
  /// there is no room for it beside others that are being sent.
  std::shared_ptr<const std::string> unpacked(const Packed& mesh);
  /// The navigation mesh for R2R-CE's body: {"scan", "body", "walker", "polygons"}. World frame,
  /// metres.
  /// \throws Refusal kNotFound, with the remedy, if there is none; as load_navigation_mesh()
  nlohmann::ordered_json floor_json(ScanIndex scan) const;
  /// A page of a split's episodes of R2R-CE or RxR-CE. Goals, paths and distances are left out if
  /// the site hides those of R2R's or RxR's split of that name. So are those that are secret in a
  /// phase.
  /// \pre benchmark.continuous()
  /// \throws Refusal kNotFound if there is no such file; InvalidInput for a broken one
  nlohmann::ordered_json episodes_json(const tasks::Benchmark& benchmark, const std::string& split,
                                       const EpisodeFilter& filter);

 private:
  using Episodes = std::shared_ptr<const tasks::ContinuousEpisodes>;
  struct Read {
    Episodes episodes;
    bool tells = false;  // secret goals
  };
  static constexpr std::size_t kMostUnpacked = 256U << 20U;  // Matterport3D's largest has 200 MB
  Packed make_mesh(ScanIndex scan);

  std::shared_ptr<const Site> site_;
  std::mutex making_;  // of meshes
  std::size_t most_unpacked_;
  std::mutex unpacking_;
  std::map<std::string, std::weak_ptr<const std::string>> unpacked_;  // being sent, by digest
  detail::OnceCache<ScanIndex, Packed> meshes_;
  detail::OnceCache<std::string, Read> episodes_;  // by "benchmark/split"
};

}  // namespace enfilade::service::browsing
