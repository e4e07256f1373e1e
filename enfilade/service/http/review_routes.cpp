// For reviewers and organisers: what workers handed in.
#include <limits>

#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/collecting/handed_in.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/bodies.h"
#include "enfilade/service/http/work_routes.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kLongestReason = 500;

bool may_know_secrets(const Request& request) {
  return request.principal->role == accounts::Role::kOrganiser;
}

Response work_queue(Context& context, const Request& request) {
  const collecting::Collection collection =
      collecting::collection_named(*context.database, request.parameter("collection"));
  std::string state = request.text("state");
  if (state.empty()) state = "submitted";
  if (state != "submitted" && state != "accepted" && state != "rejected" && state != "all") {
    throw HttpError(400, "bad-query", "state: not submitted, accepted, rejected or all");
  }
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  const collecting::WorkPage page = collecting::list_work(*context.database, collection.id, state,
                                                          request.number("after", 0, 0, kMost),
                                                          request.number("limit", 50, 1, 200));
  auto work = ordered_json::array();
  for (const collecting::Task& task : page.tasks)
    work.push_back(collecting::work_json(task, may_know_secrets(request)));
  return json_response(ordered_json{{"matching", page.matching}, {"work", work}}.dump());
}

Response judge_work(Context& context, const Request& request) {
  const ordered_json body = parse_object(request.body);
  const std::string verdict = field(body, "verdict", true);
  const std::string reason = field(body, "reason", false);
  if (verdict != "accepted" && verdict != "rejected") {
    throw HttpError(400, "bad-body", "verdict: not \"accepted\" or \"rejected\"");
  }
  const bool rejected = verdict == "rejected";
  if (rejected ? !detail::is_prose(reason, kLongestReason) : !reason.empty()) {
    throw HttpError(400, "bad-body",
                    "reason: of a rejection, 1 to 500 printable characters; else none");
  }
  const std::int64_t id = task_id(request);
  collecting::judge(*context.database, id,
                    rejected ? collecting::Verdict::kRejected : collecting::Verdict::kAccepted,
                    reason, request.principal->name, context.clock());
  return work_response(context, request, id);
}

Response correct(Context& context, const Request& request) {
  const std::string instruction = field(parse_object(request.body), "instruction", true);
  collecting::check_instruction(instruction, "$.instruction");
  const std::int64_t id = task_id(request);
  if (collecting::find_work(*context.database, id).kind != collecting::Kind::kWrite) {
    throw HttpError(409, "a-walk", "it is a walk, and has no instruction of its own");
  }
  collecting::edit(*context.database, id, instruction, request.principal->name, context.clock());
  return work_response(context, request, id);
}

}  // namespace

Response work_response(Context& context, const Request& request, std::int64_t id) {
  const collecting::Task task = collecting::find_work(*context.database, id);
  ordered_json out = collecting::work_json(task, may_know_secrets(request));
  if (task.kind == collecting::Kind::kWalk) out["steps"] = ordered_json::parse(task.content);
  out["history"] = collecting::events_json(collecting::events_of(*context.database, id));
  return json_response(out.dump());
}

void add_review_routes(Router& router, Context& context) {
  router.add({"GET", "/api/v1/collections/{collection}/work", Access::kReviewer,
              [&context](const Request& request) { return work_queue(context, request); }});
  router.add({"PUT", "/api/v1/tasks/{task}/review", Access::kReviewer,
              [&context](const Request& request) { return judge_work(context, request); }});
  router.add({"PUT", "/api/v1/tasks/{task}/instruction", Access::kReviewer,
              [&context](const Request& request) { return correct(context, request); }});
}

}  // namespace enfilade::service::http
