/// \file  Instructions as rows of word ids, and the vocabulary of a training.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::models {

/// The words that occur at least `least_count` times in the instructions of these episodes. Default
/// 5 as in the released code: 991 entries with the special ones for R2R's train.
tasks::Vocabulary training_vocabulary(const tasks::EpisodeSet& episodes,
                                      std::size_t least_count = 5);

/// The instructions of a split as rows of ids (Vocabulary::encode()). Immutable: any thread may
/// read.
class EncodedInstructions {
 public:
  /// Encodes the instructions of all episodes; longer ones are cut to max_words.
  EncodedInstructions(const tasks::EpisodeSet& episodes, const tasks::Vocabulary& vocabulary,
                      std::size_t max_words = 80);

  std::size_t size() const noexcept { return size_; }  ///< rows: one per episode
  std::size_t max_words() const noexcept { return max_words_; }
  /// The ids of one episode, (max_words). \pre episode < size()
  std::span<const std::uint32_t> row(std::size_t episode) const {
    return std::span(ids_).subspan(episode * max_words_, max_words_);
  }
  /// Copies the rows of a batch, one after another. \pre out.size() == episodes.size() *
  /// max_words()
  void gather(std::span<const std::size_t> episodes, std::span<std::uint32_t> out) const;

 private:
  std::size_t size_;
  std::size_t max_words_;
  std::vector<std::uint32_t> ids_;
};

/// The number of words of an encoded row, "<EOS>" counted: the index of the first "<PAD>", or all.
std::size_t word_count(std::span<const std::uint32_t> row);

/// The words of an encoded row in reading order ("<UNK>" for those not in the vocabulary), then
/// "<EOS>" unless it was cut off. Word k is words[k], at places[k] of the row.
struct ReadingOrder {
  std::vector<std::string> words;
  std::vector<std::size_t> places;
};
/// Decodes a row. \pre each of its ids is in the vocabulary
ReadingOrder reading_order(std::span<const std::uint32_t> row, const tasks::Vocabulary& vocabulary);

}  // namespace enfilade::models
