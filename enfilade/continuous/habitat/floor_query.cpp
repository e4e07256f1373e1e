#include "enfilade/continuous/habitat/floor_query.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "enfilade/core/errors.h"

namespace enfilade::continuous::habitat {
namespace {

constexpr int kSearchNodes = 2048;
constexpr std::array<float, 3> kReach{2, 4, 2};  // metres to each side

}  // namespace

FloorQuery::FloorQuery(const NavMesh& mesh) : mesh_(open_in_detour(mesh, "navigation mesh")) {
  if (dtStatusFailed(query_.init(mesh_.get(), kSearchNodes))) {
    throw Error("navigation mesh: out of memory");
  }
  filter_.setIncludeFlags(kWalkable);
  std::size_t count = 0;
  for (int t = 0; t < mesh_->getMaxTiles(); ++t) {
    first_of_tile_.push_back(count);
    const dtMeshTile* tile = const_mesh().getTile(t);
    if (tile->header != nullptr) count += static_cast<std::size_t>(tile->header->polyCount);
  }
  island_of_.assign(count, -1);
  find_islands();
}

std::optional<OnFloor> FloorQuery::project(Vec3f point) const {
  OnFloor out;
  std::array<float, 3> nearest{};
  const dtStatus status = query_.findNearestPoly(array_of(point).data(), kReach.data(), &filter_,
                                                 &out.polygon, nearest.data());
  if (dtStatusFailed(status) || out.polygon == 0) return std::nullopt;
  out.point = point_of(nearest.data());
  return out;
}

std::optional<OnFloor> FloorQuery::project(Vec3f point, int island) {
  if (island == kAnyIsland) return project(point);
  return with_only([&](dtPolyRef ref, const PolygonPlace&) { return island_of(ref) == island; },
                   [&] { return project(point); });
}

std::size_t FloorQuery::index_of(dtPolyRef polygon) const {
  return first_of_tile_[mesh_->decodePolyIdTile(polygon)] + mesh_->decodePolyIdPoly(polygon);
}

int FloorQuery::island_of(dtPolyRef polygon) const { return island_of_[index_of(polygon)]; }

PolygonPlace FloorQuery::place(dtPolyRef polygon) const {
  const dtMeshTile* tile = const_mesh().getTile(static_cast<int>(mesh_->decodePolyIdTile(polygon)));
  return {tile, tile->polys + mesh_->decodePolyIdPoly(polygon)};
}

dtPolyRef FloorQuery::beyond(dtPolyRef polygon, std::size_t edge) const {
  const auto [tile, at] = place(polygon);
  for (unsigned int k = at->firstLink; k != DT_NULL_LINK; k = tile->links[k].next) {
    const dtLink& link = tile->links[k];
    if (link.edge == edge && link.ref != 0 && (place(link.ref).polygon->flags & kWalkable) != 0) {
      return link.ref;
    }
  }
  return 0;
}

void FloorQuery::find_islands() {
  std::vector<dtPolyRef> open;
  std::vector<Vec3f> corners;
  for_each([&](dtPolyRef first, const PolygonPlace& place) {
    if (island_of(first) >= 0 || (place.polygon->flags & kWalkable) == 0) return;
    const auto island = static_cast<int>(radii_.size());
    corners.clear();
    const auto reach = [&](dtPolyRef ref) {
      island_of_[index_of(ref)] = island;
      open.push_back(ref);
    };
    reach(first);
    while (!open.empty()) {
      const PolygonPlace from = this->place(open.back());
      open.pop_back();
      // In this order: the middle is a sum in float32.
      for (std::size_t k = 0; k < from.size(); ++k) corners.push_back(point_of(from.corner(k)));
      for (unsigned int k = from.polygon->firstLink; k != DT_NULL_LINK;
           k = from.tile->links[k].next) {
        const dtPolyRef next = from.tile->links[k].ref;
        if (next == 0 || island_of(next) >= 0) continue;
        if ((this->place(next).polygon->flags & kWalkable) != 0) reach(next);
      }
    }
    Vec3f middle;
    for (const Vec3f corner : corners) middle += corner;
    const auto count = static_cast<float>(corners.size());
    middle = {middle.x / count, middle.y / count, middle.z / count};
    float radius = 0;
    for (const Vec3f corner : corners) radius = std::max(radius, length(corner - middle));
    radii_.push_back(radius);
  });
}

}  // namespace enfilade::continuous::habitat
