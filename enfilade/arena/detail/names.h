/// \file  Names of neighbouring viewpoints: letters in the order of first sight.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace enfilade::arena::detail {

/// 0 -> "A", 25 -> "Z", 26 -> "AA", 27 -> "AB", ...
inline std::string letters(std::uint32_t number) {
  std::string name;
  for (std::uint64_t rest = std::uint64_t{number} + 1; rest > 0; rest = (rest - 1) / 26) {
    name.insert(name.begin(), static_cast<char>('A' + (rest - 1) % 26));
  }
  return name;
}

/// Its inverse. \pre name is one
inline std::uint32_t number_of_letters(std::string_view name) {
  std::uint32_t number = 0;
  for (const char letter : name) {
    number = number * 26 + static_cast<std::uint32_t>(letter - 'A') + 1;
  }
  return number - 1;
}

}  // namespace enfilade::arena::detail
