/// \file  DUET's fine-tuning: losses of two walks, and a step of AdamW.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/neural/duet/rollout.h"

namespace enfilade::neural::duet {

/// AdamW as PyTorch has it. The published code's option for the decay is not connected, so its
/// decay is PyTorch's own, 0.01.
struct AdamWConfig {
  double rate = 1e-5;
  double first_decay = 0.9, second_decay = 0.999;
  double epsilon = 1e-8;
  double weight_decay = 0.01;
  double clip = 40;  ///< largest norm of all gradients together; they are scaled down to it
};

/// Moments and number of updates. Parameters without a gradient stay as they are.
class AdamW {
 public:
  explicit AdamW(const AdamWConfig& config) : config_(config) {}

  /// Clips the gradients, updates the weights, forgets the gradients.
  /// \return the norm before clipping
  /// \throws Error naming a gradient that is not finite; then no weight has changed
  double update(const DuetNetwork& network);
  std::uint64_t updates() const noexcept { return updates_; }  ///< so far

  /// Weights, moments and number of updates, as one safetensors file. \throws FileError
  void save(const DuetNetwork& network, const std::filesystem::path& file) const;
  /// Of save()'s file. \throws InvalidInput naming every array that is missing or does not fit
  void load(DuetNetwork& network, const features::TensorFile& file);

 private:
  void step(const std::string& name, at::Tensor weight, const at::Tensor& gradient);

  AdamWConfig config_;
  std::uint64_t updates_ = 0;
  encoders::Weights first_, second_;
};

/// Forgets the gradients of all weights.
void clear_gradients(const DuetNetwork& network);

/// A part of an iteration: one batch, walked in one way.
struct TrainingWalk {
  std::span<const WalkEpisode> episodes;
  WalkOptions options;  ///< with an expert
  double weight = 1;    ///< of its loss, which is summed over steps and averaged over episodes
};

/// What an iteration came to.
struct TrainingStep {
  double loss = 0;             ///< the sum of `losses`
  std::vector<double> losses;  ///< by walk, weights included
  double norm = 0;             ///< of the gradients before clipping
};

/// Walks and adds up the losses; gradients are then those of their sum. The same seeds and weights
/// give the same numbers with the same number of threads. `norm` stays 0.
/// \throws Error for a loss that is not finite
TrainingStep accumulate(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, const StepWatcher& watcher = {});

/// accumulate(), and one update of the network. \throws Error for a loss or gradient that is not
/// finite; then no weight has changed
TrainingStep train_once(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, AdamW& optimizer,
                        const StepWatcher& watcher = {});

}  // namespace enfilade::neural::duet
