/// \file  What agents are trained and validated on.
#pragma once
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "enfilade/features/feature_set.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::neural {

struct ContinuousData;  // continuous_agent.h

/// The episodes of an agent in navigation graphs.
struct GraphData {
  tasks::EpisodeSet training;                 ///< of all splits trained on, fourth instructions too
  std::vector<tasks::EpisodeSet> validation;  ///< scored instructions only
  std::optional<features::FeatureSet> features;  ///< none: the agent does not see
};

/// What an agent is trained and validated on: load_training_data(), load_continuous_data().
struct TrainingData {
  models::DataFingerprint fingerprint;  ///< its features are those of the episodes
  std::variant<GraphData, std::shared_ptr<const ContinuousData>> episodes;

  /// \throws std::bad_variant_access for an agent of the continuous world
  GraphData& graph() { return std::get<GraphData>(episodes); }
  const GraphData& graph() const { return std::get<GraphData>(episodes); }
  /// Null for an agent in navigation graphs.
  const ContinuousData* continuous() const noexcept {
    const auto* own = std::get_if<std::shared_ptr<const ContinuousData>>(&episodes);
    return own != nullptr ? own->get() : nullptr;
  }
};

}  // namespace enfilade::neural
