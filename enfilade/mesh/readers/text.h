/// \file  Text formats of meshes: lines of words and numbers, and what is wrong with them.
/// Internal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::mesh::readers {

/// A text's lines one after the other; ends `\n` and `\r\n`.
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

/// Cuts the first word off `line`; empty at its end. White space is blanks, tabs, \r, \v, \f.
std::string_view cut_word(std::string_view& line);
/// Without white space at both ends.
std::string_view trim(std::string_view text);
std::vector<std::string_view> words(std::string_view line);

/// A number that takes up the whole word; finite. "1e999", "nan" are none.
std::optional<double> to_number(std::string_view word);
std::optional<std::int64_t> to_integer(std::string_view word);

/// The start of a word for messages, its control bytes escaped.
std::string in_quotes(std::string_view word);

/// What is wrong with a file. Broken files have millions of faults: it gives up after some.
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
