/// \file  Longer episodes, joined from R2R's: R4R, R6R, R8R (Jain et al. 2019; Zhu et al. 2020).
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks {

/// How paths are joined.
struct JoinOptions {
  /// Largest distance from the end of one path to the start of the next, metres along the graph.
  /// The published sets have 3.
  double most_gap = 3.0;
  /// Paths of the input that make one: 2 (R4R), 3 (R6R), 4 (R8R).
  std::size_t paths = 2;
  int threads = 0;  ///< 0: all cores; never changes a result
};

/// A joined path, and what it was joined from.
struct JoinedPath {
  PathAnnotation path;
  std::vector<std::int64_t> from;     ///< path_ids of the input
  std::vector<std::string> shortest;  ///< from first to last viewpoint, as NavGraph::path()
  double shortest_distance = 0;       ///< metres
};

/// The result of join_paths().
struct Joined {
  std::vector<JoinedPath> paths;
  /// Ordered sequences of JoinOptions::paths that were tried: each result for the paths before the
  /// last, with every path.
  std::size_t pairs = 0;
};

/// Joins the paths of a split by the rule of the published generator
/// (google-research/r4r/r4r_generate_data.py).
///
/// - Scans come in the order in which they first appear. Every ordered pair of a scan's paths is
///   tried in file order, a path with itself included. A pair is joined unless the distance from
///   the first's end to the second's start is more than `most_gap`.
/// - The path is the first without its last viewpoint, the shortest path between, both ends
///   included, and the second without its first.
/// - `distance` is the sum of the three, with R2R's own values for the two.
/// - An instruction is x + y for each x of the first and y of the second, without a blank.
/// - The heading is the first's; path_ids are running numbers.
/// - For three and more, the pairs so far are joined with every path in the same way.
///
/// \throws InvalidInput as look_up_paths()
/// \throws ArgumentError for fewer than 2 paths, a hidden goal, a path without `distance`, or a
/// negative or infinite gap
/// \throws ArgumentError for a joined path whose end is out of reach from its start
Joined join_paths(const Annotations& annotations, const graph::GraphSet& graphs,
                  const JoinOptions& options = {});

/// Counts of the written file: paths, sequences as in Joined, and sums over all paths.
struct JoinTotals {
  std::size_t paths = 0, pairs = 0, instructions = 0;
  double length = 0;  ///< metres
};
/// Gets the next part of a text.
using TakeText = std::function<void(std::string_view)>;
/// Passes the text of to_json(join_paths(...)) to `take`, in parts, in order, in the calling
/// thread. Needs memory only for some thousand joined paths: for R2R's train, R6R has gigabytes.
/// \throws as join_paths() and to_json(), and the errors of `take`; parts were taken by then
JoinTotals write_joined(const Annotations& annotations, const graph::GraphSet& graphs,
                        const JoinOptions& options, const TakeText& take);

/// As the generator writes them, one entry per line: distance, first_path_id, second_path_id,
/// heading, instructions, path, path_id, scan, shortest_path, shortest_path_distance. For three and
/// more, `path_ids` instead of the two ids. Read by formats::parse_r2r_family().
/// \throws ArgumentError for infinite numbers and text that is not UTF-8
std::string to_json(const Joined& joined);

}  // namespace enfilade::tasks
