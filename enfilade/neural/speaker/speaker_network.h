/// \file  The speaker of EnvDrop (Tan, Yu, Bansal 2019): a network that describes a path in words.
/// Its input, loss and instructions; a whole split, environmental dropout, BLEU-4.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/agents/panorama.h"
#include "enfilade/core/progress.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/network_config.h"
#include "enfilade/models/train_config.h"
#include "enfilade/models/training_log.h"
#include "enfilade/neural/core/lstm_parts.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/panoramic/panoramic_episode.h"
#include "enfilade/neural/panoramic/panoramic_network.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::neural::speaker {

using models::SpeakerConfig;
using panoramic::FeaturesDropped;

/// The arrays of the speaker's encoder and decoder, by the names of the published code.
std::vector<core::ArraySpec> array_specs(const SpeakerConfig& config);

/// Paths as the encoder reads them. A step is a viewpoint and the choice that is made there; the
/// last choice is to stop.
struct PathBatch {
  at::Tensor actions;  ///< (n, longest, feature) the candidates that are chosen; zeros for stop
  at::Tensor views;    ///< (n, longest, 36, feature); behind a path's end nothing is read
  std::vector<std::int64_t> lengths;  ///< (n) steps, stop among them, from 1 to longest
  FeaturesDropped dropped = FeaturesDropped::kByNetwork;
};

/// Output of the encoder.
struct PathEncoding {
  at::Tensor context;  ///< (n, longest, hidden); zeros behind a path's end
  at::Tensor mask;     ///< (n, longest) bool: true behind a path's end
};

/// The decoder's memory.
struct SpeakerState {
  at::Tensor hidden, cell;  ///< (n, hidden)
};

/// Parameters, and the functions of the network.
///
/// Nothing is read after the end of a path. The published code pads to the longest path of the
/// batch and lets its backward LSTM begin there, so its results depend on the batch. With paths of
/// one length, or one at a time, both are the same.
class SpeakerNetwork : public core::LstmNetwork {
 public:
  /// Random weights as PyTorch's modules begin with, from a seed. \throws ArgumentError as
  /// validate()
  SpeakerNetwork(const SpeakerConfig& config, std::uint64_t seed, c10::Device device = c10::kCPU);
  /// Those of a file: `.npz` or safetensors with the published names, or EnvDrop's checkpoint.
  /// `decoder.baseline_projection`, which the published code has and does not use here, is ignored.
  /// \throws InvalidInput naming every array that is missing, surplus or of another shape
  SpeakerNetwork(const SpeakerConfig& config, const features::TensorFile& file,
                 c10::Device device = c10::kCPU);

  const SpeakerConfig& config() const noexcept { return config_; }

  /// \throws ArgumentError for sizes that do not fit each other or the configuration
  PathEncoding encode(const PathBatch& paths);
  /// The state before the first word: zeros.
  SpeakerState begin(std::int64_t n) const;
  /// Reads words one after another, from `state`, which becomes that after the last of them.
  /// \param words (n, length) int64, at least one; what stands behind an `<EOS>` changes nothing
  ///     before it
  /// \return (n, length, vocabulary): logits of each word's successor
  /// \throws ArgumentError for ids beyond the vocabulary, or other rows than the encoding's
  at::Tensor decode(const PathEncoding& encoding, const at::Tensor& words, SpeakerState& state);

 private:
  at::Tensor drop_images(const at::Tensor& features, FeaturesDropped dropped);
  at::Tensor read_steps(const at::Tensor& x, const PathBatch& paths, const std::string& name);

  SpeakerConfig config_;
};

using panoramic::ImageSource;

/// A path to be described: neighbours, one after another.
struct PathToDescribe {
  ScanIndex scan;
  Radians heading;                         ///< at the start, rounded to the nearest of the 12
  std::vector<ViewpointIndex> viewpoints;  ///< at least one; the last is the goal
};

/// The views along paths: the 36 views at each viewpoint and its chosen candidate, from the
/// listener's direction on that path (headings relative to its view). Zeros after the end of each.
/// \param graphs those of `panoramas`
/// \throws ArgumentError for no paths, one without viewpoints, or a step without an edge, naming
/// the path by its index
PathBatch see_paths(std::span<const PathToDescribe> paths, const SpeakerConfig& config,
                    const ImageSource& images, agents::PanoramaCache& panoramas,
                    const graph::GraphSet& graphs);

/// Sentences as rows of one length: (n, longest) int64, 0 behind their ends.
/// \throws ArgumentError for no sentences, or one with less than two words
at::Tensor pad_sentences(std::span<const std::vector<std::int64_t>> sentences);

/// How well the speaker predicts instructions, each word after the true ones before it.
struct InstructionLoss {
  at::Tensor mean;          ///< cross-entropy a word of the batch, natural logarithm; a scalar
  double sum = 0;           ///< over all words
  std::size_t words = 0;    ///< that were predicted: all but `<BOS>`
  std::size_t correct = 0;  ///< of these, predictions that are the most likely word
};
/// \param sentences (n, length) of ids from `<BOS>` to `<EOS>`, then 0: pad_sentences()
/// \throws as encode() and decode(); ArgumentError without words to predict
InstructionLoss instruction_loss(SpeakerNetwork& network, const PathBatch& paths,
                                 const at::Tensor& sentences);

/// How words are chosen.
enum class WordChoice : std::uint8_t {
  kLikeliest,  ///< the most probable, the first of equals
  kDrawn,      ///< by their probabilities
};

