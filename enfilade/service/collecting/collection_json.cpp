#include "enfilade/service/collecting/collection_json.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/core/enum_names.h"
#include "enfilade/service/collecting/quality.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::collecting {
namespace {

using nlohmann::ordered_json;

/// How the worker tells the platform that the visit is finished.
/// \param code of Prolific
ordered_json completion_json(const Platform& platform, const Visit& visit,
                             const std::string& code) {
  ordered_json out{{"kind", enum_name(platform.kind)}};
  if (platform.kind == PlatformKind::kMturk) {
    out["action"] = visit.submit_to + "/mturk/externalSubmit";
    // MTurk refuses a form that has nothing but the assignment.
    out["fields"] = {{"assignmentId", visit.assignment},
                     {"visit", std::to_string(visit.id)},
                     {"tasks", std::to_string(visit.done)}};
  } else if (platform.kind == PlatformKind::kProlific) {
    out["url"] = "https://app.prolific.com/submissions/complete?cc=" + code;
    out["code"] = code;
  }
  return out;
}

/// Without the answers that are right.
ordered_json question_json(const Question& question) {
  return {{"question", question.id}, {"text", question.text}, {"choices", question.choices}};
}

ordered_json asked_json(const Question& question) {
  return {
      {"question", question.text}, {"choices", question.choices}, {"accept", question.accepted}};
}

/// {"name", "outlines"}. \param viewpoints those whose outlines are given; null: all
ordered_json object_json(const WorkItem& item, const std::vector<std::string>* viewpoints) {
  ordered_json outlines = ordered_json::object();
  if (!item.outlines.empty()) {
    const ordered_json all = ordered_json::parse(item.outlines);
    for (const auto& [viewpoint, list] : all.items()) {
      const bool told =
          viewpoints == nullptr || std::ranges::find(*viewpoints, viewpoint) != viewpoints->end();
      if (told) outlines[viewpoint] = list;
    }
  }
  return {{"name", item.target}, {"outlines", std::move(outlines)}};
}

/// More tasks than that are not counted for a worker, who will not do them today; counting them
/// would take a millisecond of each answer.
constexpr std::int64_t kMostCounted = 100;

constexpr std::size_t kMostDays = 60;  ///< of a study's progress

/// Rules, splits and progress.
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
          {"check_every", collection.check_every},
          {"seed", collection.seed},
          {"splits", detail::json_list(splits_of(db, collection.id), split_json)},
          {"progress",
           {{"items", progress.items},
            {"places", progress.items * collection.per_item},
            {"leased", progress.leased},
            {"submitted", progress.submitted},
            {"accepted", progress.accepted},
            {"rejected", progress.rejected},
            {"complete", progress.complete},
            {"workers", progress.workers},
            {"minutes", progress.minutes},
            {"days", detail::json_list(days_of(db, collection.id, kMostDays), day_json)}}}};
}

/// {"screening", "checks"} with the right answers.
ordered_json questions_json(store::Database& db, const Collection& collection) {
  ordered_json out{{"screening", ordered_json::array()}, {"checks", ordered_json::array()}};
  for (const Question& one : questions_of(db, collection.id)) {
    out[one.stage == QuestionStage::kScreening ? "screening" : "checks"].push_back(asked_json(one));
  }
  return out;
}

ordered_json platform_json(const Platform& platform) {
  ordered_json out{{"kind", enum_name(platform.kind)}};
  if (platform.kind == PlatformKind::kMturk) out["origins"] = platform.origins;
  if (platform.kind == PlatformKind::kProlific) {
    out["completion_code"] = platform.completion_code;
    if (!platform.screen_out_code.empty()) out["screen_out_code"] = platform.screen_out_code;
  }
  return out;
}

/// Path and query of the page for workers, with the key and the platform's placeholders.
std::string link_of(const Collection& collection) {
  // What Prolific fills in. MTurk adds its parameters itself.
  constexpr std::string_view kProlific =
      "&PROLIFIC_PID={{%PROLIFIC_PID%}}&STUDY_ID={{%STUDY_ID%}}&SESSION_ID={{%SESSION_ID%}}";
  return fmt::format("/{}?collection={}&key={}{}", shows_path(collection.kind) ? "collect" : "walk",
                     collection.name, collection.key,
                     collection.platform.kind == PlatformKind::kProlific ? kProlific : "");
}

}  // namespace

