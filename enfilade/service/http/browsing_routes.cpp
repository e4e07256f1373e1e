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
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/names.h"
#include "enfilade/core/nearest_name.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/service/browsing/pictures.h"
#include "enfilade/service/browsing/site_json.h"
#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/http/messages.h"
#include "enfilade/service/http/routes.h"
#include "enfilade/tasks/benchmark.h"

namespace enfilade::service::http {
namespace {

/// 404 for a name that nothing has. \param what "scan"  \param names those that there are
HttpError nothing_named(std::string_view what, const std::string& name,
                        std::span<const std::string_view> names) {
  constexpr std::size_t kMostListed = 20;
  std::string advice =
      names.empty() ? "the data set has none" : fmt::format("there are {}", names.size());
  const bool few = !names.empty() && names.size() <= kMostListed;
  if (few || !nearest_names(name, names).empty()) advice = advice_on_name(name, names);
  return {404, fmt::format("{}: there is no {}; {}", what, quote(name), advice)};
}

ScanIndex scan_of(const RouteContext& context, const Request& request) {
  const std::string& name = request.parameter("scan");
  const graph::GraphSet& graphs = context.site->graphs();
  if (const auto found = graphs.find(name)) return *found;
  throw nothing_named("scan", name,
                      std::vector<std::string_view>(graphs.scans().begin(), graphs.scans().end()));
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
  const ScanIndex scan = scan_of(context, request);
  const homes::BuildingPlan plan = browsing::plan_of(*context.site, scan);
  draw::FloorPlanOptions options;
  options.underlay = plan.drawn();
  return draw::floor_plan_svg(context.site->graphs().graph(scan), {}, options);
}

/// "2.jpg" or "2.png".
std::size_t face_of(const std::string& name, std::string_view suffix) {
  if (name.size() != 1 + suffix.size() || name[0] < '0' || name[0] > '5' ||
      !name.ends_with(suffix)) {
    throw HttpError(404, fmt::format("a face is 0{} to 5{}", suffix, suffix));
  }
  return static_cast<std::size_t>(name[0] - '0');
}

/// A picture of the scan, which browsers may keep for a day; while the server's pictures are being
/// replaced, they ask each time. Both are asked before the picture: nothing gets the version of a
/// later picture, and none is kept that was replaced just then. No headers if the source does not
/// say which version it is.
template <class Make>
Response versioned(RouteContext& context, ScanIndex scan, std::string_view name, const Make& make) {
  const auto& change = context.config.pictures_change;
  const bool changes = change && change();
  const std::string version = context.faces.version(scan);
  Response response = make();
  if (version.empty()) return response;
  response.add_header("ETag", fmt::format("\"{}-{}\"", version, name));
  response.add_header("Cache-Control", changes ? "no-cache" : "public, max-age=86400");
  return response;
}

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
  const std::string& id = request.parameter("viewpoint");
  const auto viewpoint = source == nullptr ? std::nullopt : source->find(id);
  if (viewpoint) return {scan, *viewpoint, source};
  throw HttpError(404, fmt::format("viewpoint {} of scan {} has no pictures", quote(id),
                                   context.site->graphs().graph(scan).scan()));
}

/// \throws HttpError 404 where the viewpoint lacks the layer
void require(const Pictured& at, scan::Layer layer, const Request& request) {
  if (at.source->face_sizes(at.viewpoint)[index(layer)] != 0) return;
  throw HttpError(404, fmt::format("viewpoint {} has no {}", quote(request.parameter("viewpoint")),
                                   to_string(layer)));
}

/// The same for what is made of one viewpoint's pictures.
template <class Make>
Response versioned(RouteContext& context, const Pictured& at, std::string_view what,
                   const Make& make) {
  return versioned(context, at.scan, fmt::format("{}-{}", at.viewpoint.value, what), make);
}

template <scan::Layer kLayer>
Response face(RouteContext& context, const Request& request) {
  constexpr bool kColour = kLayer == scan::Layer::kColour;
  const std::size_t face = face_of(request.parameter("face"), kColour ? ".jpg" : ".png");
  const Pictured at = pictured(context, request);
  require(at, kLayer, request);
  return versioned(context, at, fmt::format("{}-{}", index(kLayer), face), [&] {
    return shared_response(kColour ? "image/jpeg" : "image/png",
                           context.faces.get(at.scan, at.viewpoint, kLayer)[face]);
  });
}

Response distances(RouteContext& context, const Request& request) {
  const Pictured at = pictured(context, request);
  require(at, scan::Layer::kDepth, request);
  return versioned(context, at, "distances", [&] {
    return shared_response("application/octet-stream",
                           context.faces.distances(at.scan, at.viewpoint));
  });
}

Response legends(RouteContext& context, const Request& request) {
  const Pictured at = pictured(context, request);
  return versioned(context, at, "legends", [&] {
    return shared_response("application/json", context.faces.legends(at.scan, at.viewpoint));
  });
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
  if (!context.stills.outlook(scan)) throw HttpError(404, "this scan has no pictures");
  return versioned(context, scan, fmt::format("still-{}", width),
                   [&] { return shared_response("image/jpeg", context.stills.get(scan, width)); });
}

Response thumbnail(RouteContext& context, const Request& request) {
  const Pictured at = pictured(context, request);
  require(at, scan::Layer::kColour, request);
  return versioned(context, at, "thumbnail", [&] {
    return shared_response("image/jpeg", context.stills.thumbnail(at.scan, at.viewpoint));
  });
}

browsing::EpisodeFilter filter_of(const Request& request) {
  return {request.text("scan"),
          request.text("q"),
          request.text("id"),
          request.text("trajectory"),
          request.number("offset", 0, 0, 1'000'000'000),
          request.number("limit", 50, 1, 500)};
}

/// The benchmark of a world that a query names; the first of that world where it names none.
const tasks::Benchmark& benchmark_of(const std::string& name, tasks::WorldKind world) {
  std::vector<std::string_view> names;
  for (const tasks::Benchmark& one : tasks::benchmarks()) {
    if (one.world != world) continue;
    if (name.empty() || one.name == name) return one;
    names.push_back(one.name);
  }
  throw nothing_named("task", name, names);
}

/// Of a query; R2R where it names none.
tasks::Task task_of(const std::string& name) {
  return benchmark_of(name, tasks::WorldKind::kGraph).task;
}

Response splits(RouteContext& context, const Request& request) {
  const std::string name = request.text("task");
  if (name == "all") return json_response(browsing::split_list_json(*context.site, std::nullopt));
  return json_response(browsing::split_list_json(*context.site, task_of(name)));
}

Response episodes(RouteContext& context, const Request& request) {
  const std::string& name = request.parameter("split");
  const tasks::Task task = task_of(request.text("task"));
  if (const PublicSplit* split = context.site->find_split(name, task)) {
    return json_response(
        browsing::episodes_json(*context.site, context.pieces, *split, filter_of(request)));
  }
  std::vector<std::string_view> names;
  for (const PublicSplit& one : context.site->splits()) {
    if (one.annotations.task == task) names.emplace_back(one.annotations.split);
  }
  throw nothing_named("split", name, names);
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
  const auto& benchmark = benchmark_of(request.text("task"), tasks::WorldKind::kContinuous);
  return json_response(
      context.roaming.episodes_json(benchmark, request.parameter("split"), filter_of(request)));
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
  router.add({"GET", viewpoint + "picture.jpg", Access::kPublic, thumbnail});
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
