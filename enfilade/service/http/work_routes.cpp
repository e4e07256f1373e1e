// For workers: joining by a link, getting a task, submitting it.
#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/collecting/kinds/dialogues.h"
#include "enfilade/service/collecting/order.h"
#include "enfilade/service/collecting/submitted_work.h"
#include "enfilade/service/detail/json_limits.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using collecting::Collection;
using collecting::Task;
using collecting::Visit;
using nlohmann::ordered_json;

constexpr std::size_t kMostDraftBytes = 256U << 10U;
constexpr std::size_t kMostWorkBytes = 1U << 20U;  // 5000 steps, some 120 bytes each

Visit own_visit(Context& context, const Request& request) {
  return collecting::get_visit(context.db, request.principal->visit);
}

collecting::Parameters read_parameters(const std::string& body) {
  const ordered_json object = parse_object(body);
  const auto found = object.find("parameters");
  if (found == object.end() || !found->is_object()) {
    throw HttpError(400, "parameters: must be there, and an object");
  }
  collecting::Parameters parameters;
  for (const auto& [name, value] : found->items()) {
    parameters.emplace(name, text_field(*found, name.c_str()));
  }
  return parameters;
}

/// More tasks than that are not counted for a worker, who will not do them today; counting them
/// would take a millisecond of each answer.
constexpr std::int64_t kMostCounted = 100;

/// How the visit stands; changes nothing.
collecting::VisitState state_of(Context& context, const Collection& collection, std::int64_t id) {
  store::Database& db = context.db;
  const auto held = db.hold();
  const Visit visit = collecting::get_visit(db, id);
  collecting::VisitState state;
  state.visit = visit;
  state.task = collecting::held_task(db, visit);
  const std::int64_t held_work = state.task && !state.task->item.practice ? 1 : 0;
  const std::int64_t most = collection.tasks_per_visit;
  const std::int64_t open =
      collecting::count_open_items(db, collection, visit.worker, most > 0 ? most : kMostCounted);
  if (most > 0) {
    state.of = std::min(most, visit.done + held_work + open);
  } else if (open < kMostCounted) {
    state.of = visit.done + held_work + open;
  }
  state.practice = collecting::count_practice(db, collection, visit.worker);
  state.finished = collecting::is_finished(collection, visit);
  state.screened_out = collecting::is_screened_out(db, visit.worker);
  if (visit.consented && !state.task && !state.finished && open + state.practice > 0) {
    state.questions = collecting::pending_questions_of(db, collection, visit);
  }
  state.rejected = collecting::rejected_of(db, visit);
  if (collecting::is_followed(collection.kind) && visit.done_by_worker > 0 &&
      collecting::has_had_all(db, collection, visit)) {
    state.bonuses = visit.bonuses;
  }
  return state;
}
ordered_json visit_of(Context& context, std::int64_t id) {
  const Collection collection = collecting::collection_of_visit(context.db, id);
  return collecting::visit_json(collection, state_of(context, collection, id));
}

Response visit_response(Context& context, const Request& request) {
  return json_response(visit_of(context, request.principal->visit));
}

Response join(Context& context, const Request& request) {
  context.joins.count(request.address, context.db.now());
  const Collection collection = collection_of(context, request);
  const collecting::Parameters parameters = read_parameters(request.body);
  const auto key = parameters.find("key");
  if (key == parameters.end() || key->second != collection.key) {
    context.failures.count(request.address, context.db.now());
    throw HttpError(403, "the link is incomplete: its key is wrong");
  }
  const collecting::Arrival arrival = collecting::read_arrival(collection.platform, parameters);
  ordered_json out{
      {"preview", arrival.preview},
      {"collection", collecting::collection_json(collection, context.site->synthetic())}};
  if (arrival.preview) {
    const collecting::Item item = collecting::first_item(context.db, collection.id);
    out["example"] = collecting::item_json(item, collection.kind);
    return json_response(out);
  }
  const std::int64_t visit = collecting::join(context.db, collection, arrival);
  out["worker"] = arrival.worker;
  const std::string label =
      fmt::format("worker {}", collecting::get_visit(context.db, visit).worker);
  out["token"] = accounts::add_worker_token(context.db, visit, label);
  out["visit"] = visit_of(context, visit);
  return json_response(out);
}

Response give_consent(Context& context, const Request& request) {
  collecting::give_consent(context.db, own_visit(context, request));
  return visit_response(context, request);
}

Response next_task(Context& context, const Request& request) {
  using collecting::NoTask;
  const Visit visit = own_visit(context, request);
  const Collection collection = collecting::collection_of_visit(context.db, visit.id);
  const auto held = context.db.hold();
  const collecting::Lease lease = collecting::lease_task(context.db, collection, visit);
  collecting::VisitState state = state_of(context, collection, visit.id);
  state.finished =
      !lease.task && (lease.why == NoTask::kFinished || lease.why == NoTask::kNoneLeft);
  ordered_json out = collecting::visit_json(collection, state);
  if (!lease.task) out["why"] = enum_name(lease.why);
  return json_response(out);
}

