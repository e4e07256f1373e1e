/// \file  A mutator of libFuzzer's that changes one thing of a JSON text. Random bytes seldom come
/// further than its parser. For one source of a program.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace enfilade::fuzz {

using Json = nlohmann::ordered_json;
using Random = std::minstd_rand;

/// What an input says, read as JSON; a discarded value if it is none, or is nested too deeply to be
/// written again.
inline Json parse_input(const std::uint8_t* data, std::size_t size) {
  constexpr int kDeepest = 500;
  int depth = 0;
  for (const std::uint8_t byte : std::basic_string_view<std::uint8_t>(data, size)) {
    depth += byte == '[' || byte == '{' ? 1 : byte == ']' || byte == '}' ? -1 : 0;
    if (depth > kDeepest) return Json(Json::value_t::discarded);
  }
  return Json::parse(data, data + size, nullptr, false);
}

/// A text of an input as it stands, another value in JSON.
inline std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

namespace detail {

inline std::size_t below(Random& random, std::size_t count) { return random() % count; }

/// A value and all that are in it.
inline void collect(Json& value, std::vector<Json*>& all) {
  all.push_back(&value);
  if (!value.is_structured()) return;
  for (Json& part : value) collect(part, all);
}

inline std::string changed(std::string text) {
  const std::size_t size = text.size(), most = std::max<std::size_t>(2 * size, 16);
  text.resize(most);
  auto* bytes = reinterpret_cast<std::uint8_t*>(text.data());
  text.resize(LLVMFuzzerMutate(bytes, size, most));
  return text;
}

inline Json extreme(Random& random) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  const std::array<Json, 16> values{0,
                                    1,
                                    -1,
                                    -0.0,
                                    0.5,
                                    1e-320,
                                    kLargest,
                                    -kLargest,
                                    std::numeric_limits<std::int64_t>::min(),
                                    std::numeric_limits<std::uint64_t>::max(),
                                    std::uint64_t{1} << 53U,
                                    nullptr,
                                    true,
                                    "",
                                    Json::array(),
                                    Json::object()};
  return values[below(random, values.size())];
}

/// Another value of the document, of its keys one time in three.
inline Json taken(const std::vector<Json*>& all, Random& random) {
  const Json& value = *all[below(random, all.size())];
  if (!value.is_object() || value.empty() || below(random, 3) != 0) return value;
  return std::next(value.begin(), static_cast<std::ptrdiff_t>(below(random, value.size()))).key();
}

inline void change_list(Json& list, Random& random, const Json& other) {
  const std::size_t at = below(random, list.size() + 1);
  const auto place = [&list](std::size_t k) {
    return list.begin() + static_cast<std::ptrdiff_t>(k);
  };
  if (list.empty() || below(random, 4) == 0) {
    list.insert(place(at), other);
  } else if (below(random, 2) == 0) {
    list.erase(place(at % list.size()));
  } else {
    const Json part = list[at % list.size()];
    list.insert(place(at), std::size_t{1} << below(random, 7), part);
  }
}

inline void change_object(Json& object, Random& random, const Json& other) {
  if (object.empty()) {
    object[text_of(other)] = other;
    return;
  }
  const auto at =
      std::next(object.begin(), static_cast<std::ptrdiff_t>(below(random, object.size())));
  const std::string key = at.key();
  const Json value = at.value();
  if (below(random, 3) != 0) object.erase(key);  // else it is there twice, by two names
  const std::size_t kind = below(random, 3);
  if (kind == 0) object[other.is_string() ? other.get<std::string>() : changed(key)] = value;
  if (kind == 1) object[key] = other;
}

inline void change(Json& document, Random& random) {
  std::vector<Json*> all;
  collect(document, all);
  Json& value = *all[below(random, all.size())];
  const Json other = taken(all, random);
  switch (below(random, 6)) {
    case 0:
      value = extreme(random);
      return;
    case 1:
      value = other;
      return;
    case 2: {
      Json within = value;
      const std::size_t levels = std::size_t{1} << below(random, 7);
      for (std::size_t k = 0; k < levels; ++k) within = Json::array({std::move(within)});
      value = std::move(within);
      return;
    }
    default:
      break;
  }
  if (value.is_array()) {
    change_list(value, random, other);
  } else if (value.is_object()) {
    change_object(value, random, other);
  } else if (value.is_string()) {
    value = changed(value.get<std::string>());
  } else {
    value = extreme(random);
  }
}

}  // namespace detail
}  // namespace enfilade::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned int seed) {
  using namespace enfilade::fuzz;
  Random random(seed + 1);
  Json document = parse_input(data, size);
  constexpr std::size_t kBytes = 10;  // one time in so many, bytes change and not values
  if (!document.is_discarded() && detail::below(random, kBytes) != 0) {
    detail::change(document, random);
    const std::string text = document.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (text.size() <= most) {
      std::ranges::copy(text, data);
      return text.size();
    }
  }
  return LLVMFuzzerMutate(data, size, most);
}
