/// \file  UTF-8 characters.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace enfilade {

/// What editors write before a text to mark it as UTF-8: U+FEFF.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
/// The text behind a byte-order mark at its beginning; the whole text if there is none.
constexpr std::string_view without_byte_order_mark(std::string_view text) noexcept {
  return text.substr(text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
}

/// Length in bytes of the first character of `text`, 1 to 4. 0 if the text is empty or does not
/// begin with a well-formed character; overlong forms, surrogates and values above U+10FFFF are not
/// well-formed (Unicode 15, table 3-7).
std::size_t utf8_length(std::string_view text);

/// The longest prefix of a text, at most `most` bytes, that does not end within a character.
/// \pre the text is well-formed; otherwise the prefix may be a few bytes shorter
std::string_view utf8_prefix(std::string_view text, std::size_t most);

/// Appends the character of a code point to a text. \pre code is at most 0x10ffff, and no surrogate
void append_utf8(std::uint32_t code, std::string& text);

}  // namespace enfilade
