#include "enfilade/service/collecting/export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "enfilade/scan/file_tree.h"
#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/collecting/kinds/dialogues.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/pose_trace.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

/// The first walk of each instruction, only of paths whose instructions were all walked.
void keep_whole_walks(const std::vector<WorkItem>& items, Selection& selection) {
  std::set<std::int64_t> walked;
  const std::size_t before = selection.tasks.size();
  std::erase_if(selection.tasks,
                [&](const Assignment& task) { return !walked.insert(task.item.id).second; });
  const std::size_t once = selection.tasks.size();
  std::set<std::int64_t> incomplete;  // path ids
  for (const WorkItem& item : items) {
    if (!walked.contains(item.id)) incomplete.insert(item.path_id);
  }
  std::erase_if(selection.tasks,
                [&](const Assignment& task) { return incomplete.contains(task.item.path_id); });
  selection.report.repeated = static_cast<std::int64_t>(before - once);
  selection.report.incomplete = static_cast<std::int64_t>(once - selection.tasks.size());
}

/// Dialogues of which both tasks are there. Whoever sat there alone to the end has one, too.
void keep_whole_dialogues(Selection& selection) {
  std::map<std::int64_t, std::set<std::string>> roles;
  const auto dialogue_of = [](const Assignment& task) {
    return ordered_json::parse(task.content).at("dialogue").get<std::int64_t>();
  };
  for (const Assignment& task : selection.tasks) roles[dialogue_of(task)].insert(task.role);
  const auto left = std::erase_if(
      selection.tasks, [&](const Assignment& task) { return roles[dialogue_of(task)].size() < 2; });
  selection.report.incomplete = static_cast<std::int64_t>(left);
}

/// Of REVERIE: a path's objects each have their instructions.
struct ObjectOfPath {
  std::int64_t path_id = 0, object = 0;
  friend auto operator<=>(const ObjectOfPath&, const ObjectOfPath&) = default;
};
ObjectOfPath object_of(const WorkItem& item) { return {item.path_id, item.object.value_or(0)}; }

/// The ids of instructions, by item. REVERIE's count those of one object.
std::map<std::int64_t, std::string> instruction_ids(const Selection& selection) {
  std::map<std::int64_t, std::string> ids;
  std::map<ObjectOfPath, std::size_t> numbers;
  for (const Assignment& task : selection.tasks) {
    const WorkItem& item = task.item;
    if (ids.contains(item.id)) continue;
    const ObjectOfPath object = object_of(item);
    ids[item.id] = selection.report.kind == WorkKind::kFind
                       ? fmt::format("{}_{}_{}", item.path_id, object.object, numbers[object]++)
                       : tasks::instruction_id(item.path_id, item.number);
  }
  return ids;
}

/// \throws Refusal kConflict if there are none
const std::vector<Assignment>& tasks_of(const Selection& selection) {
  if (selection.tasks.empty()) {
    const char* hint = selection.report.waiting > 0 ? "; state=all takes what waits, too" : "";
    throw detail::Refusal(detail::Reason::kConflict,
                          fmt::format("nothing to export: {}{}", selection.report.summary(), hint));
  }
  return selection.tasks;
}

std::string list_lines(const std::vector<ordered_json>& entries) {
  std::string out = "[";
  for (const ordered_json& one : entries) out += (out.size() > 1 ? ",\n" : "\n") + one.dump();
  return out + "\n]\n";
}

/// The instruction of a guide has the number of its task.
std::string guide_id(const Assignment& task) {
  return fmt::format("{}_{}", task.item.path_id, task.id);
}

ordered_json steps_of(const Assignment& task) {
  ordered_json content = ordered_json::parse(task.content);
  return task.kind == WorkKind::kWalk ? content : content.at("steps");
}

/// The walks as [a, b, ...], one a line. \param add adds the other fields of a walk
template <class Add>
std::string list_walks(const Selection& selection, const Add& add) {
  std::vector<ordered_json> entries;
  const bool guide = selection.report.kind == WorkKind::kGuide;
  const auto ids = instruction_ids(selection);
  for (const Assignment& task : tasks_of(selection)) {
    ordered_json one{{"instr_id", guide ? guide_id(task) : ids.at(task.item.id)}};
    add(one, task);
    entries.push_back(std::move(one));
  }
  return list_lines(entries);
}

}  // namespace

