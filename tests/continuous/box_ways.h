/// \file  Shortest ways of a round body among boxes, found without a navigation mesh: the truth
/// that tests hold geodesics against.
#pragma once
#include <utility>
#include <vector>

#include "enfilade/homes/home.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::tests {

/// A point seen from above, metres.
struct PlanPoint {
  double x = 0, y = 0;
};

/// Ways on one storey of a home, from the generator's own knowledge of walls, leaves and furniture:
/// a visibility graph whose nodes are points of the arcs that the body's middle describes around
/// the corners of boxes.
class BoxWays {
 public:
  /// \param storey  of the home's plan; what is higher than a step above its floor and lower than
  /// the body's head counts
  BoxWays(const homes::Home& home, std::size_t storey, const mesh::Body& body);

  /// Whether the body can stand at a point.
  bool is_free(PlanPoint at) const { return is_free(at, at); }
  /// Metres; infinite: no way. \pre the body can stand at both
  double distance(PlanPoint from, PlanPoint to) const;

 private:
  struct Box {
    double x = 0, y = 0, half_x = 0, half_y = 0, cos = 1, sin = 0, reach = 0;
  };
  bool is_free(PlanPoint a, PlanPoint b) const;
  static double distance(const Box& box, PlanPoint a, PlanPoint b);
  void add_arcs(const Box& box);

  double radius_;
  std::vector<Box> boxes_;
  std::vector<PlanPoint> nodes_;
  std::vector<std::vector<std::pair<std::size_t, double>>> lines_;  // from each node
};

}  // namespace enfilade::tests
