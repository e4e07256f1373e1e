// For workers: coming by a link, taking a task, handing it in.
#include "enfilade/service/http/work_routes.h"

#include <fmt/format.h>

#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/collecting/handed_in.h"
#include "enfilade/service/detail/clock.h"
#include "enfilade/service/http/bodies.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostDraftBytes = 256U << 10U;
constexpr std::size_t kMostWorkBytes = 1U << 20U;  // 5000 steps, some 120 bytes each

collecting::Visit own_visit(Context& context, const Request& request) {
  return collecting::visit_of(*context.database, request.principal->visit);
}

collecting::Parameters read_parameters(const std::string& body) {
  const ordered_json object = parse_object(body);
  const auto found = object.find("parameters");
  if (found == object.end() || !found->is_object()) {
    throw HttpError(400, "bad-body", "parameters: must be there, and an object");
  }
  collecting::Parameters parameters;
  for (const auto& [name, value] : found->items()) {
    parameters.emplace(name, field(*found, name.c_str(), true));
  }
  return parameters;
}

/// \param task what it holds \param finished nothing more is given out to it
ordered_json visit_json(const collecting::Collection& collection, const collecting::Visit& visit,
                        const std::optional<collecting::Task>& task, bool finished) {
  ordered_json out{{"consented", visit.consented}, {"done", visit.done}};
  if (collection.tasks_per_visit > 0) out["of"] = collection.tasks_per_visit;
  out["finished"] = finished;
  out["task"] = task ? collecting::task_json(*task) : ordered_json();
  if (finished && visit.done > 0) {
    out["completion"] = collecting::completion_json(collecting::completion(
        collection.platform, visit.assignment, visit.submit_to, visit.id, visit.done));
  }
  return out;
}

/// How a visit stands, without giving it anything.
ordered_json standing(Context& context, std::int64_t id) {
  const collecting::Visit visit = collecting::visit_of(*context.database, id);
  const collecting::Collection collection = collecting::collection_of_visit(*context.database, id);
  return visit_json(collection, visit, collecting::held_task(*context.database, visit),
                    collecting::has_had_all(collection, visit));
}

Response come(Context& context, const Request& request) {
  const std::int64_t now = context.clock();
  context.joins.take(request.address, now);
  const collecting::Collection collection =
      collecting::collection_named(*context.database, request.parameter("collection"));
  const collecting::Parameters parameters = read_parameters(request.body);
  const auto key = parameters.find("key");
  if (key == parameters.end() || key->second != collection.key) {
    context.failures.take(request.address, now);
    throw HttpError(403, "bad-key", "the link is not whole: its key is wrong");
  }
  const collecting::Arrival arrival = collecting::read_arrival(collection.platform, parameters);
  ordered_json out{
      {"preview", arrival.preview},
      {"collection", collecting::collection_json(collection, context.site->synthetic())}};
  if (arrival.preview) {
    const collecting::Item item = collecting::first_item(*context.database, collection.id);
    out["example"] = collecting::example_json(item, collection.kind);
    return json_response(out.dump());
  }
  const std::int64_t visit = collecting::join(*context.database, collection, arrival, now);
  out["worker"] = arrival.worker;
  const std::string label =
      "worker " + std::to_string(collecting::visit_of(*context.database, visit).worker);
  out["token"] = accounts::add_worker_token(*context.database, visit, label, now);
  out["visit"] = standing(context, visit);
  return json_response(out.dump());
}

Response agree(Context& context, const Request& request) {
  collecting::consent(*context.database, own_visit(context, request), context.clock());
  return json_response(standing(context, request.principal->visit).dump());
}

Response next_task(Context& context, const Request& request) {
  const collecting::Visit visit = own_visit(context, request);
  const collecting::Collection collection =
      collecting::collection_of_visit(*context.database, visit.id);
  const collecting::Lease lease =
      collecting::lease_task(*context.database, collection, visit, context.clock());
  const bool finished = !lease.task && (lease.why == collecting::NoTask::kFinished ||
                                        lease.why == collecting::NoTask::kNoneLeft);
  ordered_json out = visit_json(collection, visit, lease.task, finished);
  if (!lease.task) out["why"] = to_string(lease.why);
  return json_response(out.dump());
}

