/// \file  Golden vectors of metrics and of navigable viewpoints, compared with what we compute.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"

namespace enfilade::tests {

/// Largest differences that count as equal.
struct VectorTolerances {
  double metrics = 1e-9;  ///< double-precision sums in another order
  double nav = 1e-5;      ///< angles and distances from single-precision positions
};

struct VectorReport {
  std::size_t cases = 0;
  std::size_t mismatches = 0;         ///< cases in which something differs
  std::vector<std::string> examples;  ///< what differs, a line each, of the first few of them
};

/// Compares the cases of a file: `metrics_*.json` (cases with "metrics") or `nav_*.json` (cases
/// with "navigable"). \throws FileError; InvalidInput with JSON paths for a file that cannot be
/// used: not JSON, missing or wrongly typed fields, scans, viewpoints or metrics that do not exist
VectorReport check_vectors(const std::filesystem::path& file,
                           const std::shared_ptr<const graph::GraphSet>& graphs,
                           const VectorTolerances& tolerances);

}  // namespace enfilade::tests
