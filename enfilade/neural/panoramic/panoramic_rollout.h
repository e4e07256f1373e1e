/// \file  Walks of the panoramic agent: greedy, behind a teacher, or drawn, with the losses of
/// EnvDrop.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "enfilade/models/train_config.h"
#include "enfilade/neural/panoramic/panoramic_episode.h"
#include "enfilade/neural/panoramic/panoramic_network.h"

namespace enfilade::neural::panoramic {

/// Pads sentences for the encoder. \pre sentences by falling length, none empty
WordBatch batch_words(std::span<const std::vector<std::int64_t>> sentences);

/// How choices of models::Feedback::kSample are made.
enum class Draw : std::uint8_t {
  kRandom,     ///< by the network's probabilities
  kLikeliest,  ///< the likeliest, as in recordings
};

/// Options of a rollout.
struct PanoramicRolloutOptions {
  models::Feedback feedback = models::Feedback::kArgmax;
  std::size_t max_actions = 20;  ///< after which an episode ends where it is
  bool imitate = false;          ///< compute RolloutLosses::imitation
  bool reinforce = false;        ///< compute RolloutLosses::reinforcement
  Draw draw = Draw::kRandom;
  std::uint64_t seed = 1, stream = 0;  ///< of the draws
  double discount = 0.9;               ///< of a reward per step
  double entropy = 0.01;               ///< weight of the entropy
  double success_distance = 3;         ///< metres, strictly below: a stop is rewarded with 2
  /// Whether `images` have columns dropped already: drop_environment().
  FeaturesDropped dropped = FeaturesDropped::kByNetwork;
  /// The pictures in place of `images`, on the network's device; null: `images`, sent there at each
  /// step.
  core::ResidentViews* resident = nullptr;
};

/// One step, for an observer; valid during the call, before the agents move.
struct PanoramicStep {
  std::size_t step = 0;
  const StepInput& input;
  const StepOutput& output;
  std::span<const PanoramicEpisode> walks;
  std::span<const std::size_t> choices;  ///< (n); of ended walks meaningless
};
/// Called at each step of a rollout.
using PanoramicObserver = std::function<void(const PanoramicStep&)>;

/// Tensors of a rollout for training. Arrays are [step][row]; where `active` is 0 their values have
/// no meaning.
struct RolloutLosses {
  at::Tensor imitation;      ///< cross-entropy of the teacher's choices, summed, divided by rows
  at::Tensor reinforcement;  ///< advantage actor-critic, divided by the actions taken
  std::size_t steps = 0;
  double environment_seconds = 0;  ///< of looking, moving and teachers
  std::vector<std::vector<double>> rewards, returns, values;
  std::vector<std::vector<std::uint8_t>> active;  ///< 1: the row acted
  std::vector<double> last_values;                ///< of the states after the last step
};

/// Computes rollouts to the end or max_actions. Rewards: the sign of the fall in distance (0 for
/// none), 2 or -2 for a stop. A rollout that reaches the limit has the critic's value of its last
/// state as return.
/// \pre rows of `words` and `walks` belong together
/// \throws ArgumentError for other sizes, or a teacher or reward without goals
RolloutLosses roll_out(PanoramicNetwork& network, const WordBatch& words,
                       std::span<PanoramicEpisode> walks, const ImageSource& images,
                       const PanoramicRolloutOptions& options,
                       const PanoramicObserver& observer = {});

}  // namespace enfilade::neural::panoramic
