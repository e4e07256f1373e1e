/// \file  The expert of continuous episodes: follows reference points by shortest paths.
#pragma once
#include <cstddef>
#include <memory>
#include <vector>

#include "enfilade/continuous/floor.h"
#include "enfilade/continuous/simulator.h"

namespace enfilade::continuous {

/// When a point counts as reached: metres, straight lines.
struct FollowerConfig {
  double reached = 0.5;       ///< of points on the way: VLN-CE's experts; > 0
  double last_reached = 0.5;  ///< of the last one, where it stops; StreamVLN: 0.25; > 0.
  /// For a teacher whose pupil may leave the path: no point is given up, and a body that passes the
  /// last point is led back.
  bool patient = false;
};

/// Chooses the next action in a simulator with the given config, by the rule of VLN-CE's recorded
/// experts. Points are visited in order. If the shortest path to the present point leads more than
/// one turn off, it turns to the nearer side (left if both are). Else it goes forward. If this
/// brings it no nearer several times, as if a body cannot come closer, it goes on to the next
/// point. One thread at a time.
class ReferenceFollower {
 public:
  /// \pre points is not empty; all are of the building
  /// \throws ArgumentError for no point, or distances that are not positive
  ReferenceFollower(std::shared_ptr<const Floor> floor, std::vector<FloorPoint> points,
                    const SimulatorConfig& simulator, const FollowerConfig& config = {});

  /// The next action of a body at this point. After kStop the episode is over.
  Action next(const FloorPoint& at, Radians heading);

 private:
  bool advance(const FloorPoint& at);

  std::shared_ptr<const Floor> floor_;
  std::vector<FloorPoint> points_;
  std::vector<DistanceField> fields_;  // of the present point; at most one
  double turn_;
  FollowerConfig config_;
  std::size_t target_ = 0;
  double nearest_ = 0;  // to the present point so far
  int in_vain_ = 0;     // steps that came no nearer
};

}  // namespace enfilade::continuous
