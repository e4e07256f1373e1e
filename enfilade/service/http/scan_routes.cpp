// Scans: graphs, faces, plans.
#include <fmt/format.h>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/rng.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/service/http/app.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

ScanIndex scan_of(const Context& context, const Request& request) {
  const auto found = context.site->graphs().find(request.parameter("scan"));
  if (!found) throw HttpError(404, "unknown-scan", "no scan of this name");
  return *found;
}

/// The panoramas of a scan; null if the data set has none of it.
const scan::PanoramaSource* source_of(const Context& context, ScanIndex scan) {
  try {
    return &context.site->panoramas().source(scan);
  } catch (const LookupError&) {
    return nullptr;
  }
}

// A float's shortest digits: who reads them as a double and rounds has the same float.
ordered_json number(float value) { return ordered_json::parse(fmt::format("{}", value)); }

ordered_json viewpoint_json(const graph::NavGraph& graph, ViewpointIndex v,
                            const scan::PanoramaSource* source) {
  const Vec3f position = graph.position(v);
  ordered_json one{{"id", graph.id(v)},
                   {"included", graph.included(v)},
                   {"position", {number(position.x), number(position.y), number(position.z)}},
                   {"height", number(graph.height(v))}};
  auto& neighbours = one["neighbours"] = ordered_json::array();
  for (const graph::Edge& edge : graph.edges(v)) neighbours.push_back(edge.target.value);
  auto& layers = one["layers"] = ordered_json::array();
  const auto pictured = source == nullptr ? std::nullopt : source->find(graph.id(v));
  if (!pictured) return one;
  one["rotation"] = source->poses()[pictured->at()].world_from_panorama.m;
  const scan::FaceSizes sizes = source->face_sizes(*pictured);
  for (const scan::Layer layer : {scan::Layer::kColour, scan::Layer::kDepth, scan::Layer::kClass}) {
    if (sizes[index(layer)] != 0) layers.push_back(to_string(layer));
  }
  return one;
}

std::string scan_json(const Context& context, ScanIndex scan) {
  const graph::NavGraph& graph = context.site->graphs().graph(scan);
  const scan::PanoramaSource* source = source_of(context, scan);
  ordered_json out{{"scan", graph.scan()}, {"synthetic", context.site->synthetic()}};
  auto& storeys = out["storeys"] = ordered_json::array();
  for (const draw::Storey& storey : draw::find_storeys(graph)) {
    auto& list = storeys.emplace_back(ordered_json{{"floor", storey.floor}})["viewpoints"] =
        ordered_json::array();
    for (const ViewpointIndex v : storey.viewpoints) list.push_back(v.value);
  }
  auto& viewpoints = out["viewpoints"] = ordered_json::array();
  for (std::size_t v = 0; v < graph.size(); ++v) {
    viewpoints.push_back(viewpoint_json(graph, ViewpointIndex(v), source));
  }
  return out.dump();
}

std::string scan_list_json(const Context& context) {
  auto list = ordered_json::array();
  for (std::size_t s = 0; s < context.site->graphs().size(); ++s) {
    const graph::NavGraph& graph = context.site->graphs().graph(ScanIndex(s));
    list.push_back({{"scan", graph.scan()},
                    {"viewpoints", graph.included_count()},
                    {"edges", graph.edge_count() / 2},
                    {"pictures", source_of(context, ScanIndex(s)) != nullptr}});
  }
  return ordered_json{{"synthetic", context.site->synthetic()}, {"scans", list}}.dump();
}

/// Answers that don't change while the server runs, made when first asked for.
class Kept {
 public:
  explicit Kept(std::string type) : type_(std::move(type)) {}

  template <class Make>
  Response get(const std::string& key, Make make) {
    {
      const std::scoped_lock lock(mutex_);
      if (const auto found = responses_.find(key); found != responses_.end()) return found->second;
    }
    const std::string body = make();
    Response response = json_response(body);
    response.type = type_;
    response.headers.emplace_back("ETag",
                                  fmt::format("\"{:016x}\"", stream_of(body.data(), body.size())));
    response.headers.emplace_back("Cache-Control", "no-cache");  // ask, and mostly hear 304
    const std::scoped_lock lock(mutex_);
    return responses_.emplace(key, std::move(response)).first->second;
  }

 private:
  std::string type_;
  std::mutex mutex_;
  std::map<std::string, Response> responses_;
};

/// "2.jpg" or "2.png".
std::size_t face_of(const std::string& name, std::string_view suffix) {
  if (name.size() != 1 + suffix.size() || name[0] < '0' || name[0] > '5' ||
      !name.ends_with(suffix)) {
    throw HttpError(404, "unknown-face", fmt::format("a face is 0{} to 5{}", suffix, suffix));
  }
  return static_cast<std::size_t>(name[0] - '0');
}

Response face_response(Context& context, const Request& request, scan::Layer layer) {
  const bool colour = layer == scan::Layer::kColour;
  const std::size_t face = face_of(request.parameter("face"), colour ? ".jpg" : ".png");
  const ScanIndex scan = scan_of(context, request);
  const scan::PanoramaSource* source = source_of(context, scan);
  const auto viewpoint =
      source == nullptr ? std::nullopt : source->find(request.parameter("viewpoint"));
  if (!viewpoint || source->face_sizes(*viewpoint)[index(layer)] == 0) {
    throw HttpError(404, "no-picture", "no such picture of this viewpoint");
  }
  Response response;
  response.type = colour ? "image/jpeg" : "image/png";
  response.body = context.faces.get(scan, *viewpoint, layer)[face];
  const std::string version = context.faces.version(scan);
  if (!version.empty()) {
    response.headers.emplace_back(
        "ETag", fmt::format("\"{}-{}-{}-{}\"", version, viewpoint->value, index(layer), face));
    response.headers.emplace_back("Cache-Control", "public, max-age=86400");
  }
  return response;
}

}  // namespace

void add_scan_routes(Router& router, Context& context) {
  const auto kept = std::make_shared<Kept>("application/json");
  const auto plans = std::make_shared<Kept>("image/svg+xml");
  router.add({"GET", "/api/v1/scans", Access::kPublic, [&context, kept](const Request&) {
                return kept->get("", [&] { return scan_list_json(context); });
              }});
  router.add(
      {"GET", "/api/v1/scans/{scan}", Access::kPublic, [&context, kept](const Request& request) {
         const ScanIndex scan = scan_of(context, request);
         return kept->get(request.parameter("scan"), [&] { return scan_json(context, scan); });
       }});
  router.add({"GET", "/api/v1/scans/{scan}/plan.svg", Access::kPublic,
              [&context, plans](const Request& request) {
                const ScanIndex scan = scan_of(context, request);
                Response response = plans->get(request.parameter("scan"), [&] {
                  return draw::floor_plan_svg(context.site->graphs().graph(scan));
                });
                // A picture with styles of its own, which must not run anything.
                response.headers.emplace_back("Content-Security-Policy",
                                              "default-src 'none'; style-src 'unsafe-inline'");
                return response;
              }});
  const std::pair<const char*, scan::Layer> layers[]{{"faces", scan::Layer::kColour},
                                                     {"depth", scan::Layer::kDepth},
                                                     {"classes", scan::Layer::kClass}};
  for (const auto& [name, layer] : layers) {
    router.add({"GET",
                fmt::format("/api/v1/scans/{{scan}}/viewpoints/{{viewpoint}}/{}/{{face}}", name),
                Access::kPublic, [&context, layer = layer](const Request& request) {
                  return face_response(context, request, layer);
                }});
  }
}

}  // namespace enfilade::service::http
