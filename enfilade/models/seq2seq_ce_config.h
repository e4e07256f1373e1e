/// \file  The sizes of the agent that walks freely, and how DAgger gathers what it learns from.
#pragma once
#include <cstddef>

namespace enfilade::models {

/// Of "seq2seq-ce": Krantz et al., "Beyond the Nav-Graph: Vision-and-Language Navigation in
/// Continuous Environments" (ECCV 2020), the sequence-to-sequence baseline. The defaults are the
/// published ones, as far as we know them (docs/neural.md).
struct Seq2SeqCeConfig {
  std::size_t word_embedding = 50;    ///< numbers a word
  std::size_t sentence = 128;         ///< of the LSTM that reads the instruction
  std::size_t picture = 256;          ///< of what a linear layer makes of a picture's features
  std::size_t depth = 128;            ///< likewise of depth
  std::size_t action_embedding = 32;  ///< of the action before
  std::size_t hidden = 512;           ///< of the GRU

  /// Weight of the loss where the teacher's action is another than its last one, beside 1: forward
  /// is most of all actions.
  double inflection = 3.2;
  std::size_t sets = 10;         ///< of walks, gathered one after another
  std::size_t set_walks = 5000;  ///< walks in a set; all episodes, if there are fewer
  std::size_t epochs = 4;        ///< passes over all sets so far after each one
  /// Probability of the teacher's action at each step of the second set's walks; its square in the
  /// third set, and so on. The first set has the teacher's walks.
  double teacher_share = 0.75;
};

/// \throws ArgumentError naming the field, its value and what is allowed
void validate(const Seq2SeqCeConfig& config);

/// The updates of a training: after set s the passes over s sets, in batches.
/// \pre config is valid, batch > 0
std::size_t updates_of(const Seq2SeqCeConfig& config, std::size_t batch);

}  // namespace enfilade::models
