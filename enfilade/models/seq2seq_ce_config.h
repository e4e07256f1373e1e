/// \file  Sizes of the continuous agent, and settings of DAgger's data collection.
#pragma once
#include <cstddef>

namespace enfilade::models {

/// Sizes of "seq2seq-ce", the sequence-to-sequence baseline of Krantz et al., "Beyond the
/// Nav-Graph: Vision-and-Language Navigation in Continuous Environments" (ECCV 2020). The defaults
/// are the published ones, as far as known (docs/neural.md).
struct Seq2SeqCeConfig {
  std::size_t word_embedding = 50;    ///< numbers per word
  std::size_t sentence = 128;         ///< of the LSTM that reads the instruction
  std::size_t picture = 256;          ///< of a picture's features after a linear layer
  std::size_t depth = 128;            ///< likewise of depth
  std::size_t action_embedding = 32;  ///< of the previous action
  std::size_t hidden = 512;           ///< of the GRU

  /// Weight of the loss where the teacher's action is another than its last one, beside 1: forward
  /// is most of all actions.
  double inflection = 3.2;
  std::size_t sets = 10;         ///< of trajectories, gathered one after another
  std::size_t set_walks = 5000;  ///< trajectories per set; all episodes, if there are fewer
  std::size_t epochs = 4;        ///< passes over all sets so far after each one.
  /// Probability of the teacher's action at each step of the second set's rollouts; its square in
  /// the third set, and so on. The first set has the teacher's rollouts.
  double teacher_share = 0.75;
};

/// \throws ArgumentError naming the field, its value and the allowed range
void validate(const Seq2SeqCeConfig& config);

/// The updates of a training: after set s the passes over s sets, in batches.
/// \pre config is valid, batch > 0
std::size_t updates_of(const Seq2SeqCeConfig& config, std::size_t batch);

}  // namespace enfilade::models
