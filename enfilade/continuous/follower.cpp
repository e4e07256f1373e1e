#include "enfilade/continuous/follower.h"

#include <cmath>
#include <limits>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::continuous {
namespace {

constexpr int kMostInVain = 40;   // actions: a full turn of 24, and a few steps
constexpr double kNearer = 0.01;  // metres that count as nearer

}  // namespace

ReferenceFollower::ReferenceFollower(std::shared_ptr<const Floor> floor,
                                     std::vector<FloorPoint> points,
                                     const SimulatorConfig& simulator, const FollowerConfig& config)
    : floor_(std::move(floor)),
      points_(std::move(points)),
      turn_(simulator.turn.value),
      config_(config) {
  if (!floor_) throw ArgumentError("floor: null");
  if (points_.empty()) throw ArgumentError("points: none, at least one");
  check_range("reached", config.reached, 1e-6, 1e6);
  check_range("last_reached", config.last_reached, 1e-6, 1e6);
}

// Whether there is a point left.
bool ReferenceFollower::advance(const FloorPoint& at) {
  while (target_ < points_.size()) {
    const bool last = target_ + 1 == points_.size();
    const double metres = length(to_double(points_[target_].point) - to_double(at.point));
    const bool there = metres <= (last ? config_.last_reached : config_.reached);
    if (config_.patient && last) return !there;
    if (!there && (config_.patient || in_vain_ <= kMostInVain)) return true;
    ++target_;
    fields_.clear();
    in_vain_ = 0;
  }
  return false;
}

Action ReferenceFollower::next(const FloorPoint& at, Radians heading) {
  if (!advance(at)) return Action::kStop;
  if (fields_.empty()) {
    fields_.push_back(floor_->field(points_[target_]));
    nearest_ = std::numeric_limits<double>::infinity();
  }
  const auto way = fields_.front().way(at);
  const double metres = way ? way->metres : std::numeric_limits<double>::infinity();
  if (metres < nearest_ - kNearer) {
    nearest_ = metres;
    in_vain_ = 0;
  } else {
    ++in_vain_;
  }
  if (!way) return Action::kForward;
  const double east = static_cast<double>(way->next.x) - at.point.x;
  const double north = static_cast<double>(way->next.y) - at.point.y;
  if (east == 0 && north == 0) return Action::kForward;
  const double off = wrap_difference(Radians(std::atan2(east, north)) - heading).value;
  if (std::abs(off) <= turn_ + 1e-6) return Action::kForward;
  return off > 0 && off < kPi - 1e-9 ? Action::kRight : Action::kLeft;
}

}  // namespace enfilade::continuous
