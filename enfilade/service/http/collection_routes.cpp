// For organisers: making collections, watching them, taking what they came to.
#include <fmt/format.h>
#include <algorithm>

#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/collecting/export.h"
#include "enfilade/service/detail/clock.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/app.h"
#include "enfilade/service/http/bodies.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

collecting::Collection collection_of(Context& context, const Request& request) {
  return collecting::collection_named(*context.database, request.parameter("collection"));
}

ordered_json progress_json(const collecting::Progress& progress, int per_item) {
  return {{"items", progress.items},       {"places", progress.items * per_item},
          {"leased", progress.leased},     {"submitted", progress.submitted},
          {"accepted", progress.accepted}, {"rejected", progress.rejected},
          {"complete", progress.complete}, {"workers", progress.workers}};
}

ordered_json platform_json(const collecting::Platform& platform) {
  ordered_json out{{"kind", to_string(platform.kind)}};
  if (platform.kind == collecting::PlatformKind::kMturk) out["origins"] = platform.origins;
  if (platform.kind == collecting::PlatformKind::kProlific)
    out["completion_code"] = platform.completion_code;
  return out;
}

/// As much of it as the asker may see.
ordered_json view_of(Context& context, const Request& request,
                     const collecting::Collection& collection) {
  ordered_json out = collecting::collection_json(collection, context.site->synthetic());
  const bool organiser = request.principal && request.principal->role == accounts::Role::kOrganiser;
  if (!organiser && !(request.principal && request.principal->role == accounts::Role::kReviewer))
    return out;
  out["created"] = detail::iso_time(collection.created);
  out["per_item"] = collection.per_item;
  out["lease_minutes"] = collection.lease_seconds / 60;
  out["tasks_per_visit"] = collection.tasks_per_visit;
  auto& splits = out["splits"] = ordered_json::array();
  for (const collecting::SplitSize& split :
       collecting::splits_of(*context.database, collection.id)) {
    splits.push_back(
        {{"split", split.split}, {"items", split.items}, {"goals_hidden", split.secret}});
  }
  out["progress"] =
      progress_json(collecting::progress_of(*context.database, collection.id, context.clock()),
                    collection.per_item);
  if (organiser) {
    out["platform"] = platform_json(collection.platform);
    out["link"] = collecting::link_of(collection);
  }
  return out;
}

Response create(Context& context, const Request& request) {
  const collecting::NewCollection made =
      collecting::read_new_collection(*context.site, request.body);
  const collecting::Collection collection =
      collecting::add_collection(*context.database, made, context.clock());
  return json_response(view_of(context, request, collection).dump(), 201);
}

Response all_collections(Context& context, const Request& request) {
  auto collections = ordered_json::array();
  for (const collecting::Collection& collection : collecting::list_collections(*context.database)) {
    collections.push_back(view_of(context, request, collection));
  }
  return json_response(ordered_json{{"collections", collections}}.dump());
}

Response change_state(Context& context, const Request& request) {
  collecting::Collection collection = collection_of(context, request);
  const std::string state = field(parse_object(request.body), "state", true);
  if (state != "open" && state != "closed") {
    throw HttpError(400, "bad-body", "state: not \"open\" or \"closed\"");
  }
  collection.open = state == "open";
  collecting::set_open(*context.database, collection.id, collection.open);
  return json_response(view_of(context, request, collection).dump());
}

std::string visits_csv(const std::vector<collecting::VisitSummary>& visits) {
  std::string csv =
      "visit,worker,external,assignment,group,created,to_review,accepted,rejected,bonuses,"
      "finished\r\n";
  for (const collecting::VisitSummary& visit : visits) {
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\r\n", visit.visit, visit.worker,
                       detail::sheet_text(visit.external), detail::sheet_text(visit.assignment),
                       detail::sheet_text(visit.group), detail::iso_time(visit.created),
                       visit.submitted, visit.accepted, visit.rejected, visit.bonuses,
                       visit.finished ? 1 : 0);
  }
  return csv;
}

