/// \file  Enumerations whose values have names, as the database and the API write them.
#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>
#include <type_traits>

namespace enfilade::service::detail {

/// An enumeration with a function names_of(Enum) beside it: an array of the names of all values, in
/// their order.
template <class Enum>
concept Named = std::is_enum_v<Enum> && requires(Enum value) { names_of(value).front(); };

template <Named Enum>
constexpr std::string_view name_of(Enum value) {
  return names_of(value)[static_cast<std::size_t>(value)];
}

/// The value of that name; none if no value has it.
template <Named Enum>
std::optional<Enum> find_named(std::string_view name) {
  const auto names = names_of(Enum{});
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

}  // namespace enfilade::service::detail
