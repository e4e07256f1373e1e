/// \file  Habitat-Sim's floor for everything that stands on a Floor: simulator, experts, scores.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/continuous/floor.h"
#include "enfilade/continuous/habitat/nav_mesh.h"
#include "enfilade/geometry/triangle_draw.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::continuous::habitat {

class PathFinder;

/// The triangles of an island, or of all (kAnyIsland), in our world frame.
std::vector<std::array<Vec3f, 3>> world_triangles(const PathFinder& finder, int island);

/// The settings of a body, whose other numbers are Habitat's defaults.
NavMeshSettings settings_of(const mesh::Body& body);

/// A navigation mesh of Habitat-Sim as a Floor in our world frame, by the rules of PathFinder up to
/// v0.3.3. Points are projected in each query, so distances and steps begin at FloorPoint::asked.
/// Heights, collisions and lengths are Habitat's, to the bit. Unlike Habitat's bodies, ours turn by
/// counted angles (Simulator), and a turn does not put a body onto the floor.
/// Threads that ask at once use PathFinders of their own: each has a copy of the mesh.
class HabitatFloor final : public Floor {
 public:
  /// Islands are the connected parts.
  /// \throws InvalidInput `too-large` for more than 65,534 corners or polygons
  explicit HabitatFloor(NavMesh mesh);
  ~HabitatFloor() override;

  const NavMeshSettings& settings() const noexcept;

  FloorKind kind() const noexcept override { return FloorKind::kHabitat; }
  Reach widest_reach() const noexcept override { return {2, 4}; }
  std::optional<FloorPoint> nearest(Vec3f point, Reach reach) const override;
  std::size_t areas() const noexcept override { return areas_m2_.size(); }
  double area_m2(std::size_t area) const override;
  std::size_t area_of(const FloorPoint& at) const override;
  FloorPoint random_point(Rng& rng, std::optional<std::uint32_t> area) const override;
  Walked move(Walker& walker, const FloorPoint& from, Vec3d by, Walls walls) const override;
  double distance(const FloorPoint& a, const FloorPoint& b) const override;
  std::optional<std::vector<Vec3f>> path(const FloorPoint& a, const FloorPoint& b) const override;
  DistanceField field(std::span<const FloorPoint> goals) const override;
  using Floor::field;
  const mesh::FloorPolygons& polygons() const noexcept override;

 private:
  class Finders;
  struct Goals;
  struct Draws;
  const TriangleDraw& draw_of(int island) const;

  std::shared_ptr<const Finders> finders_;
  mesh::FloorPolygons polygons_;
  std::vector<double> areas_m2_;
  std::unique_ptr<Draws> draws_;
};

}  // namespace enfilade::continuous::habitat