Response list_visits(Context& context, const Request& request) {
  const collecting::Collection collection = collection_of(context, request);
  const std::vector<collecting::VisitSummary> visits =
      collecting::visits_of(*context.database, collection);
  if (request.text("format") == "csv") {
    return csv_response(visits_csv(visits));
  }
  auto list = ordered_json::array();
  for (const collecting::VisitSummary& visit : visits) {
    list.push_back({{"visit", visit.visit},
                    {"worker", visit.worker},
                    {"external", visit.external},
                    {"assignment", visit.assignment},
                    {"group", visit.group},
                    {"created", detail::iso_time(visit.created)},
                    {"submitted", visit.submitted},
                    {"accepted", visit.accepted},
                    {"rejected", visit.rejected},
                    {"bonuses", visit.bonuses},
                    {"finished", visit.finished}});
  }
  return json_response(ordered_json{{"visits", list}}.dump());
}

Response file_of(std::string content, const std::string& name) {
  Response response = json_response(std::move(content));
  response.headers.emplace_back("Content-Disposition",
                                fmt::format("attachment; filename=\"{}\"", name));
  return response;
}

/// One of the collection's splits, whose names can stand in a file's.
std::string split_of(Context& context, const Request& request,
                     const collecting::Collection& collection) {
  std::string name = request.text("split");
  const auto splits = collecting::splits_of(*context.database, collection.id);
  if (std::ranges::find(splits, name, &collecting::SplitSize::split) == splits.end()) {
    throw HttpError(404, "unknown-split", "split: the collection has no such split");
  }
  return name;
}

Response export_file(Context& context, const Request& request) {
  const collecting::Collection collection = collection_of(context, request);
  const std::string split = split_of(context, request, collection);
  const std::string what = request.text("what");
  const std::string state = request.text("state");
  if (!state.empty() && state != "accepted" && state != "all") {
    throw HttpError(400, "bad-query", "state: not \"accepted\" or \"all\"");
  }
  const collecting::Taken taken =
      state == "all" ? collecting::Taken::kAll : collecting::Taken::kAccepted;
  store::Database& database = *context.database;
  if (what.empty() || what == "annotations") {
    const auto items = collecting::items_of(database, collection.id, split);
    if (std::ranges::any_of(items, &collecting::Item::secret)) {
      throw HttpError(403, "secret-goals", "the goals of this split are secret");
    }
    return file_of(collecting::annotations_json(database, collection, split, taken),
                   fmt::format("R2R_{}.json", split));
  }
  if (collection.kind != collecting::Kind::kWalk || (what != "results" && what != "walks")) {
    throw HttpError(400, "bad-query",
                    "what: not annotations, nor, where instructions are walked, results or walks");
  }
  return file_of(what == "results" ? collecting::results_json(database, collection, split, taken)
                                   : collecting::walks_json(database, collection, split, taken),
                 fmt::format("human_{}_{}.json", what, split));
}

}  // namespace

void add_collection_routes(Router& router, Context& context) {
  const std::string one = "/api/v1/collections/{collection}";
  router.add({"POST", "/api/v1/collections", Access::kOrganiser,
              [&context](const Request& request) { return create(context, request); },
              context.config.most_submission_bytes});
  router.add({"GET", "/api/v1/collections", Access::kReviewer,
              [&context](const Request& request) { return all_collections(context, request); }});
  router.add({"GET", one, Access::kPublic, [&context](const Request& request) {
                const collecting::Collection collection = collection_of(context, request);
                return json_response(view_of(context, request, collection).dump());
              }});
  router.add({"PATCH", one, Access::kOrganiser,
              [&context](const Request& request) { return change_state(context, request); }});
  router.add({"GET", one + "/workers", Access::kOrganiser,
              [&context](const Request& request) { return list_visits(context, request); }});
  router.add({"GET", one + "/export", Access::kOrganiser,
              [&context](const Request& request) { return export_file(context, request); }});
}

}  // namespace enfilade::service::http