Response show_task(Context& context, const Request& request) {
  if (!request.principal) throw HttpError(401, "who-are-you", "this needs a token");
  switch (request.principal->role) {
    case accounts::Role::kWorker:
      return json_response(
          collecting::task_json(collecting::own_task(*context.database, own_visit(context, request),
                                                     task_id(request)))
              .dump());
    case accounts::Role::kOrganiser:
    case accounts::Role::kReviewer:
      return work_response(context, request, task_id(request));
    case accounts::Role::kTeam:
      break;
  }
  throw HttpError(404, "unknown-task", "no such task");
}

/// \throws HttpError 400 for a body that would take long, or much of the stack, to write again
nlohmann::json parse_draft(const std::string& text) {
  static constexpr int kDeepest = 16;
  const auto check_depth = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > kDeepest) {
      throw HttpError(400, "bad-body", fmt::format("the draft is deeper than {}", kDeepest));
    }
    return true;
  };
  // Not ordered_json, to which each further name of an object costs a look at all before it.
  return nlohmann::json::parse(text, check_depth, false);
}

Response save_draft(Context& context, const Request& request) {
  const nlohmann::json body = parse_draft(request.body);
  const auto draft = body.is_object() ? body.find("draft") : body.end();
  if (draft == body.end() || !draft->is_object()) {
    throw HttpError(400, "bad-body", "draft: must be there, and an object");
  }
  const std::int64_t expires =
      collecting::keep_draft(*context.database, own_visit(context, request), task_id(request),
                             draft->dump(), context.clock());
  return json_response(ordered_json{{"expires", detail::iso_time(expires)}}.dump());
}

Response submit(Context& context, const Request& request) {
  const collecting::Visit visit = own_visit(context, request);
  const collecting::Task task = collecting::own_task(*context.database, visit, task_id(request));
  const bool walk = task.kind == collecting::Kind::kWalk;
  const collecting::HandedIn work =
      walk ? collecting::read_walked(request.body, task.item, context.site->graphs())
           : collecting::read_written(request.body);
  collecting::hand_in(*context.database, visit, task.id, work, context.clock());
  ordered_json out = standing(context, visit.id);
  if (walk) {
    out["walked"] = ordered_json::object();
    const collecting::Task done = collecting::own_task(*context.database, visit, task.id);
    if (!done.item.secret) out["walked"]["bonus"] = done.bonus();
  }
  return json_response(out.dump());
}

}  // namespace

std::int64_t task_id(const Request& request) {
  const auto id = parse_number(request.parameter("task"));
  if (!id) throw HttpError(404, "unknown-task", "no such task");
  return *id;
}

void add_work_routes(Router& router, Context& context) {
  const std::string one = "/api/v1/tasks/{task}";
  router.add({"POST", "/api/v1/collections/{collection}/join", Access::kPublic,
              [&context](const Request& request) { return come(context, request); }});
  router.add({"GET", "/api/v1/visit", Access::kWorker, [&context](const Request& request) {
                return json_response(standing(context, request.principal->visit).dump());
              }});
  router.add({"PUT", "/api/v1/visit/consent", Access::kWorker,
              [&context](const Request& request) { return agree(context, request); }});
  router.add({"POST", "/api/v1/visit/task", Access::kWorker,
              [&context](const Request& request) { return next_task(context, request); }});
  router.add({"GET", one, Access::kPublic,
              [&context](const Request& request) { return show_task(context, request); }});
  router.add({"DELETE", one, Access::kWorker, [&context](const Request& request) {
                collecting::give_back(*context.database, own_visit(context, request),
                                      task_id(request), context.clock());
                return json_response(standing(context, request.principal->visit).dump());
              }});
  router.add({"PUT", one + "/draft", Access::kWorker,
              [&context](const Request& request) { return save_draft(context, request); },
              kMostDraftBytes});
  router.add({"PUT", one + "/submission", Access::kWorker,
              [&context](const Request& request) { return submit(context, request); },
              kMostWorkBytes});
}

}  // namespace enfilade::service::http
