/// \file  DAgger's rollouts: mixed of the teacher's actions and the network's own, with the
/// teacher's advice at every step.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/neural/continuous/episode_file.h"
#include "enfilade/neural/continuous/episode_states.h"

namespace enfilade::neural::continuous {

/// Rule that chooses the performed action.
struct Mixture {
  /// Probability of the teacher's action, independently at each step.
  double teacher_share = 1;
  /// Else the network's: drawn by its probabilities, or the likeliest.
  bool drawn = true;
  /// The network stops at the latest with this action, counted from 1; 0: no limit.
  std::size_t last_action = 0;
};

/// What all walkers have in common. All but `sight` may not be null, and all outlive the walker.
struct GathererParts {
  const CeNetwork* network = nullptr;
  const models::InstructionWords* words = nullptr;
  const models::NetworkConfig* config = nullptr;
  Sight* sight = nullptr;  ///< null: it does not see
};

/// Computes and records rollouts. An oracle: its teacher follows the reference path.
class Gatherer : public agents::ContinuousAgent {
 public:
  /// \param episodes those that are walked through, which outlive *this
  Gatherer(const GathererParts& parts, const Mixture& mixture,
           const tasks::ContinuousEpisodes& episodes);

  std::string_view name() const override { return "gatherer"; }
  bool needs_goal() const override { return true; }
  void start(std::size_t slot, const agents::ContinuousObservation& seen,
             const enfilade::continuous::SimulatorConfig& config) override;
  void act(std::span<const agents::ContinuousObservation> batch,
           std::span<enfilade::continuous::Action> actions) override;

  /// One an episode, in their order.
  const std::vector<RecordedEpisode>& walks() const noexcept { return walks_; }

 private:
  GathererParts parts_;
  Mixture mixture_;
  const tasks::ContinuousEpisodes& episodes_;
  std::unique_ptr<agents::ContinuousAgent> teacher_;
  EpisodeStates states_;
  double eye_height_ = 0;
  std::vector<RecordedEpisode> walks_;
};

/// Which of `batch` have not ended.
std::vector<std::size_t> walking(std::span<const agents::ContinuousObservation> batch);

}  // namespace enfilade::neural::continuous
