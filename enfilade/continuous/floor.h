/// \file  The floor of a building, as bodies, experts and scores use it: one interface, two floors.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/continuous/navigation_mesh.h"
#include "enfilade/core/rng.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/floor_polygons.h"

namespace enfilade::continuous {

/// The two floors (docs/continuous.md).
enum class FloorKind : std::uint8_t {
  kEnfilade,  ///< exact polygons and exact shortest paths: Geodesics
  kHabitat,   ///< Habitat-Sim's navigation mesh, steps and paths: habitat::HabitatFloor
};
constexpr std::array<std::string_view, 2> names_of(FloorKind /*enum*/) {
  return {"enfilade", "habitat"};
}

/// Its name in scores.
constexpr std::string_view name_of(FloorKind kind) noexcept {
  return kind == FloorKind::kEnfilade ? "enfilade" : "habitat 0.3.3";
}

/// Distances to the nearest of some goals, from anywhere. Immutable: any thread; keeps what it
/// needs of the building alive. Queries of our own floor allocate nothing.
class DistanceField {
 public:
  /// A straight way to begin with, and the whole length.
  struct Way {
    double metres = 0;
    Vec3f next;  ///< where the straight line ends: a goal, or a corner to go around
  };
  /// What a floor keeps of the goals.
  class Goals {
   public:
    Goals() = default;
    Goals(const Goals&) = delete;
    Goals& operator=(const Goals&) = delete;
    virtual ~Goals() = default;
    virtual std::optional<Way> way(const FloorPoint& from) const = 0;  ///< of the field
  };
  /// \pre goals is not null
  explicit DistanceField(std::shared_ptr<const Goals> goals) : goals_(std::move(goals)) {}

  /// Metres to the nearest goal; +inf: there is no way.
  double distance(const FloorPoint& from) const;
  /// The beginning of the shortest path; no value if out of reach.
  std::optional<Way> way(const FloorPoint& from) const { return goals_->way(from); }

 private:
  std::shared_ptr<const Goals> goals_;
};

/// Where bodies of one size stand in a building, how they move and how far it is. Immutable: any
/// thread, shared by all users of the building. Results depend on arguments only. Points that its
/// calls take come from its own calls.
class Floor {
 public:
  Floor() = default;
  Floor(const Floor&) = delete;
  Floor& operator=(const Floor&) = delete;
  virtual ~Floor() = default;

  virtual FloorKind kind() const noexcept = 0;
  /// The widest reach that nearest() has.
  virtual Reach widest_reach() const noexcept = 0;

  /// The point of the floor that is nearest to any point; none within reach: no value.
  virtual std::optional<FloorPoint> nearest(Vec3f point, Reach reach) const = 0;
  virtual std::size_t areas() const noexcept = 0;               ///< connected parts
  virtual double area_m2(std::size_t area) const = 0;           ///< \pre area < areas()
  virtual std::size_t area_of(const FloorPoint& at) const = 0;  ///< < areas()
  /// A point drawn uniformly from one connected part or from all. \pre area < areas()
  virtual FloorPoint random_point(Rng& rng, std::optional<std::uint32_t> area) const = 0;
  /// Moves straight by an offset in the world frame, whose height does not count. Allocates nothing
  /// once a thread has moved.
  virtual Walked move(Walker& walker, const FloorPoint& from, Vec3d by, Walls walls) const = 0;

  /// Metres; +inf: there is no way.
  virtual double distance(const FloorPoint& a, const FloorPoint& b) const = 0;
  /// The path, both ends included; no value if out of reach.
  virtual std::optional<std::vector<Vec3f>> path(const FloorPoint& a,
                                                 const FloorPoint& b) const = 0;
  /// For many queries with the same goals. \throws ArgumentError for no goal
  virtual DistanceField field(std::span<const FloorPoint> goals) const = 0;
  DistanceField field(const FloorPoint& goal) const { return field(std::span(&goal, 1)); }

  /// Its outlines, for maps.
  virtual const mesh::FloorPolygons& polygons() const noexcept = 0;
};

}  // namespace enfilade::continuous
