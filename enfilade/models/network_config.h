/// \file  Sizes of all networks, what they read, and settings of their optimisers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "enfilade/core/enum_names.h"

namespace enfilade::models {

// --- names of values, in config.json, options and messages ---

/// The name of a value.
template <NamedEnum Enum>
constexpr std::string_view to_string(Enum value) noexcept {
  return enum_name(value);
}

/// \throws ArgumentError listing the allowed names
[[noreturn]] void refuse_name(std::string_view what, std::string_view name,
                              std::span<const std::string_view> allowed);

/// The value of that name. \param what for the message: "sampled loss" \throws as refuse_name()
template <NamedEnum Enum>
Enum parse_name(std::string_view what, std::string_view name) {
  const auto found = find_enum<Enum>(name);
  if (!found) refuse_name(what, name, names_of(Enum{}));
  return *found;
}

// --- texts ---

/// Tokens of an instruction.
enum class TextKind : std::uint8_t {
  kWords,           ///< the words of the training instructions
  kWordPieces,      ///< pieces of BERT's vocabulary
  kSentencePieces,  ///< pieces of XLM-R's vocabulary
};
constexpr std::array<std::string_view, 3> names_of(TextKind /*enum*/) {
  return {"words", "word-pieces", "sentence-pieces"};
}

/// Whether text is read as it is written, or without its capitals and accents: released BERT models
/// come as "cased" and "uncased".
enum class Letters : std::uint8_t {
  kAsWritten,  ///< cased
  kFolded,     ///< uncased: lower case, accents stripped
};
constexpr std::array<std::string_view, 2> names_of(Letters /*enum*/) {
  return {"cased", "uncased"};
}

// --- seq2seq ---

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
constexpr std::array<std::string_view, 3> names_of(Feedback /*enum*/) {
  return {"teacher", "sample", "argmax"};
}

// --- EnvDrop: the panoramic LSTM agent, and the speaker, which describes paths in words ---

/// Start of the decoder. EnvDrop's own word.
enum class Subout : std::uint8_t {
  kTanh,  ///< the last hidden state of the sentence.
  /// The largest value of each number over the sentence and the zeros behind it, up to the longest
  /// of the batch (EnvDrop's run script). So an agent's actions depend on the other episodes of its
  /// batch.
  kMax,
  kOwnMax,  ///< the largest value over its own words
};
constexpr std::array<std::string_view, 3> names_of(Subout /*enum*/) {
  return {"tanh", "max", "own-max"};
}

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

void validate(const SpeakerConfig& config);  ///< likewise

// --- DUET ---

/// How the scores of the map and of the viewpoint become one.
enum class Fusion : std::uint8_t {
  kDynamic,  ///< a weight that the network computes
  kAverage,  ///< one half each
};
constexpr std::array<std::string_view, 2> names_of(Fusion /*enum*/) {
  return {"dynamic", "average"};
}

/// Sizes of the network of Chen et al., "Think Global, Act Local: Dual-scale Graph Transformer for
/// Vision-and-Language Navigation" (CVPR 2022). The defaults are the published ones for R2R.
struct DuetConfig {
  std::int64_t hidden = 768;
  std::int64_t heads = 12;                    ///< of each attention; divides `hidden`
  std::int64_t feed_forward = 3072;           ///< inner size of a layer's two linear maps
  std::int64_t panorama_feed_forward = 3072;  ///< likewise, of the panorama's layers
  std::int64_t text_layers = 9;
  std::int64_t panorama_layers = 2;
  std::int64_t cross_layers = 4;  ///< of each of the two branches
  std::int64_t vocabulary = 30522;
  std::int64_t positions = 512;  ///< of words
  std::int64_t token_types = 2;
  std::int64_t steps = 100;  ///< rows of the table of step numbers
  std::int64_t image = 768;  ///< columns of a view's features
  std::int64_t object = 0;   ///< columns of an object's features; 0: no objects
  Fusion fusion = Fusion::kDynamic;
  bool map_distances = true;      ///< the map's distances bias the attention among its nodes
  std::int64_t max_words = 200;   ///< per instruction, those at both ends included
  std::int64_t max_actions = 15;  ///< per episode; the last one always stops.
  /// A trajectory ends where the agent has stopped by itself, and not where stopping was most
  /// probable.
  bool stays_where_it_stops = false;
  double dropout = 0.1;          ///< within the network, in training
  double feature_dropout = 0.4;  ///< of image and object features, in training

  /// The object features have linear maps of their own.
  bool own_object_map() const noexcept { return object != 0 && object != image; }
};

/// "duet" (as published) or "duet-s" (a small one for two CPU cores).
/// \throws ArgumentError for another name, naming those that there are
DuetConfig duet_preset(std::string_view name);

/// \throws ArgumentError naming the first impossible size, and the possible ones
void validate(const DuetConfig& config);

// --- the continuous agent ---

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
