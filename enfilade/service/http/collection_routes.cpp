// Collections. For organisers: making them, following them, exporting their work. For workers:
// joining by a link, getting a task, submitting it. For reviewers: what workers submitted.
#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "enfilade/core/enum_names.h"
#include "enfilade/service/collecting/assignments.h"
#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/collecting/collections.h"
#include "enfilade/service/collecting/export.h"
#include "enfilade/service/collecting/kinds/dialogues.h"
#include "enfilade/service/collecting/quality.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using collecting::Assignment;
using collecting::AssignmentState;
using collecting::Collection;
using collecting::Visit;
using nlohmann::ordered_json;

constexpr std::size_t kMostChangeBytes = 256U << 10U;  // two texts of 20,000 characters

/// The part of a collection that the client may see.
ordered_json view_of(RouteContext& context, const Request& request, const Collection& collection) {
  return collecting::collection_json(context.db, collection, context.site->synthetic(),
                                     request.role());
}

Response create(RouteContext& context, const Request& request) {
  const auto added = collecting::read_new_collection(*context.site, context.db, request.body);
  const Collection collection = collecting::add_collection(context.db, added);
  return json_response(view_of(context, request, collection), 201);
}

ordered_json example_json(const collecting::WorkItem& item, collecting::WorkKind kind) {
  ordered_json out = collecting::item_json(item, kind);
  if (item.practice) out["practice"] = true;
  return out;
}

/// What a new collection would have; nothing is made.
Response preview(RouteContext& context, const Request& request) {
  const auto added = collecting::read_new_collection(*context.site, context.db, request.body);
  const auto work = [](const collecting::WorkItem& item) { return !item.practice; };
  std::map<std::string, std::int64_t> objects;
  std::set<std::int64_t> paths;
  std::int64_t items = 0;
  for (const collecting::WorkItem& item : added.items) {
    if (!work(item)) continue;
    ++items;
    paths.insert(item.path_id);
    if (collecting::has_target(added.about.kind)) ++objects[item.target];
  }
  const auto shown = std::ranges::find_if(added.items, work);  // there is one, or it is refused
  ordered_json out{{"items", items}, {"paths", paths.size()}};
  if (!objects.empty()) {
    out["objects"] = detail::json_list(objects, [](const auto& one) {
      return ordered_json{{"name", one.first}, {"items", one.second}};
    });
  }
  out["collection"] =
      collecting::collection_json(context.db, added.about, context.site->synthetic());
  out["example"] = example_json(*shown, added.about.kind);
  return json_response(out);
}

/// The collection that {collection} of the path names.
/// \throws Refusal kNotFound for an unknown collection
Collection collection_of(RouteContext& context, const Request& request) {
  return collecting::get_collection(context.db, request.parameter("collection"));
}

Response show(RouteContext& context, const Request& request) {
  return json_response(view_of(context, request, collection_of(context, request)));
}

Response list(RouteContext& context, const Request& request) {
  const std::string state = request.text("state");
  if (!state.empty() && state != "archived") throw HttpError(400, "state: not \"archived\"");
  const auto view = [&](const Collection& one) { return view_of(context, request, one); };
  return json_response(
      {{"collections",
        detail::json_list(
            collecting::list_collections(context.db, request.text("q"), !state.empty()), view)}});
}

Response show_example(RouteContext& context, const Request& request) {
  const Collection collection = collection_of(context, request);
  return json_response({{"collection", collecting::collection_json(context.db, collection,
                                                                   context.site->synthetic())},
                        {"example", example_json(collecting::first_item(context.db, collection.id),
                                                 collection.kind)}});
}

Response change(RouteContext& context, const Request& request) {
  const Collection changed = collecting::read_changed_collection(collection_of(context, request),
                                                                 request.body, context.db.now());
  collecting::change_collection(context.db, changed);
  return json_response(view_of(context, request, collection_of(context, request)));
}

Response copy(RouteContext& context, const Request& request) {
  const Collection from = collection_of(context, request);
  const Collection made = collecting::copy_collection(
      context.db, from, collecting::read_copied_collection(from, request.body));
  return json_response(view_of(context, request, made), 201);
}

