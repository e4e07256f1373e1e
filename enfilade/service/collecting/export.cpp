#include "enfilade/service/collecting/export.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

r2r::PathAnnotation annotation_of(const Item& item) {
  return {item.path_id, item.scan, item.heading, item.path, item.distance, {}};
}

/// The first walk of each instruction, of the paths that have all of theirs.
std::vector<Task> whole_walks(store::Database& db, const Collection& collection,
                              const std::string& split, Reviewed reviewed) {
  std::vector<Task> walks;
  std::set<std::int64_t> walked;
  for (Task& task : work_of(db, collection.id, split, reviewed)) {
    if (walked.insert(task.item.id).second) walks.push_back(std::move(task));
  }
  std::set<std::int64_t> incomplete;  // path ids
  for (const Item& item : items_of(db, collection.id, split)) {
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

/// The whole walks as [a, b, ...], a line each. \param add what a walk's object has besides its id
template <class Add>
std::string list_walks(store::Database& db, const Collection& collection, const std::string& split,
                       Reviewed reviewed, const Add& add) {
  std::string out = "[";
  for (const Task& task : whole_walks(db, collection, split, reviewed)) {
    ordered_json one{{"instr_id", r2r::instruction_id(task.item.path_id, task.item.number)}};
    add(one, task);
    out += (out.size() > 1 ? ",\n" : "\n") + one.dump();
  }
  return out + "\n]\n";
}

}  // namespace

std::string annotations_json(store::Database& db, const Collection& collection,
                             const std::string& split, Reviewed reviewed) {
  if (collection.kind == Kind::kWrite) {
    return r2r::to_json(by_path(split, work_of(db, collection.id, split, reviewed),
                                [](const Task& task) { return task.content; }));
  }
  return r2r::to_json(by_path(split, whole_walks(db, collection, split, reviewed),
                              [](const Task& task) { return task.item.instruction; }));
}

std::string results_json(store::Database& db, const Collection& collection,
                         const std::string& split, Reviewed reviewed) {
  return list_walks(db, collection, split, reviewed, [](ordered_json& one, const Task& task) {
    one["trajectory"] = detail::json_list(ordered_json::parse(task.content), [](const auto& step) {
      return ordered_json{step["viewpoint"], step["heading"], step["elevation"]};
    });
  });
}

std::string walks_json(store::Database& db, const Collection& collection, const std::string& split,
                       Reviewed reviewed) {
  return list_walks(db, collection, split, reviewed, [](ordered_json& one, const Task& task) {
    one["scan"] = task.item.scan;
    one["worker"] = task.worker;
    one["submitted"] = detail::iso_time(task.submitted);
    one["seconds"] = task.seconds;
    if (!task.camera.empty()) one["camera"] = ordered_json::parse(task.camera);
    one["steps"] = ordered_json::parse(task.content);
  });
}

}  // namespace enfilade::service::collecting
