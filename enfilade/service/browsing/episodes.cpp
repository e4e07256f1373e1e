#include "enfilade/service/browsing/episodes.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "enfilade/service/detail/json_list.h"

namespace enfilade::service::browsing {
namespace {

using nlohmann::ordered_json;

bool contains(std::string_view text, std::string_view wanted) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return !std::ranges::search(text, wanted, {}, lower, lower).empty() || wanted.empty();
}

ordered_json episode_json(const r2r::PathAnnotation& path, std::size_t k) {
  ordered_json one{{"instruction_id", r2r::instruction_id(path.path_id, k)},
                   {"path_id", path.path_id},
                   {"scan", path.scan},
                   {"heading", path.heading.value},
                   {"instruction", path.instructions[k]},
                   {"start", path.path.front()}};
  if (!path.goal_hidden()) {
    one["path"] = path.path;
    if (path.distance) one["distance"] = *path.distance;
  }
  return one;
}

}  // namespace

ordered_json split_list_json(const Site& site) {
  const auto split_json = [](const PublicSplit& split) {
    std::size_t instructions = 0;
    for (const auto& path : split.annotations.paths) instructions += path.instructions.size();
    return ordered_json{{"split", split.annotations.split},
                        {"paths", split.annotations.paths.size()},
                        {"instructions", instructions},
                        {"goals_hidden", split.goals_hidden}};
  };
  return {{"splits", detail::json_list(site.splits(), split_json)}};
}

ordered_json episodes_json(const PublicSplit& split, const EpisodeFilter& filter) {
  std::int64_t matching = 0;
  auto list = ordered_json::array();
  for (const r2r::PathAnnotation& path : split.annotations.paths) {
    if (!filter.scan.empty() && path.scan != filter.scan) continue;
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      if (!contains(path.instructions[k], filter.words)) continue;
      if (!filter.id.empty() && r2r::instruction_id(path.path_id, k) != filter.id) continue;
      const bool on_page = matching >= filter.offset && matching < filter.offset + filter.limit;
      if (on_page) list.push_back(episode_json(path, k));
      ++matching;
    }
  }
  return {{"split", split.annotations.split},
          {"goals_hidden", split.goals_hidden},
          {"matching", matching},
          {"episodes", list}};
}

}  // namespace enfilade::service::browsing
