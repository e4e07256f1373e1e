#include "enfilade/tasks/continuous_score.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/geometry/habitat_frame.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/metrics.h"

namespace enfilade::tasks {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Points = std::vector<Point3>;
using Alignment = std::vector<std::pair<std::size_t, std::size_t>>;  // from the start to the end

// Columns of a row that may be used, both included.
struct Bounds {
  std::size_t low = 0, high = 0;
  bool has(std::size_t j) const { return low <= j && j <= high; }
};
using Window = std::vector<Bounds>;

double distance(const Point3& a, const Point3& b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
}

enum class Step : std::uint8_t { kUp, kLeft, kCorner };

// The alignment within a window, row by row.
class Aligner {
 public:
  Aligner(std::span<const Point3> a, std::span<const Point3> b, Window window, FastDtw form)
      : a_(a), b_(b), window_(std::move(window)), form_(form), steps_(a.size()) {}

  double cost() {
    for (std::size_t i = 0; i < a_.size(); ++i) fill(i);
    return row_.back();
  }

  // \pre cost() was called
  Alignment path() const {
    Alignment path;
    std::size_t i = a_.size() - 1, j = b_.size() - 1;
    path.emplace_back(i, j);
    while (i > 0 || j > 0) {
      const Step step = steps_[i][j - window_[i].low];
      if (step != Step::kLeft) --i;
      if (step != Step::kUp) --j;
      path.emplace_back(i, j);
    }
    std::ranges::reverse(path);
    return path;
  }

 private:
  void fill(std::size_t i) {
    const Bounds bounds = window_[i];
    std::vector<double> row(bounds.high - bounds.low + 1, kInfinity);
    steps_[i].resize(row.size());
    for (std::size_t j = bounds.low; j <= bounds.high; ++j) {
      const std::size_t k = j - bounds.low;
      if (i == 0 && j == 0) {
        row[0] = distance(a_[0], b_[0]);
        continue;
      }
      const double left = k > 0 ? row[k - 1] : kInfinity;
      const auto [least, step] = best(above(i, j), left, corner(i, j));
      row[k] = least + distance(a_[i], b_[j]);
      steps_[i][k] = step;
    }
    row_ = std::move(row);
  }

  double above(std::size_t i, std::size_t j) const {
    return i > 0 && window_[i - 1].has(j) ? row_[j - window_[i - 1].low] : kInfinity;
  }
  double corner(std::size_t i, std::size_t j) const {
    if (i == 0 || j == 0 || !window_[i - 1].has(j - 1)) return kInfinity;
    if (form_ == FastDtw::kCompiled && j > window_[i - 1].high) return kInfinity;
    return row_[j - 1 - window_[i - 1].low];
  }
  std::pair<double, Step> best(double up, double left, double corner) const {
    using enum Step;
    const std::array<std::pair<double, Step>, 3> plain{
        {{up, kUp}, {left, kLeft}, {corner, kCorner}}};
    const std::array<std::pair<double, Step>, 3> compiled{
        {{corner, kCorner}, {left, kLeft}, {up, kUp}}};
    const auto& order = form_ == FastDtw::kPlain ? plain : compiled;
    return *std::ranges::min_element(order, {},
                                     &std::pair<double, Step>::first);  // the first of equals
  }

  std::span<const Point3> a_, b_;
  Window window_;
  FastDtw form_;
  std::vector<std::vector<Step>> steps_;
  std::vector<double> row_;  // the last one that was filled
};

Window whole(std::size_t rows, std::size_t columns) { return Window(rows, {0, columns - 1}); }

// Means of neighbours; the last of an odd number is left out.
Points halved(std::span<const Point3> points) {
  Points half(points.size() / 2);
  for (std::size_t k = 0; k < half.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      half[k][c] = (points[2 * k][c] + points[2 * k + 1][c]) / 2;
    }
  }
  return half;
}

// The window within one cell of a coarse alignment, for twice as many rows and columns.
Window refined(const Alignment& path, std::size_t rows, std::size_t columns, FastDtw form) {
  std::vector<Bounds> coarse(path.back().first + 2, {columns, 0});  // one row beyond
  for (const auto& [i, j] : path) {
    for (std::size_t row = i > 0 ? i - 1 : 0; row <= i + 1; ++row) {
      coarse[row].low = std::min(coarse[row].low, j > 0 ? j - 1 : 0);
      coarse[row].high = std::max(coarse[row].high, j + 1);
    }
  }
  Window window(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    const Bounds& from = coarse[i / 2];
    window[i] = {2 * from.low, std::min(columns - 1, 2 * from.high + 1)};
  }
  if (form == FastDtw::kCompiled && rows % 2 == 1) window[rows - 1] = window[rows - 2];
  return window;
}

std::pair<double, Alignment> align(std::span<const Point3> a, std::span<const Point3> b,
                                   FastDtw form) {
  constexpr std::size_t kLeast = 3;  // radius + 2
  Window window;
  if (a.size() < kLeast || b.size() < kLeast) {
    window = whole(a.size(), b.size());
  } else {
    window = refined(align(halved(a), halved(b), form).second, a.size(), b.size(), form);
  }
  Aligner aligner(a, b, std::move(window), form);
  const double cost = aligner.cost();
  return {cost, aligner.path()};
}

}  // namespace

double exact_dtw(std::span<const Point3> a, std::span<const Point3> b) {
  EN_CHECK(!a.empty() && !b.empty());
  std::vector<double> row(b.size(), kInfinity);
  for (std::size_t i = 0; i < a.size(); ++i) {
    double diagonal = i == 0 ? 0 : kInfinity, left = kInfinity;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const double above = row[j];
      left = distance(a[i], b[j]) + std::min({left, above, diagonal});
      row[j] = left;
      diagonal = above;
    }
  }
  return row.back();
}

double fast_dtw(std::span<const Point3> a, std::span<const Point3> b, FastDtw form) {
  EN_CHECK(!a.empty() && !b.empty());
  return align(a, b, form).first;
}

namespace {

constexpr double kSuccessDistance = MetricOptions{}.success_distance;  // metres
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
    stopped_ = stopped_ || walk_.actions[i] == ContinuousResult::kStop;
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

ScoredWalk to_score(const ContinuousResult& walk, std::vector<double> goal_distances) {
  check_sizes(walk, "a walk");
  if (goal_distances.size() != walk.positions.size()) {
    throw ArgumentError(fmt::format("{} distances to the goal of {} positions",
                                    goal_distances.size(), walk.positions.size()));
  }
  ScoredWalk scored{{}, walk.actions, std::move(goal_distances), walk.collided};
  scored.positions.reserve(walk.positions.size());
  for (const Vec3f position : walk.positions) {
    const Vec3f theirs = to_habitat(position);
    scored.positions.push_back({theirs.x, theirs.y, theirs.z});
  }
  return scored;
}

std::vector<Point3> reference_to_score(std::span<const Vec3d> points) {
  std::vector<Point3> reference;
  reference.reserve(points.size());
  for (const Vec3d point : points) {
    const Vec3d theirs = to_habitat(point);
    reference.push_back({theirs.x, theirs.y, theirs.z});
  }
  return reference;
}

}  // namespace enfilade::tasks
