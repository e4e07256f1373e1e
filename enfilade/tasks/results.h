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

/// Viewpoint and direction of an agent after one of its actions.
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

/// Whether a benchmark requires an answer beside the path: R2R-Back, REVERIE, SOON.
constexpr bool asks_for_answer(Task task) noexcept {
  return task == Task::kR2rBack || task == Task::kReverie || task == Task::kSoon;
}

/// The trajectory of one episode: the start, then one entry per action.
struct Trajectory {
  std::size_t episode = 0;  ///< index into EpisodeSet::episodes
  std::vector<TrajectoryPoint> points;
  /// Where one action may pass several viewpoints, or none (DUET's sub-paths): how many there were.
  /// No value: an entry an action.
  std::optional<std::size_t> actions = {};
  // Answers that some benchmarks require beside the path.
  std::optional<ViewpointIndex> turning_point = {};  ///< R2R-Back: where it turned, by its own
                                                     ///< report
  std::string object = {};                           ///< REVERIE: the object's id; empty: none
  std::optional<SpherePoint> point = {};             ///< SOON: where the object is
};

/// A results file, checked against its split.
struct Results {
  std::vector<Trajectory> trajectories;  ///< one per episode, in the order of the episodes
  std::vector<Diagnostic> warnings;      ///< e.g. an unscored fourth instruction was left out
};

/// Which instructions of the split a results file has to answer.
enum class Coverage : std::uint8_t {
  kAll,   ///< a missing one is a fault
  kPart,  ///< at least one: for a part of the split
};

/// Reads [{"instr_id": "1_0", "trajectory": [...]}, ...] and checks all of it. A trajectory's
/// entries may be [viewpoint, heading, elevation] triples, [viewpoint] singles, plain viewpoint
/// ids, or lists of those (sub-paths, as of DUET), in any mixture. Entries are read one by one.
/// Beside the text this takes 24 bytes per trajectory point, and up to 14 times the largest entry,
/// of at most 1 MiB.
///
/// With Coverage::kPart, missing instructions have no trajectory, and the others are in the order
/// of the episodes; part_of() makes a set of them.
/// \throws FileError
/// \throws InvalidInput with *every* problem and its JSON path:
/// - not JSON, wrong types, an entry that is too large
/// - an unknown, missing or repeated instr_id
/// - an empty trajectory, a wrong start, unknown or excluded viewpoints
/// - a jump between viewpoints that are not adjacent
///
/// After kMostFaultsKept errors the rest of the file is not read, and the last diagnostic says so.
Results load_results(const std::filesystem::path& file, const EpisodeSet& episodes,
                     Coverage coverage = Coverage::kAll);
Results parse_results(std::string_view json, const std::string& file, const EpisodeSet& episodes,
                      Coverage coverage = Coverage::kAll);

/// The episodes that have a trajectory, in their order, with all paths. The trajectories' `episode`
/// become indices into it. Input for scoring a part of a split.
/// \pre each names an episode of `episodes`, and no two the same
EpisodeSet part_of(const EpisodeSet& episodes, std::vector<Trajectory>& trajectories);

/// Results in the form of the benchmark's public code, one episode per line, the trajectory as
/// [viewpoint, heading, elevation] triples. They have `instr_id` and `trajectory`, and
/// - R2R-Back `midstop`, REVERIE `predObjId`, each null without an answer
/// - RxR `instruction_id`
/// - CVDN `inst_idx` for `instr_id`, if the id is a number
/// - SOON `path`, `obj_heading` and `obj_elevation` in `trajectory`
///
/// Except `actions`, parse_results() reads them back equal. Linear in the points (bench/ has its
/// time).
/// \throws ArgumentError for infinite numbers and text that is not UTF-8
std::string to_json(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes);

/// \throws ArgumentError if a trajectory names no episode, is empty or leaves its graph, or if the
/// goal is hidden: then it cannot be scored
void check_trajectory(const Trajectory& trajectory, const EpisodeSet& episodes);
/// The place of each episode's trajectory, in the order of the episodes.
/// \pre check_trajectory() accepts each
/// \throws ArgumentError unless each episode has exactly one
std::vector<std::size_t> trajectory_by_episode(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes);

}  // namespace enfilade::tasks
