/// \file  Objects of a synthetic home that are visible from each viewpoint. Internal.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::homes::instructions {

/// An object in view.
struct Sight {
  std::size_t thing = 0;  ///< index in home.things
  double heading = 0;     ///< radians, world, of the middle of its visible part
  double elevation = 0;
  double distance = 0;  ///< metres, to the same
  double share = 0;     ///< of the whole sphere of directions, [0, 1]
};

/// Things in view from all viewpoints of a home. Immutable.
class Sights {
 public:
  /// Casts `rays` rays from each viewpoint, spread evenly over all directions. An object is in view
  /// if at least 3 rays hit it.
  /// \pre graph's viewpoints are in the home
  Sights(const Home& home, const mesh::RayTracer& tracer, const graph::NavGraph& graph,
         std::size_t rays = 8192, int threads = 0);
  /// Things in view, the largest share first.
  std::span<const Sight> at(ViewpointIndex v) const { return sights_[v.at()]; }
  /// The room of the floor below the viewpoint, by room_at().
  std::optional<std::size_t> room(ViewpointIndex v) const { return rooms_[v.at()]; }

 private:
  std::vector<std::vector<Sight>> sights_;
  std::vector<std::optional<std::size_t>> rooms_;
};

}  // namespace enfilade::homes::instructions
