/// \file  Agents that choose among viewpoints, in the simulator's small steps.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "enfilade/agents/panorama.h"
#include "enfilade/agents/route.h"
#include "enfilade/neural/trained_agent.h"

namespace enfilade::neural::detail {

/// Computes the whole trajectory when an episode begins: a building does not change during it, and
/// a network's input at a viewpoint is known before. So all callers get trajectories from the same
/// code, batch by batch.
class PlannedAgent : public TrainedAgent {
 public:
  explicit PlannedAgent(models::ModelConfig config, std::uint64_t iteration,
                        agents::Turning turning)
      : config_(std::move(config)), iteration_(iteration), turning_(turning) {}

  const models::ModelConfig& config() const noexcept override { return config_; }
  std::uint64_t iteration() const noexcept override { return iteration_; }
  /// The kind, as in config.json.
  std::string_view name() const override { return to_string(config_.training.agent); }
  void enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override;
  void start(std::span<const agents::Observation> batch) override;
  void act(std::span<const agents::Observation> batch,
           std::span<agents::Decision> decisions) override;

 protected:
  /// enter() of the kind. \param features that it uses; null if it does not see
  virtual void prepare(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) = 0;
  /// Greedy trajectories of these of the entered episodes, in their order.
  virtual std::vector<tasks::Trajectory> walk(std::span<const std::size_t> episodes) = 0;
  using TrainedAgent::walk;

 private:
  struct Slot {
    agents::Route route;
    agents::Answer answer;
  };

  models::ModelConfig config_;
  std::uint64_t iteration_;
  agents::Turning turning_;
  const tasks::EpisodeSet* episodes_ = nullptr;
  std::unique_ptr<agents::PanoramaCache> panoramas_;
  std::vector<Slot> slots_;
};

}  // namespace enfilade::neural::detail
