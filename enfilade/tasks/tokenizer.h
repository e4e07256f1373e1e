/// \file  The released tokenizers and vocabularies of R2R and VLN-CE.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace enfilade::tasks {

struct InstructionVocabulary;

/// Splits on runs of characters that are not letters, digits or _, keeps the pieces, strips and
/// lower-cases them. A piece of only ASCII punctuation becomes one token per character, except a
/// run of full stops, which stays one. Bytes above 127 count as letters and are not changed.
/// Source: the rules of the released R2R code, stated in docs/tasks.md.
std::vector<std::string> tokenize(std::string_view text);

/// Words and their ids. Immutable: any thread.
class Vocabulary {
 public:
  static constexpr std::uint32_t kPad = 0;      ///< `<PAD>`
  static constexpr std::uint32_t kUnknown = 1;  ///< `<UNK>`
  static constexpr std::uint32_t kEnd = 2;      ///< `<EOS>`

  /// The three specials, then each word that occurs at least `least_count` times, by falling count,
  /// ties in alphabetical order.
  static Vocabulary build(std::span<const std::string> texts, std::size_t least_count = 5);
  /// One word a line; the first three must be the specials. Line ends of any system, a byte-order
  /// mark and blank lines at the end are accepted. \throws FileError, InvalidInput
  static Vocabulary load(const std::filesystem::path& file);
  /// Vocabulary of words(), by id: the first three must be the specials.
  /// \param origin  names them in errors
  /// \throws InvalidInput
  static Vocabulary of(std::vector<std::string> words, const std::string& origin = "<words>");
  void save(const std::filesystem::path& file) const;  ///< \throws FileError

  std::size_t size() const noexcept { return words_.size(); }
  const std::vector<std::string>& words() const noexcept { return words_; }
  std::uint32_t id(std::string_view word) const;  ///< kUnknown if it has none

  /// Ids for the sequence-to-sequence recipe: tokens *reversed*, kEnd, then kPad, cut to `length`
  /// (so a long instruction loses its beginning and kEnd).
  std::vector<std::uint32_t> encode(std::string_view text, std::size_t length = 80) const;
  /// Back to words in reading order, without specials except `<UNK>`. Ids without a word become
  /// `<UNK>`.
  std::string decode(std::span<const std::uint32_t> ids) const;

 private:
  explicit Vocabulary(std::vector<std::string> words);
  std::vector<std::string> words_;
  std::unordered_map<std::string, std::uint32_t> ids_;
};

/// The words of a text by the rule of Habitat's loader: lower case; a blank before each "'s";
/// commas and question marks removed. The text is split on runs of characters that are not letters,
/// digits, _ or -; those runs are kept, without the blanks around them. Bytes above 127 count as
/// letters and are not changed.
std::vector<std::string> tokenize_continuous(std::string_view text);

/// Ids of words by a file's vocabulary. Immutable: any thread.
class InstructionEncoder {
 public:
  /// Tokens of an instruction in R2R-CE's files.
  static constexpr std::size_t kLength = 200;

  /// \throws ArgumentError if the vocabulary has no words, or one twice, or if its unknown or
  /// padding token (default: 1 and 0) is beyond the range of a token
  explicit InstructionEncoder(const InstructionVocabulary& vocabulary);

  /// The ids of a text's words, in their order, padded and cut to `length`.
  std::vector<std::int32_t> encode(std::string_view text, std::size_t length = kLength) const;

 private:
  std::unordered_map<std::string, std::int32_t> ids_;
  std::int32_t unknown_ = 1, padding_ = 0;
};

}  // namespace enfilade::tasks
