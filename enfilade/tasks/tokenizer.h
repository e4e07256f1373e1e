/// \file  R2R's released tokenizer and vocabulary.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace enfilade::tasks {

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
  /// One word a line; the first three must be the specials. \throws FileError, InvalidInput
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

}  // namespace enfilade::tasks
