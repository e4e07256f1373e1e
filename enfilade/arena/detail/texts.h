/// \file  Small functions for texts that models and users wrote, and for names of viewpoints.
#pragma once
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <string>
#include <string_view>

namespace enfilade::arena::detail {

/// Actions of continuous space by the names that calls have, by continuous::Action. Looks last:
/// R2R-CE has none.
inline constexpr std::array<std::string_view, 6> kMoves{"stop",  "forward", "left",
                                                        "right", "up",      "down"};

/// Whether two texts are equal, ignoring the case of ASCII letters.
inline bool is_same(std::string_view one, std::string_view other) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return std::ranges::equal(one, other, {}, lower, lower);
}

/// The name of a neighbouring viewpoint by its place in the order of first sight: 0 -> "A", 25 ->
/// "Z", 26 -> "AA", 27 -> "AB", ...
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
