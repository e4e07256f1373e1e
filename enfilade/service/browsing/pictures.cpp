#include "enfilade/service/browsing/pictures.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/draw/colour_maps.h"
#include "enfilade/image/codecs.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/render/renderer.h"

namespace enfilade::service::browsing {
namespace {

using nlohmann::ordered_json;

constexpr int kFaceQuality = 92;

std::shared_ptr<const std::string> file_of(const std::vector<std::uint8_t>& bytes) {
  return std::make_shared<const std::string>(reinterpret_cast<const char*>(bytes.data()),
                                             bytes.size());
}

FaceFiles make_files(const scan::PanoramaSource& source, ViewpointIndex viewpoint,
                     scan::Layer layer) {
  if (source.face_sizes(viewpoint)[index(layer)] == 0) {
    throw LookupError(fmt::format("this viewpoint has no {} pictures", to_string(layer)));
  }
  FaceFiles files;
  const bool colour = layer == scan::Layer::kColour;
  if (auto jpegs = colour ? source.colour_jpegs(viewpoint) : std::nullopt) {
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      files[k] = std::make_shared<const std::string>(std::move((*jpegs)[k]));
    }
    return files;
  }
  const scan::Panorama panorama = scan::read_panorama(source, viewpoint, scan::mask_of(layer));
  // One scale for the six depth pictures of a panorama, or the edges of faces would show.
  const draw::DepthRange range = draw::depth_range(panorama.depth);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    files[k] = file_of(colour ? image::encode_jpeg(panorama.colour[k], kFaceQuality)
                              : image::encode_png(layer == scan::Layer::kDepth
                                                      ? draw::colour_depth(panorama.depth[k], range)
                                                      : draw::colour_ids(panorama.classes[k])));
  }
  return files;
}

std::size_t bytes_of(const FaceFiles& files) {
  std::size_t bytes = 0;
  for (const auto& file : files) bytes += file == nullptr ? 0 : file->size();
  return bytes;
}

std::string hex(const draw::Rgb& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

ordered_json depth_legend(const image::CubeMap<std::uint16_t>& depth) {
  constexpr int kColours = 16;  // as many as the map is made of
  auto colours = ordered_json::array();
  for (int k = 0; k < kColours; ++k) {
    colours.push_back(hex(draw::depth_colour(static_cast<double>(k) / (kColours - 1))));
  }
  const auto [nearest, farthest] = draw::depth_range(depth);
  return {{"nearest", nearest}, {"farthest", farthest}, {"colours", colours}};
}

ordered_json class_legend(const image::CubeMap<std::uint16_t>& classes) {
  std::map<std::uint32_t, std::size_t> areas;
  std::size_t texels = 0;
  for (const image::Image16& face : classes) {
    for (const draw::IdArea& area : draw::count_ids(face)) areas[area.id] += area.pixels;
    texels += face.pixels.size();
  }
  std::vector<std::pair<std::uint32_t, std::size_t>> order(areas.begin(), areas.end());
  std::ranges::stable_sort(order, std::greater{}, &std::pair<std::uint32_t, std::size_t>::second);
  auto list = ordered_json::array();
  for (const auto& [id, pixels] : order) {
    const double share = static_cast<double>(pixels) / static_cast<double>(texels);
    list.push_back({{"id", id},
                    {"name", mesh::class_name(id)},
                    {"colour", hex(draw::id_colour(id))},
                    {"share", std::round(share * 1e4) / 1e4}});
  }
  return list;
}

// Points of a face's edge in distance_grid(), at most.
constexpr std::size_t kMostDistances = 96;

std::string distance_grid(const scan::PanoramaSource& source, ViewpointIndex viewpoint) {
  if (source.face_sizes(viewpoint)[index(scan::Layer::kDepth)] == 0) {
    throw source.lacks(scan::Layer::kDepth, viewpoint);
  }
  const auto depth =
      scan::read_panorama(source, viewpoint, scan::mask_of(scan::Layer::kDepth)).depth;
  const std::size_t size = depth[0].width, n = std::min(size, kMostDistances);
  constexpr unsigned kStep = 8;  // 2 mm
  std::string grid;
  grid.reserve(kCubeFaces * n * n * 2);
  const auto middle = [&](std::size_t k) { return (2 * k + 1) * size / (2 * n); };
  for (const image::Image16& face : depth) {
    for (std::size_t y = 0; y < n; ++y) {
      for (std::size_t x = 0; x < n; ++x) {
        const unsigned reading = *face.at(middle(x), middle(y));
        // What is nearer than 2 mm must not become unknown.
        const unsigned kept = reading == 0 ? 0 : std::max(reading / kStep, 1U) * kStep;
        grid.push_back(static_cast<char>(kept & 255U));
        grid.push_back(static_cast<char>(kept >> 8U));
      }
    }
  }
  return grid;
}

ordered_json legends_json(const scan::PanoramaSource& source, ViewpointIndex viewpoint) {
  const scan::FaceSizes sizes = source.face_sizes(viewpoint);
  ordered_json legends{{"depth", nullptr}, {"classes", nullptr}};
  const auto read = [&](scan::Layer layer) {
    return scan::read_panorama(source, viewpoint, scan::mask_of(layer));
  };
  using enum scan::Layer;
  if (sizes[index(kDepth)] != 0) legends["depth"] = depth_legend(read(kDepth).depth);
  if (sizes[index(kClass)] != 0) legends["classes"] = class_legend(read(kClass).classes);
  return legends;
}

constexpr int kStillQuality = 85;
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

/// The most open direction, and how open it is.
struct Widest {
  Radians heading;
  std::uint64_t sum = 0;  // 0: no depth says so
};

/// With depth by the distance to surfaces, else towards the farthest neighbour.
Widest widest(Drawing& drawing, const graph::NavGraph& graph, const scan::PanoramaSource& source,
              const Place& place) {
  if (source.face_sizes(place.in_source)[index(scan::Layer::kDepth)] == 0) {
    return {towards_farthest(graph, place.in_graph)};
  }
  const auto sums = drawing.openness(place.in_source, Reach(graph, place.in_graph));
  const auto most = std::ranges::max_element(sums);
  return {heading_of(static_cast<std::size_t>(most - sums.begin())), *most};
}

std::optional<Outlook> choose(const std::shared_ptr<const Site>& site, ScanIndex scan) {
  const scan::PanoramaSource* source = site->panoramas().find_source(scan);
  if (source == nullptr) return std::nullopt;
  const graph::NavGraph& graph = site->graphs().graph(scan);
  std::optional<Outlook> best;
  std::uint64_t most = 0;
  Drawing drawing(panoramas_of(site), scan);
  for (const Place& place : candidates(graph, *source)) {
    const auto [heading, sum] = widest(drawing, graph, *source, place);
    if (best && sum <= most) continue;
    most = sum;
    best = {place.in_graph, heading, kElevation};
  }
  return best;
}

}  // namespace

