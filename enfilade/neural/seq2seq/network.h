/// \file  What the sequence-to-sequence network is given and gives: six actions, a batch of
/// episodes, rollouts.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "enfilade/agents/six_actions.h"
#include "enfilade/models/network_config.h"

namespace enfilade::neural::seq2seq {

/// The network's outputs are the six actions, in their order.
using agents::kSixActionCount;
using agents::SixAction;
/// Two inputs that are not actions: the one before the first action, and that of an episode that is
/// over. So the network has 8 inputs.
inline constexpr std::int32_t kStartInput = 6;
inline constexpr std::int32_t kIgnoreInput = 7;
/// A teacher's label for an episode that no longer adds to the loss.
inline constexpr std::int32_t kIgnoreLabel = -1;

/// Observation of n episodes before an action. The memory belongs to the network.
struct EnvironmentView {
  std::span<float> features;             ///< (n, dimensions) of the view each agent has
  std::span<std::uint8_t> forward_open;  ///< (n) 1 if there is a viewpoint forward
  /// (n) 0..5 or kIgnoreLabel; filled only on request.
  std::span<std::int32_t> labels;
};

/// A batch of episodes in lock-step. The network calls observe() and step(), alternating.
class Environment {
 public:
  virtual ~Environment() = default;
  virtual std::size_t size() const = 0;        ///< n
  virtual std::size_t dimensions() const = 0;  ///< of the features
  virtual bool has_teacher() const = 0;        ///< whether it can fill `labels`
  /// The present observation of every episode. \param out its spans are filled
  virtual void observe(const EnvironmentView& out) = 0;
  /// One action per episode; that of an ended episode is ignored, except with AfterEnd::kWalksOn.
  /// False when every episode is over.
  virtual bool step(std::span<const std::int32_t> actions) = 0;
  /// (n) 1 if the episode is over; valid until the next step().
  virtual std::span<const std::uint8_t> ended() const = 0;
};

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
  double environment_seconds = 0;  ///< of its observations and steps
};

}  // namespace enfilade::neural::seq2seq
