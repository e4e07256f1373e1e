#include "enfilade/neural/duet/duet_agent.h"

#include <utility>

namespace enfilade::neural::duet {

DuetAgent::DuetAgent(models::ModelConfig config, models::InstructionWords words,
                     std::uint64_t iteration, DuetNetwork network)
    : PlannedAgent(std::move(config), iteration, agents::Turning::kShorter),
      words_(std::move(words)),
      network_(std::move(network)) {}

void DuetAgent::prepare(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) {
  split_ = std::make_unique<DuetSplit>(episodes, words_, config().training, features);
}

std::vector<tasks::Trajectory> DuetAgent::walk(const SplitWalk& options, const Progress& progress) {
  return walk_and_write(network_, *split_, options, progress);
}

std::vector<tasks::Trajectory> DuetAgent::walk(std::span<const std::size_t> episodes) {
  return walk_episodes(network_, *split_, episodes);
}

}  // namespace enfilade::neural::duet
