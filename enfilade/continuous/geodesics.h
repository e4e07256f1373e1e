/// \file  Shortest ways on a floor: exact on the polygons of a navigation mesh.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/continuous/floor.h"
#include "enfilade/continuous/navigation_mesh.h"

namespace enfilade::continuous {

/// Our own floor: a navigation mesh and its shortest paths. A path is straight lines that bend at
/// corners of the rim. Its length is that of these lines in three dimensions, as Habitat measures
/// it. All paths on the polygons are considered, whereas Detour's own search takes the shortest
/// chain of polygons' middles, and shortens that. Corners of the rim count as the arcs that they
/// stand for. Immutable: any thread, shared by all users of the building.
class Geodesics final : public Floor {
 public:
  /// Finds the corners that see each other: milliseconds for a home, about 0.1 s for a large
  /// building.
  explicit Geodesics(std::shared_ptr<const NavigationMesh> mesh);

  const NavigationMesh& mesh() const noexcept;
  std::size_t bends() const noexcept;  ///< corners at which a shortest way can bend

  FloorKind kind() const noexcept override { return FloorKind::kEnfilade; }
  Reach widest_reach() const noexcept override { return {20, 20}; }
  std::optional<FloorPoint> nearest(Vec3f point, Reach reach) const override;
  std::size_t areas() const noexcept override;      ///< ranked as mesh::WalkableFloor's
  double area_m2(std::size_t area) const override;  ///< seen from above. \pre area < areas()
  std::size_t area_of(const FloorPoint& at) const override;
  FloorPoint random_point(Rng& rng, std::optional<std::uint32_t> area) const override;
  Walked move(Walker& walker, const FloorPoint& from, Vec3d by, Walls walls) const override;
  double distance(const FloorPoint& a, const FloorPoint& b) const override;
  std::optional<std::vector<Vec3f>> path(const FloorPoint& a, const FloorPoint& b) const override;
  DistanceField field(std::span<const FloorPoint> goals) const override;
  using Floor::field;
  const mesh::FloorPolygons& polygons() const noexcept override;

 private:
  struct Impl;
  struct Goals;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace enfilade::continuous
