/// \file  Scores of walks in continuous space (VLN-CE): those of its released measures, and of
/// ETPNav's evaluation, which much later code copies. The time warping of points that both need.
/// Formulas: docs/tasks.md.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/geometry/vec.h"

namespace enfilade::tasks {

struct ContinuousResult;

/// x, y, z in metres.
using Point3 = std::array<double, 3>;

/// Least sum of Euclidean distances over alignments with steps (1, 0), (0, 1), (1, 1), both ends
/// tied; metres. O(|a| |b|). \pre neither is empty
double exact_dtw(std::span<const Point3> a, std::span<const Point3> b);

/// The two forms of the Python package `fastdtw`. They disagree. In the compiled one, the last row
/// of an odd list has the bounds of the row before. It allows no diagonal step beyond the end of
/// the row above. It breaks ties in another order.
enum class FastDtw : std::uint8_t { kPlain, kCompiled };

/// FastDTW (Salvador and Chan 2007) with radius 1, as that package computes it. Both lists are
/// halved until one has fewer than three points, and aligned. Then the alignment is refined in a
/// window around the coarser one. Never less than exact_dtw(). O(|a| + |b|).
/// \pre neither is empty
double fast_dtw(std::span<const Point3> a, std::span<const Point3> b, FastDtw form);

/// A walk as a simulator recorded it: n + 1 poses, n actions between them. Spans must outlive what
/// is computed from it.
struct ContinuousWalk {
  std::span<const std::array<float, 3>> positions;  ///< metres, (n + 1)
  std::span<const std::uint8_t> actions;            ///< (n): 0 stop, 1 forward, 2 left, 3 right
  std::span<const double> goal_distances;  ///< geodesic, at each pose, (n + 1); infinite: no way
  /// Whether each action ended in a collision, (n); empty if that is not known.
  std::span<const std::uint8_t> collided;
};

/// Owns the trajectory that score_continuous() takes. In Habitat's frame, as sums in single
/// precision depend on the order of the coordinates.
struct ScoredWalk {
  std::vector<std::array<float, 3>> positions;  ///< Habitat's frame, metres, (n + 1)
  std::vector<std::uint8_t> actions;            ///< (n)
  std::vector<double> goal_distances;           ///< geodesic, metres, (n + 1)
  std::vector<std::uint8_t> collided;           ///< (n); empty if it is not known

  /// Valid as long as *this.
  ContinuousWalk view() const noexcept { return {positions, actions, goal_distances, collided}; }
};
/// \param goal_distances  per position, metres; infinite: out of reach
/// \throws ArgumentError if there are not as many as positions, or the trajectory's arrays do not
/// fit
ScoredWalk to_score(const ContinuousResult& walk, std::vector<double> goal_distances);
/// An expert's locations, or a reference path, as score_continuous() takes them.
std::vector<Point3> reference_to_score(std::span<const Vec3d> points);

/// The measures of VLN-CE with Habitat 0.1.7. Lengths and errors in metres, shares as fractions.
struct ContinuousScore {
  double distance_to_goal = 0;
  double success = 0;  ///< 1 if stop was called and the distance is below 3
  double spl = 0;      ///< NaN where the start is the goal: the measures divide by zero there
  double path_length = 0;
  double oracle_success = 0;           ///< 1 if the distance ever was below 3, stop or not
  double oracle_navigation_error = 0;  ///< least distance
  double oracle_spl = 0;               ///< largest SPL at any time
  double steps_taken = 0;              ///< actions
  /// No value before the first action, and where it is not known.
  std::optional<double> collisions;
  double dtw = 0;                                      ///< exact
  double ndtw = 0;                                     ///< exp(-dtw / (3 |reference|))
  double ndtw_fastdtw = 0, ndtw_fastdtw_compiled = 0;  ///< with the approximations: FastDtw
  double sdtw = 0;                                     ///< success * ndtw
};

/// The measures after `actions` of the walk's actions (all: n).
/// \param reference  the expert's positions; \pre not empty, sizes of the walk as stated
ContinuousScore score_continuous(const ContinuousWalk& walk, std::span<const Point3> reference,
                                 std::size_t actions);
inline ContinuousScore score_continuous(const ContinuousWalk& walk,
                                        std::span<const Point3> reference) {
  return score_continuous(walk, reference, walk.actions.size());
}

/// The values of the scorer "vlnce", in the order of its metrics. NaN: collisions are not known.
std::array<double, 10> vlnce_values(const ContinuousScore& score) noexcept;

/// ETPNav's measures of the same trajectory, which differ:
/// - success is an end within 3 m (inclusive), with or without a stop
/// - collisions are divided by the number of different poses; unknown ones are NaN
/// - time warping is FastDtw::kPlain
/// - lengths are summed in single precision
struct EtpNavScore {
  double steps_taken = 0, distance_to_goal = 0, success = 0, oracle_success = 0, path_length = 0,
         collisions = 0, spl = 0, ndtw = 0, sdtw = 0;
};
EtpNavScore score_as_etpnav(const ContinuousWalk& walk, std::span<const Point3> reference);

}  // namespace enfilade::tasks
