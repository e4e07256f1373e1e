#include "enfilade/tasks/soon_submission.h"

#include <fmt/format.h>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::tasks {
namespace {

using Json = nlohmann::ordered_json;

double finite(double value, const Episode& episode) {
  if (std::isfinite(value)) return value + 0.0;  // -0 would be read as a whole number
  throw ArgumentError(
      fmt::format("trajectory of {}: {}, not a finite number", episode.instruction_id, value));
}

Json answer_of(const Trajectory& trajectory, const EpisodeSet& episodes, const Episode& episode) {
  const graph::NavGraph& graph = episodes.graph_of(episode);
  Json path = Json::array();
  for (const TrajectoryPoint& point : trajectory.points) {
    path.push_back({graph.id(point.viewpoint), finite(point.heading.value, episode),
                    finite(point.elevation.value, episode)});
  }
  Json answer{{"path", std::move(path)}, {"obj_heading", nullptr}, {"obj_elevation", nullptr}};
  if (trajectory.point) {
    answer["obj_heading"] = finite(trajectory.point->heading, episode);
    answer["obj_elevation"] = finite(trajectory.point->elevation, episode);
  }
  return answer;
}

std::string entry_of(const Episode& episode) {
  if (episode.details.entry) return *episode.details.entry;
  throw ArgumentError(
      fmt::format("{}: its annotations do not say which entry it belongs to; they "
                  "have to be in the released form, with instr_id",
                  episode.instruction_id));
}

}  // namespace

std::string to_released_soon(const std::vector<Trajectory>& trajectories,
                             const EpisodeSet& episodes) {
  std::vector<std::pair<std::string, Json>> entries;
  std::map<std::pair<std::string, std::size_t>, std::size_t> places;
  for (const Trajectory& trajectory : trajectories) {
    const Episode& episode = episodes.episodes.at(trajectory.episode);
    const std::string id = entry_of(episode);
    const auto [place, fresh] = places.emplace(std::pair(id, episode.instruction), entries.size());
    if (fresh) entries.emplace_back(id, Json::array());
    entries[place->second].second.push_back(answer_of(trajectory, episodes, episode));
  }
  std::string text = "[";
  try {
    for (auto& [id, answers] : entries) {
      text += text.size() == 1 ? "\n" : ",\n";
      text += Json{{"instr_id", id}, {"trajectory", std::move(answers)}}.dump();
    }
  } catch (const Json::type_error&) {
    throw ArgumentError("an instr_id or a viewpoint is not UTF-8, which JSON is");
  }
  return text + "\n]\n";
}

}  // namespace enfilade::tasks
