/// \file  Fields of JSON with limits, for files and bodies that people write.
#pragma once
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/core/detail/json.h"

namespace enfilade::service::detail {

/// What json::fields() found.
template <std::size_t N>
using Found = std::array<std::optional<json::Element>, N>;

/// How much of a wrong value a message quotes.
inline constexpr std::size_t kQuoted = 40;

/// The value; reports "out-of-range", and anything that is no number.
inline double number_within(json::Element element, const json::Path& path, double least,
                            double most, json::Faults& faults) {
  const auto value = json::number(element, path, faults);
  if (value && !(*value >= least && *value <= most)) {
    faults.error(path, "out-of-range", fmt::format("{}, not from {} to {}", *value, least, most));
  }
  return value.value_or(least);
}

/// As number_within(), of whole numbers; what is out of range is clamped.
inline int integer_within(json::Element element, const json::Path& path, int least, int most,
                          json::Faults& faults) {
  const auto value = json::integer(element, path, faults);
  if (value && (*value < least || *value > most)) {
    faults.error(path, "out-of-range", fmt::format("{}, not from {} to {}", *value, least, most));
  }
  return static_cast<int>(std::clamp<std::int64_t>(value.value_or(least), least, most));
}

/// A text; reports `code` unless check(text). \param allowed what check() allows, for the message
template <class Check>
std::string text_that(const Check& check, json::Element element, const json::Path& path,
                      std::string_view allowed, json::Faults& faults,
                      const char* code = "bad-text") {
  const auto text = json::string(element, path, faults);
  if (text && !check(*text)) {
    faults.error(path, code, fmt::format("{:?}, not {}", text->substr(0, kQuoted), allowed));
  }
  return std::string(text.value_or(""));
}

}  // namespace enfilade::service::detail
