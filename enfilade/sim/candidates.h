/// \file  Where an agent can go from a viewpoint, seen from the best of its 36 discretized views.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/sim/simulator.h"

namespace enfilade::sim {

/// A neighbour, and the view that has it nearest to its middle.
struct Candidate {
  ViewpointIndex viewpoint;
  std::uint32_t view = 0;   ///< 0..35, the first of equally good ones
  std::uint32_t index = 0;  ///< of the navigable list in that view, >= 1
  Radians rel_heading;      ///< from that view's middle, right positive
  Radians rel_elevation;    ///< from that view's middle, up positive
  Radians heading;          ///< of the view + rel_heading, not wrapped
  Radians elevation;        ///< of the view + rel_elevation
  double angle = 0;         ///< sqrt(rel_heading^2 + rel_elevation^2), radians
  double distance = 0;      ///< straight line, metres
};

/// Computes the candidates that agents of the literature find by turning through all 36 views, to
/// the bit, without a simulator's state. Known as EnvDrop's `make_candidate` (Tan, Yu, Bansal
/// 2019). Camera, navigation and field of view of the configuration decide which neighbours a view
/// has; its other fields are not used. One thread at a time.
class CandidateFinder {
 public:
  /// \throws ArgumentError as Simulator
  CandidateFinder(std::shared_ptr<const graph::GraphSet> graphs,
                  const SimulatorConfig& config = SimulatorConfig::room_to_room());

  /// In the order in which turning from view 0 to 35 meets them. Valid until the next call.
  /// \throws ActionError for an unknown or excluded viewpoint; errors of graph files
  const std::vector<Candidate>& find(graph::Location location);

 private:
  void keep(std::uint32_t view, std::uint32_t index);

  Simulator simulator_;
  std::vector<EpisodeStart> starts_;
  std::vector<Candidate> found_;
};

}  // namespace enfilade::sim
