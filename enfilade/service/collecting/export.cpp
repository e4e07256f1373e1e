#include "enfilade/service/collecting/export.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "enfilade/service/detail/clock.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

r2r::PathAnnotation annotation_of(const Item& item) {
  return {item.path_id, item.scan, item.heading, item.path, item.distance, {}};
}

/// The first walk of each instruction, of the paths that have all of theirs.
std::vector<Task> whole_walks(store::Database& database, const Collection& collection,
                              const std::string& split, Reviewed reviewed) {
  std::vector<Task> walks;
  std::set<std::int64_t> walked;
  for (Task& task : work_of(database, collection.id, split, reviewed)) {
    if (walked.insert(task.item.id).second) walks.push_back(std::move(task));
  }
  std::set<std::int64_t> incomplete;  // path ids
  for (const Item& item : items_of(database, collection.id, split)) {
    if (!walked.contains(item.id)) incomplete.insert(item.path_id);
  }
  std::erase_if(walks, [&](const Task& task) { return incomplete.contains(task.item.path_id); });
  return walks;
}

/// A path of each run of tasks that have it in common. \param text the instruction of a task
template <class Text>
r2r::Annotations by_path(const std::string& split, const std::vector<Task>& tasks,
                         const Text& text) {
  r2r::Annotations annotations{split, "", {}};
  auto& paths = annotations.paths;
  for (const Task& task : tasks) {
    if (paths.empty() || paths.back().path_id != task.item.path_id) {
      paths.push_back(annotation_of(task.item));
    }
    paths.back().instructions.push_back(text(task));
  }
  return annotations;
}

/// [a, b, ...], a line each.
std::string list_of(const std::vector<std::string>& entries) {
  std::string out = "[";
  for (const std::string& entry : entries) out += (out.size() > 1 ? ",\n" : "\n") + entry;
  return out + "\n]\n";
}

std::string instruction_id(const Item& item) {
  return r2r::instruction_id(item.path_id, item.number);
}

}  // namespace

std::string annotations_json(store::Database& database, const Collection& collection,
                             const std::string& split, Reviewed reviewed) {
  if (collection.kind == Kind::kWrite) {
    return r2r::to_json(by_path(split, work_of(database, collection.id, split, reviewed),
                                [](const Task& task) { return task.content; }));
  }
  return r2r::to_json(by_path(split, whole_walks(database, collection, split, reviewed),
                              [](const Task& task) { return task.item.instruction; }));
}

std::string results_json(store::Database& database, const Collection& collection,
                         const std::string& split, Reviewed reviewed) {
  std::vector<std::string> entries;
  for (const Task& task : whole_walks(database, collection, split, reviewed)) {
    auto trajectory = ordered_json::array();
    for (const auto& step : ordered_json::parse(task.content)) {
      trajectory.push_back({step["viewpoint"], step["heading"], step["elevation"]});
    }
    entries.push_back(
        ordered_json{{"instr_id", instruction_id(task.item)}, {"trajectory", trajectory}}.dump());
  }
  return list_of(entries);
}

std::string walks_json(store::Database& database, const Collection& collection,
                       const std::string& split, Reviewed reviewed) {
  std::vector<std::string> entries;
  for (const Task& task : whole_walks(database, collection, split, reviewed)) {
    ordered_json one{{"instr_id", instruction_id(task.item)},
                     {"scan", task.item.scan},
                     {"worker", task.worker},
                     {"submitted", detail::iso_time(task.submitted)},
                     {"seconds", task.seconds}};
    if (!task.camera.empty()) one["camera"] = ordered_json::parse(task.camera);
    one["steps"] = ordered_json::parse(task.content);
    entries.push_back(one.dump());
  }
  return list_of(entries);
}

}  // namespace enfilade::service::collecting
