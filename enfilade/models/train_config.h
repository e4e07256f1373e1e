/// \file  How a sequence-to-sequence agent is trained.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/models/network_config.h"

namespace enfilade::models {

/// What an agent that said `end` away from its goal goes through while others of its batch walk.
enum class AfterEnd {
  kWalksOn,  ///< as in the released code: it is labelled and moved like the others, and adds loss;
             ///< only its recorded path has ended
  kStays,    ///< neither moves nor is labelled
};
std::string_view to_string(AfterEnd value) noexcept;  ///< "walks-on", "stays"
AfterEnd parse_after_end(std::string_view name);      ///< \throws ArgumentError

/// Where `forward` leads.
enum class ForwardTo {
  kNearest,   ///< to navigable index 1, as in the released code, also where the teacher's label
              ///< means another neighbour (18.6 % of them), so that teacher-forcing strays
  kIntended,  ///< where the label is `forward`, to the neighbour that it means, so that the teacher
              ///< keeps to the shortest path; looks at the goal, so never for results
};
std::string_view to_string(ForwardTo value) noexcept;  ///< "nearest", "intended"
ForwardTo parse_forward_to(std::string_view name);     ///< \throws ArgumentError

/// The paper's, with student-forcing. Teacher-forcing takes 5,000 iterations there.
struct TrainConfig {
  /// `vocabulary` and `features` are found from the data.
  NetworkConfig network;
  AdamConfig adam;
  Feedback feedback = Feedback::kSample;  ///< not kArgmax
  std::size_t iterations = 20'000;
  std::size_t batch_size = 100;
  std::size_t max_steps = 20;
  AfterEnd after_end = AfterEnd::kWalksOn;
  ForwardTo forward = ForwardTo::kNearest;
  std::uint64_t seed = 1;  ///< of weights, order of episodes, dropout and drawn actions
  std::vector<std::string> splits{"train"};  ///< trained on, and the vocabulary's
  std::size_t least_count = 5;               ///< of a word of the vocabulary
  /// Of them, validation loss and greedy scores every `evaluate_every` iterations (0: never) and
  /// after the last. Changes no weight.
  std::vector<std::string> validation{"val_seen", "val_unseen"};
  std::size_t evaluate_every = 100;
  std::size_t checkpoint_every = 100;  ///< iterations; also after the last
};

/// The paper's number of iterations: 5,000 for kTeacher, 20,000 for kSample.
std::size_t paper_iterations(Feedback feedback) noexcept;

/// What an agent may use, as in "--inputs": "language+vision", "language", "vision", "none".
std::string_view to_string(const Inputs& inputs) noexcept;
/// \throws ArgumentError naming the four
Inputs parse_inputs(std::string_view name);
/// "student" or "teacher". \throws ArgumentError
Feedback parse_feedback(std::string_view name);

/// Of everything but network.vocabulary and network.features.
/// \throws ArgumentError naming the field, its value and what is allowed
void validate(const TrainConfig& config);

/// How two configs differ in what weights depend on ("hidden: 512, not 256"), which leaves out
/// iterations, validation and how often to evaluate and to write checkpoints.
std::vector<std::string> differences(const TrainConfig& there, const TrainConfig& here);

}  // namespace enfilade::models
