// Splits and episodes.
#include <nlohmann/json.hpp>

#include "enfilade/service/browsing/episodes.h"
#include "enfilade/service/http/errors.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

constexpr std::int64_t kMostEpisodes = 500;

Response splits(Context& context, const Request& /*request*/) {
  return json_response(browsing::split_list_json(*context.site));
}

Response episodes(Context& context, const Request& request) {
  const PublicSplit* split = context.site->find_split(request.parameter("split"));
  if (split == nullptr) throw HttpError(404, "no split of this name");
  return json_response(
      browsing::episodes_json(*split, {request.text("scan"), request.text("q"), request.text("id"),
                                       request.number("offset", 0, 0, 1'000'000'000),
                                       request.number("limit", 50, 1, kMostEpisodes)}));
}

}  // namespace

void add_episode_routes(Router& router) {
  router.add({"GET", "/api/v1/splits", Access::kPublic, splits});
  router.add({"GET", "/api/v1/splits/{split}/episodes", Access::kPublic, episodes});
}

}  // namespace enfilade::service::http
