/// \file  Lists of JSON.
#pragma once
#include <nlohmann/json.hpp>

namespace enfilade::service::detail {

/// [make(element), ...] of a range's elements.
template <class Range, class Make>
nlohmann::ordered_json json_list(const Range& range, const Make& make) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& element : range) list.push_back(make(element));
  return list;
}

}  // namespace enfilade::service::detail
