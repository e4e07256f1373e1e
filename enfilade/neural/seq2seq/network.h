/// \file  The attentional LSTM sequence-to-sequence network of the paper (section 4.3).
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/network_config.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/seq2seq/environment.h"

namespace enfilade::neural::seq2seq {

/// Options of a rollout.
struct RolloutOptions {
  models::Feedback feedback = models::Feedback::kArgmax;
  std::size_t max_steps = 20;  ///< as in the released code
  bool dropout = false;  ///< in training and, as in the released code, in the validation loss.
  /// Seed and stream determine dropout and sampling. Equal ones give equal rollouts, so a
  /// checkpoint has no state of a generator.
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;  ///< e.g. the iteration
};

/// n instructions: word ids (n, max_words), see Vocabulary::encode().
struct InstructionBatch {
  std::span<const std::uint32_t> tokens;
  std::size_t size = 0;
};

/// One step of a rollout, for an observer; valid during the call.
struct StepRecord {
  std::size_t step = 0;
  std::span<const float> attention;  ///< (n, words), words = length of the longest
  std::size_t words = 0;
  std::span<const float> logits;          ///< (n, 6); -inf where forward is closed
  std::span<const std::int32_t> actions;  ///< (n)
};
/// Called after each step of a rollout.
using StepObserver = std::function<void(const StepRecord&)>;

/// The result of a rollout.
struct RolloutResult {
  /// Cross-entropy, averaged over the rows with a label and summed over steps; 0 without a teacher.
  double loss = 0;
  std::size_t steps = 0;
};

/// The network's parameters, their gradients and moments, on one device. One thread at a time; it
/// computes on the threads of set_threads(). The same calls give the same bits with the same number
/// of threads. With another number results differ as the BLAS's do (OpenBLAS: by up to 1e-6 of the
/// largest gradient).
class Network {
 public:
  /// Random weights by `seed`, from the distributions with which PyTorch initialises its modules.
  /// \throws ArgumentError as validate(); Error for a device that is not available
  Network(const models::NetworkConfig& config, std::uint64_t seed,
          const std::string& device = "cpu");
  ~Network();
  Network(Network&&) noexcept;
  Network& operator=(Network&&) noexcept;

  const models::NetworkConfig& config() const noexcept;

  /// Computes a rollout of the batch to its end or max_steps, without gradients. With kTeacher and
  /// no observer the whole trajectory is made before the network runs, as the labels do not depend
  /// on it.
  /// \throws ArgumentError for sizes that do not fit, kTeacher or a loss without a teacher
  RolloutResult rollout(const InstructionBatch& instructions, Environment& environment,
                        const RolloutOptions& options, const StepObserver& observer = {});
  /// The same with gradients, which replace the previous ones. Sampling an action has no gradient.
  /// \param decoder_done called when the gradients of the decoder are complete, and only those
  RolloutResult rollout_with_gradients(const InstructionBatch& instructions,
                                       Environment& environment, const RolloutOptions& options,
                                       const std::function<void()>& decoder_done = {});
  /// Begins a greedy rollout that the caller steps: n instructions, then at most max_steps calls of
  /// act(). Each gives the n most likely actions. No other rollout may come between.
  /// \throws ArgumentError for sizes that do not fit
  void begin(const InstructionBatch& instructions, std::size_t max_steps);
  /// One step of the rollout that begin() began.
  /// \param features (n, config().features) \param forward_open (n) \param actions (n), 0..5
  /// \throws ArgumentError for sizes that do not fit, or without begin()
  void act(std::span<const float> features, std::span<const std::uint8_t> forward_open,
           std::span<std::int32_t> actions);

  /// One Adam update of all parameters from the gradients. \throws Error naming a gradient that is
  /// not finite; then nothing has changed
  void update(const models::AdamConfig& config);
  std::uint64_t updates() const noexcept;  ///< so far

  /// Copies of arrays, with the names of the released PyTorch code ("encoder.embedding.weight",
  /// "decoder.lstm.weight_ih", ...) and, for training, "adam.first.<name>" and so on.
  using State = core::State;
  State weights() const;         ///< the parameters
  State gradients() const;       ///< of the last rollout_with_gradients()
  State training_state() const;  ///< parameters, moments and number of updates
  /// Loads what weights() or training_state() gave.
  /// \throws InvalidInput naming every missing, surplus and wrong-shaped array of the file
  void load_weights(const features::TensorFile& file);
  /// \throws as load_weights()
  void load_training_state(const features::TensorFile& file);

  struct Impl;
  Impl& implementation() noexcept { return *impl_; }  ///< of the library itself

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::neural::seq2seq
