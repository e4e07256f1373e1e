// Results files, as the public code of each benchmark has them.
#include <fmt/format.h>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {
namespace {

std::string quoted(const char* what, const std::string& text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::type_error&) {
    throw ArgumentError(fmt::format("{} {}: not UTF-8, which JSON is", what, quote(text)));
  }
}

// A number as JSON has it, if the text is one without decoration: "66", not "066" or "66 ".
std::optional<std::int64_t> plain_number(const std::string& text) {
  const auto number = parse_number<std::int64_t>(text);
  return number && fmt::to_string(*number) == text ? number : std::nullopt;
}

// Writes one file. What is the same in many entries (viewpoints, angles) is made into text once.
class Writer {
 public:
  explicit Writer(const EpisodeSet& episodes) : episodes_(episodes) {}

  std::string write(const std::vector<Trajectory>& trajectories) {
    add("[");
    for (const Trajectory& trajectory : trajectories) {
      add(text_.size() == 1 ? "\n{" : ",\n{");
      write_entry(trajectory, episodes_.episodes.at(trajectory.episode));
      add("}");
    }
    add("\n]\n");
    return std::move(text_);
  }

 private:
  void add(std::string_view text) { text_ += text; }

  void write_entry(const Trajectory& trajectory, const Episode& episode) {
    const std::string& id = episode.instruction_id;
    const auto cvdn_id = episodes_.task == Task::kCvdn ? plain_number(id) : std::nullopt;
    if (cvdn_id) {
      fmt::format_to(std::back_inserter(text_), "\"inst_idx\": {}", *cvdn_id);
    } else {
      fmt::format_to(std::back_inserter(text_), "\"instr_id\": {}", quoted("instr_id", id));
    }
    if (episodes_.task == Task::kRxr) {
      if (const auto own = plain_number(id.substr(id.rfind('_') + 1))) {
        fmt::format_to(std::back_inserter(text_), ", \"instruction_id\": {}", *own);
      }
    }
    const bool pointed = episodes_.task == Task::kSoon;
    add(pointed ? ", \"trajectory\": {\"path\": [" : ", \"trajectory\": [");
    write_points(trajectory, episode);
    add("]");
    if (pointed) write_point(trajectory, id);
    write_answer(trajectory, episode);
  }

  void write_points(const Trajectory& trajectory, const Episode& episode) {
    const std::vector<std::string>& names = names_of(episodes_.path_of(episode).scan);
    bool first = true;
    for (const TrajectoryPoint& point : trajectory.points) {
      add(first ? "[" : ", [");
      first = false;
      add(names.at(point.viewpoint.at()));
      write_angle(point.heading, heading_, episode.instruction_id);
      write_angle(point.elevation, elevation_, episode.instruction_id);
      add("]");
    }
  }

  // Agents turn by steps, and look level for most of the time: an angle is often the one before.
  struct LastAngle {
    double value = 0;
    std::string text = ", 0";
  };
  void write_angle(Radians angle, LastAngle& last, const std::string& id) {
    // Adding 0 turns -0, which JSON readers take for an integer, into 0.
    const double value = angle.value + 0.0;
    if (value != last.value) {
      last.value = value;
      last.text = ", " + number(value, id);
    }
    add(last.text);
  }

  // The shortest text that is read back equal.
  static std::string number(double value, const std::string& id) {
    if (std::isfinite(value)) return fmt::format("{}", value + 0.0);
    throw ArgumentError(fmt::format("trajectory of {}: angle {}, not a finite number", id, value));
  }

  void write_point(const Trajectory& trajectory, const std::string& id) {
    const auto list = [&](double SpherePoint::*field) {
      return trajectory.point ? "[" + number((*trajectory.point).*field, id) + "]"
                              : std::string("null");
    };
    fmt::format_to(std::back_inserter(text_), ", \"obj_heading\": {}, \"obj_elevation\": {}}}",
                   list(&SpherePoint::heading), list(&SpherePoint::elevation));
  }

  void write_answer(const Trajectory& trajectory, const Episode& episode) {
    if (episodes_.task == Task::kR2rBack) {
      const auto& turn = trajectory.turning_point;
      add(", \"midstop\": ");
      add(turn ? names_of(episodes_.path_of(episode).scan).at(turn->at()) : "null");
    }
    if (episodes_.task != Task::kReverie) return;
    add(", \"predObjId\": ");
    if (trajectory.object.empty()) {
      add("null");
    } else if (const auto id = plain_number(trajectory.object)) {
      add(fmt::to_string(*id));
    } else {
      add(quoted("object", trajectory.object));
    }
  }

  // Viewpoint ids of a scan as JSON has them.
  const std::vector<std::string>& names_of(ScanIndex scan) {
    std::vector<std::string>& names = names_[scan.value];
    const graph::NavGraph& graph = episodes_.graphs->graph(scan);
    if (names.empty()) {
      for (std::size_t v = 0; v < graph.size(); ++v) {
        names.push_back(quoted("viewpoint", graph.id(ViewpointIndex(v))));
      }
    }
    return names;
  }

  const EpisodeSet& episodes_;
  std::unordered_map<decltype(ScanIndex::value), std::vector<std::string>> names_;
  LastAngle heading_, elevation_;
  std::string text_;
};

// The released form of SOON.

using Json = nlohmann::ordered_json;

double finite_number(double value, const Episode& episode) {
  if (std::isfinite(value)) return value + 0.0;  // -0 would be read as a whole number
  throw ArgumentError(
      fmt::format("trajectory of {}: {}, not a finite number", episode.instruction_id, value));
}

Json answer_of(const Trajectory& trajectory, const EpisodeSet& episodes, const Episode& episode) {
  const graph::NavGraph& graph = episodes.graph_of(episode);
  Json path = Json::array();
  for (const TrajectoryPoint& point : trajectory.points) {
    path.push_back({graph.id(point.viewpoint), finite_number(point.heading.value, episode),
                    finite_number(point.elevation.value, episode)});
  }
  Json answer{{"path", std::move(path)}, {"obj_heading", nullptr}, {"obj_elevation", nullptr}};
  if (trajectory.point) {
    answer["obj_heading"] = finite_number(trajectory.point->heading, episode);
    answer["obj_elevation"] = finite_number(trajectory.point->elevation, episode);
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

std::string to_json(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes) {
  return Writer(episodes).write(trajectories);
}

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
