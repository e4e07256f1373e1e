#include "enfilade/mesh/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "enfilade/core/threads.h"
#include "enfilade/image/tone.h"

namespace enfilade::mesh {

namespace {

constexpr std::uint32_t kLargestFace = 8192, kMostSamples = 16;
constexpr std::uint32_t kTile = 8;  // pixels across
constexpr std::size_t kTilePixels = kTile * kTile;
constexpr std::size_t kRays = 256;  // looked along at once

// --- tone, of colours that are averaged after it ----------------------------------------------

Vec3f shoulder(Vec3f c) {
  return {image::shoulder(c.x), image::shoulder(c.y), image::shoulder(c.z)};
}

// --- pixels ---------------------------------------------------------------------------------

// Where a pixel's rays pass through it, from its top left corner, in pixels. No two share a row or
// a column of the pixel's finer grid, so that nearly vertical and nearly horizontal edges get all
// steps between two colours.
using Pattern = std::vector<std::array<double, 2>>;
Pattern pattern_of(std::uint32_t samples) {
  const auto n = static_cast<std::uint32_t>(std::lround(std::sqrt(samples)));
  Pattern pattern;
  for (std::uint32_t a = 0; a < n; ++a) {
    for (std::uint32_t b = 0; b < n; ++b) {
      pattern.push_back({(a + (b + 0.5) / n) / n, (b + (n - 1 - a + 0.5) / n) / n});
    }
  }
  return pattern;
}

// A picture to take: pixel coordinates (0, 0 at the top left corner, whole numbers at edges) seen
// along origin + x across + y down.
struct View {
  Vec3d corner, across, down;
  std::uint32_t width = 0, height = 0;
  Vec3d forward;  ///< of length 1: depth is along it; 0: along the ray
  std::uint8_t* colour = nullptr;
  std::uint16_t* depth = nullptr;
  std::uint16_t* classes = nullptr;
  std::uint32_t* instances = nullptr;

  Vec3f towards(double x, double y) const {
    const Vec3d d = corner + x * across + y * down;
    const double size = length(d);
    return to_float({d.x / size, d.y / size, d.z / size});
  }
  std::uint32_t tiles_across() const { return (width + kTile - 1) / kTile; }
  std::uint32_t tiles() const { return tiles_across() * ((height + kTile - 1) / kTile); }
};

class Photographer {
 public:
  Photographer(const LitMesh& mesh, Vec3d eye, const CaptureOptions& options)
      : mesh_(mesh), eye_(to_float(eye)), options_(options), pattern_(pattern_of(options.samples)) {
    scale_ = image::kMidGrey<float> / mesh.key() * std::exp2(options.exposure);
  }

  void take(std::span<const View> views) const {
    std::size_t tiles = 0;
    for (const View& view : views) tiles += view.tiles();
    constexpr std::size_t kGrain = 8;
    parallel_for(tiles, kGrain, options_.threads, [&](std::size_t first, std::size_t last) {
      for (std::size_t tile = first; tile < last; ++tile) {
        std::size_t at = tile;
        const View* view = views.data();
        for (; at >= view->tiles(); ++view) at -= view->tiles();
        take_tile(*view, static_cast<std::uint32_t>(at));
      }
    });
  }

 private:
  // The tile's pixels, in Z-order.
  struct Pixels {
    std::array<TilePlace, kTilePixels> at;
    std::size_t count = 0;
  };

  void take_tile(const View& view, std::uint32_t tile) const {
    const std::uint32_t x0 = tile % view.tiles_across() * kTile;
    const std::uint32_t y0 = tile / view.tiles_across() * kTile;
    Pixels pixels;
    for (const TilePlace place : kZOrder) {
      const TilePlace at{x0 + place.x, y0 + place.y};
      if (at.x < view.width && at.y < view.height) pixels.at[pixels.count++] = at;
    }
    const bool truth = view.depth != nullptr || view.classes != nullptr;
    const bool shared = view.colour != nullptr && pattern_.size() == 1;
    if (truth || shared) take_middles(view, pixels, shared);
    if (view.colour != nullptr && !shared) take_colours(view, pixels);
  }

