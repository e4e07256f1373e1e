/// \file  Small functions for texts that models and users wrote.
#pragma once
#include <algorithm>
#include <cctype>
#include <string_view>

namespace enfilade::arena::detail {

/// Without blanks and line ends around it.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Whether two texts are equal, ignoring the case of ASCII letters.
inline bool is_same(std::string_view one, std::string_view other) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return std::ranges::equal(one, other, {}, lower, lower);
}

}  // namespace enfilade::arena::detail
