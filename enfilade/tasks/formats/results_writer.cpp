// Results files, as the public code of each benchmark has them.
#include <fmt/format.h>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {
namespace {

std::string quoted(const char* what, const std::string& text) {
  try {
    return nlohmann::json(text).dump();
  } catch (const nlohmann::json::type_error&) {
    throw ArgumentError(fmt::format("{} {:?}: not UTF-8, which JSON is", what, text));
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

}  // namespace

std::string to_json(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes) {
  return Writer(episodes).write(trajectories);
}

}  // namespace enfilade::tasks