  void take_middles(const View& view, const Pixels& pixels, bool colours) const {
    std::array<Ray, kTilePixels> rays;
    std::array<Hit, kTilePixels> hits;
    const std::size_t n = pixels.count;
    for (std::size_t i = 0; i < n; ++i) {
      rays[i] = {eye_, view.towards(pixels.at[i].x + 0.5, pixels.at[i].y + 0.5)};
    }
    const auto all = std::span(rays).first(n);
    mesh_.tracer().trace(all, std::span(hits).first(n));
    for (std::size_t i = 0; i < n; ++i) write_truth(view, pixels.at[i], rays[i], hits[i]);
    if (!colours) return;
    std::array<Vec3f, kTilePixels> radiance;
    mesh_.look(all, std::span(hits).first(n), std::span(radiance).first(n), spread(view));
    for (std::size_t i = 0; i < n; ++i) {
      write_colour(view, pixels.at[i], shoulder(scale_ * radiance[i]));
    }
  }

  void take_colours(const View& view, const Pixels& pixels) const {
    std::array<Ray, kRays> rays;
    std::array<Vec3f, kRays> radiance;
    const std::size_t samples = pattern_.size(), at_once = kRays / samples;
    for (std::size_t first = 0; first < pixels.count; first += at_once) {
      const std::size_t last = std::min(first + at_once, pixels.count);
      std::size_t n = 0;
      for (std::size_t i = first; i < last; ++i) {
        for (const auto& [dx, dy] : pattern_) {
          rays[n++] = {eye_, view.towards(pixels.at[i].x + dx, pixels.at[i].y + dy)};
        }
      }
      mesh_.look(std::span(rays).first(n), std::span(radiance).first(n), spread(view));
      n = 0;
      for (std::size_t i = first; i < last; ++i) {
        // Averaged after the tone curve: one ray to a bright window must not make a white pixel.
        Vec3f sum;
        for (std::size_t k = 0; k < samples; ++k) sum += shoulder(scale_ * radiance[n++]);
        write_colour(view, pixels.at[i], (1 / static_cast<float>(samples)) * sum);
      }
    }
  }

  float spread(const View& view) const {
    const double pixel = std::sqrt(length(view.across) * length(view.down));
    return static_cast<float>(pixel / std::sqrt(static_cast<double>(pattern_.size())));
  }

  static void write_colour(const View& view, TilePlace at, Vec3f colour) {
    std::uint8_t* out = view.colour + 3 * (std::size_t{at.y} * view.width + at.x);
    out[0] = image::srgb_byte(colour.x);
    out[1] = image::srgb_byte(colour.y);
    out[2] = image::srgb_byte(colour.z);
  }

  void write_truth(const View& view, TilePlace at, const Ray& ray, const Hit& hit) const {
    const std::size_t i = std::size_t{at.y} * view.width + at.x;
    if (view.depth != nullptr) view.depth[i] = hit ? quarter_millimetres(view, ray, hit) : 0;
    if (view.classes == nullptr) return;
    const Mesh& mesh = mesh_.mesh();
    const std::uint32_t object =
        hit && !mesh.triangle_object.empty() ? mesh.triangle_object[hit.triangle] : kNoObject;
    view.classes[i] = object == kNoObject ? 0 : mesh.objects[object].category;
    view.instances[i] = object == kNoObject ? 0 : object + 1;
  }

  static std::uint16_t quarter_millimetres(const View& view, const Ray& ray, const Hit& hit) {
    double metres = hit.distance;
    if (view.forward != Vec3d{}) metres *= dot(to_double(ray.direction), view.forward);
    return image::depth_units(metres);
  }

