/// \file  For tests: the English vocabulary of the reader of instructions.
#pragma once
#include <map>
#include <string>
#include <vector>

namespace enfilade::homes::instructions::testing {

using Words = std::vector<std::string>;

/// In small letters.
std::string lower(std::string text);
/// Lower-case words and punctuation.
Words split_words(const std::string& text);
/// Other names for an object, or a room, in a home's lists.
const std::map<std::string, Words>& other_words();
const std::map<std::string, Words>& other_rooms();
/// The words for a colour that other words stand for.
const std::map<std::string, Words>& other_colours();
/// Whether a word of a clause has no meaning of its own.
bool is_function_word(const std::string& word);
/// Whether a noun phrase stands for neither a place nor an object.
bool is_plain_phrase(const std::string& phrase);

}  // namespace enfilade::homes::instructions::testing
