#include "enfilade/service/browsing/stills.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "enfilade/image/codecs.h"
#include "enfilade/render/pictures.h"

namespace enfilade::service::browsing {
namespace {

constexpr int kJpegQuality = 85;
// Slightly down: floors tell more of a room than ceilings do.
constexpr Radians kElevation = degrees(-8);
constexpr std::size_t kCandidates = 4;
constexpr std::size_t kHeadings = 12;
// What is farther counts no more: a long corridor shows less than a large room.
constexpr double kFarEnough = 7;  // m
// From the outermost viewpoints to where a building ends: what one sees through its windows is not
// what a picture of it should show.
constexpr double kBeyondViewpoints = 1.5;  // m

Radians heading_of(std::size_t k) { return degrees(360.0 * static_cast<double>(k) / kHeadings); }

/// Metres from a viewpoint to where the building ends: to the box around all viewpoints and
/// kBeyondViewpoints more, at most kFarEnough.
class Reach {
 public:
  Reach(const graph::NavGraph& graph, ViewpointIndex viewpoint) {
    const Vec3f here = graph.position(viewpoint);
    for (const Vec3f& there : graph.positions()) {
      east_ = std::max(east_, double{there.x - here.x});
      west_ = std::max(west_, double{here.x - there.x});
      north_ = std::max(north_, double{there.y - here.y});
      south_ = std::max(south_, double{here.y - there.y});
    }
  }
  double operator()(Radians heading) const {
    const double x = std::sin(heading.value);
    const double y = std::cos(heading.value);
    const auto until = [](double room, double speed) {
      return (room + kBeyondViewpoints) / std::max(std::abs(speed), 1e-9);
    };
    return std::min(
        {until(x > 0 ? east_ : west_, x), until(y > 0 ? north_ : south_, y), kFarEnough});
  }

 private:
  double east_ = 0, west_ = 0, north_ = 0, south_ = 0;
};

/// A renderer that keeps nothing: stills are drawn once, and the server's memory is for others.
class Drawing {
 public:
  Drawing(std::shared_ptr<const scan::PanoramaSet> panoramas, ScanIndex scan)
      : scan_(scan),
        source_(panoramas->source(scan)),
        renderer_(
            render::make_renderer(std::make_shared<render::FaceCache>(
                                      std::move(panoramas), render::FaceCacheConfig{0, 1, false}),
                                  {render::Backend::kCpu, 1, {}, ""})) {}

  image::Image8 colour(ViewpointIndex viewpoint, Radians heading, std::int64_t width) {
    const auto columns = static_cast<std::uint32_t>(width);
    const Camera camera{columns, columns * 5 / 8, kStillFieldOfView};
    return draw(camera, viewpoint, std::vector{heading}, scan::Layer::kColour).colour;
  }

  /// How open it is in each of kHeadings directions from north on: sums over small pictures.
  std::vector<std::uint64_t> openness(ViewpointIndex viewpoint, const Reach& reach) {
    constexpr Camera kSmall{32, 20, kStillFieldOfView};
    std::vector<Radians> headings;
    for (std::size_t k = 0; k < kHeadings; ++k) headings.push_back(heading_of(k));
    const auto depth = draw(kSmall, viewpoint, headings, scan::Layer::kDepth).depth;
    const double focal = kSmall.height / 2 / std::tan(kStillFieldOfView.value / 2);
    std::vector<std::uint64_t> sums(kHeadings);
    const std::uint16_t* pixel = depth.pixels.data();
    for (std::size_t k = 0; k < kHeadings; ++k) {
      for (std::size_t row = 0; row < kSmall.height; ++row) {
        for (std::size_t column = 0; column < kSmall.width; ++column) {
          const double turn =
              std::atan((static_cast<double>(column) + 0.5 - kSmall.width / 2) / focal);
          const double most = reach(headings[k] + Radians(turn)) * std::cos(turn);
          sums[k] +=
              std::min(*pixel++, static_cast<std::uint16_t>(most * scan::kDepthUnitsPerMetre));
        }
      }
    }
    return sums;
  }