std::string ExportReport::summary() const {
  const bool written = shows_path(kind);
  const bool dialogue = kind == WorkKind::kDialogue;
  const char* exported = kind == WorkKind::kDescribe ? "objects have a description"
                         : written                   ? "paths have directions"
                         : dialogue                  ? "goals have a dialogue"
                                                     : "instructions have a walk";
  std::string text = fmt::format("{} of {} {}", exported_items, items, exported);
  std::vector<std::string> parts;
  const auto add = [&parts](std::int64_t count, const char* what) {
    if (count > 0) parts.push_back(fmt::format("{} {}", count, what));
  };
  add(waiting, "not reviewed yet");
  add(rejected, "rejected");
  add(repeated, "later walks of the same instruction");
  add(incomplete, dialogue ? "of dialogues without the other one's task"
                           : "of paths with an instruction that no worker has walked");
  if (!parts.empty()) {
    text += fmt::format("; {} {}{} left out: {}", left_out(),
                        written    ? "text"
                        : dialogue ? "task"
                                   : "walk",
                        left_out() == 1 ? " is" : "s are", fmt::join(parts, ", "));
  }
  return text;
}

Selection select_work(store::Database& db, const ExportedSplit& exported) {
  const auto held = db.hold();
  const std::vector<WorkItem> items = items_of(db, exported.collection.id, exported.split);
  Selection selection{work_of(db, exported), {exported.split, exported.collection.kind}};
  ExportReport& report = selection.report;
  const auto count = [&](AssignmentState state) {
    return db.find_number(
        "SELECT count(*) FROM task JOIN item ON item.id = task.item WHERE collection = ? AND split "
        "= ? AND practice = 0 AND task.state = ?",
        exported.collection.id, exported.split, state);
  };
  report.waiting = exported.with_waiting ? 0 : count(AssignmentState::kSubmitted);
  report.rejected = count(AssignmentState::kRejected);
  report.language = exported.collection.language;
  if (is_followed(report.kind)) keep_whole_walks(items, selection);
  if (report.kind == WorkKind::kDialogue) keep_whole_dialogues(selection);
  std::set<std::int64_t> paths, exported_items, exported_paths;
  for (const WorkItem& item : items) paths.insert(item.path_id);
  for (const Assignment& task : selection.tasks) {
    exported_items.insert(task.item.id);
    exported_paths.insert(task.item.path_id);
  }
  const auto size = [](const auto& of) { return static_cast<std::int64_t>(of.size()); };
  selection.secret = std::ranges::any_of(items, &WorkItem::secret);
  report.items = size(items);
  report.paths = size(paths);
  report.exported_items = size(exported_items);
  report.exported_paths = size(exported_paths);
  report.exported_tasks = size(selection.tasks);
  return selection;
}

ordered_json report_json(const ExportReport& report) {
  return {{"split", report.split},
          {"items", report.items},
          {"paths", report.paths},
          {"exported",
           {{"items", report.exported_items},
            {"paths", report.exported_paths},
            {"tasks", report.exported_tasks}}},
          {"left_out",
           {{"waiting", report.waiting},
            {"rejected", report.rejected},
            {"repeated", report.repeated},
            {"incomplete", report.incomplete}}},
          {"summary", report.summary()}};
}

namespace {

std::string r2r_json(const Selection& selection) {
  const bool written = is_written(selection.report.kind);
  tasks::Annotations annotations{selection.report.split, "", {}};
  auto& paths = annotations.paths;
  for (const Assignment& task : tasks_of(selection)) {
    const WorkItem& item = task.item;
    if (paths.empty() || paths.back().path_id != item.path_id) {  // tasks are sorted by item
      paths.push_back({item.path_id, item.scan, item.heading, item.path, item.distance, {}});
    }
    paths.back().instructions.push_back(written ? task.content : item.instruction);
  }
  return tasks::to_json(annotations);
}

std::string reverie_json(const Selection& selection) {
  std::vector<ordered_json> entries;
  std::map<ObjectOfPath, std::size_t> places;
  for (const Assignment& task : tasks_of(selection)) {
    const WorkItem& item = task.item;
    const ObjectOfPath object = object_of(item);
    const auto [place, fresh] = places.emplace(object, entries.size());
    if (fresh) {
      entries.push_back({{"id", fmt::format("{}_{}", object.path_id, object.object)},
                         {"path_id", object.path_id},
                         {"objId", object.object},
                         {"scan", item.scan},
                         {"heading", item.heading.value},
                         {"path", item.path},
                         {"instructions", ordered_json::array()}});
    }
    entries[place->second]["instructions"].push_back(
        task.kind == WorkKind::kDescribe ? task.content : item.instruction);
  }
  return list_lines(entries);
}

std::string rxr_lines(const Selection& selection) {
  tasks::Annotations annotations{selection.report.split, "", {}, tasks::Task::kRxr};
  for (const Assignment& task : tasks_of(selection)) {
    const WorkItem& item = task.item;
    const ordered_json content = ordered_json::parse(task.content);
    tasks::PathAnnotation path{item.path_id,  item.scan,
                               item.heading,  item.path,
                               item.distance, {content.at("instruction").get<std::string>()}};
    path.group = item.path_id;
    tasks::InstructionDetails& details = path.details.emplace_back();
    details.id = guide_id(task);
    details.language = selection.report.language;
    for (const ordered_json& word : content.at("words")) {
      details.words.push_back({word.at("word").get<std::string>(), word.at("start").get<double>(),
                               word.at("end").get<double>()});
    }
    annotations.paths.push_back(std::move(path));
  }
  return tasks::to_text(annotations);
}

std::string cvdn_json(const Selection& selection, const graph::GraphSet& graphs) {
  std::vector<ordered_json> entries;
  for (const Assignment& task : tasks_of(selection)) {
    if (task.role != "navigator") continue;
    for (ordered_json& one : kinds::cvdn_instances(task, graphs)) entries.push_back(std::move(one));
  }
  return list_lines(entries);
}

}  // namespace

