#include "enfilade/service/collecting/export.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "enfilade/r2r/annotations.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

/// The first walk of each instruction, only of paths whose instructions were all walked.
std::vector<Task> whole_walks(store::Database& db, const ExportedSplit& exported) {
  std::vector<Task> walks;
  std::set<std::int64_t> walked;
  for (Task& task : work_of(db, exported)) {
    if (walked.insert(task.item.id).second) walks.push_back(std::move(task));
  }
  std::set<std::int64_t> incomplete;  // path ids
  for (const Item& item : items_of(db, exported.collection.id, exported.split)) {
    if (!walked.contains(item.id)) incomplete.insert(item.path_id);
  }
  std::erase_if(walks, [&](const Task& task) { return incomplete.contains(task.item.path_id); });
  return walks;
}

/// whole_walks() as [a, b, ...], one a line. \param add adds the other fields of a walk
template <class Add>
std::string list_walks(store::Database& db, const ExportedSplit& exported, const Add& add) {
  std::string out = "[";
  for (const Task& task : whole_walks(db, exported)) {
    ordered_json one{{"instr_id", r2r::instruction_id(task.item.path_id, task.item.number)}};
    add(one, task);
    out += (out.size() > 1 ? ",\n" : "\n") + one.dump();
  }
  return out + "\n]\n";
}

}  // namespace

std::string annotations_json(store::Database& db, const ExportedSplit& exported) {
  const bool written = exported.collection.kind == Kind::kWrite;
  r2r::Annotations annotations{exported.split, "", {}};
  auto& paths = annotations.paths;
  for (const Task& task : written ? work_of(db, exported) : whole_walks(db, exported)) {
    const Item& item = task.item;
    if (paths.empty() || paths.back().path_id != item.path_id) {  // tasks are sorted by item
      paths.push_back({item.path_id, item.scan, item.heading, item.path, item.distance, {}});
    }
    paths.back().instructions.push_back(written ? task.content : item.instruction);
  }
  return r2r::to_json(annotations);
}

std::string results_json(store::Database& db, const ExportedSplit& exported) {
  return list_walks(db, exported, [](ordered_json& one, const Task& task) {
    one["trajectory"] = detail::json_list(ordered_json::parse(task.content), [](const auto& step) {
      return ordered_json{step["viewpoint"], step["heading"], step["elevation"]};
    });
  });
}

std::string walks_json(store::Database& db, const ExportedSplit& exported) {
  return list_walks(db, exported, [](ordered_json& one, const Task& task) {
    one["scan"] = task.item.scan;
    one["worker"] = task.worker;
    one["submitted"] = detail::iso_time(task.submitted);
    one["seconds"] = task.seconds;
    if (!task.camera.empty()) one["camera"] = ordered_json::parse(task.camera);
    one["steps"] = ordered_json::parse(task.content);
  });
}

}  // namespace enfilade::service::collecting