ordered_json collection_json(store::Database& db, const Collection& collection, bool synthetic,
                             std::optional<TokenRole> reader) {
  ordered_json out{{"collection", collection.name},
                   {"title", collection.title},
                   {"kind", enum_name(collection.kind)},
                   {"state", enum_name(collection.state())},
                   {"platform", {{"kind", enum_name(collection.platform.kind)}}},
                   {"consent", collection.consent},
                   {"instructions", collection.instructions},
                   {"synthetic", synthetic}};
  if (collection.kind == WorkKind::kGuide) out["language"] = collection.language;
  // What a worker wants to know before agreeing.
  if (!collection.pay.empty()) out["pay"] = collection.pay;
  if (collection.minutes > 0) out["minutes"] = collection.minutes;
  const bool organiser = reader == TokenRole::kOrganiser;
  if (organiser || reader == TokenRole::kReviewer) out.update(progress_json(db, collection));
  if (organiser) {
    out["platform"] = platform_json(collection.platform);
    out.update(questions_json(db, collection));
    out["link"] = link_of(collection);
  }
  return out;
}

ordered_json visit_summary_json(const VisitSummary& visit) {
  return {{"visit", visit.visit},
          {"worker", visit.worker},
          {"external", visit.external},
          {"assignment", visit.assignment},
          {"group", visit.group},
          {"created", detail::iso_time(visit.created)},
          {"submitted", visit.submitted},
          {"accepted", visit.accepted},
          {"rejected", visit.rejected},
          {"bonuses", visit.bonuses},
          {"finished", visit.finished},
          {"seconds", visit.seconds},
          {"checks", visit.checks},
          {"checks_failed", visit.checks_failed},
          {"screened_out", visit.screened_out}};
}

std::string visits_csv(const std::vector<VisitSummary>& visits) {
  std::string csv =
      "visit,worker,external,assignment,group,created,to_review,accepted,rejected,bonuses,"
      "finished,seconds,checks,checks_failed,screened_out\r\n";
  for (const VisitSummary& visit : visits) {
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\r\n", visit.visit,
                       visit.worker, detail::sheet_text(visit.external),
                       detail::sheet_text(visit.assignment), detail::sheet_text(visit.group),
                       detail::iso_time(visit.created), visit.submitted, visit.accepted,
                       visit.rejected, visit.bonuses, visit.finished ? 1 : 0, visit.seconds,
                       visit.checks, visit.checks_failed, visit.screened_out ? 1 : 0);
  }
  return csv;
}

ordered_json visit_json(store::Database& db, const Collection& collection, std::int64_t id,
                        std::optional<bool> finished) {
  const auto held = db.hold();
  const Visit visit = get_visit(db, id);
  const std::optional<Assignment> task = held_task(db, visit);
  const std::int64_t most = collection.tasks_per_visit;
  const std::int64_t open =
      count_open_items(db, collection, visit.worker, most > 0 ? most : kMostCounted);
  const std::int64_t all = visit.done + (task && !task->item.practice ? 1 : 0) + open;
  const std::int64_t practice = count_practice(db, collection, visit.worker);
  const bool had_all = is_finished(collection, visit);
  ordered_json out{{"consented", visit.consented}, {"done", visit.done}};
  if (most > 0 || open < kMostCounted) out["of"] = most > 0 ? std::min(most, all) : all;
  if (practice > 0) out["practice"] = practice;
  out["finished"] = finished.value_or(had_all);
  out["task"] = task ? task_json(*task) : ordered_json();
  if (visit.consented && !task && !had_all && open + practice > 0) {
    const auto questions = pending_questions_of(db, collection, visit);
    if (!questions.empty()) out["questions"] = detail::json_list(questions, question_json);
  }
  if (const auto rejected = rejected_of(db, visit); !rejected.empty()) {
    out["rejected"] = detail::json_list(rejected, [](const Assignment& one) {
      return ordered_json{{"task", one.id},
                          {"path_id", one.item.path_id},
                          {"submitted", detail::iso_time(one.submitted)},
                          {"reason", one.reason}};
    });
  }
  // Only once knowing them helps with no other task.
  if (is_followed(collection.kind) && visit.done_by_worker > 0 &&
      has_had_all(db, collection, visit)) {
    out["bonuses"] = visit.bonuses;
  }
  const Platform& platform = collection.platform;
  if (is_screened_out(db, visit.worker)) {
    out["screened_out"] = true;
    if (!platform.screen_out_code.empty()) {
      out["completion"] = completion_json(platform, visit, platform.screen_out_code);
    }
  } else if (finished.value_or(had_all) && visit.done > 0) {
    out["completion"] = completion_json(platform, visit, platform.completion_code);
  }
  return out;
}

ordered_json item_json(const WorkItem& item, WorkKind kind) {
  ordered_json out{{"kind", enum_name(kind)}, {"scan", item.scan}, {"heading", item.heading.value}};
  if (shows_path(kind)) {
    out["path"] = item.path;
  } else {
    if (is_followed(kind)) out["instruction"] = item.instruction;
    out["start"] = item.path.front();
  }
  if (kind == WorkKind::kDescribe) out["object"] = object_json(item, &item.path);
  if (kind == WorkKind::kDialogue) out["target"] = item.target;
  return out;
}

