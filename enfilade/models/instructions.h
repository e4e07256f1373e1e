/// \file  Instructions as the network reads them.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enfilade/r2r/annotations.h"
#include "enfilade/r2r/tokenizer.h"

namespace enfilade::models {

/// The words of these episodes' instructions that occur at least `least_count` times (the recipe:
/// 5; 991 entries with the specials on R2R's train).
r2r::Vocabulary training_vocabulary(const r2r::EpisodeSet& episodes, std::size_t least_count = 5);

/// The instructions of a split as rows of ids (Vocabulary::encode()). Immutable: any thread.
class EncodedInstructions {
 public:
  /// Encodes the instruction of every episode once. \param max_words further words are cut off
  EncodedInstructions(const r2r::EpisodeSet& episodes, const r2r::Vocabulary& vocabulary,
                      std::size_t max_words = 80);

  std::size_t size() const noexcept { return size_; }  ///< rows: one an episode
  std::size_t max_words() const noexcept { return max_words_; }
  /// The words' ids of an episode. \pre episode < size()
  std::span<const std::uint32_t> row(std::size_t episode) const {
    return std::span(ids_).subspan(episode * max_words_, max_words_);
  }
  /// Rows of a batch, one after another. \pre out.size() == episodes.size() * max_words()
  void gather(std::span<const std::size_t> episodes, std::span<std::uint32_t> out) const;

 private:
  std::size_t size_;
  std::size_t max_words_;
  std::vector<std::uint32_t> ids_;
};

/// What the places of an encoded row say, in reading order: the instruction's words ("<UNK>" for
/// those that the vocabulary lacks), then "<EOS>" unless it was cut off. Place k of this list is
/// place reading_order()[k] of the row.
struct ReadingOrder {
  std::vector<std::string> words;
  std::vector<std::size_t> places;
};
ReadingOrder reading_order(std::span<const std::uint32_t> row, const r2r::Vocabulary& vocabulary);

}  // namespace enfilade::models
