#include "enfilade/models/detail/shares_json.h"

#include <fmt/format.h>

namespace enfilade::models::detail {

double read_share(json::Element element, const json::Path& path, const char* code,
                  json::Faults& faults) {
  constexpr double kMost = 1.001;  // a softmax in single precision may sum to a little more than 1
  const auto value = json::number(element, path, faults);
  if (value && !(*value >= 0 && *value <= kMost)) {
    faults.error(path, code, fmt::format("{}, not from 0 to 1", *value));
  }
  return value.value_or(0);
}

std::vector<double> read_attention(json::Element element, std::size_t words, const json::Path& path,
                                   const char* code, json::Faults& faults) {
  std::vector<double> weights;
  const auto list = json::array(element, path, faults);
  if (!list) return weights;
  if (list->size() != words) {
    faults.error(path, "attention-size",
                 fmt::format("{} weights, not {}, the number of words", list->size(), words));
  }
  for (const json::Element one : *list) {
    weights.push_back(read_share(one, json::Path(path, weights.size()), code, faults));
  }
  return weights;
}

}  // namespace enfilade::models::detail