ordered_json task_json(const Assignment& task) {
  ordered_json out{{"task", task.id},
                   {"state", enum_name(task.state)},
                   {"expires", detail::iso_time(task.expires)}};
  if (task.item.practice) out["practice"] = true;
  out.update(item_json(task.item, task.kind));
  if (!task.role.empty()) {
    out["role"] = task.role;
    // The oracle knows what the navigator looks for.
    if (task.role == "oracle") out["object"] = object_json(task.item, nullptr);
  }
  if (!task.draft.empty()) out["draft"] = nlohmann::json::parse(task.draft);
  if (!task.reason.empty()) out["reason"] = task.reason;
  return out;
}

ordered_json practice_json(const Assignment& task) {
  ordered_json out = ordered_json::object();
  if (shows_path(task.kind)) {
    if (!task.item.instruction.empty()) out["example"] = task.item.instruction;
  } else if (!task.item.secret) {
    out["reached"] = task.bonus();
    if (task.kind == WorkKind::kWalk && std::isfinite(task.error.value_or(0))) {
      out["distance"] = task.error.value_or(0);
    }
  }
  return out;
}

void add_times(ordered_json& out, const Assignment& task) {
  if (task.leased > 0) out["leased"] = detail::iso_time(task.leased);
  out["submitted"] = detail::iso_time(task.submitted);
  if (const auto seconds = task.server_seconds()) out["seconds"] = *seconds;
  out["page_seconds"] = task.seconds;
}

ordered_json work_summary_json(const WorkSummary& work, SummaryBy by) {
  ordered_json out{{by == SummaryBy::kWorker ? "worker" : "path_id", work.id},
                   {"submitted", work.submitted},
                   {"accepted", work.accepted},
                   {"rejected", work.rejected},
                   {"flagged", work.flagged},
                   {"mean_seconds", work.mean_seconds}};
  if (by == SummaryBy::kWorker) {
    out["checks"] = work.checks;
    out["checks_failed"] = work.checks_failed;
  }
  return out;
}

ordered_json work_json(const Assignment& task, bool secrets) {
  ordered_json out{{"task", task.id},
                   {"kind", enum_name(task.kind)},
                   {"state", enum_name(task.state)},
                   {"worker", task.worker},
                   {"split", task.item.split},
                   {"path_id", task.item.path_id},
                   {"scan", task.item.scan},
                   {"heading", task.item.heading.value}};
  if (shows_path(task.kind)) {
    out["path"] = task.item.path;
    out["instruction"] = is_written(task.kind)
                             ? ordered_json(task.content)
                             : ordered_json::parse(task.content).at("instruction");
  } else {
    if (is_followed(task.kind)) out["instruction"] = task.item.instruction;
    out["start"] = task.item.path.front();
    if (secrets || !task.item.secret) out["bonus"] = task.bonus();
    if (!task.camera.empty()) out["camera"] = ordered_json::parse(task.camera);
  }
  if (!task.role.empty()) out["role"] = task.role;
  if (has_target(task.kind)) {
    out["object"] = object_json(task.item, nullptr);
    if (task.item.object) out["object"]["object"] = *task.item.object;
  }
  add_times(out, task);
  if (!task.flags.empty()) out["flags"] = task.flags;
  if (!task.reason.empty()) out["reason"] = task.reason;
  return out;
}

void add_content(ordered_json& out, store::Database& db, const Assignment& task) {
  if (task.kind == WorkKind::kDescribe) {
    const Verified verified = verified_of(db, task.id);
    out["verified"] = {{"walked", verified.walked}, {"found", verified.found}};
  }
  if (is_written(task.kind)) return;
  const ordered_json content = ordered_json::parse(task.content);
  if (task.kind == WorkKind::kWalk) {
    out["steps"] = content;
  } else if (task.kind == WorkKind::kFind) {
    out["steps"] = content.at("steps");
    out["point"] = content.at("point");
    out["pointed_at"] = content.at("object");
  } else if (task.kind == WorkKind::kGuide) {
    for (const char* name : {"words", "steps", "spoken"}) out[name] = content.at(name);
  } else {
    out["dialogue"] = content.at("dialogue");
    out["turns"] = content.at("turns");
  }
}

ordered_json event_json(const Event& event) {
  ordered_json out{
      {"when", detail::iso_time(event.at)}, {"who", event.who}, {"what", enum_name(event.what)}};
  if (event.what == EventKind::kEdited) out["before"] = event.before;
  if (!event.reason.empty()) out["reason"] = event.reason;
  return out;
}

}  // namespace enfilade::service::collecting
