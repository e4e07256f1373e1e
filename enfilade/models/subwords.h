/// \file  Vocabularies of word pieces, read from the files that BERT and XLM-R are released with.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "enfilade/models/network_config.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::models {

/// Pieces of words and their ids, with which text becomes what BERT's and XLM-R's descendants
/// (HAMT, DUET, ...) read. Immutable: any thread. A copy shares the pieces.
class Subwords {
 public:
  /// How text becomes ids of pieces; the two kinds are such.
  class Pieces {
   public:
    virtual ~Pieces() = default;
    Pieces() = default;
    Pieces(const Pieces&) = delete;
    Pieces& operator=(const Pieces&) = delete;

    /// Appends the ids of a text, without special ones around them.
    virtual void cut(std::string_view text, std::vector<std::int32_t>& ids) const = 0;

    std::vector<std::string> names;                           ///< by id
    std::unordered_map<std::string_view, std::uint32_t> ids;  ///< of names
    std::uint32_t begin = 0, end = 0, pad = 0, unknown = 0;
    std::optional<std::uint32_t> mask;
  };

  /// BERT's `vocab.txt`: a piece a line, its id the line's number from 0; pieces inside words begin
  /// with "##". A vocabulary has [PAD], [UNK], [CLS] and [SEP]; [MASK] may be missing. CR LF, a
  /// byte-order mark and blank lines at the end are accepted.
  /// \throws FileError; InvalidInput listing empty lines, pieces that stand twice or are not UTF-8,
  /// and special ones that are missing
  static Subwords load_word_pieces(const std::filesystem::path& file,
                                   Letters letters = Letters::kFolded);
  static Subwords parse_word_pieces(std::string_view text, const std::string& origin,
                                    Letters letters = Letters::kFolded);
  /// XLM-R's `sentencepiece.bpe.model`: SentencePiece's protocol buffer with a unigram model, whose
  /// pieces begin with `<unk>`, `<s>`, `</s>`. Ids are fairseq's, as XLM-R's: `<s>` 0, `<pad>` 1,
  /// `</s>` 2, `<unk>` 3, each other piece one more than in the file, and `<mask>` last.
  /// \throws FileError; InvalidInput for other bytes, another kind of model, other first pieces, or
  /// a table of characters that points outside itself
  static Subwords load_sentence_pieces(const std::filesystem::path& file);
  static Subwords parse_sentence_pieces(std::string_view bytes, const std::string& origin);
  /// Either kind: a file whose name ends in `.model` is SentencePiece's.
  static Subwords load(const std::filesystem::path& file, Letters letters = Letters::kFolded);

  std::size_t size() const noexcept { return pieces_->names.size(); }  ///< ids are below it
  std::uint32_t begin() const noexcept { return pieces_->begin; }      ///< [CLS], `<s>`
  std::uint32_t end() const noexcept { return pieces_->end; }          ///< [SEP], `</s>`
  std::uint32_t pad() const noexcept { return pieces_->pad; }          ///< [PAD], `<pad>`
  std::uint32_t unknown() const noexcept { return pieces_->unknown; }  ///< [UNK], `<unk>`
  /// [MASK], `<mask>`
  std::optional<std::uint32_t> mask() const noexcept { return pieces_->mask; }
  std::string_view piece(std::uint32_t id) const;                   ///< \pre id < size()
  std::optional<std::uint32_t> find(std::string_view piece) const;  ///< its id

  /// A text as token ids, begin() and end() around them; nothing is cut off. Words that the pieces
  /// cannot make are unknown(). Special pieces written out in the text ("[SEP]") are text like any
  /// other. Bytes that are not UTF-8 count as U+FFFD, which WordPiece skips. Linear in the text
  /// except for the longest piece.
  ///
  /// - WordPiece: control characters go, CJK characters and punctuation are words of their own.
  ///   Other words, of at most 100 characters, give each longest piece from the left (Devlin et
  ///   al., 2019, as in their code and in Hugging Face's).
  /// - SentencePiece: characters are replaced by the file's table, and the most probable pieces
  ///   taken (Kudo, 2018).
  std::vector<std::int32_t> encode(std::string_view text) const;

 private:
  explicit Subwords(std::shared_ptr<const Pieces> pieces) : pieces_(std::move(pieces)) {}
  std::shared_ptr<const Pieces> pieces_;
};

/// Puts the ids of each instruction's text into its details' `tokens`, which files of the public
/// code have as `instr_encodings`; existing ones are replaced.
/// \throws ArgumentError for CVDN, whose token ids are those of a whole dialogue, not of a text
void encode_instructions(tasks::Annotations& annotations, const Subwords& words);

}  // namespace enfilade::models
