#include "enfilade/service/collecting/export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

/// The first walk of each instruction, only of paths whose instructions were all walked.
void keep_whole_walks(const std::vector<Item>& items, Selection& selection) {
  std::set<std::int64_t> walked;
  const std::size_t before = selection.tasks.size();
  std::erase_if(selection.tasks,
                [&](const Task& task) { return !walked.insert(task.item.id).second; });
  const std::size_t once = selection.tasks.size();
  std::set<std::int64_t> incomplete;  // path ids
  for (const Item& item : items) {
    if (!walked.contains(item.id)) incomplete.insert(item.path_id);
  }
  std::erase_if(selection.tasks,
                [&](const Task& task) { return incomplete.contains(task.item.path_id); });
  selection.report.repeated = static_cast<std::int64_t>(before - once);
  selection.report.incomplete = static_cast<std::int64_t>(once - selection.tasks.size());
}

/// \throws Refusal kConflict if there are none
const std::vector<Task>& tasks_of(const Selection& selection) {
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

/// The walks as [a, b, ...], one a line. \param add adds the other fields of a walk
template <class Add>
std::string list_walks(const Selection& selection, const Add& add) {
  std::vector<ordered_json> entries;
  for (const Task& task : tasks_of(selection)) {
    ordered_json one{{"instr_id", tasks::instruction_id(task.item.path_id, task.item.number)}};
    add(one, task);
    entries.push_back(std::move(one));
  }
  return list_lines(entries);
}

}  // namespace

std::string ExportReport::summary() const {
  const bool written = kind == Kind::kWrite;
  std::string text = fmt::format("{} of {} {}", exported_items, items,
                                 written ? "paths have directions" : "instructions have a walk");
  std::vector<std::string> parts;
  const auto add = [&parts](std::int64_t count, const char* what) {
    if (count > 0) parts.push_back(fmt::format("{} {}", count, what));
  };
  add(waiting, "not reviewed yet");
  add(rejected, "rejected");
  add(repeated, "later walks of the same instruction");
  add(incomplete, "of paths with an instruction that nobody has walked");
  if (!parts.empty()) {
    text += fmt::format("; {} {}{} left out: {}", left_out(), written ? "text" : "walk",
                        left_out() == 1 ? " is" : "s are", fmt::join(parts, ", "));
  }
  return text;
}

Selection select_work(store::Database& db, const ExportedSplit& exported) {
  const auto held = db.hold();
  const std::vector<Item> items = items_of(db, exported.collection.id, exported.split);
  Selection selection{work_of(db, exported), {exported.split, exported.collection.kind}};
  ExportReport& report = selection.report;
  const auto count = [&](TaskState state) {
    return db.find_number(
        "SELECT count(*) FROM task JOIN item ON item.id = task.item WHERE collection = ? AND split "
        "= ? AND practice = 0 AND task.state = ?",
        exported.collection.id, exported.split, state);
  };
  report.waiting = exported.with_waiting ? 0 : count(TaskState::kSubmitted);
  report.rejected = count(TaskState::kRejected);
  if (report.kind == Kind::kWalk) keep_whole_walks(items, selection);
  std::set<std::int64_t> paths, exported_items, exported_paths;
  for (const Item& item : items) paths.insert(item.path_id);
  for (const Task& task : selection.tasks) {
    exported_items.insert(task.item.id);
    exported_paths.insert(task.item.path_id);
  }
  const auto size = [](const auto& of) { return static_cast<std::int64_t>(of.size()); };
  selection.secret = std::ranges::any_of(items, &Item::secret);
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

std::string annotations_json(const Selection& selection) {
  const bool written = selection.report.kind == Kind::kWrite;
  tasks::Annotations annotations{selection.report.split, "", {}};
  auto& paths = annotations.paths;
  for (const Task& task : tasks_of(selection)) {
    const Item& item = task.item;
    if (paths.empty() || paths.back().path_id != item.path_id) {  // tasks are sorted by item
      paths.push_back({item.path_id, item.scan, item.heading, item.path, item.distance, {}});
    }
    paths.back().instructions.push_back(written ? task.content : item.instruction);
  }
  return tasks::to_json(annotations);
}

std::string results_json(const Selection& selection) {
  return list_walks(selection, [](ordered_json& one, const Task& task) {
    one["trajectory"] = detail::json_list(ordered_json::parse(task.content), [](const auto& step) {
      return ordered_json{step["viewpoint"], step["heading"], step["elevation"]};
    });
  });
}

std::string walks_json(const Selection& selection) {
  return list_walks(selection, [](ordered_json& one, const Task& task) {
    one["scan"] = task.item.scan;
    one["worker"] = task.worker;
    add_times(one, task);
    if (!task.camera.empty()) one["camera"] = ordered_json::parse(task.camera);
    one["steps"] = ordered_json::parse(task.content);
  });
}

std::string tasks_json(store::Database& db, const ExportedSplit& exported) {
  std::vector<ordered_json> entries;
  for (const Task& task : submitted_of(db, exported)) {
    ordered_json one{{"task", task.id},
                     {"state", detail::name_of(task.state)},
                     {"path_id", task.item.path_id},
                     {"number", task.item.number},
                     {"worker", task.worker}};
    if (task.item.practice) one["practice"] = true;
    add_times(one, task);
    if (!task.flags.empty()) one["flags"] = task.flags;
    if (!task.reason.empty()) one["reason"] = task.reason;
    if (task.kind == Kind::kWrite) one["instruction"] = task.content;
    entries.push_back(std::move(one));
  }
  return list_lines(entries);
}

}  // namespace enfilade::service::collecting
