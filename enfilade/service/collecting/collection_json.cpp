#include "enfilade/service/collecting/collection_json.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/names.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

/// How the worker tells the platform that the visit is finished.
ordered_json completion_json(const Platform& platform, const Visit& visit) {
  ordered_json out{{"kind", detail::name_of(platform.kind)}};
  if (platform.kind == PlatformKind::kMturk) {
    out["action"] = visit.submit_to + "/mturk/externalSubmit";
    // MTurk refuses a form that has nothing but the assignment.
    out["fields"] = {{"assignmentId", visit.assignment},
                     {"visit", std::to_string(visit.id)},
                     {"tasks", std::to_string(visit.done)}};
  } else if (platform.kind == PlatformKind::kProlific) {
    out["url"] = "https://app.prolific.com/submissions/complete?cc=" + platform.completion_code;
    out["code"] = platform.completion_code;
  }
  return out;
}

}  // namespace

ordered_json collection_json(const Collection& collection, bool synthetic) {
  return {{"collection", collection.name},
          {"title", collection.title},
          {"kind", detail::name_of(collection.kind)},
          {"state", collection.open ? "open" : "closed"},
          {"platform", {{"kind", detail::name_of(collection.platform.kind)}}},
          {"consent", collection.consent},
          {"instructions", collection.instructions},
          {"synthetic", synthetic}};
}

ordered_json progress_json(store::Database& db, const Collection& collection) {
  const auto split_json = [](const SplitSize& split) {
    return ordered_json{
        {"split", split.split}, {"items", split.items}, {"goals_hidden", split.secret}};
  };
  const Progress progress = progress_of(db, collection.id);
  return {{"created", detail::iso_time(collection.created)},
          {"per_item", collection.per_item},
          {"lease_minutes", collection.lease_seconds / 60},
          {"tasks_per_visit", collection.tasks_per_visit},
          {"splits", detail::json_list(splits_of(db, collection.id), split_json)},
          {"progress",
           {{"items", progress.items},
            {"places", progress.items * collection.per_item},
            {"leased", progress.leased},
            {"submitted", progress.submitted},
            {"accepted", progress.accepted},
            {"rejected", progress.rejected},
            {"complete", progress.complete},
            {"workers", progress.workers}}}};
}

ordered_json platform_json(const Platform& platform) {
  ordered_json out{{"kind", detail::name_of(platform.kind)}};
  if (platform.kind == PlatformKind::kMturk) out["origins"] = platform.origins;
  if (platform.kind == PlatformKind::kProlific) out["completion_code"] = platform.completion_code;
  return out;
}

ordered_json visit_summary_json(const VisitSummary& visit) {
  return {{"visit", visit.visit},         {"worker", visit.worker},
          {"external", visit.external},   {"assignment", visit.assignment},
          {"group", visit.group},         {"created", detail::iso_time(visit.created)},
          {"submitted", visit.submitted}, {"accepted", visit.accepted},
          {"rejected", visit.rejected},   {"bonuses", visit.bonuses},
          {"finished", visit.finished}};
}

std::string visits_csv(const std::vector<VisitSummary>& visits) {
  std::string csv =
      "visit,worker,external,assignment,group,created,to_review,accepted,rejected,bonuses,"
      "finished\r\n";
  for (const VisitSummary& visit : visits) {
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\r\n", visit.visit, visit.worker,
                       detail::sheet_text(visit.external), detail::sheet_text(visit.assignment),
                       detail::sheet_text(visit.group), detail::iso_time(visit.created),
                       visit.submitted, visit.accepted, visit.rejected, visit.bonuses,
                       visit.finished ? 1 : 0);
  }
  return csv;
}

ordered_json visit_json(const Collection& collection, const Visit& visit,
                        const std::optional<Task>& task, bool finished) {
  ordered_json out{{"consented", visit.consented}, {"done", visit.done}};
  if (collection.tasks_per_visit > 0) out["of"] = collection.tasks_per_visit;
  out["finished"] = finished;
  out["task"] = task ? task_json(*task) : ordered_json();
  if (finished && visit.done > 0) {
    out["completion"] = completion_json(collection.platform, visit);
  }
  return out;
}

ordered_json item_json(const Item& item, Kind kind) {
  ordered_json out{
      {"kind", detail::name_of(kind)}, {"scan", item.scan}, {"heading", item.heading.value}};
  if (kind == Kind::kWrite) {
    out["path"] = item.path;
  } else {
    out["instruction"] = item.instruction;
    out["start"] = item.path.front();
  }
  return out;
}

ordered_json task_json(const Task& task) {
  ordered_json out{{"task", task.id},
                   {"state", detail::name_of(task.state)},
                   {"expires", detail::iso_time(task.expires)}};
  out.update(item_json(task.item, task.kind));
  if (!task.draft.empty()) out["draft"] = nlohmann::json::parse(task.draft);
  if (!task.reason.empty()) out["reason"] = task.reason;
  return out;
}

ordered_json work_json(const Task& task, bool secrets) {
  ordered_json out{{"task", task.id},
                   {"kind", detail::name_of(task.kind)},
                   {"state", detail::name_of(task.state)},
                   {"worker", task.worker},
                   {"split", task.item.split},
                   {"path_id", task.item.path_id},
                   {"scan", task.item.scan},
                   {"heading", task.item.heading.value}};
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

ordered_json event_json(const Event& event) {
  ordered_json out{{"when", detail::iso_time(event.at)},
                   {"who", event.who},
                   {"what", detail::name_of(event.what)}};
  if (event.what == EventKind::kEdited) out["before"] = event.before;
  if (!event.reason.empty()) out["reason"] = event.reason;
  return out;
}

}  // namespace enfilade::service::collecting
