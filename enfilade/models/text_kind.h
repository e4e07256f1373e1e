/// \file  Whose words an agent reads.
#pragma once
#include <cstdint>
#include <string_view>

namespace enfilade::models {

/// Tokens of an instruction.
enum class TextKind : std::uint8_t {
  kWords,           ///< the words of the training instructions
  kWordPieces,      ///< pieces of BERT's vocabulary
  kSentencePieces,  ///< pieces of XLM-R's vocabulary
};
std::string_view to_string(TextKind value) noexcept;  ///< "words", "word-pieces", "sentence-pieces"
TextKind parse_text_kind(std::string_view name);      ///< \throws ArgumentError

/// Whether text is read as it is written, or without its capitals and accents: released BERT models
/// come as "cased" and "uncased".
enum class Letters : std::uint8_t {
  kAsWritten,  ///< cased
  kFolded,     ///< uncased: lower case, accents stripped
};
std::string_view to_string(Letters value) noexcept;  ///< "cased", "uncased"
Letters parse_letters(std::string_view name);        ///< \throws ArgumentError

}  // namespace enfilade::models
