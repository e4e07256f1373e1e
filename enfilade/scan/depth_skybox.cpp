#include "enfilade/scan/depth_skybox.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "enfilade/core/threads.h"

namespace enfilade::scan {
namespace {

/// Four pixels around a point lie on one surface if their depths are within this ratio. The floor
/// at 10 m, from eyes at 1.5 m, changes by .6 % from one row to the next; a pillar in front of a
/// wall usually by much more.
constexpr double kSurfaceRatio = 1.03;
/// Readings of two cameras within 2 cm or 2 % are of one surface: the error of Matterport's camera
/// is about 1 % of the depth.
constexpr double kSameSurface = .02;
/// A surface wins over a farther one if it has at least this share of its weight, as the nearer of
/// two surfaces on a ray is the visible one.
constexpr double kNearerWins = .5;
/// Where the search along a ray begins. The first start is nearer than anything that the camera
/// measures, so that the nearer of two surfaces on the ray is found; the others are tried if the
/// search ended at an edge or at a pixel without a reading.
constexpr std::array<double, 4> kStarts{.3, 1, 3, 1e6};  // metres
/// Cameras are only centimetres from the eye, so each step divides the error by ten or more, unless
/// the surface is seen edge on.
constexpr int kSteps = 12;
constexpr double kSettled = kSameSurface / 400;  // metres; a fifth of the depth's unit

/// A ray of the eye in the frame of one camera.
struct Ray {
  Vec3d origin, direction;  ///< metres; direction of length 1
};

struct Pixel {
  double x, y;  ///< columns from the left, rows from the top
};

struct Reading {
  double distance = 0;  ///< along the ray, metres
  double weight = 0;    ///< (0, 1]
};

/// One picture, prepared for queries.
class View {
 public:
  View(const DepthImage& image, const PanoramaPose& eye)
      : image_(image.depth), fx_(image.camera.fx), fy_(image.camera.fy), cx_(image.camera.cx) {
    cy_ = image_.height - 1 - image.camera.cy;  // the file counts rows from the bottom
    const Mat3d camera_from_world = transpose(image.camera.world_from_camera);
    origin_ = camera_from_world * (eye.position - image.camera.position);
    camera_from_panorama_ = camera_from_world * eye.world_from_panorama;
  }

  /// The nearest surface along the ray that the picture shows. \param direction of length 1
  std::optional<Reading> look(Vec3d direction_in_panorama) const {
    const Ray ray{origin_, camera_from_panorama_ * direction_in_panorama};
    if (!is_near_frame(ray)) return std::nullopt;
    for (const double t : kStarts) {
      const Vec3d start = point(ray, t);
      if (start.z >= 0) continue;
      if (const auto reading = follow(ray, project(start))) return reading;
    }
    return std::nullopt;
  }

 private:
  static Vec3d point(const Ray& ray, double t) { return ray.origin + t * ray.direction; }

  Pixel project(Vec3d p) const { return {cx_ - fx_ * p.x / p.z, cy_ + fy_ * p.y / p.z}; }

  /// Whether the ray may be in the picture at some distance from the first start on. May be true
  /// for rays that are not; it only saves work.
  bool is_near_frame(const Ray& ray) const {
    constexpr double kMargin = .35;  // of the frame; 10 cm beside the eye at .3 m are .3 of it
    if (ray.direction.z > -.1) return false;
    const Pixel p = project(ray.direction);
    const double w = image_.width, h = image_.height;
    return p.x > -kMargin * w && p.x < (1 + kMargin) * w && p.y > -kMargin * h &&
           p.y < (1 + kMargin) * h;
  }

  bool is_inside(Pixel p) const {
    return p.x >= 0 && p.y >= 0 && p.x <= image_.width - 1. && p.y <= image_.height - 1.;
  }

