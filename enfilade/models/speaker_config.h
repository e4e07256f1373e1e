/// \file  The sizes of the speaker, which describes paths in words.
#pragma once
#include <cstddef>

namespace enfilade::models {

/// The sizes of EnvDrop's speaker (Tan, Yu, Bansal 2019) as its run script has them.
struct SpeakerConfig {
  std::size_t vocabulary = 992;      ///< words, `<BOS>` among them
  std::size_t word_embedding = 256;  ///< numbers per word
  std::size_t hidden = 512;          ///< of all LSTMs; even if bidirectional
  std::size_t image = 2048;          ///< of a view's picture; 0: no vision
  std::size_t angle = 128;           ///< of a direction: 4 numbers, repeated
  bool bidirectional = true;         ///< the path is read in both directions
  double dropout = 0.6;              ///< of embeddings and hidden states, in training
  double feature_dropout = 0.3;      ///< of the pictures' numbers, in training

  std::size_t feature() const noexcept { return image + angle; }  ///< numbers of a view
  friend bool operator==(const SpeakerConfig&, const SpeakerConfig&) = default;
};

/// \throws ArgumentError naming the field for a size of 0 (except `image`) or above 2^24, or a
/// dropout outside [0, 1)
/// \throws ArgumentError for an odd `hidden` with two directions, or an `angle` that is not a
/// multiple of 4
void validate(const SpeakerConfig& config);

}  // namespace enfilade::models
