/// \file  Room-to-Room episodes in the native simulator, for the network.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/agents/episode_batch.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/seq2seq/environment.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::neural::seq2seq {

/// How many episodes run at once, and where the released code differs from what one expects.
struct R2rEnvironmentConfig {
  std::size_t batch_size = 100;
  std::size_t max_steps = 20;  ///< for which memory is kept; longer trajectories allocate
  models::AfterEnd after_end = models::AfterEnd::kWalksOn;
  models::ForwardTo forward = models::ForwardTo::kNearest;
};

/// A batch of episodes of one split, in SimulatorConfig::room_to_room(). Start: the path's first
/// viewpoint, heading snapped to 30 degrees, elevation 0. `forward` where nothing is ahead, and
/// numbers that are no action, leave the agent where it is. observe() and step() allocate nothing
/// up to max_steps. One thread at a time.
class R2rEnvironment : public Environment {
 public:
  /// `episodes` and `features` (null: none, dimensions() is 0) have to outlive *this.
  /// \throws ArgumentError for a batch_size of 0, or kIntended where goals are hidden
  R2rEnvironment(const tasks::EpisodeSet& episodes, const core::ViewFeatures* features,
                 const R2rEnvironmentConfig& config);

  /// Begins these episodes (indices into EpisodeSet::episodes). Must come before the first
  /// observe(). \throws ArgumentError for another number than batch_size, or an index out of range
  void start(std::span<const std::size_t> episodes);

  std::size_t size() const override { return config_.batch_size; }
  std::size_t dimensions() const override;
  bool has_teacher() const override { return has_teacher_; }  ///< no goal of the split is hidden
  void observe(const EnvironmentView& out) override;
  bool step(std::span<const std::int32_t> actions) override;
  std::span<const std::uint8_t> ended() const override { return batch_.ended(); }

  /// Each agent's trajectory since start(), as in results files: the start, then one entry per
  /// action until `end`, which adds none.
  std::span<const tasks::Trajectory> trajectories() const noexcept { return batch_.trajectories(); }

 private:
  agents::Decision teacher(std::size_t slot) const;
  std::int32_t label(std::size_t slot) const;
  sim::Action action_of(std::size_t slot, std::int32_t action) const;

  const core::ViewFeatures* features_;
  R2rEnvironmentConfig config_;
  bool has_teacher_;
  agents::EpisodeBatch batch_;
  std::vector<sim::Action> actions_;
};

}  // namespace enfilade::neural::seq2seq
