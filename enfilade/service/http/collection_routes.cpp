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

/// The part of a collection that the client may see.
ordered_json view_of(Context& context, const Request& request, const Collection& collection) {
  ordered_json out = collecting::collection_json(collection, context.site->synthetic());
  const bool organiser = request.is_from(Role::kOrganiser);
  if (organiser || request.is_from(Role::kReviewer)) {
    out.update(collecting::progress_json(context.db, collection));
  }
  if (organiser) {
    out["platform"] = collecting::platform_json(collection.platform);
    out["link"] = collecting::link_of(collection);
  }
  return out;
}

Response create(Context& context, const Request& request) {
  const auto added = collecting::read_new_collection(*context.site, request.body);
  const Collection collection = collecting::add_collection(context.db, added);
  return json_response(view_of(context, request, collection), 201);
}

Response show(Context& context, const Request& request) {
  return json_response(view_of(context, request, collection_of(context, request)));
}

Response list(Context& context, const Request& request) {
  const auto view = [&](const Collection& one) { return view_of(context, request, one); };
  return json_response(
      {{"collections", detail::json_list(collecting::list_collections(context.db), view)}});
}

Response change_state(Context& context, const Request& request) {
  Collection collection = collection_of(context, request);
  const std::string state = text_field(parse_object(request.body), "state");
  if (state != "open" && state != "closed") {
    throw HttpError(400, "state: not \"open\" or \"closed\"");
  }
  collection.open = state == "open";
  collecting::set_open(context.db, collection.id, collection.open);
  return json_response(view_of(context, request, collection));
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

Response export_file(Context& context, const Request& request) {
  const Collection collection = collection_of(context, request);
  const std::string split = split_of(context, request, collection);
  const std::string what = request.text("what");
  const std::string state = request.text("state");
  if (!state.empty() && state != "accepted" && state != "all") {
    throw HttpError(400, "state: not \"accepted\" or \"all\"");
  }
  const collecting::ExportedSplit exported{collection, split, state == "all"};
  if (what.empty() || what == "annotations") {
    const auto items = collecting::items_of(context.db, collection.id, split);
    if (std::ranges::any_of(items, &collecting::Item::secret)) {
      throw HttpError(403, "the goals of this split are secret");
    }
    return file_response(collecting::annotations_json(context.db, exported),
                         fmt::format("R2R_{}.json", split));
  }
  if (collection.kind != collecting::Kind::kWalk || (what != "results" && what != "walks")) {
    throw HttpError(400,
                    "what: not annotations, nor, where instructions are walked, results or walks");
  }
  return file_response(what == "results" ? collecting::results_json(context.db, exported)
                                         : collecting::walks_json(context.db, exported),
                       fmt::format("human_{}_{}.json", what, split));
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
  router.add({"PATCH", one, Access::kOrganiser, change_state});
  router.add({"GET", one + "/workers", Access::kOrganiser, list_visits});
  router.add({"GET", one + "/export", Access::kOrganiser, export_file});
}

}  // namespace enfilade::service::http
