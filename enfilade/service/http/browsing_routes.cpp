// Scans (graphs, faces, plans), splits and episodes.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/service/browsing/plans.h"
#include "enfilade/service/browsing/site_json.h"
#include "enfilade/service/http/routes.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"

namespace enfilade::service::http {
namespace {

ScanIndex scan_of(const Context& context, const Request& request) {
  const auto found = context.site->graphs().find(request.parameter("scan"));
  if (!found) throw HttpError(404, "no scan of this name");
  return *found;
}

/// Responses that don't change while the server runs, by path. Made at the first request.
class Cache {
 public:
  template <class Make>
  Response get(const Request& request, const char* type, const Make& make) {
    {
      const std::scoped_lock lock(mutex_);
      const auto found = responses_.find(request.path);
      if (found != responses_.end()) return found->second;
    }
    Response response = text_response(type, make());
    const std::string& body = *response.body;
    response.add_header("ETag", fmt::format("\"{:016x}\"", stream_of(body.data(), body.size())));
    response.add_header("Cache-Control", "no-cache");  // ask each time, and mostly get a 304
    const std::scoped_lock lock(mutex_);
    return responses_.emplace(request.path, std::move(response)).first->second;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, Response> responses_;
};

Response floor_plan(Cache& cache, Context& context, const Request& request) {
  const ScanIndex scan = scan_of(context, request);
  Response response = cache.get(request, "image/svg+xml", [&] {
    return draw::floor_plan_svg(context.site->graphs().graph(scan));
  });
  // An SVG has its own styles, and must not run scripts.
  response.add_header("Content-Security-Policy", "default-src 'none'; style-src 'unsafe-inline'");
  return response;
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
void add_version(Context& context, ScanIndex scan, std::string_view name, Response& response) {
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
Pictured pictured(const Context& context, const Request& request) {
  const ScanIndex scan = scan_of(context, request);
  const scan::PanoramaSource* source = context.site->panoramas().find_source(scan);
  const auto viewpoint =
      source == nullptr ? std::nullopt : source->find(request.parameter("viewpoint"));
  if (!viewpoint) throw HttpError(404, kNoPicture);
  return {scan, *viewpoint, source};
}

/// The same for what is made of one viewpoint's pictures.
void let_keep(Context& context, const Pictured& at, const std::string& what, Response& response) {
  add_version(context, at.scan, fmt::format("{}-{}", at.viewpoint.value, what), response);
}

Response face(Context& context, const Request& request, scan::Layer layer) {
  const bool colour = layer == scan::Layer::kColour;
  const std::size_t face = face_of(request.parameter("face"), colour ? ".jpg" : ".png");
  const Pictured at = pictured(context, request);
  if (at.source->face_sizes(at.viewpoint)[index(layer)] == 0) throw HttpError(404, kNoPicture);
  Response response;
  response.type = colour ? "image/jpeg" : "image/png";
  response.body = context.faces.get(at.scan, at.viewpoint, layer)[face];
  let_keep(context, at, fmt::format("{}-{}", index(layer), face), response);
  return response;
}

Response distances(Context& context, const Request& request) {
  const Pictured at = pictured(context, request);
  if (at.source->face_sizes(at.viewpoint)[index(scan::Layer::kDepth)] == 0) {
    throw HttpError(404, "this viewpoint has no depth");
  }
  Response response;
  response.type = "application/octet-stream";
  response.body = context.faces.distances(at.scan, at.viewpoint);
  let_keep(context, at, "distances", response);
  return response;
}

Response legends(Context& context, const Request& request) {
  const Pictured at = pictured(context, request);
  Response response;
  response.body = context.faces.legends(at.scan, at.viewpoint);
  let_keep(context, at, "legends", response);
  return response;
}

Response outlook(Context& context, const Request& request) {
  const ScanIndex scan = scan_of(context, request);
  const auto found = context.stills.outlook(scan);
  if (!found) throw HttpError(404, "this scan has no pictures");
  return json_response({{"viewpoint", context.site->graphs().graph(scan).id(found->viewpoint)},
                        {"heading", found->heading.value},
                        {"elevation", found->elevation.value},
                        {"vfov", browsing::kStillFieldOfView.value}});
}

Response still(Context& context, const Request& request) {
  const ScanIndex scan = scan_of(context, request);
  const auto& widths = browsing::kStillWidths;
  const std::int64_t width = request.number("width", widths.front(), widths.front(), widths.back());
  if (std::ranges::find(widths, width) == widths.end()) {
    throw HttpError(400, fmt::format("width: {}; it can be {}", width, fmt::join(widths, " or ")));
  }
  Response response;
  response.type = "image/jpeg";
  response.body = context.stills.get(scan, width);
  if (response.body == nullptr) throw HttpError(404, "this scan has no pictures");
  add_version(context, scan, fmt::format("still-{}", width), response);
  return response;
}

constexpr std::int64_t kMostEpisodes = 500;

/// Of a query; R2R where it names none.
tasks::Task task_of(const std::string& name) {
  if (name.empty()) return tasks::Task::kR2r;
  try {
    return tasks::benchmark(name, tasks::World::kGraph).task;
  } catch (const LookupError&) {
    throw HttpError(404, "no benchmark of this name");
  }
}

Response splits(Context& context, const Request& request) {
  const std::string name = request.text("task");
  if (name == "all") return json_response(browsing::split_list_json(*context.site, std::nullopt));
  return json_response(browsing::split_list_json(*context.site, task_of(name)));
}

Response episodes(Context& context, const Request& request) {
  const PublicSplit* split =
      context.site->find_split(request.parameter("split"), task_of(request.text("task")));
  if (split == nullptr) throw HttpError(404, "no split of this name");
  return json_response(
      browsing::episodes_json(*context.site, *split,
                              {request.text("scan"), request.text("q"), request.text("id"),
                               request.number("offset", 0, 0, 1'000'000'000),
                               request.number("limit", 50, 1, kMostEpisodes)}));
}

/// What pages show in their headers is known with the first thing that they ask for.
std::string with_runs(nlohmann::ordered_json about, const Context& context) {
  about["runs"] = !context.config.runs.empty();
  return about.dump();
}

}  // namespace

void add_browsing_routes(Router& router) {
  const auto cache = std::make_shared<Cache>();
  const std::string one = "/api/v1/scans/{scan}";
  router.add(
      {"GET", "/api/v1/scans", Access::kPublic, [cache](Context& context, const Request& request) {
         return cache->get(request, "application/json", [&] {
           return with_runs(browsing::scan_list_json(*context.site), context);
         });
       }});
  router.add({"GET", one, Access::kPublic, [cache](Context& context, const Request& request) {
                const ScanIndex scan = scan_of(context, request);
                return cache->get(request, "application/json", [&] {
                  return with_runs(browsing::scan_json(*context.site, scan), context);
                });
              }});
  router.add({"GET", one + "/plan.svg", Access::kPublic,
              [cache](Context& context, const Request& request) {
                return floor_plan(*cache, context, request);
              }});
  router.add({"GET", one + "/outlook", Access::kPublic, outlook});
  router.add({"GET", one + "/picture.jpg", Access::kPublic, still});
  router.add(
      {"GET", one + "/plan", Access::kPublic, [cache](Context& context, const Request& request) {
         const ScanIndex scan = scan_of(context, request);
         return cache->get(request, "application/json",
                           [&] { return browsing::plan_json(*context.site, scan).dump(); });
       }});
  router.add({"GET", one + "/viewpoints/{viewpoint}/distances", Access::kPublic, distances});
  router.add({"GET", one + "/viewpoints/{viewpoint}/legends", Access::kPublic, legends});
  const std::pair<const char*, scan::Layer> layers[]{{"faces", scan::Layer::kColour},
                                                     {"depth", scan::Layer::kDepth},
                                                     {"classes", scan::Layer::kClass}};
  for (const auto& [name, layer] : layers) {
    router.add({"GET", fmt::format("{}/viewpoints/{{viewpoint}}/{}/{{face}}", one, name),
                Access::kPublic, [layer = layer](Context& context, const Request& request) {
                  return face(context, request, layer);
                }});
  }
  router.add({"GET", "/api/v1/splits", Access::kPublic, splits});
  router.add({"GET", "/api/v1/splits/{split}/episodes", Access::kPublic, episodes});
}

}  // namespace enfilade::service::http
