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
#include "enfilade/neural/environment.h"

namespace enfilade::neural {

/// How a batch of episodes is walked by the network.
struct RolloutOptions {
  models::Feedback feedback = models::Feedback::kArgmax;
  std::size_t max_steps = 20;  ///< the recipe's
  bool dropout = false;        ///< on in training, and in the recipe's validation loss
  /// Names the random numbers of dropout and sampling: equal ones give equal rollouts, so that
  /// nothing of a generator has to be saved with a checkpoint.
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;  ///< e.g. the iteration
};

/// n instructions: ids (n, max_words) as Vocabulary::encode() makes them.
struct InstructionBatch {
  std::span<const std::uint32_t> tokens;
  std::size_t size = 0;
};

/// One step of a rollout, to whoever wants to look: valid during the call.
struct StepRecord {
  std::size_t step = 0;
  std::span<const float> attention;  ///< (n, words), words = length of the longest
  std::size_t words = 0;
  std::span<const float> logits;          ///< (n, 6); -inf where forward is closed
  std::span<const std::int32_t> actions;  ///< (n)
};
/// Called after each step of a rollout.
using StepObserver = std::function<void(const StepRecord&)>;

/// What a rollout comes to.
struct RolloutResult {
  /// Sum over steps of the cross-entropy averaged over rows that count; 0 without a teacher.
  double loss = 0;
  std::size_t steps = 0;
};

/// Parameters, their gradients and moments, on one device. One thread at a time (it uses the
/// threads that set_threads() gives). The same calls give the same numbers to the bit with the same
/// number of threads; with another one, as far as the BLAS's do (OpenBLAS: up to 1e-6 of the
/// largest gradient apart).
class Network {
 public:
  /// Random weights by `seed`, distributed as PyTorch's modules initialise theirs.
  /// \throws ArgumentError as validate(); Error for a device that is not there
  Network(const models::NetworkConfig& config, std::uint64_t seed,
          const std::string& device = "cpu");
  ~Network();
  Network(Network&&) noexcept;
  Network& operator=(Network&&) noexcept;

  const models::NetworkConfig& config() const noexcept;

  /// Walks the batch to its end or max_steps, without gradients. kTeacher without an observer walks
  /// all of it before the network looks: what the labels say does not depend on it.
  /// \throws ArgumentError for sizes that do not fit, kTeacher or a loss without a teacher
  RolloutResult rollout(const InstructionBatch& instructions, Environment& environment,
                        const RolloutOptions& options, const StepObserver& observer = {});
  /// The same with gradients, which replace those before. Nothing goes through a drawn action.
  RolloutResult rollout_with_gradients(const InstructionBatch& instructions,
                                       Environment& environment, const RolloutOptions& options);
  /// A greedy rollout from outside, for an agent that somebody else moves: reads n instructions,
  /// then gives n likeliest actions at each of max_steps calls of act(). No rollout may come
  /// between. \throws ArgumentError for sizes that do not fit, or act() without begin()
  void begin(const InstructionBatch& instructions, std::size_t max_steps);
  /// \param features (n, config().features) \param forward_open (n) \param actions (n), 0..5
  void act(std::span<const float> features, std::span<const std::uint8_t> forward_open,
           std::span<std::int32_t> actions);

  /// One Adam update of all parameters from the gradients. \throws Error if one is not finite,
  /// naming it; then nothing has changed.
  void update(const models::AdamConfig& config);
  std::uint64_t updates() const noexcept;  ///< so far

  /// Copies, named as the released PyTorch code names its parameters ("encoder.embedding.weight",
  /// "decoder.lstm.weight_ih", ...), and what training needs to go on ("adam.first.<name>", ...).
  struct State {
    std::vector<features::NamedArray> arrays;
    std::vector<std::vector<std::byte>> storage;  ///< what they point into
  };
  State weights() const;
  State gradients() const;
  State training_state() const;  ///< weights and moments and the number of updates
  /// \throws InvalidInput naming every missing, surplus and wrong-shaped array of the file
  void load_weights(const features::TensorFile& file);
  void load_training_state(const features::TensorFile& file);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Threads of libtorch's and the BLAS's products; process-wide. 0: all cores
void set_threads(int threads);

}  // namespace enfilade::neural