Response list_visits(RouteContext& context, const Request& request) {
  const auto visits = collecting::visits_of(context.db, collection_of(context, request));
  if (request.text("format") == "csv") return csv_response(collecting::visits_csv(visits));
  return json_response({{"visits", detail::json_list(visits, collecting::visit_summary_json)}});
}

/// The query's split, checked to be one of the collection's: it becomes part of a file name.
std::string split_of(RouteContext& context, const Request& request, const Collection& collection) {
  std::string name = request.text("split");
  const auto splits = collecting::splits_of(context.db, collection.id);
  if (std::ranges::find(splits, name, &collecting::SplitSize::split) == splits.end()) {
    throw HttpError(404, "split: the collection has no such split");
  }
  return name;
}

/// What is exported by default: walks were checked when they were submitted, directions were not.
bool with_waiting(const Request& request, const Collection& collection) {
  const std::string state = request.text("state");
  if (!state.empty() && state != "accepted" && state != "all") {
    throw HttpError(400, "state: not \"accepted\" or \"all\"");
  }
  return state.empty() ? !collecting::shows_path(collection.kind) : state == "all";
}

/// One of the files that a selection makes, JSON. \throws HttpError 400 for another word
std::string file_of(RouteContext& context, const collecting::Selection& selection,
                    const std::string& what) {
  using collecting::WorkKind;
  const WorkKind kind = selection.report.kind;
  const bool walks = collecting::is_followed(kind);
  if (walks && what == "results") return collecting::results_json(selection);
  if (what == "walks" && (walks || kind == WorkKind::kGuide))
    return collecting::walks_json(selection);
  if (what == "dialogues" && kind == WorkKind::kDialogue) {
    return collecting::dialogues_json(selection);
  }
  if (what != "annotations") {
    throw HttpError(400,
                    "what: not annotations, tasks, report, nor, where instructions are walked, "
                    "results or walks, of guides walks or traces, of dialogues dialogues");
  }
  if (selection.secret) throw HttpError(403, "the goals of this split are secret");
  return collecting::annotations_json(selection, context.site->graphs());
}

/// As the benchmark calls its file.
std::string annotations_name(collecting::WorkKind kind, const std::string& split) {
  using collecting::WorkKind;
  if (kind == WorkKind::kDescribe || kind == WorkKind::kFind)
    return fmt::format("REVERIE_{}.json", split);
  if (kind == WorkKind::kGuide) return fmt::format("rxr_{}_guide.jsonl", split);
  if (kind == WorkKind::kDialogue) return fmt::format("{}.json", split);
  return fmt::format("R2R_{}.json", split);
}

Response export_file(RouteContext& context, const Request& request) {
  const Collection collection = collection_of(context, request);
  const collecting::ExportedSplit exported{collection, split_of(context, request, collection),
                                           with_waiting(request, collection)};
  const std::string given = request.text("what");
  const std::string what = given.empty() ? "annotations" : given;
  const std::string name = what == "annotations"
                               ? annotations_name(collection.kind, exported.split)
                               : fmt::format("human_{}_{}.json", what, exported.split);
  const char* json = "application/json";
  if (what == "tasks") {
    return file_response(json, collecting::tasks_json(context.db, exported), name);
  }
  const collecting::Selection selection = collecting::select_work(context.db, exported);
  if (what == "report") return json_response(collecting::report_json(selection.report));
  const bool traces = what == "traces";
  if (traces && collection.kind != collecting::WorkKind::kGuide) {
    throw HttpError(400, "what: traces are of guides");
  }
  Response response = traces
                          ? file_response("application/zip",
                                          collecting::traces_zip(selection, context.site->graphs()),
                                          fmt::format("rxr_{}_pose_traces.zip", exported.split))
                          : file_response(json, file_of(context, selection, what), name);
  response.add_header("X-Enfilade-Export", selection.report.summary());
  return response;
}

constexpr std::size_t kLongestReason = 500;
constexpr std::int64_t kMostNumber = std::numeric_limits<std::int64_t>::max();

bool may_know_secrets(const Request& request) {
  return request.is_from(accounts::ClientRole::kOrganiser);
}

