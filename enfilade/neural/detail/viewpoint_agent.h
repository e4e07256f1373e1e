/// \file  A trained agent that chooses among viewpoints, of its network and its splits.
#pragma once
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/detail/planned_agent.h"

namespace enfilade::neural::detail {

/// \tparam Split made of episodes, words, a TrainConfig and features; walk_episodes() and
/// walk_and_write() of Network and Split are found beside them
template <class Network, class Split>
class ViewpointAgent : public PlannedAgent {
 public:
  ViewpointAgent(models::ModelConfig config, models::InstructionWords words,
                 std::uint64_t iteration, Network network, agents::Turning turning)
      : PlannedAgent(std::move(config), iteration, turning),
        words_(std::move(words)),
        network_(std::move(network)) {}

  std::vector<tasks::Trajectory> walk(const SplitWalk& options, const Progress& progress) override {
    return walk_and_write(network_, *split_, options, progress);
  }

 protected:
  void prepare(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override {
    split_ = std::make_unique<Split>(episodes, words_, config().training, features);
  }
  std::vector<tasks::Trajectory> walk(std::span<const std::size_t> episodes) override {
    return walk_episodes(network_, *split_, episodes);
  }

 private:
  models::InstructionWords words_;
  Network network_;
  std::unique_ptr<Split> split_;
};

}  // namespace enfilade::neural::detail
