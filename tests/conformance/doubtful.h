/// \file  Doubtful inputs: what the public scorers make of them, and what ours does.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"

namespace enfilade::tests {

struct DoubtfulInput {
  std::string scorer, input;
  std::string theirs;  ///< "means", or the error that it ends with
  std::string ours;    ///< "the same means", "other means", or the codes of the faults
};

/// The "behaviour" of a benchmark's recorded file. Each input is read by our reader of results and,
/// if that accepts it, scored. \throws FileError for a file of another form
std::vector<DoubtfulInput> doubtful_inputs(const std::filesystem::path& file,
                                           const std::filesystem::path& data,
                                           const std::shared_ptr<const graph::GraphSet>& graphs);

}  // namespace enfilade::tests
