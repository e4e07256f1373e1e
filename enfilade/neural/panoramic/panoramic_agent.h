/// \file  The trained panoramic LSTM as an Agent.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/detail/planned_agent.h"
#include "enfilade/neural/panoramic/panoramic_split.h"

namespace enfilade::neural::panoramic {

/// Goes to the likeliest candidate at each choice, at most TrainConfig::max_steps of them, and
/// turns to the right only, as EnvDrop's. With Subout::kMax an episode's choices depend on the
/// longest instruction of its batch, as published.
class PanoramicAgent : public detail::PlannedAgent {
 public:
  PanoramicAgent(models::ModelConfig config, models::InstructionWords words,
                 std::uint64_t iteration, PanoramicNetwork network);

  std::vector<tasks::Trajectory> walk(const SplitWalk& options, const Progress& progress) override;

 protected:
  void prepare(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override;
  std::vector<tasks::Trajectory> walk(std::span<const std::size_t> episodes) override;

 private:
  models::InstructionWords words_;
  PanoramicNetwork network_;
  std::unique_ptr<PanoramicSplit> split_;
};

}  // namespace enfilade::neural::panoramic