/// A number of the query; none if it is absent.
std::optional<std::int64_t> number_of(const Request& request, std::string_view name) {
  if (request.text(name).empty()) return std::nullopt;
  return request.number(name, 0, 0, kMostNumber);
}

/// The query's state of submitted work; none: all.
std::optional<AssignmentState> state_of(const Request& request) {
  const std::string text = request.text("state");
  if (text.empty()) return AssignmentState::kSubmitted;
  if (text == "all") return std::nullopt;
  const auto state = find_enum<AssignmentState>(text);
  if (!state || *state < AssignmentState::kSubmitted) {
    throw HttpError(400, "state: not submitted, accepted, rejected or all");
  }
  return state;
}

Response list_work(RouteContext& context, const Request& request) {
  const Collection collection = collection_of(context, request);
  const collecting::WorkPage page = collecting::list_work(
      context.db, collection.id,
      {state_of(request), number_of(request, "worker"), number_of(request, "path_id"),
       request.text("q")},
      request.number("after", 0, 0, kMostNumber), request.number("limit", 50, 1, 200));
  const auto view = [&request](const Assignment& task) {
    return collecting::work_json(task, may_know_secrets(request));
  };
  return json_response(
      {{"matching", page.matching}, {"work", detail::json_list(page.tasks, view)}});
}

template <collecting::SummaryBy By>
Response summarise(RouteContext& context, const Request& request) {
  const Collection collection = collection_of(context, request);
  const auto found = collecting::summarise_work(context.db, collection.id, By,
                                                request.number("after", -1, -1, kMostNumber),
                                                request.number("limit", 200, 1, 1000));
  const auto view = [](const collecting::WorkSummary& one) {
    return collecting::work_summary_json(one, By);
  };
  return json_response({{By == collecting::SummaryBy::kWorker ? "workers" : "paths",
                         detail::json_list(found, view)}});
}

std::int64_t task_of(const Request& request) { return request.id("task", "no such task"); }

/// A submitted task with its history and any steps. \pre the client is a reviewer or an organiser
/// \throws Refusal kNotFound if no submitted task has this number
Response work_response(RouteContext& context, const Request& request, std::int64_t id) {
  const Assignment task = collecting::find_work(context.db, id);
  ordered_json out = collecting::work_json(task, may_know_secrets(request));
  collecting::add_content(out, context.db, task);
  out["history"] = detail::json_list(collecting::events_of(context.db, id), collecting::event_json);
  return json_response(out);
}

/// The fields "verdict" and "reason". \throws HttpError 400
collecting::Verdict verdict_of(Form& form) {
  const auto verdict = find_enum<AssignmentState>(form.text("verdict"));
  const std::string reason = form.text("reason", Presence::kOptional);
  form.check();  // the rest is asked of texts only: each fault is told once
  const bool needs_reason = verdict == AssignmentState::kRejected;
  if (!needs_reason && verdict != AssignmentState::kAccepted) {
    throw HttpError(400, "verdict: not \"accepted\" or \"rejected\"");
  }
  if (needs_reason ? !detail::is_prose(reason, kLongestReason) : !reason.empty()) {
    throw HttpError(400, "reason: of a rejection, 1 to 500 printable characters; else none");
  }
  return {*verdict, reason, ""};
}

Response review(RouteContext& context, const Request& request) {
  Form form(request.body);
  const std::string instruction = form.text("instruction", Presence::kOptional);
  collecting::Verdict verdict = verdict_of(form);
  if (!instruction.empty()) collecting::check_instruction(instruction, "$.instruction");
  verdict.instruction = instruction;
  const std::int64_t task = task_of(request);
  collecting::review(context.db, task, verdict, request.principal->name);
  return work_response(context, request, task);
}

constexpr std::size_t kMostAtOnce = 500;  ///< tasks that are reviewed together