/// {"answers": [{"question": 3, "choice": "Yes"}, ...]}
Response answer_questions(Context& context, const Request& request) {
  const ordered_json body = parse_object(request.body);
  const auto answers = body.find("answers");
  if (answers == body.end() || !answers->is_array()) {
    throw HttpError(400, "answers: must be there, and a list");
  }
  const Visit visit = own_visit(context, request);
  const Collection collection = collecting::collection_of_visit(context.db, visit.id);
  context.db.transact([&] {
    for (const ordered_json& one : *answers) {
      const auto question = one.is_object() ? one.find("question") : one.end();
      if (!one.is_object() || question == one.end() || !question->is_number_integer()) {
        throw HttpError(400, "answers: not a list of {\"question\": number, \"choice\": text}");
      }
      collecting::answer(context.db, collection.id, visit.worker, question->get<std::int64_t>(),
                         text_field(one, "choice"));
    }
  });
  return visit_response(context, request);
}

Response show_task(Context& context, const Request& request) {
  const accounts::Role role = request.known_principal().role;
  if (role == accounts::Role::kTeam) throw HttpError(404, "no such task");
  if (role != accounts::Role::kWorker) return work_response(context, request, task_of(request));
  return json_response(collecting::task_json(
      collecting::own_task(context.db, own_visit(context, request), task_of(request))));
}

/// \throws HttpError 400 for a body beyond detail::kWorkLimits
nlohmann::json parse_draft(const std::string& text) {
  const std::string found = json::excess(text, detail::kWorkLimits);
  if (!found.empty()) throw HttpError(400, "the draft has " + found);
  // Not ordered_json, which compares each name of an object with all before it.
  return nlohmann::json::parse(text, nullptr, false);
}

Response save_draft(Context& context, const Request& request) {
  const nlohmann::json body = parse_draft(request.body);
  const auto draft = body.is_object() ? body.find("draft") : body.end();
  if (draft == body.end() || !draft->is_object()) {
    throw HttpError(400, "draft: must be there, and an object");
  }
  const std::int64_t expires = collecting::save_draft(context.db, own_visit(context, request),
                                                      task_of(request), draft->dump());
  return json_response({{"expires", detail::iso_time(expires)}});
}

Response return_task(Context& context, const Request& request) {
  collecting::return_task(context.db, own_visit(context, request), task_of(request));
  return visit_response(context, request);
}

/// \throws InvalidInput; Refusal kConflict for a dialogue
collecting::SubmittedWork read_work(Context& context, const Request& request, const Task& task) {
  using collecting::Kind;
  const graph::GraphSet& graphs = context.site->graphs();
  switch (task.kind) {
    case Kind::kWrite:
    case Kind::kDescribe:
      return collecting::read_instruction(request.body);
    case Kind::kWalk:
      return collecting::read_walk(request.body, task.item, graphs);
    case Kind::kFind:
      return collecting::read_find(request.body, task.item, graphs, context.site->objects());
    case Kind::kGuide:
      return collecting::read_guide(request.body, task.item, graphs);
    case Kind::kDialogue:
      break;
  }
  throw detail::Refusal(detail::Reason::kConflict,
                        "a dialogue is submitted when its navigator stops");
}

Response submit(Context& context, const Request& request) {
  const Visit visit = own_visit(context, request);
  const Task task = collecting::own_task(context.db, visit, task_of(request));
  collecting::submit(context.db, visit, task.id, read_work(context, request, task));
  ordered_json out = visit_of(context, visit.id);
  // Other tasks give no feedback: neither whether the goal was reached, nor the distance. The same
  // path may come again with other words.
  if (task.item.practice) {
    out["practised"] = collecting::practice_json(collecting::own_task(context.db, visit, task.id));
  }
  return json_response(out);
}

Response show_dialogue(Context& context, const Request& request) {
  return json_response(collecting::kinds::dialogue_json(
      context.db, own_visit(context, request), task_of(request),
      request.number("after", 0, 0, std::numeric_limits<std::int64_t>::max()),
      context.site->graphs()));
}

Response act_in_dialogue(Context& context, const Request& request) {
  const Visit visit = own_visit(context, request);
  collecting::kinds::act_in_dialogue(context.db, visit, task_of(request), request.body,
                                     context.site->graphs());
  return show_dialogue(context, request);
}

}  // namespace

std::int64_t task_of(const Request& request) { return request.id("task", "no such task"); }

void add_work_routes(Router& router) {
  const std::string visit = "/api/v1/visit";
  const std::string task = "/api/v1/tasks/{task}";
  router.add({"POST", "/api/v1/collections/{collection}/join", Access::kPublic, join});
  router.add({"GET", visit, Access::kWorker, visit_response});
  router.add({"PUT", visit + "/consent", Access::kWorker, give_consent});
  router.add({"PUT", visit + "/answers", Access::kWorker, answer_questions});
  router.add({"POST", visit + "/task", Access::kWorker, next_task});
  router.add({"GET", task, Access::kPublic, show_task});
  router.add({"DELETE", task, Access::kWorker, return_task});
  router.add({"PUT", task + "/draft", Access::kWorker, save_draft, kMostDraftBytes});
  router.add({"GET", task + "/dialogue", Access::kWorker, show_dialogue});
  router.add({"POST", task + "/dialogue", Access::kWorker, act_in_dialogue});
  router.add({"PUT", task + "/submission", Access::kWorker, submit, kMostWorkBytes});
}

}  // namespace enfilade::service::http
