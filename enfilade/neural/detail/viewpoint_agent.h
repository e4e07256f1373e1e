/// \file  A trained agent that chooses among viewpoints, of its network and its splits.
#pragma once
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/detail/planned_agent.h"

namespace enfilade::neural::detail {

/// \tparam Split made of episodes, words, a TrainConfig and features; also of objects if its agent
/// may name one. Its functions walk_episodes() and walk_and_write() with Network are found beside
/// them
template <class Network, class Split>
class ViewpointAgent : public PlannedAgent {
 public:
  ViewpointAgent(models::ModelConfig config, models::InstructionWords words,
                 std::uint64_t iteration, Network network, agents::Turning turning)
      : PlannedAgent(std::move(config), iteration, turning),
        words_(std::move(words)),
        network_(std::move(network)) {}

  void set_objects(const std::shared_ptr<const features::ObjectSet>& objects) override {
    objects_ = objects;
  }
  std::vector<tasks::Trajectory> walk(const SplitWalk& options, const Progress& progress) override {
    return walk_and_write(network_, *split_, options, progress);
  }

 protected:
  void prepare(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override {
    const models::TrainConfig& training = config().training;
    if constexpr (kShowsObjects) {
      split_ = std::make_unique<Split>(episodes, words_, training, features, objects_);
    } else {
      split_ = std::make_unique<Split>(episodes, words_, training, features);
    }
  }
  std::vector<tasks::Trajectory> walk(std::span<const std::size_t> episodes) override {
    return walk_episodes(network_, *split_, episodes);
  }

 private:
  using Objects = std::shared_ptr<const features::ObjectSet>;
  static constexpr bool kShowsObjects =
      std::is_constructible_v<Split, const tasks::EpisodeSet&, const models::InstructionWords&,
                              const models::TrainConfig&, const features::FeatureSet*, Objects>;

  models::InstructionWords words_;
  Network network_;
  Objects objects_;
  std::unique_ptr<Split> split_;
};

}  // namespace enfilade::neural::detail
