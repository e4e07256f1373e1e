/// \file  Hashes of the data that a model was trained on, to detect other data.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::models {

/// Hashes are 16 hex digits of XXH3. They are of the content, not of files: white space is ignored.
struct DataFingerprint {
  std::map<std::string, std::string> annotations;  ///< by split
  std::map<std::string, std::string> graphs;       ///< by scan
  std::optional<features::FeatureInfo> features;   ///< none if the agent does not see

  void add(const tasks::Annotations& split);           ///< the annotations of a split
  void add(const tasks::ContinuousEpisodes& split);    ///< the episodes of a split
  void add_graphs(const tasks::EpisodeSet& episodes);  ///< of all scans that these are in
};

/// Differences between the data of training and the present data, as warnings naming the split,
/// scan or field. Only of splits, scans and features that are in both. `file` is the model's, for
/// messages.
std::vector<Diagnostic> differences(const DataFingerprint& trained, const DataFingerprint& now,
                                    const std::string& file);

}  // namespace enfilade::models
