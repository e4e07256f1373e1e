/// \file  What Habitat's queries stand on: a Detour mesh, a query, and islands.
#pragma once
#include <DetourNavMesh.h>
#include <DetourNavMeshQuery.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "enfilade/continuous/habitat/detour.h"
#include "enfilade/continuous/habitat/path_finder.h"

namespace enfilade::continuous::habitat {

/// A point of the floor.
struct OnFloor {
  dtPolyRef polygon = 0;
  Vec3f point;
};

/// A polygon of the mesh in Detour's memory.
struct PolygonPlace {
  const dtMeshTile* tile = nullptr;
  dtPoly* polygon = nullptr;
  const float* corner(std::size_t k) const {
    return tile->verts + std::size_t{3} * polygon->verts[k];
  }
  std::size_t size() const { return polygon->vertCount; }
};

/// Detour's objects of one PathFinder. Flags of polygons change while a query of one island runs.
class FloorQuery {
 public:
  explicit FloorQuery(const NavMesh& mesh);

  std::optional<OnFloor> project(Vec3f point) const;
  /// The same on one island.
  std::optional<OnFloor> project(Vec3f point, int island);
  int island_of(dtPolyRef polygon) const;  ///< -1: not walkable
  std::size_t islands() const noexcept { return radii_.size(); }
  float radius(std::size_t island) const { return radii_.at(island); }
  PolygonPlace place(dtPolyRef polygon) const;
  /// Whether an edge (from corner k to the next) leads to a walkable polygon; which one first. 0: a
  /// wall.
  dtPolyRef beyond(dtPolyRef polygon, std::size_t edge) const;

  template <class Visit>  ///< Visit(dtPolyRef, PolygonPlace): each polygon in order
  void for_each(const Visit& visit) const {
    for (int t = 0; t < mesh_->getMaxTiles(); ++t) {
      const dtMeshTile* tile = const_mesh().getTile(t);
      if (tile->header == nullptr) continue;
      const dtPolyRef base = mesh_->getPolyRefBase(tile);
      for (int p = 0; p < tile->header->polyCount; ++p) {
        visit(base | static_cast<dtPolyRef>(p), PolygonPlace{tile, tile->polys + p});
      }
    }
  }
  /// Calls `query` while only polygons for which keep(ref, place) holds are walkable.
  template <class Keep, class Query>
  auto with_only(const Keep& keep, const Query& query) {
    struct Restore {
      std::vector<std::pair<dtPoly*, unsigned short>> flags;
      ~Restore() {
        for (const auto& [polygon, flag] : flags) polygon->flags = flag;
      }
    } restore;
    for_each([&](dtPolyRef ref, PolygonPlace place) {
      if (keep(ref, place)) return;
      restore.flags.emplace_back(place.polygon, place.polygon->flags);
      place.polygon->flags = 0;
    });
    return query();
  }

  const dtNavMesh& const_mesh() const noexcept { return *mesh_; }
  const dtNavMeshQuery& query() const noexcept { return query_; }
  const dtQueryFilter& filter() const noexcept { return filter_; }

 private:
  void find_islands();
  std::size_t index_of(dtPolyRef polygon) const;

  std::unique_ptr<dtNavMesh> mesh_;
  dtNavMeshQuery query_;
  dtQueryFilter filter_;
  std::vector<std::size_t> first_of_tile_;
  std::vector<int> island_of_;  // by index_of()
  std::vector<float> radii_;
};

/// Habitat's try_step (kSlide) and try_step_no_sliding (kStop).
Vec3f floor_step(const FloorQuery& floor, Navigation navigation, Vec3f from, Vec3f to, Moves moves);

}  // namespace enfilade::continuous::habitat
