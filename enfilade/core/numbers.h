/// \file  Numbers in text, and limits of numbers in files.
#pragma once
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace enfilade {

/// Limits of angles and positions in files. Real ones are some turns and some hundred metres;
/// beyond these limits single precision has no centimetres, and sums may overflow.
inline constexpr double kMostRadians = 1e4;
inline constexpr double kMostMetres = 1e6;

/// The number that is all of `text`, as std::from_chars reads it: integers in base 10.
/// Floating-point numbers may have an exponent or be "inf" or "nan", with or without a sign. No
/// value for any other text: empty, with white space or a leading '+', or out of T's range. For an
/// unsigned T that includes a minus sign.
template <class T>
std::optional<T> parse_number(std::string_view text) {
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (code != std::errc() || stop != end) return std::nullopt;
  return value;
}

}  // namespace enfilade
