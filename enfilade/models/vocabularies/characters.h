/// \file  Characters, and the words that BERT's rules make of them.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/models/subwords.h"

namespace enfilade::models::vocabularies {

/// Takes one character off the front of `text`; U+FFFD for a byte that begins none.
/// \pre text is not empty
std::uint32_t take_character(std::string_view& text);

/// The words of a text in BERT's sense: without control characters, split at blanks. Each CJK
/// character and each punctuation mark is a word of its own. Folded if `letters` requires it.
std::vector<std::u32string> words_of(std::string_view text, Letters letters);

}  // namespace enfilade::models::vocabularies
