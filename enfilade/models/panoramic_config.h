/// \file  The sizes of the panoramic LSTM agent.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace enfilade::models {

/// Start of the decoder. EnvDrop's own word.
enum class Subout : std::uint8_t {
  kTanh,  ///< the last hidden state of the sentence.
  /// The largest value of each number over the sentence and the zeros behind it, up to the longest
  /// of the batch (EnvDrop's run script). So an agent's actions depend on the other episodes of its
  /// batch.
  kMax,
  kOwnMax,  ///< the largest value over its own words
};
std::string_view to_string(Subout value) noexcept;  ///< "tanh", "max", "own-max"
Subout parse_subout(std::string_view name);         ///< \throws ArgumentError

/// The sizes of EnvDrop's listener (Tan, Yu, Bansal 2019) as its run script has them.
struct PanoramicConfig {
  std::size_t vocabulary = 992;       ///< words, `<BOS>` among them
  std::size_t word_embedding = 256;   ///< numbers per word
  std::size_t action_embedding = 64;  ///< numbers of the agent's own direction, embedded
  std::size_t hidden = 512;           ///< of the decoder; even if bidirectional
  std::size_t image = 2048;           ///< of a view's picture; 0: no vision
  std::size_t angle = 128;            ///< of a direction: 4 numbers, repeated
  bool bidirectional = true;          ///< the sentence is read in both directions
  Subout subout = Subout::kMax;
  double dropout = 0.5;          ///< of embeddings and hidden states, in training
  double feature_dropout = 0.3;  ///< of the pictures' numbers, in training

  std::size_t feature() const noexcept { return image + angle; }  ///< numbers of a view
  friend bool operator==(const PanoramicConfig&, const PanoramicConfig&) = default;
};

/// \throws ArgumentError naming the field for a size of 0 (except `image`) or above 2^24, or a
/// dropout outside [0, 1)
/// \throws ArgumentError for an odd `hidden` with two directions, or an `angle` that is not a
/// multiple of 4
void validate(const PanoramicConfig& config);

}  // namespace enfilade::models