/// One verdict on several tasks: {"tasks": [3, 4], "verdict", "reason"}.
Response review_all(RouteContext& context, const Request& request) {
  const Collection collection = collection_of(context, request);
  const ordered_json body = parse_object(request.body);
  const ordered_json& list = form_field(body, "tasks", &ordered_json::is_array, "a list");
  if (list.empty() || list.size() > kMostAtOnce ||
      !std::all_of(list.begin(), list.end(),
                   [](const ordered_json& one) { return one.is_number_unsigned(); })) {
    throw HttpError(400, fmt::format("tasks: not a list of 1 to {} tasks' numbers", kMostAtOnce));
  }
  Form form(request.body);
  const collecting::Verdict verdict = verdict_of(form);
  const auto tasks = list.get<std::vector<std::int64_t>>();
  collecting::review_all(context.db, collection.id, tasks, verdict, request.principal->name);
  return json_response(
      {{"reviewed", tasks.size()}, {"collection", view_of(context, request, collection)}});
}

Response show_quality(RouteContext& context, const Request& request) {
  const Collection collection = collection_of(context, request);
  const bool organiser = may_know_secrets(request);
  return json_response(
      {{"agreement",
        collecting::agreement_json(collecting::agreement_of(context.db, collection, organiser))},
       {"questions", detail::json_list(collecting::question_results(context.db, collection.id),
                                       [organiser](const collecting::QuestionResult& one) {
                                         return collecting::question_result_json(one, organiser);
                                       })}});
}

Response edit(RouteContext& context, const Request& request) {
  const std::string instruction = text_field(parse_object(request.body), "instruction");
  collecting::check_instruction(instruction, "$.instruction");
  const std::int64_t task = task_of(request);
  collecting::edit(context.db, task, instruction, request.principal->name);
  return work_response(context, request, task);
}

constexpr std::size_t kMostDraftBytes = 256U << 10U;
constexpr std::size_t kMostWorkBytes = 1U << 20U;  // 5000 steps, some 120 bytes each

Visit own_visit(RouteContext& context, const Request& request) {
  return collecting::get_visit(context.db, request.principal->visit);
}

collecting::Parameters read_parameters(const std::string& body) {
  const ordered_json object = parse_object(body);
  const ordered_json& given =
      form_field(object, "parameters", &ordered_json::is_object, "an object");
  collecting::Parameters parameters;
  for (const auto& [name, value] : given.items()) {
    parameters.emplace(name, text_field(given, name.c_str()));
  }
  return parameters;
}

ordered_json visit_of(RouteContext& context, std::int64_t id) {
  return collecting::visit_json(context.db, collecting::collection_of_visit(context.db, id), id);
}

Response visit_response(RouteContext& context, const Request& request) {
  return json_response(visit_of(context, request.principal->visit));
}

