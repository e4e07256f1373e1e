/// \file  Results files: what agents hand in.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks {

/// Where an agent was, and looked, after one of its actions.
struct TrajectoryPoint {
  ViewpointIndex viewpoint;
  Radians heading;    ///< 0 where the file gives none
  Radians elevation;  ///< likewise
};

/// A point on a viewpoint's sphere, as SOON's results have it.
struct SpherePoint {
  double heading = 0;    ///< heading / 2 pi, [0, 1)
  double elevation = 0;  ///< (elevation + pi) / 2 pi
  friend bool operator==(const SpherePoint&, const SpherePoint&) = default;
};
/// A direction as such a point: the heading wrapped to [0, 2 pi), the elevation to (-pi, pi].
SpherePoint sphere_point(const Direction& direction);

/// What an agent did in one episode: the start, then one entry per action.
struct Trajectory {
  std::size_t episode = 0;  ///< index into EpisodeSet::episodes
  std::vector<TrajectoryPoint> points;
  /// Where one action may pass several viewpoints, or none (DUET's sub-paths): how many there were.
  /// No value: an entry an action.
  std::optional<std::size_t> actions = {};
  // What some benchmarks ask for beside the path.
  std::optional<ViewpointIndex> turning_point = {};  ///< R2R-Back: where it turned, as it says
  std::string object = {};                           ///< REVERIE: the object's id; empty: none
  std::optional<SpherePoint> point = {};             ///< SOON: where the object is
};

/// A results file, checked against its split.
struct Results {
  std::vector<Trajectory> trajectories;  ///< one per episode, in the order of the episodes
  std::vector<Diagnostic> warnings;      ///< e.g. an unscored fourth instruction was left out
};

/// Reads [{"instr_id": "1_0", "trajectory": [...]}, ...] and checks all of it. A trajectory's
/// entries may be [viewpoint, heading, elevation] triples, [viewpoint] singles, plain viewpoint
/// ids, or lists of those (sub-paths, as of DUET), in any mixture.
///
/// With Coverage::kPart, instructions that the file leaves out have no trajectory. The others are
/// in the order of the episodes, and part_of() makes a set of them.
///
/// Entries are read one by one. Memory beside the text is 24 bytes per trajectory point, and up to
/// 14 times the largest entry, of at most 1 MiB.
/// \throws FileError
/// \throws InvalidInput with *every* problem and its JSON path. After kMostFaultsKept errors the
/// rest of the file is not read, and the last diagnostic says so. The problems:
///   - not JSON, wrong types, an entry that is too large
///   - an unknown, missing or repeated instr_id; invalid ids (core/names.h)
///   - an empty trajectory, a wrong start, unknown or excluded viewpoints, angles beyond 1e4
///   - a jump between viewpoints that are not adjacent
Results load_results(const std::filesystem::path& file, const EpisodeSet& episodes,
                     Coverage coverage = Coverage::kAll);
Results parse_results(std::string_view json, const std::string& file, const EpisodeSet& episodes,
                      Coverage coverage = Coverage::kAll);

/// The episodes that have a trajectory, in their order, with all paths; the trajectories' `episode`
/// become indices into it. What scores a part of a split needs. \pre each names an episode of
/// `episodes`, and no two the same
EpisodeSet part_of(const EpisodeSet& episodes, std::vector<Trajectory>& trajectories);

/// Results as the public code of the benchmark has them, one episode per line. Trajectories are
/// [viewpoint, heading, elevation] triples. parse_results() reads them back equal, except
/// `actions`. The fields are `instr_id` and `trajectory`, with these exceptions:
/// - R2R-Back: also `midstop`, null without an answer
/// - REVERIE: also `predObjId`, null without an answer
/// - RxR: also `instruction_id`
/// - CVDN: `inst_idx` for `instr_id`, where the id is a number
/// - SOON: `path`, `obj_heading` and `obj_elevation` in `trajectory`
///
/// Linear in the points (bench/ has its time).
/// \throws ArgumentError for values that JSON cannot express
std::string to_json(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes);

/// \throws ArgumentError if a trajectory names no episode, is empty or leaves its graph, or if the
/// goal is hidden: then it cannot be scored
void check_trajectory(const Trajectory& trajectory, const EpisodeSet& episodes);
/// The place of each episode's trajectory, in the order of the episodes.
/// \pre check_trajectory() accepts each
/// \throws ArgumentError unless each episode has exactly one
std::vector<std::size_t> trajectory_by_episode(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes);

/// SOON's results as its own code (github.com/ZhuFengdaaa/SOON) writes and scores them:
/// [{"instr_id": "7", "trajectory": [{"path": [[viewpoint, heading, elevation], ...],
/// "obj_heading": h, "obj_elevation": e}, ...]}, ...]. Each instruction of an entry is an element
/// of the list. It has an answer for each of its alternative paths that has a trajectory; null if
/// the agent gave no direction.
///
/// parse_results() reads this form too. An answer is that of the first path of the entry which
/// begins where it does and has none yet; "7_1" names one instruction. If all episodes have
/// answers, the text is read back equal except `actions`.
/// \throws ArgumentError if an episode's annotations did not name its entry, as those in DUET's
/// form do not; for infinite numbers and text that is not UTF-8
std::string to_released_soon(const std::vector<Trajectory>& trajectories,
                             const EpisodeSet& episodes);

}  // namespace enfilade::tasks
