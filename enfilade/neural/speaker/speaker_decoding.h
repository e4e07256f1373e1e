/// \file  From paths to words: the speaker's input, its loss, and its instructions.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enfilade/neural/panoramic/panoramic_episode.h"
#include "enfilade/neural/speaker/speaker_network.h"

namespace enfilade::neural::speaker {

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

}  // namespace enfilade::neural::speaker
