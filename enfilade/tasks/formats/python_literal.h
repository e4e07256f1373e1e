/// \file  Lists as Python writes them: fine-grained R2R has them as texts within its JSON.
/// Internal.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::tasks::formats {

/// By instruction, by piece of the instruction, by word.
using WordLists = std::vector<std::vector<std::vector<std::string>>>;

/// Why a literal cannot be read.
struct LiteralFault {
  std::size_t byte = 0;  ///< from 0
  std::string message;   ///< the text found there, and the expected one
};

/// Reads a list of lists of lists of strings. Strings are in single or double quotes, with the
/// escapes of Python's repr(): \\ \' \" \n \r \t \xNN \uNNNN \UNNNNNNNN. As in Python, a comma may
/// follow the last element, and white space may separate any two signs. Other escapes, prefixes and
/// strings side by side are refused. Linear time.
/// \param text  UTF-8
/// \return the first fault; no value: `lists` has the result
std::optional<LiteralFault> read_word_lists(std::string_view text, WordLists& lists);

/// As repr() writes it, but that characters beyond ASCII stand as they are. read_word_lists() reads
/// it back equal.
std::string write_word_lists(const WordLists& lists);

}  // namespace enfilade::tasks::formats
