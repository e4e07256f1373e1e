#include "enfilade/tasks/continuous_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "enfilade/core/check.h"

namespace enfilade::tasks {
namespace {

constexpr double kSuccessDistance = 3.0;  // metres
using Position = std::array<float, 3>;

// Whether a distance is asked anew: positions that are close, in the sense of NumPy's allclose()
// with an absolute tolerance of 1e-4, keep the old one. A slow drift therefore shows late.
bool moved(const Position& from, const Position& to) {
  constexpr float kAbsolute = 1e-4F, kRelative = 1e-5F;
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::abs(from[c] - to[c]) > kAbsolute + kRelative * std::abs(to[c])) return true;
  }
  return false;
}

float length(const Position& from, const Position& to) {
  const float x = to[0] - from[0], y = to[1] - from[1], z = to[2] - from[2];
  return std::sqrt(x * x + y * y + z * z);
}

// Positions without those that repeat the one before, exactly.
std::vector<std::size_t> kept(std::span<const Position> positions) {
  std::vector<std::size_t> places{0};
  for (std::size_t i = 1; i < positions.size(); ++i) {
    if (positions[i] != positions[places.back()]) places.push_back(i);
  }
  return places;
}

std::vector<Point3> points_at(std::span<const Position> positions,
                              std::span<const std::size_t> places) {
  std::vector<Point3> points;
  points.reserve(places.size());
  for (const std::size_t i : places) {
    points.push_back({positions[i][0], positions[i][1], positions[i][2]});
  }
  return points;
}

double similarity(double dtw, std::size_t reference) {
  return std::exp(-dtw / (kSuccessDistance * static_cast<double>(reference)));
}

void check_sizes(const ContinuousWalk& walk, std::span<const Point3> reference) {
  EN_CHECK(!reference.empty());
  EN_CHECK_EQ(walk.positions.size(), walk.actions.size() + 1);
  EN_CHECK_EQ(walk.goal_distances.size(), walk.positions.size());
  if (!walk.collided.empty()) EN_CHECK_EQ(walk.collided.size(), walk.actions.size());
}

// success * shortest / max(shortest, walked); NaN where the public code divides by zero.
double spl(bool success, double shortest, double walked) {
  const double share = shortest / std::max(shortest, walked);
  return (success ? 1 : 0) * share;
}

// The measures that change with each action.
class Running {
 public:
  explicit Running(const ContinuousWalk& walk) : walk_(walk), asked_(walk.positions[0]), score_{} {
    score_.distance_to_goal = walk.goal_distances[0];
    update();
    score_.oracle_navigation_error = score_.distance_to_goal;
  }

  void act(std::size_t i) {
    const Position& here = walk_.positions[i + 1];
    stopped_ = stopped_ || walk_.actions[i] == ContinuousWalk::kStop;
    if (moved(asked_, here)) {
      asked_ = here;
      score_.distance_to_goal = walk_.goal_distances[i + 1];
    }
    score_.path_length += static_cast<double>(length(walk_.positions[i], here));
    if (!walk_.collided.empty()) {
      score_.collisions = score_.collisions.value_or(0) + (walk_.collided[i] != 0 ? 1 : 0);
    }
    ++score_.steps_taken;
    update();
  }

  ContinuousScore score() const { return score_; }

 private:
  void update() {
    const bool near = score_.distance_to_goal < kSuccessDistance;
    score_.success = stopped_ && near ? 1 : 0;
    score_.spl = spl(score_.success > 0, walk_.goal_distances[0], score_.path_length);
    if (near) score_.oracle_success = 1;
    score_.oracle_navigation_error =
        std::min(score_.oracle_navigation_error, score_.distance_to_goal);
    score_.oracle_spl = std::max(score_.oracle_spl, score_.spl);
  }

  const ContinuousWalk& walk_;
  Position asked_;  // where the distance was asked last
  bool stopped_ = false;
  ContinuousScore score_;
};

}  // namespace

ContinuousScore score_continuous(const ContinuousWalk& walk, std::span<const Point3> reference,
                                 std::size_t actions) {
  check_sizes(walk, reference);
  EN_CHECK(actions <= walk.actions.size());
  Running running(walk);
  for (std::size_t i = 0; i < actions; ++i) running.act(i);
  ContinuousScore score = running.score();
  const auto positions = walk.positions.first(actions + 1);
  const auto path = points_at(positions, kept(positions));
  score.dtw = exact_dtw(path, reference);
  score.ndtw = similarity(score.dtw, reference.size());
  score.ndtw_fastdtw = similarity(fast_dtw(path, reference, FastDtw::kPlain), reference.size());
  score.ndtw_fastdtw_compiled =
      similarity(fast_dtw(path, reference, FastDtw::kCompiled), reference.size());
  score.sdtw = score.success * score.ndtw;
  return score;
}

std::array<double, 10> vlnce_values(const ContinuousScore& s) noexcept {
  return {s.path_length, s.distance_to_goal,
          s.success,     s.oracle_success,
          s.spl,         s.ndtw,
          s.sdtw,        s.ndtw_fastdtw,
          s.steps_taken, s.collisions.value_or(std::numeric_limits<double>::quiet_NaN())};
}

EtpNavScore score_as_etpnav(const ContinuousWalk& walk, std::span<const Point3> reference) {
  check_sizes(walk, reference);
  const auto places = kept(walk.positions);
  EtpNavScore score;
  float walked = 0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    walked += length(walk.positions[places[k - 1]], walk.positions[places[k]]);
  }
  const auto near = [&walk](std::size_t i) { return walk.goal_distances[i] <= kSuccessDistance; };
  score.steps_taken = static_cast<double>(walk.actions.size());
  score.distance_to_goal = walk.goal_distances[places.back()];
  score.success = near(places.back()) ? 1 : 0;
  score.oracle_success = std::ranges::any_of(places, near) ? 1 : 0;
  score.path_length = walked;
  score.collisions =
      static_cast<double>(std::ranges::count_if(walk.collided, [](auto c) { return c != 0; })) /
      static_cast<double>(places.size());
  const bool known = !walk.collided.empty() || walk.actions.empty();
  if (!known) score.collisions = std::numeric_limits<double>::quiet_NaN();
  score.spl = spl(score.success > 0, walk.goal_distances[0], walked);
  const auto path = points_at(walk.positions, places);
  score.ndtw = similarity(fast_dtw(path, reference, FastDtw::kPlain), reference.size());
  score.sdtw = score.success * score.ndtw;
  return score;
}

}  // namespace enfilade::tasks