Response join(RouteContext& context, const Request& request) {
  context.joins.count(request.address, context.db.now());
  const Collection collection = collection_of(context, request);
  const collecting::Parameters parameters = read_parameters(request.body);
  const auto key = parameters.find("key");
  if (key == parameters.end() || key->second != collection.key) {
    context.failures.count(request.address, context.db.now());
    throw HttpError(403, "the link is incomplete: its key is wrong");
  }
  const collecting::Arrival arrival = collecting::read_arrival(collection.platform, parameters);
  ordered_json out{{"preview", arrival.preview},
                   {"collection", collecting::collection_json(context.db, collection,
                                                              context.site->synthetic())}};
  if (arrival.preview) {
    const collecting::WorkItem item = collecting::first_item(context.db, collection.id);
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

Response give_consent(RouteContext& context, const Request& request) {
  collecting::give_consent(context.db, own_visit(context, request));
  return visit_response(context, request);
}

Response next_task(RouteContext& context, const Request& request) {
  using collecting::NoTask;
  const Visit visit = own_visit(context, request);
  const Collection collection = collecting::collection_of_visit(context.db, visit.id);
  const auto held = context.db.hold();
  const collecting::Lease lease = collecting::lease_task(context.db, collection, visit);
  const bool finished =
      !lease.task && (lease.why == NoTask::kFinished || lease.why == NoTask::kNoneLeft);
  ordered_json out = collecting::visit_json(context.db, collection, visit.id, finished);
  if (!lease.task) out["why"] = enum_name(lease.why);
  return json_response(out);
}

/// {"answers": [{"question": 3, "choice": "Yes"}, ...]}
Response answer_questions(RouteContext& context, const Request& request) {
  const ordered_json body = parse_object(request.body);
  const ordered_json& answers = form_field(body, "answers", &ordered_json::is_array, "a list");
  const Visit visit = own_visit(context, request);
  const Collection collection = collecting::collection_of_visit(context.db, visit.id);
  context.db.transact([&] {
    for (const ordered_json& one : answers) {
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

Response show_task(RouteContext& context, const Request& request) {
  const accounts::ClientRole role = request.known_principal().role;
  if (role == accounts::ClientRole::kTeam) throw HttpError(404, "no such task");
  if (role != accounts::ClientRole::kWorker)
    return work_response(context, request, task_of(request));
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

Response save_draft(RouteContext& context, const Request& request) {
  const nlohmann::json body = parse_draft(request.body);
  const auto draft = body.is_object() ? body.find("draft") : body.end();
  if (draft == body.end() || !draft->is_object()) {
    throw HttpError(400, "draft: must be there, and an object");
  }
  const std::int64_t expires = collecting::save_draft(context.db, own_visit(context, request),
                                                      task_of(request), draft->dump());
  return json_response({{"expires", detail::iso_time(expires)}});
}

Response return_task(RouteContext& context, const Request& request) {
  collecting::return_task(context.db, own_visit(context, request), task_of(request));
  return visit_response(context, request);
}

Response submit(RouteContext& context, const Request& request) {
  const Visit visit = own_visit(context, request);
  const Assignment task = collecting::own_task(context.db, visit, task_of(request));
  collecting::submit(context.db, visit, task.id,
                     collecting::read_work(request.body, task, *context.site));
  ordered_json out = visit_of(context, visit.id);
  // Other tasks give no feedback: neither whether the goal was reached, nor the distance. The same
  // path may come again with other words.
  if (task.item.practice) {
    out["practised"] = collecting::practice_json(collecting::own_task(context.db, visit, task.id));
  }
  return json_response(out);
}

Response show_dialogue(RouteContext& context, const Request& request) {
  return json_response(collecting::kinds::dialogue_json(
      context.db, own_visit(context, request), task_of(request),
      request.number("after", 0, 0, std::numeric_limits<std::int64_t>::max()),
      context.site->graphs()));
}

Response act_in_dialogue(RouteContext& context, const Request& request) {
  const Visit visit = own_visit(context, request);
  collecting::kinds::act_in_dialogue(context.db, visit, task_of(request), request.body,
                                     context.site->graphs());
  return show_dialogue(context, request);
}

}  // namespace

void add_collection_routes(Router& router, std::size_t most_bytes) {
  const std::string all = "/api/v1/collections";
  const std::string one = all + "/{collection}";
  router.add({"POST", all, Access::kOrganiser, create, most_bytes});
  router.add({"GET", all, Access::kReviewer, list});
  router.add({"POST", all + "/preview", Access::kOrganiser, preview, most_bytes});
  router.add({"GET", one, Access::kPublic, show});
  router.add({"PATCH", one, Access::kOrganiser, change, kMostChangeBytes});
  router.add({"GET", one + "/example", Access::kReviewer, show_example});
  router.add({"POST", one + "/copy", Access::kOrganiser, copy});
  router.add({"GET", one + "/workers", Access::kOrganiser, list_visits});
  router.add({"GET", one + "/export", Access::kOrganiser, export_file});
  const std::string work = one + "/work";
  const std::string task = "/api/v1/tasks/{task}";
  router.add({"GET", work, Access::kReviewer, list_work});
  router.add(
      {"GET", work + "/workers", Access::kReviewer, summarise<collecting::SummaryBy::kWorker>});
  router.add({"GET", work + "/paths", Access::kReviewer, summarise<collecting::SummaryBy::kPath>});
  router.add({"GET", one + "/quality", Access::kReviewer, show_quality});
  router.add({"PUT", one + "/reviews", Access::kReviewer, review_all});
  router.add({"PUT", task + "/review", Access::kReviewer, review});
  router.add({"PUT", task + "/instruction", Access::kReviewer, edit});
  const std::string visit = "/api/v1/visit";
  router.add({"POST", one + "/join", Access::kPublic, join});
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