 private:
  render::Pictures draw(const Camera& camera, ViewpointIndex viewpoint,
                        const std::vector<Radians>& headings, scan::Layer layer) {
    std::vector<render::View> views;
    for (const Radians heading : headings) {
      views.push_back({scan_, viewpoint, heading, kElevation});
    }
    render::Pictures pictures;
    const render::Outputs outputs =
        outputs_into(pictures, scan::mask_of(layer), camera.width, camera.height, views.size());
    renderer_->render(camera, views, outputs);
    source_.release(viewpoint);
    return pictures;
  }

  ScanIndex scan_;
  const scan::PanoramaSource& source_;
  std::unique_ptr<render::Renderer> renderer_;
};

/// A viewpoint with pictures, in the graph and among the panoramas.
struct Place {
  ViewpointIndex in_graph, in_source;
};

/// Those with the most edges first; of equals the one that comes first in the graph.
std::vector<Place> candidates(const graph::NavGraph& graph, const scan::PanoramaSource& source) {
  std::vector<Place> places;
  for (std::size_t v = 0; v < graph.size(); ++v) {
    const ViewpointIndex viewpoint(v);
    const auto pictured = source.find(graph.id(viewpoint));
    if (!graph.included(viewpoint) || !pictured) continue;
    if (source.face_sizes(*pictured)[index(scan::Layer::kColour)] == 0) continue;
    places.push_back({viewpoint, *pictured});
  }
  std::ranges::stable_sort(places, std::ranges::greater{}, [&graph](const Place& place) {
    return graph.edges(place.in_graph).size();
  });
  places.resize(std::min(places.size(), kCandidates));
  return places;
}

Radians towards_farthest(const graph::NavGraph& graph, ViewpointIndex viewpoint) {
  const auto edges = graph.edges(viewpoint);
  const auto farthest = std::ranges::max_element(edges, {}, &graph::Edge::distance);
  return farthest == edges.end() ? Radians(0) : farthest->heading;
}

std::shared_ptr<const scan::PanoramaSet> panoramas_of(const std::shared_ptr<const Site>& site) {
  return {site, &site->panoramas()};  // lives as long as the site
}

std::optional<Outlook> choose(const std::shared_ptr<const Site>& site, ScanIndex scan) {
  const scan::PanoramaSource* source = site->panoramas().find_source(scan);
  if (source == nullptr) return std::nullopt;
  const graph::NavGraph& graph = site->graphs().graph(scan);
  const std::vector<Place> places = candidates(graph, *source);
  if (places.empty()) return std::nullopt;
  Outlook best{places[0].in_graph, towards_farthest(graph, places[0].in_graph), kElevation};
  std::uint64_t most = 0;
  Drawing drawing(panoramas_of(site), scan);
  for (const Place& place : places) {
    if (source->face_sizes(place.in_source)[index(scan::Layer::kDepth)] == 0) continue;
    const auto sums = drawing.openness(place.in_source, Reach(graph, place.in_graph));
    const auto widest = std::ranges::max_element(sums);
    if (*widest <= most) continue;
    most = *widest;
    const auto turn = static_cast<std::size_t>(widest - sums.begin());
    best = {place.in_graph, heading_of(turn), kElevation};
  }
  return best;
}

}  // namespace

const std::optional<Outlook>& Stills::find_outlook(ScanIndex scan) {
  const auto found = outlooks_.find(scan);
  if (found != outlooks_.end()) return found->second;
  return outlooks_.emplace(scan, choose(site_, scan)).first->second;
}

std::optional<Outlook> Stills::outlook(ScanIndex scan) {
  const std::scoped_lock lock(mutex_);
  return find_outlook(scan);
}

std::shared_ptr<const std::string> Stills::get(ScanIndex scan, std::int64_t width) {
  const std::scoped_lock lock(mutex_);
  const auto found = files_.find({scan, width});
  if (found != files_.end()) return found->second;
  std::shared_ptr<const std::string> file;
  if (const auto& outlook = find_outlook(scan)) {
    const scan::PanoramaSource& source = site_->panoramas().source(scan);
    const auto viewpoint = source.at(site_->graphs().graph(scan).id(outlook->viewpoint));
    const auto jpeg = image::encode_jpeg(
        Drawing(panoramas_of(site_), scan).colour(viewpoint, outlook->heading, width),
        kJpegQuality);
    file = std::make_shared<const std::string>(reinterpret_cast<const char*>(jpeg.data()),
                                               jpeg.size());
  }
  return files_.emplace(std::pair(scan, width), file).first->second;
}

}  // namespace enfilade::service::browsing
