// Splits and episodes, as everybody may see them.
#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "enfilade/service/http/app.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

constexpr std::int64_t kMostEpisodes = 500;

std::string split_list_json(const Context& context) {
  auto list = ordered_json::array();
  for (const PublicSplit& split : context.site->splits()) {
    std::size_t instructions = 0;
    for (const auto& path : split.annotations.paths) instructions += path.instructions.size();
    list.push_back({{"split", split.annotations.split},
                    {"paths", split.annotations.paths.size()},
                    {"instructions", instructions},
                    {"goals_hidden", split.goals_hidden}});
  }
  return ordered_json{{"splits", list}}.dump();
}

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

Response episodes(const Context& context, const Request& request) {
  const PublicSplit* split = context.site->find_split(request.parameter("split"));
  if (split == nullptr) throw HttpError(404, "unknown-split", "no split of this name");
  const std::string scan = request.text("scan");
  const std::string words = request.text("q");
  const std::string id = request.text("id");
  const auto offset = request.number("offset", 0, 0, 1'000'000'000);
  const auto limit = request.number("limit", 50, 1, kMostEpisodes);
  std::int64_t matching = 0;
  auto list = ordered_json::array();
  for (const r2r::PathAnnotation& path : split->annotations.paths) {
    if (!scan.empty() && path.scan != scan) continue;
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      if (!contains(path.instructions[k], words)) continue;
      if (!id.empty() && r2r::instruction_id(path.path_id, k) != id) continue;
      if (matching >= offset && matching < offset + limit) list.push_back(episode_json(path, k));
      ++matching;
    }
  }
  return json_response(ordered_json{
      {"split", split->annotations.split},
      {"goals_hidden", split->goals_hidden},
      {"matching", matching},
      {"episodes", list}}.dump());
}

}  // namespace

void add_episode_routes(Router& router, Context& context) {
  router.add({"GET", "/api/v1/splits", Access::kPublic,
              [&context](const Request&) { return json_response(split_list_json(context)); }});
  router.add({"GET", "/api/v1/splits/{split}/episodes", Access::kPublic,
              [&context](const Request& request) { return episodes(context, request); }});
}

}  // namespace enfilade::service::http
