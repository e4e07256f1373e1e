// For organisers: making collections, following them, exporting their work.
#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "enfilade/service/collecting/collection_json.h"
#include "enfilade/service/collecting/export.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using accounts::Role;
using collecting::Collection;
using nlohmann::ordered_json;

constexpr std::size_t kMostChangeBytes = 256U << 10U;  // two texts of 20,000 characters

/// The part of a collection that the client may see.
ordered_json view_of(Context& context, const Request& request, const Collection& collection) {
  ordered_json out = collecting::collection_json(collection, context.site->synthetic());
  const bool organiser = request.is_from(Role::kOrganiser);
  if (organiser || request.is_from(Role::kReviewer)) {
    out.update(collecting::progress_json(context.db, collection));
  }
  if (organiser) {
    out["platform"] = collecting::platform_json(collection.platform);
    out.update(collecting::questions_json(context.db, collection));
    out["link"] = collecting::link_of(collection);
  }
  return out;
}

Response create(Context& context, const Request& request) {
  const auto added = collecting::read_new_collection(*context.site, context.db, request.body);
  const Collection collection = collecting::add_collection(context.db, added);
  return json_response(view_of(context, request, collection), 201);
}

Response show(Context& context, const Request& request) {
  return json_response(view_of(context, request, collection_of(context, request)));
}

Response list(Context& context, const Request& request) {
  const std::string state = request.text("state");
  if (!state.empty() && state != "archived") throw HttpError(400, "state: not \"archived\"");
  const auto view = [&](const Collection& one) { return view_of(context, request, one); };
  return json_response(
      {{"collections",
        detail::json_list(
            collecting::list_collections(context.db, request.text("q"), !state.empty()), view)}});
}

Response change(Context& context, const Request& request) {
  const Collection changed = collecting::read_changed_collection(collection_of(context, request),
                                                                 request.body, context.db.now());
  collecting::change_collection(context.db, changed);
  return json_response(view_of(context, request, collection_of(context, request)));
}

Response copy(Context& context, const Request& request) {
  const Collection from = collection_of(context, request);
  const Collection made = collecting::copy_collection(
      context.db, from, collecting::read_copied_collection(from, request.body));
  return json_response(view_of(context, request, made), 201);
}

Response list_visits(Context& context, const Request& request) {
  const auto visits = collecting::visits_of(context.db, collection_of(context, request));
  if (request.text("format") == "csv") return csv_response(collecting::visits_csv(visits));
  return json_response({{"visits", detail::json_list(visits, collecting::visit_summary_json)}});
}

/// The query's split, checked to be one of the collection's: it becomes part of a file name.
std::string split_of(Context& context, const Request& request, const Collection& collection) {
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

/// One of the files that a selection makes. \throws HttpError 400 for another word
std::string file_of(Context& context, const collecting::Selection& selection,
                    const std::string& what) {
  using collecting::Kind;
  const Kind kind = selection.report.kind;
  const bool walks = collecting::is_followed(kind);
  if (walks && what == "results") return collecting::results_json(selection);
  if (what == "walks" && (walks || kind == Kind::kGuide)) return collecting::walks_json(selection);
  if (what == "dialogues" && kind == Kind::kDialogue) {
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

/// The pose traces of guides. \throws HttpError 400 for other work
Response traces_of(Context& context, const collecting::Selection& selection) {
  if (selection.report.kind != collecting::Kind::kGuide) {
    throw HttpError(400, "what: traces are of guides");
  }
  return archive_response(collecting::traces_zip(selection, context.site->graphs()),
                          fmt::format("rxr_{}_pose_traces.zip", selection.report.split));
}

/// As the benchmark calls its file.
std::string annotations_name(collecting::Kind kind, const std::string& split) {
  using collecting::Kind;
  if (kind == Kind::kDescribe || kind == Kind::kFind) return fmt::format("REVERIE_{}.json", split);
  if (kind == Kind::kGuide) return fmt::format("rxr_{}_guide.jsonl", split);
  if (kind == Kind::kDialogue) return fmt::format("{}.json", split);
  return fmt::format("R2R_{}.json", split);
}

Response export_file(Context& context, const Request& request) {
  const Collection collection = collection_of(context, request);
  const collecting::ExportedSplit exported{collection, split_of(context, request, collection),
                                           with_waiting(request, collection)};
  const std::string given = request.text("what");
  const std::string what = given.empty() ? "annotations" : given;
  const std::string name = what == "annotations"
                               ? annotations_name(collection.kind, exported.split)
                               : fmt::format("human_{}_{}.json", what, exported.split);
  if (what == "tasks") return file_response(collecting::tasks_json(context.db, exported), name);
  const collecting::Selection selection = collecting::select_work(context.db, exported);
  if (what == "report") return json_response(collecting::report_json(selection.report));
  Response response = what == "traces" ? traces_of(context, selection)
                                       : file_response(file_of(context, selection, what), name);
  response.add_header("X-Enfilade-Export", selection.report.summary());
  return response;
}

}  // namespace

Collection collection_of(Context& context, const Request& request) {
  return collecting::get_collection(context.db, request.parameter("collection"));
}

void add_collection_routes(Router& router, std::size_t most_bytes) {
  const std::string all = "/api/v1/collections";
  const std::string one = all + "/{collection}";
  router.add({"POST", all, Access::kOrganiser, create, most_bytes});
  router.add({"GET", all, Access::kReviewer, list});
  router.add({"GET", one, Access::kPublic, show});
  router.add({"PATCH", one, Access::kOrganiser, change, kMostChangeBytes});
  router.add({"POST", one + "/copy", Access::kOrganiser, copy});
  router.add({"GET", one + "/workers", Access::kOrganiser, list_visits});
  router.add({"GET", one + "/export", Access::kOrganiser, export_file});
}

}  // namespace enfilade::service::http
