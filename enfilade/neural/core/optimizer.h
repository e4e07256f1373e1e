/// \file  Optimizers of networks whose weights are tensors by name.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::core {

/// Forgets the gradients of all weights.
void clear_gradients(const Weights& weights);

/// The norm of all gradients of weights whose names begin with `part`; 0 without such weights.
double gradient_norm(const Weights& weights, std::string_view part = "");

/// Follows a loss back to the weights. \return its value
/// \throws Error if it is not finite; then the weights have no gradients that mean anything
double follow_back(const at::Tensor& loss);

/// How gradients become updates, as in PyTorch's modules of the same names.
struct OptimizerConfig {
  models::Optimizer kind = models::Optimizer::kAdamW;
  models::AdamConfig rates;  ///< RMSprop's share of the old mean is beta2
  double clip = 40;          ///< largest norm; larger gradients are scaled down to it.
  /// Prefixes of names; the gradients below each are clipped separately, others not at all. "": all
  /// together.
  std::vector<std::string> parts{""};
  std::uint64_t warm_up = 0;  ///< updates in which the rate rises to the one in `rates`
  std::uint64_t end = 0;      ///< updates at which the rate has fallen to 0; 0: it does not fall
};
/// That of a training. \param parts as OptimizerConfig::parts
OptimizerConfig optimizer_of(const models::TrainConfig& config, std::vector<std::string> parts);

/// Moments and the number of updates. Weights without a gradient stay as they are. One thread at a
/// time.
class WeightOptimizer {
 public:
  explicit WeightOptimizer(OptimizerConfig config) : config_(std::move(config)) {}

  /// Clips the gradients, updates the weights, forgets the gradients. \return the norm of all
  /// gradients before clipping
  /// \throws Error naming a gradient that is not finite; then no weight has changed
  double update(const Weights& weights);
  std::uint64_t updates() const noexcept { return updates_; }  ///< so far
  double rate() const noexcept;                                ///< of the next update

  /// Weights, moments and number of updates, for a file; handles to their memory. Moments of
  /// weights that were never updated are zeros.
  Weights state(const Weights& weights) const;
  /// Loads state(), into the weights too.
  /// \throws InvalidInput naming every array that is missing, surplus or does not fit
  void load(const Weights& weights, const features::TensorFile& file);

 private:
  void clip(const Weights& weights) const;
  void step(const Weights& weights);
  bool has_first() const noexcept { return config_.kind != models::Optimizer::kRmsProp; }

  OptimizerConfig config_;
  std::uint64_t updates_ = 0;
  Weights first_, second_;  // running means of gradients and of their squares
};

}  // namespace enfilade::neural::core
