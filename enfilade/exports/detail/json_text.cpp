#include "enfilade/exports/detail/json_text.h"

#include <fmt/format.h>
#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"

namespace enfilade::exports::detail {

std::string json_number(double value) {
  if (!std::isfinite(value)) {
    throw ArgumentError(fmt::format("{}: a number that JSON cannot say", value));
  }
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string json_string(std::string_view text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::exception&) {
    throw ArgumentError(fmt::format("a name that is not UTF-8: {:?}", text.substr(0, 80)));
  }
}

}  // namespace enfilade::exports::detail
