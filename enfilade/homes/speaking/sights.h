/// \file  What can be seen from each viewpoint of a model home, and what a path through it is like.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::homes::speaking {

/// A thing in view.
struct Sight {
  std::size_t thing = 0;  ///< place in home.things
  double heading = 0;     ///< radians, world, of the middle of what is seen of it
  double elevation = 0;
  double distance = 0;  ///< metres, to the same
  double share = 0;     ///< of the whole sphere of directions, [0, 1]
};

/// All viewpoints of a home. Immutable.
class Sights {
 public:
  /// By rays spread evenly over all directions from each eye (`rays` of them; a thing is in view if
  /// at least 3 meet it). \pre graph's viewpoints stand in the home
  Sights(const Home& home, const mesh::RayTracer& tracer, const graph::NavGraph& graph,
         std::size_t rays = 8192, int threads = 0);
  /// Largest share first.
  std::span<const Sight> at(ViewpointIndex v) const { return sights_[v.at()]; }
  /// room_at() of the floor below the viewpoint.
  std::optional<std::size_t> room(ViewpointIndex v) const { return rooms_[v.at()]; }

 private:
  std::vector<std::vector<Sight>> sights_;
  std::vector<std::optional<std::size_t>> rooms_;
};

}  // namespace enfilade::homes::speaking
