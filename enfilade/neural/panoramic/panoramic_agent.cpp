#include "enfilade/neural/panoramic/panoramic_agent.h"

#include <utility>

namespace enfilade::neural::panoramic {

PanoramicAgent::PanoramicAgent(models::ModelConfig config, models::InstructionWords words,
                               std::uint64_t iteration, PanoramicNetwork network)
    : PlannedAgent(std::move(config), iteration, agents::Turning::kRight),
      words_(std::move(words)),
      network_(std::move(network)) {}

void PanoramicAgent::prepare(const tasks::EpisodeSet& episodes,
                             const features::FeatureSet* features) {
  split_ = std::make_unique<PanoramicSplit>(episodes, words_, config().training, features);
}

std::vector<tasks::Trajectory> PanoramicAgent::walk(const SplitWalk& options,
                                                    const Progress& progress) {
  return walk_and_write(network_, *split_, config().training, options, progress);
}

std::vector<tasks::Trajectory> PanoramicAgent::walk(std::span<const std::size_t> episodes) {
  return walk_episodes(network_, *split_, episodes, config().training.max_steps);
}

}  // namespace enfilade::neural::panoramic
