/// \file  Parsing of text formats: lines, words, numbers, and lists of faults.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::mesh::readers {

/// Iterates over the lines of a text; line ends are `\n` and `\r\n`.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  /// The next line; nothing at the end.
  std::optional<std::string_view> next();
  std::size_t number() const noexcept { return number_; }  ///< of the line last given, from 1
  std::string where() const;                               ///< "line 7"
  std::string_view rest() const noexcept { return rest_; }

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

/// Removes and returns the first word of `line`; empty at its end. White space: space, \t, \r, \v,
/// \f.
std::string_view cut_word(std::string_view& line);
/// The text without white space at both ends.
std::string_view trim(std::string_view text);
std::vector<std::string_view> words(std::string_view line);

/// The number that is the whole word; finite. "1e999" and "nan" are invalid.
std::optional<double> to_number(std::string_view word);
std::optional<std::int64_t> to_integer(std::string_view word);

/// The start of a word, quoted and escaped, for messages.
std::string in_quotes(std::string_view word);

/// Faults of one file, at most 100: broken files have millions.
class FaultList {
 public:
  explicit FaultList(const std::string& file) : file_(file) {}
  /// \throws InvalidInput at the 100th
  void error(std::string where, std::string code, std::string message);
  /// \throws InvalidInput if there are any
  void throw_if_any();
  bool any() const noexcept { return !found_.empty(); }

 private:
  const std::string& file_;
  std::vector<Diagnostic> found_;
};
}  // namespace enfilade::mesh::readers
