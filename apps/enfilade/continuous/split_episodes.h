/// \file  Continuous episodes of a split on the floors of buildings, with their experts' walks.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/derive_continuous.h"

namespace enfilade::apps {

/// Episodes of one split.
struct SplitEpisodes {
  tasks::DerivedEpisodes derived;
  std::optional<tasks::ExpertWalks> experts;  ///< no value where goals are hidden
};

/// Derives episodes, and records the reference agent's walks through them, with a progress bar. The
/// file of episodes names Habitat's floor; ours is that of files without a name.
/// \throws as agents::record_experts()
SplitEpisodes derive_split(const tasks::Annotations& annotations, const graph::GraphSet& graphs,
                           const std::shared_ptr<const continuous::Buildings>& buildings,
                           const agents::ContinuousSetup& setup, const std::string& split,
                           const tasks::DeriveOptions& options = {});

}  // namespace enfilade::apps
