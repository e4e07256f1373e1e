/// \file  The inner loop of the simulator: which neighbours a camera sees, at which angles, sorted.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::sim::detail {

/// Where a camera points on the floor plan: of length 1, in single precision as MatterSim has it.
struct FloorDirection {
  float x = 0, y = 1;
};

/// (cos, sin) of pi/2 - heading in double precision, rounded: the definition.
FloorDirection direction_of(Radians heading);

/// The same bits, several times as fast. \pre headings in [0, 2 pi]; out.size() == headings.size()
void compute_directions(std::span<const double> headings, std::span<FloorDirection> out);

/// Which neighbours are navigable: those whose cosine to the camera's direction reaches a bound.
struct ViewLimit {
  bool all = false;  ///< no bound
  double min_cosine = 0;
};

/// Where one agent's list is written.
struct NavigableRow {
  std::uint32_t* target;  ///< the simulator's own copy of viewpoint
  ViewpointIndex* viewpoint;
  double* rel_heading;
  double* rel_elevation;
  double* distance;
};

/// The neighbours in view of a few agents, computed together. The arithmetic of all of them runs in
/// vector registers, and nothing branches on the actions of random agents. Used in rounds of
/// clear(), add() for each agent, compute(), write() for each in the same order. Allocates only in
/// the constructor.
class NavigableViews {
 public:
  NavigableViews(std::size_t agents, std::size_t max_navigable);

  void clear() noexcept;
  /// \pre no more agents and edges since clear() than given to the constructor
  void add(std::span<const graph::Edge> edges, FloorDirection camera, double elevation,
           const ViewLimit& limit);
  void compute();
  /// Writes the list of the next agent, `here` first. Returns its length.
  std::uint32_t write(ViewpointIndex here, const NavigableRow& row);

 private:
  // One element a neighbour; agent k's are [ends_[k - 1], ends_[k]).
  std::vector<float> right_, ahead_;  // offset across and along the camera's direction
  std::vector<float> rel_heading_;
  std::vector<float> distance_;
  std::vector<double> rel_elevation_;
  std::vector<double> order_;  // sort key of the list
  std::vector<std::uint32_t> target_;
  std::vector<std::uint32_t> rank_;
  std::vector<std::uint32_t> ends_;
  std::size_t agents_ = 0;   // added
  std::size_t written_ = 0;  // agents
  std::size_t size_ = 0;     // neighbours
};

}  // namespace enfilade::sim::detail
