/// \file  Sizes and optimiser settings of the sequence-to-sequence network.
#pragma once
#include <cstddef>
#include <string_view>

namespace enfilade::models {

/// Inputs of the agent. The weights have the same shapes in any case; unused ones only decay.
struct Inputs {
  bool language = true;  ///< off: every instruction is just `<EOS>`
  bool vision = true;    ///< off: features are zero and not read
};

/// Sizes of the network; the defaults are the paper's.
struct NetworkConfig {
  std::size_t vocabulary = 0;  ///< words, the three special ones included
  std::size_t max_words = 80;
  std::size_t word_embedding = 256;
  std::size_t hidden = 512;
  std::size_t action_embedding = 32;
  std::size_t features = 2048;  ///< may be 0 with vision off
  double dropout = 0.5;         ///< [0, 1)
  Inputs inputs;
};
/// \throws ArgumentError naming the field, its value and the allowed range
void validate(const NetworkConfig& config);

/// Adam with L2 regularisation, as in the released code: the same for encoder and decoder.
struct AdamConfig {
  double learning_rate = 1e-4;
  double beta1 = 0.9;
  double beta2 = 0.999;
  double epsilon = 1e-8;
  double weight_decay = 5e-4;  ///< added to the gradient, times the weight
};

/// The source of the next action in a rollout.
enum class Feedback {
  kTeacher,  ///< the label
  kSample,   ///< drawn from the softmax: student-forcing
  kArgmax,   ///< the likeliest
};
std::string_view to_string(Feedback feedback) noexcept;  ///< "teacher", "sample", "argmax"

}  // namespace enfilade::models
