/// \file  Habitat-Sim's GreedyGeodesicFollower.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "enfilade/continuous/habitat/body.h"

namespace enfilade::continuous::habitat {

/// An action of the follower. Values are Habitat's GreedyFollowerCodes.
enum class Follow : std::int8_t { kError = -2, kStop = -1, kForward = 0, kLeft = 1, kRight = 2 };

/// Steps of the body, and the distance at which it stops.
struct FollowerSettings {
  float step = 0.25F;  ///< metres
  double turn_degrees = 10;
  float goal_radius = 0.1875F;  ///< metres: it stops where the path is shorter
  bool fix_thrashing = true;
  std::size_t thrashing = 16;  ///< turns to and fro until it goes on with its plan
};

/// Follows shortest paths by trying each turn, with the floor's real steps: so it sees walls.
class GreedyFollower {
 public:
  /// \pre floor outlives this. \throws ArgumentError for steps and turns that are not positive
  GreedyFollower(const PathFinder& floor, Moves moves, const FollowerSettings& settings);

  /// The next action towards a goal. kError: it cannot be reached.
  Follow next(const Pose& pose, Vec3f goal);
  /// All actions to a goal, kStop last; empty: it cannot be reached.
  std::vector<Follow> path(const Pose& pose, Vec3f goal);
  /// Forgets the actions before.
  void reset();

 private:
  std::vector<Follow> primitive(const Pose& pose, Vec3f goal) const;
  bool is_thrashing() const;
  void apply(Pose& pose, Follow action) const;

  const PathFinder* floor_;
  Ground ground_;
  FollowerSettings settings_;
  std::vector<Follow> done_, left_;
};

}  // namespace enfilade::continuous::habitat
