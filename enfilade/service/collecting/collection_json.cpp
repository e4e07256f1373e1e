#include "enfilade/service/collecting/collection_json.h"

#include "enfilade/service/detail/clock.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

/// What of an item is shown to who is to work on it.
ordered_json shown_item(const Item& item, Kind kind) {
  ordered_json out{{"kind", to_string(kind)}, {"scan", item.scan}, {"heading", item.heading.value}};
  if (kind == Kind::kWrite) {
    out["path"] = item.path;
  } else {
    out["instruction"] = item.instruction;
    out["start"] = item.path.front();
  }
  return out;
}

}  // namespace

ordered_json collection_json(const Collection& collection, bool synthetic) {
  return {{"collection", collection.name},
          {"title", collection.title},
          {"kind", to_string(collection.kind)},
          {"state", collection.open ? "open" : "closed"},
          {"platform", {{"kind", to_string(collection.platform.kind)}}},
          {"consent", collection.consent},
          {"instructions", collection.instructions},
          {"synthetic", synthetic}};
}

ordered_json example_json(const Item& item, Kind kind) { return shown_item(item, kind); }

ordered_json task_json(const Task& task) {
  ordered_json out{
      {"task", task.id}, {"state", task.state}, {"expires", detail::iso_time(task.expires)}};
  out.update(shown_item(task.item, task.kind));
  if (!task.draft.empty()) out["draft"] = nlohmann::json::parse(task.draft);
  if (!task.reason.empty()) out["reason"] = task.reason;
  return out;
}

ordered_json completion_json(const Completion& completion) {
  ordered_json out{{"kind", to_string(completion.kind)}};
  if (!completion.action.empty()) out["action"] = completion.action;
  for (const auto& [name, value] : completion.fields) out["fields"][name] = value;
  if (!completion.url.empty()) out["url"] = completion.url;
  if (!completion.code.empty()) out["code"] = completion.code;
  return out;
}

ordered_json work_json(const Task& task, bool secrets) {
  ordered_json out{{"task", task.id},          {"kind", to_string(task.kind)},
                   {"state", task.state},      {"worker", task.worker},
                   {"split", task.item.split}, {"path_id", task.item.path_id},
                   {"scan", task.item.scan},   {"heading", task.item.heading.value}};
  if (task.kind == Kind::kWrite) {
    out["path"] = task.item.path;
    out["instruction"] = task.content;
  } else {
    out["instruction"] = task.item.instruction;
    out["start"] = task.item.path.front();
    if (secrets || !task.item.secret) out["bonus"] = task.bonus();
    if (!task.camera.empty()) out["camera"] = ordered_json::parse(task.camera);
  }
  out["submitted"] = detail::iso_time(task.submitted);
  out["seconds"] = task.seconds;
  if (!task.flags.empty()) out["flags"] = task.flags;
  if (!task.reason.empty()) out["reason"] = task.reason;
  return out;
}

ordered_json events_json(const std::vector<Event>& events) {
  auto list = ordered_json::array();
  for (const Event& event : events) {
    ordered_json one{
        {"when", detail::iso_time(event.at)}, {"who", event.who}, {"what", event.what}};
    if (event.what == "edited") one["before"] = event.before;
    if (!event.reason.empty()) one["reason"] = event.reason;
    list.push_back(std::move(one));
  }
  return list;
}

}  // namespace enfilade::service::collecting
