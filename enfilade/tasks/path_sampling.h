/// \file  Drawing Room-to-Room paths from graphs: the paper's section 4.2, never released.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/regions.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks {

/// Which start and goal are drawn. Both lie in rooms (regions), and in different ones.
enum class PairRule {
  /// R2R's rule, as its paths show (docs/sampling.md). An ordered pair of rooms gives one path at
  /// most, from a viewpoint of the first to the nearest viewpoint of the second. So the path ends
  /// at the first viewpoint in the room.
  kRooms,
  /// Any two viewpoints: many more paths, which come out longer than R2R's.
  kViewpoints,
};

/// Which paths are drawn.
struct SamplingOptions {
  PairRule pairs = PairRule::kRooms;
  std::size_t per_building = 100;  ///< at most; R2R's number
  std::size_t paths = 0;           ///< in all, at most; 0: as many as the buildings give
  std::size_t min_edges = 4;
  std::size_t max_edges = 6;
  double min_length = 5.0;  ///< metres along the path
  std::uint64_t seed = 1;
  /// Text that seeds the draws in a scan beside the seed; null: its id. \pre any thread may call it
  std::function<std::string(const std::string& scan)> draws_of = {};
  int threads = 0;  ///< 0: all cores; never changes a result
};

/// Shortest paths within the limits, no start and goal twice. Each possible pair of rooms (or of
/// viewpoints) of a building is equally likely, and so is each start within a pair of rooms.
/// Headings are uniform, one per start viewpoint; headings and distances are rounded as R2R's are.
/// Path ids count from 1, buildings in the order of `graphs`; instructions are left empty.
/// Viewpoints that are in no region of `regions` are neither starts nor goals. Deterministic: one
/// seed gives the same paths at any thread count.
/// \throws ArgumentError for limits that allow nothing; errors of graph files
std::vector<PathAnnotation> sample_paths(const graph::GraphSet& graphs,
                                         const scan::RegionMap& regions,
                                         const SamplingOptions& options,
                                         const Progress& progress = {});

/// Shares of buildings, as numbers of scans: the paper's 61 / 11 / 18.
struct SplitOptions {
  std::size_t train_scans = 61;
  std::size_t val_unseen_scans = 11;
  std::size_t test_scans = 18;
  double val_seen_share = 0.068;  ///< of the train buildings' paths: 340 of 5,015 in R2R; [0, 1)
  std::uint64_t seed = 1;
};

/// The split that split_by_building() gives each of these buildings: "train", "val_unseen" or
/// "test". Ignores `val_seen_share`.
/// \throws ArgumentError as split_by_building()
std::map<std::string, std::string> splits_of_buildings(std::vector<std::string> scans,
                                                       const SplitOptions& options);

/// "train", "val_seen" (other paths in train's buildings), "val_unseen", "test" (paths cut to their
/// start, distances dropped; "test_hidden" has them whole). If the numbers of scans do not add up
/// to those in `paths`, they are scaled in proportion, at least one for each number above 0. Paths
/// keep their order.
/// \throws ArgumentError if there are fewer scans than non-empty shares, or a share outside [0, 1)
std::map<std::string, Annotations> split_by_building(const std::vector<PathAnnotation>& paths,
                                                     const SplitOptions& options);

}  // namespace enfilade::tasks
