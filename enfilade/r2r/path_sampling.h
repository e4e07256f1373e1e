/// \file  Drawing Room-to-Room paths from graphs: the paper's section 4.2, never released.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/r2r/annotations.h"
#include "enfilade/scan/regions.h"

namespace enfilade::r2r {

struct SamplingOptions {
  std::size_t paths = 7189;     ///< in all splits together (the paper's number); fewer if the
                                ///< buildings do not hold as many
  std::size_t min_edges = 4;
  std::size_t max_edges = 6;
  double min_length = 5.0;      ///< metres along the path
  std::uint64_t seed = 1;
  int threads = 0;              ///< 0: all cores; never changes a result
};

/// Start and goal in different regions, the shortest path between them within the limits, no pair
/// twice, start heading uniform. A building's share of the paths is in proportion to its included
/// viewpoints (docs/sampling.md shows why); instructions are left empty.
/// Deterministic: one seed gives the same paths at any thread count.
/// \throws ArgumentError for limits that contradict each other; errors of graph files
std::vector<PathAnnotation> sample_paths(const graph::GraphSet& graphs,
                                         const scan::RegionMap& regions,
                                         const SamplingOptions& options,
                                         const Progress& progress = {});

/// Shares of buildings, as numbers of scans: the paper's 61 / 11 / 18.
struct SplitOptions {
  std::size_t train_scans = 61;
  std::size_t val_unseen_scans = 11;
  std::size_t test_scans = 18;
  double val_seen_share = 0.068;  ///< of the train buildings' paths: 340 of 5,015 in R2R
  std::uint64_t seed = 1;
};

/// "train", "val_seen" (other paths in train's buildings), "val_unseen", "test" (paths cut to their
/// start, distances dropped, returned whole as "test_hidden" too). If the numbers of scans do not
/// add up to those in `paths`, they are scaled in proportion, at least one each where asked for.
/// \throws ArgumentError if there are fewer scans than non-empty shares
std::map<std::string, Annotations> split_by_building(const std::vector<PathAnnotation>& paths,
                                                     const SplitOptions& options);

}  // namespace enfilade::r2r
