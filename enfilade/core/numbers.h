/// \file  Numbers in text.
#pragma once
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace enfilade {

/// The number that is all of `text`, as std::from_chars reads it: integers in base 10;
/// floating-point numbers also with an exponent, and "inf" and "nan", with or without a sign.
/// Nothing for any other text: empty, with white space or a leading '+', out of T's range (also a
/// minus sign where T is unsigned).
template <class T>
std::optional<T> parse_number(std::string_view text) {
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (code != std::errc() || stop != end) return std::nullopt;
  return value;
}

}  // namespace enfilade
