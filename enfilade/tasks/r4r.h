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
  /// Of the end of one path from the start of the next, metres along the graph, at most. The
  /// published sets have 3.
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

/// What came of it.
struct Joined {
  std::vector<JoinedPath> paths;
  /// Ordered sequences of JoinOptions::paths that were looked at: what the paths before the last
  /// give, with every path.
  std::size_t pairs = 0;
};

/// Joins the paths of a split by the rule of the published generator
/// (google-research/r4r/r4r_generate_data.py): scans in the order in which they first appear; of
/// each, every ordered pair of its paths in file order, a path with itself included; joined unless
/// the distance from the first's end to the second's start is more than `most_gap`. The path is the
/// first without its last viewpoint, the shortest path between, both ends included, and the second
/// without its first. `distance` is the sum of the three, with R2R's own figures for the two; an
/// instruction is x + y for each x of the first and y of the second, without a blank; the heading
/// is the first's; path_ids are running numbers. For three and more it goes on in the same way: the
/// pairs so far, each with every path. \throws InvalidInput as look_up_paths(); ArgumentError for a
/// path with a hidden goal or without `distance`, a joined one that would end out of reach from its
/// start, fewer than 2 paths, or a gap that is negative or not finite
Joined join_paths(const Annotations& annotations, const graph::GraphSet& graphs,
                  const JoinOptions& options = {});

/// What was written: paths, sequences looked at as in Joined, and sums over all paths.
struct JoinTotals {
  std::size_t paths = 0, pairs = 0, instructions = 0;
  double length = 0;  ///< metres
};
/// Gets the next part of a text.
using TakeText = std::function<void(std::string_view)>;
/// Gives `take` the text that to_json(join_paths(...)) has, in parts, in order, in the calling
/// thread. Memory is for some thousand joined paths alone: of R2R's train, R6R has gigabytes.
/// \throws as join_paths() and to_json(), and what `take` throws; parts were taken by then
JoinTotals write_joined(const Annotations& annotations, const graph::GraphSet& graphs,
                        const JoinOptions& options, const TakeText& take);

/// As the generator writes them, an entry a line: distance, first_path_id, second_path_id, heading,
/// instructions, path, path_id, scan, shortest_path, shortest_path_distance; of three and more,
/// `path_ids` instead of the two ids. formats::parse_r2r_family() reads it.
/// \throws ArgumentError for what JSON cannot say: an infinite number, text that is not UTF-8
std::string to_json(const Joined& joined);

}  // namespace enfilade::tasks
