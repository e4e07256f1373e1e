/// \file  Enumerations whose values have names, as files, options and messages write them.
#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace enfilade {

/// An enumeration with a function names_of(Enum) beside it: an array of the names of all values, in
/// their order.
template <class Enum>
concept NamedEnum = std::is_enum_v<Enum> && requires(Enum value) { names_of(value).front(); };

/// \pre the value is one of the enumeration's
template <NamedEnum Enum>
constexpr std::string_view enum_name(Enum value) {
  return names_of(value)[static_cast<std::size_t>(value)];
}

/// The value of that name; no value if the name is unknown.
template <NamedEnum Enum>
std::optional<Enum> find_enum(std::string_view name) {
  const auto names = names_of(Enum{});
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

/// The names of all values, in their order.
template <NamedEnum Enum>
std::vector<std::string> enum_names() {
  const auto names = names_of(Enum{});
  return {names.begin(), names.end()};
}

}  // namespace enfilade
