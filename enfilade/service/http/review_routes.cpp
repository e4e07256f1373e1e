// For reviewers and organisers: what workers submitted.
#include <limits>
#include <nlohmann/json.hpp>

#include "enfilade/core/enum_names.h"
#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/collecting/submitted_work.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using collecting::TaskState;
using nlohmann::ordered_json;

constexpr std::size_t kLongestReason = 500;
constexpr std::int64_t kMostNumber = std::numeric_limits<std::int64_t>::max();

bool may_know_secrets(const Request& request) {
  return request.is_from(accounts::Role::kOrganiser);
}

/// A number of the query; none if it is absent.
std::optional<std::int64_t> number_of(const Request& request, std::string_view name) {
  if (request.text(name).empty()) return std::nullopt;
  return request.number(name, 0, 0, kMostNumber);
}

/// The query's state of submitted work; none: all.
std::optional<TaskState> state_of(const Request& request) {
  const std::string text = request.text("state");
  if (text.empty()) return TaskState::kSubmitted;
  if (text == "all") return std::nullopt;
  const auto state = find_enum<TaskState>(text);
  if (!state || *state < TaskState::kSubmitted) {
    throw HttpError(400, "state: not submitted, accepted, rejected or all");
  }
  return state;
}

Response list_work(Context& context, const Request& request) {
  const collecting::Collection collection = collection_of(context, request);
  const collecting::WorkPage page = collecting::list_work(
      context.db, collection.id,
      {state_of(request), number_of(request, "worker"), number_of(request, "path_id")},
      request.number("after", 0, 0, kMostNumber), request.number("limit", 50, 1, 200));
  const auto view = [&request](const collecting::Task& task) {
    return collecting::work_json(task, may_know_secrets(request));
  };
  return json_response(
      {{"matching", page.matching}, {"work", detail::json_list(page.tasks, view)}});
}

template <collecting::SummaryBy By>
Response summarise(Context& context, const Request& request) {
  const collecting::Collection collection = collection_of(context, request);
  const auto found = collecting::summarise_work(context.db, collection.id, By,
                                                request.number("after", -1, -1, kMostNumber),
                                                request.number("limit", 200, 1, 1000));
  const auto view = [](const collecting::WorkSummary& one) {
    return collecting::work_summary_json(one, By);
  };
  return json_response({{By == collecting::SummaryBy::kWorker ? "workers" : "paths",
                         detail::json_list(found, view)}});
}

Response review(Context& context, const Request& request) {
  const ordered_json body = parse_object(request.body);
  const auto verdict = find_enum<TaskState>(text_field(body, "verdict"));
  const std::string reason = text_field(body, "reason", Presence::kOptional);
  const std::string instruction = text_field(body, "instruction", Presence::kOptional);
  const bool needs_reason = verdict == TaskState::kRejected;
  if (!needs_reason && verdict != TaskState::kAccepted) {
    throw HttpError(400, "verdict: not \"accepted\" or \"rejected\"");
  }
  if (needs_reason ? !detail::is_prose(reason, kLongestReason) : !reason.empty()) {
    throw HttpError(400, "reason: of a rejection, 1 to 500 printable characters; else none");
  }
  if (!instruction.empty()) collecting::check_instruction(instruction, "$.instruction");
  const std::int64_t task = task_of(request);
  collecting::review(context.db, task, {*verdict, reason, instruction}, request.principal->name);
  return work_response(context, request, task);
}

Response edit(Context& context, const Request& request) {
  const std::string instruction = text_field(parse_object(request.body), "instruction");
  collecting::check_instruction(instruction, "$.instruction");
  const std::int64_t task = task_of(request);
  collecting::edit(context.db, task, instruction, request.principal->name);
  return work_response(context, request, task);
}

}  // namespace

Response work_response(Context& context, const Request& request, std::int64_t id) {
  const collecting::Task task = collecting::find_work(context.db, id);
  ordered_json out = collecting::work_json(task, may_know_secrets(request));
  collecting::add_content(out, context.db, task);
  out["history"] = detail::json_list(collecting::events_of(context.db, id), collecting::event_json);
  return json_response(out);
}

void add_review_routes(Router& router) {
  const std::string work = "/api/v1/collections/{collection}/work";
  const std::string task = "/api/v1/tasks/{task}";
  router.add({"GET", work, Access::kReviewer, list_work});
  router.add(
      {"GET", work + "/workers", Access::kReviewer, summarise<collecting::SummaryBy::kWorker>});
  router.add({"GET", work + "/paths", Access::kReviewer, summarise<collecting::SummaryBy::kPath>});
  router.add({"PUT", task + "/review", Access::kReviewer, review});
  router.add({"PUT", task + "/instruction", Access::kReviewer, edit});
}

}  // namespace enfilade::service::http