/// Options of describe().
struct DescribeOptions {
  std::int64_t begin = 991;  ///< the id of `<BOS>`
  WordChoice choice = WordChoice::kLikeliest;
  std::size_t most_words = 120;             ///< after which a sentence ends as it is
  std::uint64_t seed = 1;                   ///< of draws
  std::vector<std::uint64_t> streams = {};  ///< of draws, one per path; empty: 0, 1, ...
};

/// Instructions, one per path: ids without `<BOS>` and `<EOS>`. Unknown words, padding and `<BOS>`
/// are never chosen. Without gradients. The same batch, weights and options give the same words.
/// \throws as encode(); ArgumentError for streams of another number, or `begin` beyond the
/// vocabulary
std::vector<std::vector<std::int64_t>> describe(SpeakerNetwork& network, const PathBatch& paths,
                                                const DescribeOptions& options);

/// Words as a text with blanks between them, but none between marks, nor before a full stop or
/// comma. The text gives the same words again in tasks::tokenize(), unless full stops follow one
/// another.
std::string join_words(std::span<const std::string> words);

/// Rate and random numbers of the dropout.
struct EnvironmentalDropoutOptions {
  double rate = 0.3;  ///< share of columns that become 0, [0, 1); the others are scaled up
  std::uint64_t seed = 1, stream = 0;  ///< of the columns: another stream, another environment
};

/// The factors of the columns: 0, or 1 / (1 - rate). The same options give the same ones.
/// \throws ArgumentError for a rate outside [0, 1)
std::vector<float> column_factors(const EnvironmentalDropoutOptions& options, std::size_t columns);

/// Pictures with columns missing, the same for all views and viewpoints of a batch, as published,
/// so also for candidates. For networks that then drop no numbers of their own: a speaker's
/// FeaturesDropped::kBefore, a listener's StepInput::dropped. Keeps `images`, and the factors after
/// their first use. One thread at a time.
/// \throws ArgumentError for a rate outside [0, 1)
ImageSource drop_environment(ImageSource images, const EnvironmentalDropoutOptions& options);

/// A generated text, and those that people wrote for the same.
struct Generated {
  std::vector<std::string> words;                    ///< of the text
  std::vector<std::vector<std::string>> references;  ///< at least one
};

/// BLEU-4 of a whole corpus, 0 to 1. It is the geometric mean of the shares of generated n-grams, 1
/// to 4, that a reference has (clipped counts), times the brevity penalty. As in EnvDrop's scoring
/// of its speaker, a reference's length is that of the shortest. Nothing is smoothed: 0 if some
/// order has no match. Source: Papineni, Roukos, Ward, Zhu 2002, section 2.
double bleu_4(std::span<const Generated> corpus);

/// Paths with their instructions as ids, and the features of their buildings. One thread at a time.
class SpeakerSplit {
 public:
  /// `episodes` and `words` have to outlive *this. \param features null without vision
  /// \throws as ViewFeatures; ArgumentError for episodes whose goals are hidden
  SpeakerSplit(const tasks::EpisodeSet& episodes, const models::InstructionWords& words,
               const models::TrainConfig& config, const features::FeatureSet* features);
  SpeakerSplit(const SpeakerSplit&) = delete;
  SpeakerSplit& operator=(const SpeakerSplit&) = delete;

  const tasks::EpisodeSet& episodes() const noexcept { return episodes_; }
  const models::InstructionWords& words() const noexcept { return words_; }
  /// The views along paths. \param paths indices into EpisodeSet::paths
  /// \param environment columns that are missing everywhere; no value: none is missing
  PathBatch see(std::span<const std::size_t> paths,
                const std::optional<EnvironmentalDropoutOptions>& environment = std::nullopt);
  /// The paths of episodes, and their instructions for instruction_loss().
  std::vector<std::size_t> paths_of(std::span<const std::size_t> episodes) const;
  at::Tensor sentences(std::span<const std::size_t> episodes) const;  ///< likewise

 private:
  const tasks::EpisodeSet& episodes_;
  const models::InstructionWords& words_;
  SpeakerConfig sizes_;
  std::vector<std::vector<std::int64_t>> ids_;  // by episode
  std::optional<core::ViewFeatures> features_;
  ImageSource images_;
  agents::PanoramaCache panoramas_;
};

/// How paths are described.
struct DescribeSplitOptions {
  std::size_t batch_size = 64;
  WordChoice choice = WordChoice::kLikeliest;
  std::size_t most_words = 120;  ///< per instruction
  std::uint64_t seed = 1;        ///< of draws, whose stream is a path's index
  /// Columns that are missing; `stream` is that of the batch.
  std::optional<EnvironmentalDropoutOptions> environment = {};
  Ranks* ranks = nullptr;  ///< as SplitRollout::ranks
};

/// An instruction a path of the split, in their order, as words. Without dropout but that of the
/// environment.
std::vector<std::vector<std::string>> describe_split(SpeakerNetwork& network, SpeakerSplit& split,
                                                     const DescribeSplitOptions& options,
                                                     const Progress& progress = {});

/// Describes all paths of a split, each word the likeliest, and predicts the words of all its
/// instructions. The iteration is left to the caller. Paths without an instruction do not count.
/// \param ranks as SplitRollout::ranks
/// \throws ArgumentError for a split without instructions
models::SpeakerRecord score_speaker(SpeakerNetwork& network, SpeakerSplit& split,
                                    std::size_t batch_size, Ranks* ranks = nullptr,
                                    const Progress& progress = {});

}  // namespace enfilade::neural::speaker
