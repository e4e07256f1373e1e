/// \file  How a sequence-to-sequence agent is trained.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/models/network_config.h"

namespace enfilade::models {

/// What happens to an agent that chose `end` away from its goal, while others of its batch go on.
enum class AfterEnd {
  kWalksOn,  ///< as in the released code: it is still labelled and moved and adds to the loss; only
             ///< its recorded path has ended
  kStays,    ///< it neither moves nor is labelled
};
std::string_view to_string(AfterEnd value) noexcept;  ///< "walks-on", "stays"
AfterEnd parse_after_end(std::string_view name);      ///< \throws ArgumentError

/// The viewpoint that `forward` leads to.
enum class ForwardTo {
  kNearest,   ///< navigable index 1, as in the released code, even where the teacher's label means
              ///< another neighbour (18.6 % of labels), so teacher-forcing leaves the path
  kIntended,  ///< where the label is `forward`, the neighbour that it means, so the teacher stays
              ///< on the shortest path; uses the goal, so never for results
};
std::string_view to_string(ForwardTo value) noexcept;  ///< "nearest", "intended"
ForwardTo parse_forward_to(std::string_view name);     ///< \throws ArgumentError

/// Settings of a training; the defaults are the paper's for student-forcing. For teacher-forcing it
/// has 5,000 iterations.
struct TrainConfig {
  /// `vocabulary` and `features` follow from the data.
  NetworkConfig network;
  AdamConfig adam;
  Feedback feedback = Feedback::kSample;  ///< not kArgmax
  std::size_t iterations = 20'000;
  std::size_t batch_size = 100;
  std::size_t max_steps = 20;
  AfterEnd after_end = AfterEnd::kWalksOn;
  ForwardTo forward = ForwardTo::kNearest;
  std::uint64_t seed = 1;  ///< of weights, order of episodes, dropout and sampled actions
  std::vector<std::string> splits{"train"};  ///< trained on; the vocabulary is made of them too
  /// Only the paths in so many buildings are trained on, those that come first in the files: for
  /// curves of success by the number of buildings. No value: all.
  std::optional<std::size_t> buildings = {};
  std::size_t least_count = 5;  ///< occurrences of a word in the vocabulary
  /// Splits of which validation loss and greedy scores are computed every `evaluate_every`
  /// iterations (0: never) and after the last. Does not affect the weights.
  std::vector<std::string> validation{"val_seen", "val_unseen"};
  std::size_t evaluate_every = 100;
  std::size_t checkpoint_every = 100;  ///< iterations; also after the last
};

/// The paper's number of iterations: 5,000 for kTeacher, 20,000 for kSample.
std::size_t paper_iterations(Feedback feedback) noexcept;

/// The name in "--inputs": "language+vision", "language", "vision", "none".
std::string_view to_string(const Inputs& inputs) noexcept;
/// \throws ArgumentError naming the four names
Inputs parse_inputs(std::string_view name);
/// "student" or "teacher". \throws ArgumentError
Feedback parse_feedback(std::string_view name);

/// Checks everything but network.vocabulary and network.features.
/// \throws ArgumentError naming the field, its value and what is allowed
void validate(const TrainConfig& config);

/// The differences of two configs that affect the weights ("hidden: 512, not 256"). Left out are
/// iterations, validation splits and how often to evaluate and to write checkpoints.
std::vector<std::string> differences(const TrainConfig& there, const TrainConfig& here);

}  // namespace enfilade::models
