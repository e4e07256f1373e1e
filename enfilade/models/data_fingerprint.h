/// \file  What data a model was trained on, so that other data is noticed.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/r2r/annotations.h"

namespace enfilade::models {

/// Hashes are 16 hex digits of XXH3 over content, not over files: white space changes nothing.
struct DataFingerprint {
  std::map<std::string, std::string> annotations;  ///< by split
  std::map<std::string, std::string> graphs;       ///< by scan
  std::optional<features::FeatureInfo> features;   ///< none: the agent does not see

  /// Adds the hash of a split's annotations.
  void add(const r2r::Annotations& split);
  void add_graphs(const r2r::EpisodeSet& episodes);  ///< of the scans that they are in
};

/// What differs between the data that a model was trained on and that which it is to walk in, for
/// what both name: warnings, each naming the split, scan or field, in `file` the model's.
std::vector<Diagnostic> differences(const DataFingerprint& trained, const DataFingerprint& now,
                                    const std::string& file);

}  // namespace enfilade::models
