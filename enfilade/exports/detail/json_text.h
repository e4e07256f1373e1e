/// \file  Small pieces of JSON text.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::exports::detail {

/// The shortest text that reads back as this number, with a point or an exponent, so that Python
/// reads a float.
/// \throws ArgumentError for an infinite number or NaN, which JSON does not have
std::string json_number(double value);
/// In quotes, escaped. \throws ArgumentError for text that is not UTF-8
std::string json_string(std::string_view text);

}  // namespace enfilade::exports::detail
