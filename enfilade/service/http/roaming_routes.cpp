// Continuous navigation: the mesh and the floor of a building, continuous episodes.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "enfilade/core/gzip.h"
#include "enfilade/core/rng.h"
#include "enfilade/service/browsing/roaming.h"
#include "enfilade/service/http/headers.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using browsing::Roaming;

// Limit of a mesh, unpacked: Matterport3D's largest has 200 MB.
constexpr std::size_t kMostBytes = std::size_t{1} << 30U;
constexpr std::int64_t kMostEpisodes = 500;

ScanIndex scan_of(const Context& context, const Request& request) {
  const auto found = context.site->graphs().find(request.parameter("scan"));
  if (!found) throw HttpError(404, "no scan of this name");
  return *found;
}

Response mesh(Roaming& roaming, const Context& context, const Request& request) {
  const Roaming::Packed packed = roaming.mesh(scan_of(context, request));
  Response response;
  response.type = "model/gltf-binary";
  response.add_header("ETag", fmt::format("\"{}\"", packed.digest));
  response.add_header("Cache-Control", "no-cache");  // ask each time, and mostly get a 304
  response.add_header("Vary", "Accept-Encoding");
  if (accepts_gzip(request)) {
    response.body = packed.gzip;
    response.add_header("Content-Encoding", "gzip");
  } else {
    response.body = std::make_shared<const std::string>(gunzip(*packed.gzip, kMostBytes));
  }
  return response;
}

Response floor(const Roaming& roaming, const Context& context, const Request& request) {
  Response response = json_response(roaming.floor_json(scan_of(context, request)));
  const std::string& body = *response.body;
  response.add_header("ETag", fmt::format("\"{:016x}\"", stream_of(body.data(), body.size())));
  response.add_header("Cache-Control", "no-cache");
  return response;
}

Response episodes(Roaming& roaming, const Request& request) {
  return json_response(
      roaming.episodes_json(request.parameter("split"),
                            {request.text("scan"), request.text("id"), request.text("trajectory"),
                             request.number("offset", 0, 0, 1'000'000'000),
                             request.number("limit", 50, 1, kMostEpisodes)}));
}

}  // namespace

void add_roaming_routes(Router& router, const std::shared_ptr<const Site>& site) {
  const auto roaming = std::make_shared<Roaming>(site);
  router.add({"GET", "/api/v1/scans/{scan}/mesh.glb", Access::kPublic,
              [roaming](Context& context, const Request& request) {
                return mesh(*roaming, context, request);
              }});
  router.add({"GET", "/api/v1/scans/{scan}/floor", Access::kPublic,
              [roaming](Context& context, const Request& request) {
                return floor(*roaming, context, request);
              }});
  router.add({"GET", "/api/v1/continuous/{split}/episodes", Access::kPublic,
              [roaming](Context&, const Request& request) { return episodes(*roaming, request); }});
}

}  // namespace enfilade::service::http
