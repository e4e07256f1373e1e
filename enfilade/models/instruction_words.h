/// \file  How agents that choose among viewpoints read an instruction: as ids, first word first.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
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

  std::size_t size() const noexcept;         ///< ids are below it
  std::int64_t begin() const noexcept;       ///< `<BOS>`, [CLS], `<s>`
  std::int64_t end() const noexcept;         ///< `<EOS>`, [SEP], `</s>`
  std::int64_t pad() const noexcept;         ///< `<PAD>`, [PAD], `<pad>`
  std::optional<std::int64_t> mask() const;  ///< `<MASK>`, [MASK], `<mask>`
  std::string word(std::int64_t id) const;   ///< for display. \pre id < size()
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
  std::variant<tasks::Vocabulary, Subwords> words_;
};

}  // namespace enfilade::models