  /// z-distance at a point of the picture, metres, or 0. On planes, 1 / z is linear in the picture,
  /// so interpolating it is exact. Across a step in depth this would invent a surface: there, and
  /// next to pixels without a reading, the nearest pixel is taken.
  double depth_at(Pixel p) const {
    // In this order NaN, from absurd intrinsics, becomes 0.
    const double x = std::min(std::max(0., p.x), image_.width - 1.);
    const double y = std::min(std::max(0., p.y), image_.height - 1.);
    const auto x0 = std::min(static_cast<std::size_t>(x), std::size_t{image_.width} - 2);
    const auto y0 = std::min(static_cast<std::size_t>(y), std::size_t{image_.height} - 2);
    const std::uint16_t* a = image_.at(x0, y0);
    const std::uint16_t* b = image_.at(x0, y0 + 1);
    const double u = x - static_cast<double>(x0), v = y - static_cast<double>(y0);
    const auto [least, most] = std::minmax({a[0], a[1], b[0], b[1]});
    if (least == 0 || most > kSurfaceRatio * least) {
      return (v < .5 ? a : b)[u < .5 ? 0 : 1] / kDepthUnitsPerMetre;
    }
    const double inverse = (1 - v) * ((1 - u) / a[0] + u / a[1]) + v * ((1 - u) / b[0] + u / b[1]);
    return 1 / (inverse * kDepthUnitsPerMetre);
  }

  /// Iterates from a first guess of the pixel: its depth gives a point of the ray, which gives the
  /// next pixel, until both agree. No value if that does not converge, for instance next to an edge
  /// that hides the surface from the camera, or if there is no reading.
  std::optional<Reading> follow(const Ray& ray, Pixel pixel) const {
    double t = 0;
    for (int step = 0; step < kSteps; ++step) {
      const double z = depth_at(pixel);
      if (z == 0) return std::nullopt;
      const double next = (z + ray.origin.z) / -ray.direction.z;
      const Vec3d p = point(ray, next);
      if (next <= 0 || p.z >= 0) return std::nullopt;
      pixel = project(p);
      if (std::abs(next - t) < kSettled) {
        if (!is_inside(pixel)) return std::nullopt;
        return Reading{next, weight_at(pixel)};
      }
      t = next;
    }
    return std::nullopt;
  }

  /// 1 in the middle, almost 0 at the edge of the picture, where lenses are worst.
  double weight_at(Pixel p) const {
    const double x = std::min(p.x, image_.width - 1. - p.x) / image_.width;
    const double y = std::min(p.y, image_.height - 1. - p.y) / image_.height;
    return std::max(2 * std::min(x, y), 1e-3);
  }

  const image::Image16& image_;
  double fx_, fy_, cx_, cy_ = 0;
  Vec3d origin_;  ///< of the eye, in the camera's frame
  Mat3d camera_from_panorama_;
};

/// The mean of the readings of a ray that are of the winning surface; 0 if there are none.
double blend(std::vector<Reading>& readings) {
  std::ranges::sort(readings, std::greater<>(), &Reading::distance);
  double best = 0, behind = 0;  // behind: the most weight of a surface farther away
  for (std::size_t i = 0; i < readings.size();) {
    const double end = readings[i].distance - kSameSurface * std::max(1., readings[i].distance);
    double sum = 0, weight = 0;
    for (; i < readings.size() && readings[i].distance >= end; ++i) {
      sum += readings[i].weight * readings[i].distance;
      weight += readings[i].weight;
    }
    if (weight >= kNearerWins * behind) best = sum / weight;
    behind = std::max(behind, weight);
  }
  return best;
}

std::uint16_t in_units(double metres) {
  return metres <= 0 ? std::uint16_t{0} : image::depth_units(metres);
}

}  // namespace

image::CubeMap<std::uint16_t> depth_skybox(std::span<const DepthImage> images,
                                           const PanoramaPose& eye, std::uint32_t size,
                                           int threads) {
  std::vector<View> views;
  for (const DepthImage& image : images) {
    // Interpolation needs two pixels in each direction.
    if (image.depth.width >= 2 && image.depth.height >= 2) views.emplace_back(image, eye);
  }
  image::CubeMap<std::uint16_t> result;
  for (auto& face : result) face = image::Image16(size, size, 1);
  parallel_for(kCubeFaces * size, 16, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Reading> readings;
    for (std::size_t row = begin; row < end; ++row) {
      const std::size_t face = row / size, y = row % size;
      for (std::size_t x = 0; x < size; ++x) {
        const Vec3d d = cube_direction(cube_face(face), (static_cast<double>(x) + .5) / size,
                                       (static_cast<double>(y) + .5) / size);
        const Vec3d direction = 1 / length(d) * d;
        readings.clear();
        for (const View& view : views) {
          if (const auto reading = view.look(direction)) readings.push_back(*reading);
        }
        *result[face].at(x, y) = in_units(blend(readings));
      }
    }
  });
  return result;
}

}  // namespace enfilade::scan