Faces::Faces(const scan::PanoramaSet& panoramas, std::size_t most_bytes)
    : newest_(panoramas), kept_(most_bytes, bytes_of) {}

FaceFiles Faces::get(ScanIndex scan, ViewpointIndex viewpoint, scan::Layer layer) {
  return find_or_make(scan, viewpoint, to_string(layer), [&](const scan::PanoramaSource& source) {
    return make_files(source, viewpoint, layer);
  });
}

std::shared_ptr<const std::string> Faces::distances(ScanIndex scan, ViewpointIndex viewpoint) {
  const auto make = [&](const scan::PanoramaSource& source) {
    return FaceFiles{std::make_shared<const std::string>(distance_grid(source, viewpoint))};
  };
  return find_or_make(scan, viewpoint, "distances", make)[0];
}

std::shared_ptr<const std::string> Faces::legends(ScanIndex scan, ViewpointIndex viewpoint) {
  const auto make = [&](const scan::PanoramaSource& source) {
    return FaceFiles{std::make_shared<const std::string>(legends_json(source, viewpoint).dump())};
  };
  return find_or_make(scan, viewpoint, "legends", make)[0];
}

FaceFiles Faces::find_or_make(ScanIndex scan, ViewpointIndex viewpoint, std::string_view what,
                              const Make& make) {
  const NewestSource newest = newest_.get(scan);
  return kept_.get({scan, viewpoint, what, newest.replaced}, [&] {
    FaceFiles files = make(*newest.source);
    // What was made are copies; visitors walk through whole buildings.
    newest.source->release(viewpoint);
    return files;
  });
}

std::string Faces::version(ScanIndex scan) {
  const NewestSource newest = newest_.get(scan);
  const std::pair key(scan, newest.replaced);
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = versions_.find(key); found != versions_.end()) return found->second;
  }
  const std::string state = newest.source->state();
  const std::string version =
      state.empty() ? "" : fmt::format("{:016x}", stream_of(state.data(), state.size()));
  const std::scoped_lock lock(mutex_);
  return versions_.emplace(key, version).first->second;
}

constexpr std::size_t kMostThumbnails = 8U << 20U;  // bytes

Stills::Stills(std::shared_ptr<const Site> site)
    : site_(std::move(site)),
      newest_(site_->panoramas()),
      thumbnails_(kMostThumbnails,
                  [](const std::shared_ptr<const std::string>& file) { return file->size(); }) {}

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
  const auto& outlook = find_outlook(scan);
  if (!outlook) return nullptr;
  const NewestSource newest = newest_.get(scan);
  const std::tuple key(scan, width, newest.replaced);
  const auto found = files_.find(key);
  if (found != files_.end()) return found->second;
  const auto viewpoint = newest.source->at(site_->graphs().graph(scan).id(outlook->viewpoint));
  Drawing drawing(scan::PanoramaSet::of({newest.source}), ScanIndex(0));
  const auto file = file_of(
      image::encode_jpeg(drawing.colour(viewpoint, outlook->heading, width), kStillQuality));
  return files_.emplace(key, file).first->second;
}

std::shared_ptr<const std::string> Stills::thumbnail(ScanIndex scan, ViewpointIndex viewpoint) {
  const NewestSource newest = newest_.get(scan);
  return thumbnails_.get({scan, viewpoint, newest.replaced}, [&] {
    const std::scoped_lock lock(drawing_);
    const scan::PanoramaSource& source = *newest.source;
    if (source.face_sizes(viewpoint)[index(scan::Layer::kColour)] == 0) {
      throw source.lacks(scan::Layer::kColour, viewpoint);
    }
    const graph::NavGraph& graph = site_->graphs().graph(scan);
    const auto in_graph = graph.find(source.poses()[viewpoint.at()].viewpoint);
    Drawing drawing(scan::PanoramaSet::of({newest.source}), ScanIndex(0));
    Radians heading(0);
    if (in_graph) heading = widest(drawing, graph, source, Place{*in_graph, viewpoint}).heading;
    return file_of(
        image::encode_jpeg(drawing.colour(viewpoint, heading, kThumbnailWidth), kStillQuality));
  });
}

}  // namespace enfilade::service::browsing
