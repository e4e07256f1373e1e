/// \file  The smallest splits of all benchmarks, in the building of served_data.h: what everybody
/// gets, what only the server knows, and results files. All SYNTHETIC.
#pragma once
#include <fmt/format.h>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"

namespace enfilade::service::testing {

using nlohmann::json;

/// All benchmarks but R2R.
inline constexpr std::array<tasks::Task, 7> kOtherTasks{
    tasks::Task::kR2rLast, tasks::Task::kR2rBack, tasks::Task::kR4r, tasks::Task::kRxr,
    tasks::Task::kReverie, tasks::Task::kCvdn,    tasks::Task::kSoon};

/// What two sets of goals differ in: by how many viewpoints paths are longer, and by how much ids
/// of objects are larger.
struct HiddenThings {
  std::size_t more_steps = 0;
  int more_id = 0;
};

/// v0 ... as a list of ids.
inline json row_path(std::size_t first, std::size_t last) {
  json path = json::array();
  for (std::size_t v = first; v <= last; ++v) path.push_back(fmt::format("v{}", v));
  return path;
}

/// A quadrilateral around heading 1, elevation 0.
inline json soon_box(const std::string& scan, const std::string& viewpoint) {
  const auto at = [](double heading, double elevation) {
    return json{{"heading", heading}, {"elevation", elevation}};
  };
  return {{"scan", scan},
          {"image_id", viewpoint},
          {"heading", 1},
          {"elevation", 0},
          {"obj_name", "vase"},
          {"target",
           {{"center", at(1, 0)},
            {"left_top", at(0.5, 0.5)},
            {"right_top", at(1.5, 0.5)},
            {"right_bottom", at(1.5, -0.5)},
            {"left_bottom", at(0.5, -0.5)}}}};
}

/// One path of a split, from v<k> on; with its goal if `goal` is not null.
inline json served_entry(tasks::Task task, std::size_t k, const HiddenThings* goal,
                         const std::string& scan = "row") {
  const std::string id = std::to_string(k + 1);
  const std::size_t last = goal == nullptr ? k : k + 2 + goal->more_steps;
  json path = row_path(k, last);
  json entry{{"scan", scan}, {"heading", 1.5}, {"path", path}, {"path_id", k + 1}};
  entry["instructions"] = {"Walk to the vase.", "Go on."};
  using enum tasks::Task;
  if (task == kReverie) {
    entry["id"] = id;
    if (goal == nullptr) return entry;
    entry["path_id"] = k + 101;
    entry["objId"] = 60 + static_cast<int>(k) + goal->more_id;
  } else if (task == kR2rBack && goal != nullptr) {
    for (std::size_t v = last; v-- > k;) path.push_back(fmt::format("v{}", v));
    entry["path"] = path;
    entry["midstop"] = fmt::format("v{}", last);
  } else if (task == kRxr) {
    entry.erase("instructions");
    entry["instruction_id"] = k + 1;
    entry["language"] = k == 0 ? "en-IN" : "hi-IN";
    entry["instruction"] = "Walk to the vase.";
    entry["timed_instruction"] = json::array();
  } else if (task == kCvdn) {
    entry = {{"inst_idx", k + 1},
             {"scan", scan},
             {"target", "vase"},
             {"start_pano", {{"heading", 1.5}, {"pano", path.front()}}},
             {"dialog_history",
              {{{"nav_idx", 0}, {"role", "navigator"}, {"message", "Which way to the vase?"}}}}};
    if (goal == nullptr) return entry;
    entry["end_panos"] = {path.back()};
    entry["player_path"] = entry["planner_path"] = path;
  } else if (task == kSoon) {
    entry["path_id"] = "4-" + id;
    entry["instructions"] = {{{"full", "Walk to the vase."}}, {{"full", "Go on."}}};
    entry.erase("heading");
    if (goal != nullptr) entry["bboxes"] = {soon_box(scan, path.back().get<std::string>())};
  }
  return entry;
}

/// The text of a file of entries.
inline std::string served_text(tasks::Task task, const std::vector<json>& entries) {
  if (task != tasks::Task::kRxr && task != tasks::Task::kSoon) return json(entries).dump();
  std::string lines;
  for (const json& entry : entries) lines += entry.dump() + "\n";
  return lines;
}

/// The text of a split of two paths. \param goal null: without goals
inline std::string served_split(tasks::Task task, const HiddenThings* goal) {
  return served_text(task, {served_entry(task, 0, goal), served_entry(task, 1, goal)});
}

/// Objects 60 to 69, each seen from every viewpoint but v0.
inline std::string served_boxes() {
  json boxes;
  for (std::size_t v = 0; v < 6; ++v) {
    json& objects = boxes[fmt::format("row_v{}", v)] = json::object();
    for (int id = 60; v > 0 && id < 70; ++id) {
      objects[std::to_string(id)] = {
          {"name", "vase"}, {"visible_pos", {0}}, {"bbox2d", {{1, 2, 30, 40}}}};
    }
  }
  return boxes.dump();
}

/// Writes the split "test" of each benchmark into a data set, and its goals, as
/// "secret-<task>.json", into the folder above it.
/// \param mistaken  the data set has the goals too, as it should not
inline void write_benchmarks(const std::filesystem::path& root, const HiddenThings& goal,
                             bool mistaken = false) {
  const auto write = [](const std::filesystem::path& file, const std::string& text) {
    make_folder(file.parent_path());
    write_file_atomically(file, text);
  };
  for (const tasks::Task task : kOtherTasks) {
    const auto place = tasks::episode_places(tasks::benchmark(task), "test").front();
    write(root / "data" / place, served_split(task, mistaken ? &goal : nullptr));
    write(root / fmt::format("secret-{}.json", tasks::benchmark(task).name),
          served_split(task, &goal));
  }
  write(root / "data" / tasks::object_places().front(), served_boxes());
}

/// What an agent says of its goals.
struct Answers {
  int object = 60;                         ///< of the first path; the others' are one more each
  double heading = 1 / 6.283185307179586;  ///< SOON's units
};

/// Results: `moves` steps along the row in each episode; of R2R-Back there and back.
inline std::string benchmark_results(tasks::Task task, std::size_t moves,
                                     const Answers& answers = {}) {
  using enum tasks::Task;
  const std::size_t instructions = task == kRxr || task == kCvdn ? 1 : 2;
  json results = json::array();
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t i = 0; i < instructions; ++i) {
      json path = json::array();
      for (const json& id : row_path(k, k + moves)) path.push_back({id, 1.5, 0.0});
      for (std::size_t v = k + moves; task == kR2rBack && v-- > k;) {
        path.push_back({fmt::format("v{}", v), 1.5, 0.0});
      }
      json one{{"instr_id", fmt::format("{}{}_{}", task == kSoon ? "4-" : "", k + 1, i)},
               {"trajectory", path}};
      if (task == kRxr) {
        one = {{"instruction_id", k + 1}, {"path", path}};
      } else if (task == kCvdn) {
        one = {{"inst_idx", k + 1}, {"trajectory", path}};
      } else if (task == kReverie) {
        one["predObjId"] = answers.object + static_cast<int>(k);
      } else if (task == kR2rBack) {
        one["midstop"] = fmt::format("v{}", k + 2);
      } else if (task == kSoon) {
        one["trajectory"] = {
            {"path", path}, {"obj_heading", {answers.heading}}, {"obj_elevation", {0.5}}};
      }
      results.push_back(one);
    }
  }
  return results.dump();
}

}  // namespace enfilade::service::testing
