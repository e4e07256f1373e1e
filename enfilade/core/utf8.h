/// \file  Characters of UTF-8.
#pragma once
#include <cstddef>
#include <string_view>

namespace enfilade {

/// Bytes of the character that `text` begins with, 1 to 4; 0 if it is empty or begins with none
/// that is well-formed: no overlong form, no surrogate, nothing above U+10FFFF (Unicode 15, table
/// 3-7).
std::size_t utf8_length(std::string_view text);

}  // namespace enfilade
