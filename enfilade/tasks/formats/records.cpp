#include "enfilade/tasks/formats/records.h"

#include <fmt/format.h>
#include <limits>

namespace enfilade::tasks::formats {

std::vector<std::string> read_path(json::Element element, const json::Path& path,
                                   json::Faults& faults) {
  const std::size_t errors = faults.errors();
  std::vector<std::string> viewpoints = json::strings(element, path, faults);
  if (viewpoints.empty() && faults.errors() == errors) {
    faults.error(path, "empty-path", "no viewpoint; the start at least is expected");
  }
  return viewpoints;
}

Radians read_angle(json::Element element, const json::Path& path, json::Faults& faults) {
  return Radians(json::number(element, path, faults).value_or(0));
}

std::vector<std::int32_t> read_tokens(json::Element element, const json::Path& path,
                                      json::Faults& faults) {
  std::vector<std::int32_t> tokens;
  const auto list = json::array(element, path, faults);
  if (!list) return tokens;
  tokens.reserve(list->size());
  std::size_t k = 0;
  for (const json::Element one : *list) {
    const json::Path place(path, k++);
    const auto token = json::integer(one, place, faults);
    if (!token) continue;
    if (*token < 0 || *token > std::numeric_limits<std::int32_t>::max()) {
      faults.error(place, "bad-token",
                   fmt::format("{} is no token id; 0 to 2147483647 are", *token));
      continue;
    }
    tokens.push_back(static_cast<std::int32_t>(*token));
  }
  return tokens;
}

void Once::check(const std::string& id, std::size_t record, const json::Path& path,
                 json::Faults& faults) {
  const auto [first, fresh] = places_.emplace(id, record);
  if (fresh) return;
  faults.error(path, code_, fmt::format("{:?} stands at $[{}] already", id, first->second));
}

}  // namespace enfilade::tasks::formats
