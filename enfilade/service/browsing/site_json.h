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

#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::service::browsing {

/// All scans, with their numbers of viewpoints, edges, storeys, instructions and rooms.
nlohmann::ordered_json scan_list_json(const Site& site);
/// Storeys, viewpoints with their neighbours, and which pictures there are of each.
nlohmann::ordered_json scan_json(const Site& site, ScanIndex scan);

/// A scan's rooms, walls and furniture: of a synthetic home from `homes.json`, of a scanned mesh
/// from its `.house` file; else empty lists. World frame, metres.
/// \throws FileError, InvalidInput for a broken file
nlohmann::ordered_json plan_json(const Site& site, ScanIndex scan);

/// Which episodes of a split. An empty text matches all.
struct EpisodeFilter {
  std::string scan;
  std::string words;       ///< on graphs: part of the instruction, in any case
  std::string id;          ///< of the instruction: "12_0"; of a continuous episode
  std::string trajectory;  ///< of a continuous episode
  std::int64_t offset = 0, limit = 50;

  /// Whether the page has the matching episode of that number.
  bool shows(std::int64_t match) const { return match >= offset && match < offset + limit; }
};

/// Those of a benchmark; without one, of all.
nlohmann::ordered_json split_list_json(const Site& site, std::optional<tasks::Task> task);
/// A page of the episodes that match, and how many there are. With an id: all that is known of it
/// (episode_json.cpp). \pre the split is one of the site's
nlohmann::ordered_json episodes_json(const Site& site, const PublicSplit& split,
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
  /// (mesh::with_vertex_light()). At most two threads make it, one building at a time, in some
  /// seconds. A mesh file has its own textures.
  /// \throws Refusal kNotFound, with the remedy, if there is no mesh; as mesh::read_mesh()
  Packed mesh(ScanIndex scan);
  /// The same unpacked: one at a time, and the same bytes for all that are sending them. Null if
  /// there is no room for it beside others that are being sent.
  std::shared_ptr<const std::string> unpacked(const Packed& mesh);
  /// The navigation mesh for R2R-CE's body: {"scan", "body", "walker", "polygons"}. World frame,
  /// metres.
  /// \throws Refusal kNotFound, with the remedy, if there is none; as load_navigation_mesh()
  nlohmann::ordered_json floor_json(ScanIndex scan) const;
  /// A page of a split's episodes of R2R-CE. Goals, paths and distances are left out if the site
  /// hides those of R2R's split of that name. So are those that are secret in a phase.
  /// \throws Refusal kNotFound if there is no such file; InvalidInput for a broken one
  nlohmann::ordered_json episodes_json(const std::string& split, const EpisodeFilter& filter);

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
  detail::OnceCache<std::string, Read> episodes_;
};

}  // namespace enfilade::service::browsing
