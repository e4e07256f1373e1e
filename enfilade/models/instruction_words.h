/// \file  Instructions as ids: for agents that choose among viewpoints, first word first, and rows
/// of a training's vocabulary for seq2seq.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "enfilade/models/subwords.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::models {

/// The words of the training instructions (then `<BOS>` and `<MASK>` have the two ids after them),
/// or the pieces of a released vocabulary. Immutable: any thread.
class InstructionWords {
 public:
  /// The words of the training instructions.
  explicit InstructionWords(tasks::Vocabulary words);
  /// Pieces of a released vocabulary.
  explicit InstructionWords(Subwords pieces);

  std::size_t size() const noexcept { return size_; }     ///< ids are below it
  std::int64_t begin() const noexcept { return begin_; }  ///< `<BOS>`, [CLS], `<s>`
  std::int64_t end() const noexcept { return end_; }      ///< `<EOS>`, [SEP], `</s>`
  std::int64_t pad() const noexcept { return pad_; }      ///< `<PAD>`, [PAD], `<pad>`
  /// `<MASK>`, [MASK], `<mask>`
  std::optional<std::int64_t> mask() const noexcept { return mask_; }
  std::string word(std::int64_t id) const;  ///< for display. \pre id < size()
  /// Null if these are pieces.
  const tasks::Vocabulary* vocabulary() const { return std::get_if<tasks::Vocabulary>(&words_); }

  /// begin(), the words, end(). With more than `most` ids the last kept one becomes end().
  /// \pre most >= 2
  std::vector<std::int64_t> encode(std::string_view text, std::size_t most) const;
  /// An episode's instruction. Uses the first `most` of its annotation's `tokens` if these are ids
  /// of these pieces: from begin() to end(), all below size(). The released agents do so, too.
  /// Otherwise encodes its text.
  /// \pre most >= 2
  std::vector<std::int64_t> encode(const tasks::Episode& episode, std::size_t most) const;
  /// The same of all episodes, in their order. \param reads whether the agent uses language: else
  /// every instruction is begin() and end() alone. \pre most >= 2
  std::vector<std::vector<std::int64_t>> encode(const tasks::EpisodeSet& episodes, std::size_t most,
                                                bool reads) const;

 private:
  std::size_t size_;
  std::int64_t begin_, end_, pad_;
  std::optional<std::int64_t> mask_;
  std::variant<tasks::Vocabulary, Subwords> words_;
};

// --- seq2seq ---

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
