/// \file  Model directories as agents, for verbs that run agents.
#pragma once
#include <memory>
#include <string>

#include "enfilade/agents/agent.h"
#include "enfilade/r2r/annotations.h"

namespace enfilade::apps {

/// The agent of a model directory, for these episodes; prints what differs between their data and
/// that which it was trained on. \param features file; empty: none
/// \throws UsageError in a build without libtorch; ArgumentError if the model sees and has no
/// features, or of another size; errors of the files
std::unique_ptr<agents::Agent> load_trained_agent(const std::string& folder,
                                                  const std::string& features,
                                                  const r2r::EpisodeSet& episodes);

}  // namespace enfilade::apps
