#include "enfilade/continuous/habitat/greedy_follower.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"

namespace enfilade::continuous::habitat {
namespace {

constexpr std::size_t kMostFollowed = 5000;  // actions until a path is given up

// What a primitive is worth: 1 for a step straight to the goal, less for the rest.
constexpr float kTurnCost = 0.0125F;
constexpr float kCollisionCost = 0.25F;
constexpr float kNearWallCost = 0.05F;
constexpr float kNearWall = 0.2F;  // metres
constexpr float kGoodEnough = 0.99F;

bool is_turn(Follow action) { return action == Follow::kLeft || action == Follow::kRight; }

}  // namespace

GreedyFollower::GreedyFollower(const PathFinder& floor, Moves moves,
                               const FollowerSettings& settings)
    : floor_(&floor), ground_{&floor, moves}, settings_(settings) {
  check_range("step", settings.step, 1e-6, 1e6);
  check_range("turn_degrees", settings.turn_degrees, 0.01, 360);
}

void GreedyFollower::apply(Pose& pose, Follow action) const {
  if (action == Follow::kForward) {
    act(pose, Motion::kMoveForward, settings_.step, ground_);
  } else {
    const Motion turn = action == Follow::kLeft ? Motion::kTurnLeft : Motion::kTurnRight;
    act(pose, turn, settings_.turn_degrees, ground_);
  }
}

std::vector<Follow> GreedyFollower::primitive(const Pose& pose, Vec3f goal) const {
  const float metres = floor_->path(pose.position, goal).length;
  if (std::isinf(metres)) return {Follow::kError};
  if (metres < settings_.goal_radius) return {Follow::kStop};

  const auto turn = static_cast<float>(degrees(settings_.turn_degrees).value);
  float best = -kCollisionCost;
  std::vector<Follow> chosen;
  Pose left = pose;
  Pose right = pose;
  std::size_t turns = 0;
  // In float, as in Habitat: the number of turns depends on it.
  for (float angle = 0; angle < static_cast<float>(kPi); angle += turn) {
    for (const auto& [turned, side] : {std::pair{&left, Follow::kLeft}, {&right, Follow::kRight}}) {
      Pose ahead = *turned;
      const bool collided = try_ahead(ahead, settings_.step, ground_);
      const float nearer = metres - floor_->path(ahead.position, goal).length;
      const float wall = floor_->closest_obstacle(ahead.position, 1.1F * kNearWall).distance;
      // What it costs is summed first, as Habitat does.
      const float cost = -kTurnCost * static_cast<float>(turns) - (collided ? kCollisionCost : 0) -
                         (wall < kNearWall ? kNearWallCost : 0);
      const float reward = nearer / settings_.step + cost;
      if (reward > best) {
        best = reward;
        chosen.assign(turns, side);
        chosen.push_back(Follow::kForward);
      }
    }
    if (best > kGoodEnough) break;
    apply(left, Follow::kLeft);
    apply(right, Follow::kRight);
    ++turns;
  }
  if (chosen.empty()) return {Follow::kError};
  return chosen;
}

bool GreedyFollower::is_thrashing() const {
  if (!settings_.fix_thrashing || done_.size() < settings_.thrashing) return false;
  const auto last = done_.end() - static_cast<std::ptrdiff_t>(settings_.thrashing);
  return std::all_of(last, done_.end(), is_turn) &&
         std::adjacent_find(last, done_.end()) == done_.end();
}

Follow GreedyFollower::next(const Pose& pose, Vec3f goal) {
  if (left_.empty()) {
    left_ = primitive(pose, goal);
    // Only its first action: the next call has a better view. To and fro, it goes on with all.
    if (!is_thrashing()) left_.resize(1);
  }
  const Follow action = left_.front();
  left_.erase(left_.begin());
  done_.push_back(action);
  return action;
}

std::vector<Follow> GreedyFollower::path(const Pose& pose, Vec3f goal) {
  std::vector<Follow> actions;
  Pose at = pose;
  while (actions.size() < kMostFollowed) {
    for (const Follow action : primitive(at, goal)) {
      if (action == Follow::kError) return {};
      actions.push_back(action);
      if (action == Follow::kStop) return actions;
      apply(at, action);
    }
  }
  return {};
}

void GreedyFollower::reset() {
  done_.clear();
  left_.clear();
}

}  // namespace enfilade::continuous::habitat
