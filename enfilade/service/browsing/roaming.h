/// \file  Continuous navigation of a building: its mesh, its floor, continuous episodes.
#pragma once
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

#include "enfilade/service/detail/kept.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::service::browsing {

/// The scans with continuous navigation: those with a mesh (synthetic homes make theirs from their
/// seeds) and with a navigation mesh in `navmesh/r2r-ce/`.
std::set<std::string, std::less<>> scans_to_roam(const Site& site);

/// Which of a split's continuous episodes; empty texts match all.
struct ContinuousFilter {
  std::string scan, id, trajectory;
  std::int64_t offset = 0, limit = 50;
};

/// Meshes, floors and episodes, made or read at the first request for one and kept. All functions
/// may be called from any thread.
class Roaming {
 public:
  explicit Roaming(std::shared_ptr<const Site> site);

  /// A file, packed as gzip does, and a name of its content.
  struct Packed {
    std::shared_ptr<const std::string> gzip;
    std::string digest;
  };
  /// The building as GLB. A synthetic home has its light in the colours of its corners
  /// (mesh::with_vertex_light()). At most two threads make it, one building at a time, in some
  /// seconds. A mesh file has its own textures.
  /// \throws Refusal kNotFound, with the remedy, if there is no mesh; as mesh::read_mesh()
  Packed mesh(ScanIndex scan);
  /// The navigation mesh for R2R-CE's body: {"scan", "body", "walker", "polygons"}. World frame,
  /// metres.
  /// \throws Refusal kNotFound, with the remedy, if there is none; as load_navigation_mesh()
  nlohmann::ordered_json floor_json(ScanIndex scan) const;
  /// A page of a split's episodes of R2R-CE; without goals, paths and distances where the site
  /// hides those of R2R's split of that name.
  /// \throws Refusal kNotFound if there is no such file; InvalidInput for a broken one
  nlohmann::ordered_json episodes_json(const std::string& split, const ContinuousFilter& filter);

 private:
  using Episodes = std::shared_ptr<const tasks::ContinuousEpisodes>;
  Packed make_mesh(ScanIndex scan);

  std::shared_ptr<const Site> site_;
  std::mutex making_;  // of meshes
  detail::Kept<ScanIndex, Packed> meshes_;
  detail::Kept<std::string, Episodes> episodes_;
};

}  // namespace enfilade::service::browsing
