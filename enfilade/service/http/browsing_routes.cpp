// Scans (graphs, faces, plans, meshes and floors), splits and episodes.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/service/browsing/pictures.h"
#include "enfilade/service/browsing/site_json.h"
#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/http/messages.h"
#include "enfilade/service/http/routes.h"
#include "enfilade/tasks/benchmark.h"

namespace enfilade::service::http {
namespace {

ScanIndex scan_of(const RouteContext& context, const Request& request) {
  const auto found = context.site->graphs().find(request.parameter("scan"));
  if (!found) throw HttpError(404, "no scan of this name");
  return *found;
}

/// Browsers ask each time, and mostly get a 304.
void add_digest(Response& response) {
  const std::string& body = *response.body;
  response.add_header("ETag", fmt::format("\"{:016x}\"", stream_of(body.data(), body.size())));
  response.add_header("Cache-Control", "no-cache");
}

using Handler = std::function<Response(RouteContext&, const Request&)>;

/// Responses that don't change while the server runs, by path. Made at the first request.
Handler cached(const char* type, std::string (*make)(RouteContext&, const Request&)) {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  const auto cache = std::make_shared<detail::OnceCache<std::string, Response>>(
      kAll, [](const Response& response) { return response.body->size(); });
  return [cache, type, make](RouteContext& context, const Request& request) {
    return cache->get(request.path, [&] {
      Response response = text_response(type, make(context, request));
      add_digest(response);
      return response;
    });
  };
}

/// What pages show in their headers is known with the first thing that they ask for.
std::string with_runs(nlohmann::ordered_json about, const RouteContext& context) {
  about["runs"] = !context.config.runs.empty();
  return about.dump();
}

std::string scan_list(RouteContext& context, const Request& /*request*/) {
  return with_runs(browsing::scan_list_json(*context.site), context);
}

std::string one_scan(RouteContext& context, const Request& request) {
  return with_runs(browsing::scan_json(*context.site, scan_of(context, request)), context);
}

std::string plan(RouteContext& context, const Request& request) {
  return browsing::plan_json(*context.site, scan_of(context, request)).dump();
}

std::string floor_plan(RouteContext& context, const Request& request) {
  return draw::floor_plan_svg(context.site->graphs().graph(scan_of(context, request)));
}

/// "2.jpg" or "2.png".
std::size_t face_of(const std::string& name, std::string_view suffix) {
  if (name.size() != 1 + suffix.size() || name[0] < '0' || name[0] > '5' ||
      !name.ends_with(suffix)) {
    throw HttpError(404, fmt::format("a face is 0{} to 5{}", suffix, suffix));
  }
  return static_cast<std::size_t>(name[0] - '0');
}

/// Lets browsers keep a picture of the scan for a day. Nothing if the source does not say which
/// version it is.
void add_version(RouteContext& context, ScanIndex scan, std::string_view name, Response& response) {
  const std::string version = context.faces.version(scan);
  if (version.empty()) return;
  response.add_header("ETag", fmt::format("\"{}-{}\"", version, name));
  response.add_header("Cache-Control", "public, max-age=86400");
}

constexpr const char* kNoPicture = "no such picture of this viewpoint";

/// A viewpoint that has pictures.
struct Pictured {
  ScanIndex scan;
  ViewpointIndex viewpoint;
  const scan::PanoramaSource* source;
};
/// The one that {scan} and {viewpoint} name. \throws HttpError 404
Pictured pictured(const RouteContext& context, const Request& request) {
  const ScanIndex scan = scan_of(context, request);
  const scan::PanoramaSource* source = context.site->panoramas().find_source(scan);
  const auto viewpoint =
      source == nullptr ? std::nullopt : source->find(request.parameter("viewpoint"));
  if (!viewpoint) throw HttpError(404, kNoPicture);
  return {scan, *viewpoint, source};
}

/// The same for what is made of one viewpoint's pictures.
void let_keep(RouteContext& context, const Pictured& at, const std::string& what,
              Response& response) {
  add_version(context, at.scan, fmt::format("{}-{}", at.viewpoint.value, what), response);
}

template <scan::Layer kLayer>
Response face(RouteContext& context, const Request& request) {
  constexpr bool kColour = kLayer == scan::Layer::kColour;
  const std::size_t face = face_of(request.parameter("face"), kColour ? ".jpg" : ".png");
  const Pictured at = pictured(context, request);
  if (at.source->face_sizes(at.viewpoint)[index(kLayer)] == 0) throw HttpError(404, kNoPicture);
  Response response = shared_response(kColour ? "image/jpeg" : "image/png",
                                      context.faces.get(at.scan, at.viewpoint, kLayer)[face]);
  let_keep(context, at, fmt::format("{}-{}", index(kLayer), face), response);
  return response;
}

Response distances(RouteContext& context, const Request& request) {
  const Pictured at = pictured(context, request);
  if (at.source->face_sizes(at.viewpoint)[index(scan::Layer::kDepth)] == 0) {
    throw HttpError(404, "this viewpoint has no depth");
  }
  Response response =
      shared_response("application/octet-stream", context.faces.distances(at.scan, at.viewpoint));
  let_keep(context, at, "distances", response);
  return response;
}

Response legends(RouteContext& context, const Request& request) {
  const Pictured at = pictured(context, request);
  Response response =
      shared_response("application/json", context.faces.legends(at.scan, at.viewpoint));
  let_keep(context, at, "legends", response);
  return response;
}

Response outlook(RouteContext& context, const Request& request) {
  const ScanIndex scan = scan_of(context, request);
  const auto found = context.stills.outlook(scan);
  if (!found) throw HttpError(404, "this scan has no pictures");
  return json_response({{"viewpoint", context.site->graphs().graph(scan).id(found->viewpoint)},
                        {"heading", found->heading.value},
                        {"elevation", found->elevation.value},
                        {"vfov", browsing::kStillFieldOfView.value}});
}

Response still(RouteContext& context, const Request& request) {
  const ScanIndex scan = scan_of(context, request);
  const auto& widths = browsing::kStillWidths;
  const std::int64_t width = request.number("width", widths.front(), widths.front(), widths.back());
  if (std::ranges::find(widths, width) == widths.end()) {
    throw HttpError(400, fmt::format("width: {}; it can be {}", width, fmt::join(widths, " or ")));
  }
  Response response = shared_response("image/jpeg", context.stills.get(scan, width));
  if (response.body == nullptr) throw HttpError(404, "this scan has no pictures");
  add_version(context, scan, fmt::format("still-{}", width), response);
  return response;
}

browsing::EpisodeFilter filter_of(const Request& request) {
  return {request.text("scan"),
          request.text("q"),
          request.text("id"),
          request.text("trajectory"),
          request.number("offset", 0, 0, 1'000'000'000),
          request.number("limit", 50, 1, 500)};
}

/// Of a query; R2R where it names none.
tasks::Task task_of(const std::string& name) {
  if (name.empty()) return tasks::Task::kR2r;
  try {
    return tasks::benchmark(name, tasks::WorldKind::kGraph).task;
  } catch (const LookupError&) {
    throw HttpError(404, "no benchmark of this name");
  }
}

Response splits(RouteContext& context, const Request& request) {
  const std::string name = request.text("task");
  if (name == "all") return json_response(browsing::split_list_json(*context.site, std::nullopt));
  return json_response(browsing::split_list_json(*context.site, task_of(name)));
}

Response episodes(RouteContext& context, const Request& request) {
  const PublicSplit* split =
      context.site->find_split(request.parameter("split"), task_of(request.text("task")));
  if (split == nullptr) throw HttpError(404, "no split of this name");
  return json_response(browsing::episodes_json(*context.site, *split, filter_of(request)));
}

Response mesh(RouteContext& context, const Request& request) {
  const browsing::Roaming::Packed packed = context.roaming.mesh(scan_of(context, request));
  Response response;
  response.type = "model/gltf-binary";
  response.add_header("ETag", fmt::format("\"{}\"", packed.digest));
  response.add_header("Cache-Control", "no-cache");  // ask each time, and mostly get a 304
  response.add_header("Vary", "Accept-Encoding");
  compare_with_cached(request, response);
  if (response.status == 304) return response;  // nothing is unpacked for it
  if (accepts_gzip(request)) {
    response.body = packed.gzip;
    response.add_header("Content-Encoding", "gzip");
  } else {
    response.body = context.roaming.unpacked(packed);
  }
  if (response.body == nullptr) {
    throw HttpError(503, "too many meshes are being sent; try again, or accept gzip");
  }
  return response;
}

Response floor(RouteContext& context, const Request& request) {
  Response response = json_response(context.roaming.floor_json(scan_of(context, request)));
  add_digest(response);
  return response;
}

Response continuous_episodes(RouteContext& context, const Request& request) {
  return json_response(
      context.roaming.episodes_json(request.parameter("split"), filter_of(request)));
}

}  // namespace

void add_browsing_routes(Router& router) {
  const std::string one = "/api/v1/scans/{scan}";
  const std::string viewpoint = one + "/viewpoints/{viewpoint}/";
  const char* json = "application/json";
  router.add({"GET", "/api/v1/scans", Access::kPublic, cached(json, scan_list)});
  router.add({"GET", one, Access::kPublic, cached(json, one_scan)});
  router.add({"GET", one + "/plan", Access::kPublic, cached(json, plan)});
  router.add(
      {"GET", one + "/plan.svg", Access::kPublic,
       [svg = cached("image/svg+xml", floor_plan)](RouteContext& context, const Request& request) {
         Response response = svg(context, request);
         // An SVG has its own styles, and must not run scripts.
         response.add_header("Content-Security-Policy",
                             "default-src 'none'; style-src 'unsafe-inline'");
         return response;
       }});
  router.add({"GET", one + "/outlook", Access::kPublic, outlook});
  router.add({"GET", one + "/picture.jpg", Access::kPublic, still});
  router.add({"GET", one + "/mesh.glb", Access::kPublic, mesh});
  router.add({"GET", one + "/floor", Access::kPublic, floor});
  router.add({"GET", viewpoint + "distances", Access::kPublic, distances});
  router.add({"GET", viewpoint + "legends", Access::kPublic, legends});
  router.add({"GET", viewpoint + "faces/{face}", Access::kPublic, face<scan::Layer::kColour>});
  router.add({"GET", viewpoint + "depth/{face}", Access::kPublic, face<scan::Layer::kDepth>});
  router.add({"GET", viewpoint + "classes/{face}", Access::kPublic, face<scan::Layer::kClass>});
  router.add({"GET", "/api/v1/splits", Access::kPublic, splits});
  router.add({"GET", "/api/v1/splits/{split}/episodes", Access::kPublic, episodes});
  router.add({"GET", "/api/v1/continuous/{split}/episodes", Access::kPublic, continuous_episodes});
}

}  // namespace enfilade::service::http