  const LitMesh& mesh_;
  Vec3f eye_;
  const CaptureOptions& options_;
  Pattern pattern_;
  float scale_ = 1;
};

void check(const CaptureOptions& options, Vec3d eye, const Mat3d& rotation) {
  const std::uint32_t s = options.samples;
  if (s != 1 && s != 4 && s != 9 && s != kMostSamples) {
    throw ArgumentError(fmt::format("samples: {}, not 1, 4, 9 or 16", s));
  }
  if (!std::isfinite(options.exposure)) {
    throw ArgumentError(fmt::format("exposure: {}, not finite", options.exposure));
  }
  if (!std::isfinite(eye.x) || !std::isfinite(eye.y) || !std::isfinite(eye.z)) {
    throw ArgumentError(fmt::format("eye: ({}, {}, {}), not finite", eye.x, eye.y, eye.z));
  }
  if (!std::ranges::all_of(rotation.m, [](double x) { return std::isfinite(x); })) {
    throw ArgumentError("rotation: not finite");
  }
}

void check_size(const char* name, std::uint32_t size) {
  if (size > 0 && size <= kLargestFace) return;
  throw ArgumentError(fmt::format("{}: {}, not 1 .. {}", name, size, kLargestFace));
}

// Makes a picture where one is wanted.
template <class T>
T* begin(image::Image<T>& picture, bool wanted, const View& view, std::uint32_t channels) {
  if (!wanted) return nullptr;
  picture = image::Image<T>(view.width, view.height, channels);
  return picture.pixels.data();
}
void begin(View& view, const CaptureOptions& options, image::Image8& colour, image::Image16& depth,
           image::Image16& classes, image::Image32& instances) {
  view.colour = begin(colour, options.colour, view, 3);
  view.depth = begin(depth, options.depth, view, 1);
  view.classes = begin(classes, options.labels, view, 1);
  view.instances = begin(instances, options.labels, view, 1);
}

}  // namespace

CubeCapture capture_cube(const LitMesh& mesh, const Mat3d& world_from_panorama, Vec3d eye,
                         std::uint32_t size, const CaptureOptions& options) {
  check(options, eye, world_from_panorama);
  check_size("size", size);
  CubeCapture capture;
  std::array<View, kCubeFaces> views;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const FaceAxes& axes = kFaceAxes[k];
    View& view = views[k];
    view.corner = world_from_panorama * cube_direction(cube_face(k), 0, 0);
    view.across = world_from_panorama * (2.0 / size * axes.right);
    view.down = world_from_panorama * (2.0 / size * axes.down);
    view.width = view.height = size;
    begin(view, options, capture.colour[k], capture.depth[k], capture.classes[k],
          capture.instances[k]);
  }
  Photographer(mesh, eye, options).take(views);
  return capture;
}

PinholeCapture capture_pinhole(const LitMesh& mesh, const Pinhole& camera,
                               const CaptureOptions& options) {
  check(options, camera.position, camera.world_from_camera);
  check_size("width", camera.width);
  check_size("height", camera.height);
  const bool usable = camera.fx > 0 && camera.fy > 0 && std::isfinite(camera.fx + camera.fy) &&
                      std::isfinite(camera.cx) && std::isfinite(camera.cy);
  if (!usable) {
    throw ArgumentError(
        fmt::format("fx, fy, cx, cy: {}, {}, {}, {}: focal lengths must be "
                    "positive, all finite",
                    camera.fx, camera.fy, camera.cx, camera.cy));
  }
  PinholeCapture capture;
  View view;
  // Whole numbers are pixels' middles, so that the picture begins at -0.5.
  view.corner = camera.world_from_camera *
                Vec3d{(-0.5 - camera.cx) / camera.fx, (-0.5 - camera.cy) / camera.fy, 1};
  view.across = camera.world_from_camera * Vec3d{1 / camera.fx, 0, 0};
  view.down = camera.world_from_camera * Vec3d{0, 1 / camera.fy, 0};
  view.forward = camera.world_from_camera * Vec3d{0, 0, 1};
  view.width = camera.width;
  view.height = camera.height;
  begin(view, options, capture.colour, capture.depth, capture.classes, capture.instances);
  Photographer(mesh, camera.position, options).take({&view, 1});
  return capture;
}

}  // namespace enfilade::mesh
