/// \file  Golden scores of the public code of the benchmarks, compared with what we compute.
#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "tests/conformance/doubtful.h"
#include "tests/conformance/vectors.h"

namespace enfilade::tests {

/// Whether a file has the form that check_benchmark() reads: "scorers" and "sets".
bool is_benchmark_file(const std::filesystem::path& file);

/// Compares the scores and means of `<task>.json`, recorded from public scorers: r2r, r2r_last,
/// r2r_back, r4r, rxr, reverie, cvdn, soon, vlnce, threshold. A case is a scorer's metrics of one
/// prediction, its means of one set, or a follower's line.
/// \param data  the data set's folder; annotation files named `data/...` are beside it under that
/// name, all others beside the file
/// \throws FileError; InvalidInput for a file that cannot be used
VectorReport check_benchmark(const std::filesystem::path& file, const std::filesystem::path& data,
                             const std::shared_ptr<const graph::GraphSet>& graphs,
                             const VectorTolerances& tolerances);

/// The "behaviour" of vlnce.json: walks in continuous space that its public scorers divide by zero
/// for, or see differently. \throws as check_benchmark()
std::vector<DoubtfulInput> doubtful_walks(const std::filesystem::path& file,
                                          const std::filesystem::path& data);

}  // namespace enfilade::tests
