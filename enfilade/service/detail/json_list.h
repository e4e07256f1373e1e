/// \file  Lists of JSON.
#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

namespace enfilade::service::detail {

/// To five digits after the point.
inline double rounded(double value) { return std::round(value * 1e5) / 1e5; }

/// [make(element), ...] of a range's elements.
template <class Range, class Make>
nlohmann::ordered_json json_list(const Range& range, Make&& make) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& element : range) list.push_back(make(element));
  return list;
}

}  // namespace enfilade::service::detail
