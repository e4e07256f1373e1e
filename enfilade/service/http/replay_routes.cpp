// Runs of the arena, shown step by step.
#include <memory>
#include <nlohmann/json.hpp>

#include "enfilade/service/http/routes.h"
#include "enfilade/service/playing/replays.h"

namespace enfilade::service::http {
namespace {

constexpr std::int64_t kMostListed = 500;  // episodes

}  // namespace

void add_replay_routes(Router& router, const std::shared_ptr<const Site>& site,
                       const std::filesystem::path& runs) {
  const auto replays = std::make_shared<const playing::Replays>(site, runs);
  router.add({"GET", "/api/v1/runs", Access::kPublic, [replays](Context&, const Request& request) {
                return json_response(replays->runs(request.text("episode")));
              }});
  router.add(
      {"GET", "/api/v1/runs/{run}", Access::kPublic, [replays](Context&, const Request& request) {
         constexpr std::int64_t kMostOffset = 1'000'000'000;
         const auto offset = request.number("offset", 0, 0, kMostOffset);
         const auto limit = request.number("limit", kMostListed, 1, kMostListed);
         return json_response(replays->run(request.parameter("run"),
                                           static_cast<std::size_t>(offset),
                                           static_cast<std::size_t>(limit)));
       }});
  router.add({"GET", "/api/v1/runs/{run}/episodes/{episode}", Access::kPublic,
              [replays](Context&, const Request& request) {
                return json_response(
                    replays->episode(request.parameter("run"), request.parameter("episode")));
              }});
}

}  // namespace enfilade::service::http