std::string annotations_json(const Selection& selection, const graph::GraphSet& graphs) {
  const WorkKind kind = selection.report.kind;
  if (kind == WorkKind::kDescribe || kind == WorkKind::kFind) return reverie_json(selection);
  if (kind == WorkKind::kGuide) return rxr_lines(selection);
  if (kind == WorkKind::kDialogue) return cvdn_json(selection, graphs);
  return r2r_json(selection);
}

std::string dialogues_json(const Selection& selection) {
  std::map<std::int64_t, ordered_json> dialogues;
  for (const Assignment& task : tasks_of(selection)) {
    const ordered_json content = ordered_json::parse(task.content);
    const auto id = content.at("dialogue").get<std::int64_t>();
    ordered_json& one = dialogues[id];
    if (one.is_null()) {
      one = {{"dialogue", id},
             {"path_id", task.item.path_id},
             {"scan", task.item.scan},
             {"target", task.item.target},
             {"end_panos", task.item.region},
             {"workers", ordered_json::object()},
             {"submitted", detail::iso_time(task.submitted)},
             {"metres_from_goal", task.error ? ordered_json(*task.error) : ordered_json()},
             {"turns", content.at("turns")}};
    }
    one["workers"][task.role] = task.worker;
  }
  std::vector<ordered_json> entries;
  for (auto& [id, one] : dialogues) entries.push_back(std::move(one));
  return list_lines(entries);
}

std::string results_json(const Selection& selection) {
  return list_walks(selection, [](ordered_json& one, const Assignment& task) {
    one["trajectory"] = detail::json_list(steps_of(task), [](const auto& step) {
      return ordered_json{step["viewpoint"], step["heading"], step["elevation"]};
    });
    if (task.kind == WorkKind::kFind) {
      one["predObjId"] = ordered_json::parse(task.content).at("object");
    }
  });
}

std::string walks_json(const Selection& selection) {
  return list_walks(selection, [](ordered_json& one, const Assignment& task) {
    one["scan"] = task.item.scan;
    one["worker"] = task.worker;
    add_times(one, task);
    if (!task.camera.empty()) one["camera"] = ordered_json::parse(task.camera);
    if (task.kind == WorkKind::kFind) one["point"] = ordered_json::parse(task.content).at("point");
    one["steps"] = steps_of(task);
  });
}

std::string traces_zip(const Selection& selection, const graph::GraphSet& graphs) {
  constexpr Radians kHigh(std::numbers::pi / 3);
  constexpr double kAspect = 4.0 / 3;
  std::vector<scan::ZipEntry> files;
  for (const Assignment& task : tasks_of(selection)) {
    const graph::NavGraph& graph = graphs.graph(task.item.scan);
    tasks::PoseTrace trace;
    for (const ordered_json& step : steps_of(task)) {
      const auto viewpoint = step.at("viewpoint").get<std::string>();
      const Vec3f at = graph.position(graph.find(viewpoint).value());
      trace.snapshots.push_back(tasks::snapshot_of(viewpoint, step.at("seconds").get<double>(),
                                                   {{at.x, at.y, at.z},
                                                    Radians(step.at("heading").get<double>()),
                                                    Radians(step.at("elevation").get<double>()),
                                                    kHigh,
                                                    kAspect}));
    }
    files.push_back({tasks::pose_trace_name(tasks::TraceRole::kGuide, task.id), to_npz(trace)});
  }
  return scan::zip(files);
}

std::string tasks_json(store::Database& db, const ExportedSplit& exported) {
  std::vector<ordered_json> entries;
  for (const Assignment& task : submitted_of(db, exported)) {
    ordered_json one{{"task", task.id},
                     {"state", enum_name(task.state)},
                     {"path_id", task.item.path_id},
                     {"number", task.item.number},
                     {"worker", task.worker}};
    if (task.item.practice) one["practice"] = true;
    add_times(one, task);
    if (!task.flags.empty()) one["flags"] = task.flags;
    if (!task.reason.empty()) one["reason"] = task.reason;
    if (is_written(task.kind)) one["instruction"] = task.content;
    if (!task.role.empty()) one["role"] = task.role;
    entries.push_back(std::move(one));
  }
  return list_lines(entries);
}

}  // namespace enfilade::service::collecting
