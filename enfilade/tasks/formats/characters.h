/// \file  Classes of characters of Python's re and str, in ASCII, whatever the C library's locale.
/// Internal.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::tasks::formats {

/// A letter, a digit or _. Bytes above 127 count as letters.
constexpr bool is_word(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte > 127 || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
         c == '_';
}

constexpr bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r') || (c >= 28 && c <= 31);
}

/// Without the blanks at both ends.
constexpr std::string_view strip(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// With lower-case letters; bytes above 127 are left as they are.
inline std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

}  // namespace enfilade::tasks::formats
