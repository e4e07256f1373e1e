#include "enfilade/scan/depth_skybox.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "enfilade/core/errors.h"
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

// --- holes ------------------------------------------------------------------------------------

namespace {

/// How wide the filter of a pass is.
struct Sigmas {
  double space;  ///< texels
  double range;  ///< of luminance in [0, 1]
};
constexpr std::array<Sigmas, 3> kPasses{{{12, .2}, {5, .08}, {8, .02}}};
/// Half the width of a window, in sigmas. Beyond it a weight is less than a seventh of the largest.
constexpr double kReach = 2;
/// Weight of an estimate of an earlier, coarser pass; a reading has 1. It decides where no reading
/// is in the window, and has little influence beside readings of similar colour.
constexpr float kEstimateWeight = .05F;
/// In windows with a larger sigma only every second, third, ... texel is used: all texels of a
/// window of sigma 12 do not give a better result.
constexpr double kTexelsPerSigma = 6;

std::size_t radius(double sigma) { return static_cast<std::size_t>(std::ceil(kReach * sigma)); }

/// Maps the texels of six faces to framed faces, each with a margin of `margin` texels around it.
/// The margin holds texels of the neighbouring faces, projected to the face's plane, so that a
/// window at an edge is complete.
class Layout {
 public:
  Layout(std::uint32_t size, std::size_t margin)
      : size_(size),
        margin_(margin),
        side_(size + 2 * margin),
        source_(kCubeFaces * side_ * side_) {
    std::size_t at = 0;
    for (std::size_t face = 0; face < kCubeFaces; ++face) {
      for (std::size_t y = 0; y < side_; ++y) {
        for (std::size_t x = 0; x < side_; ++x) source_[at++] = source_of(cube_face(face), x, y);
      }
    }
  }

  std::size_t side() const { return side_; }
  /// Index, in the framed faces, of texel (x, y) of a face.
  std::size_t place(std::size_t face, std::size_t x, std::size_t y) const {
    return (face * side_ + y + margin_) * side_ + x + margin_;
  }
  /// Copies the texels of six faces to framed faces.
  template <class T>
  void frame(const std::vector<T>& texels, std::vector<T>& framed) const {
    framed.resize(source_.size());
    for (std::size_t i = 0; i < source_.size(); ++i) framed[i] = texels[source_[i]];
  }

 private:
  std::uint32_t source_of(CubeFace face, std::size_t x, std::size_t y) const {
    const auto along = [&](std::size_t i) {
      return (static_cast<double>(i) + .5 - static_cast<double>(margin_)) / size_;
    };
    FacePoint p{face, along(x), along(y)};
    if (p.s < 0 || p.s > 1 || p.t < 0 || p.t > 1) {
      p = project_to_cube(cube_direction(face, p.s, p.t));
    }
    const auto texel = [&](double u) {
      return std::min(static_cast<std::uint32_t>(std::max(u, 0.) * size_), size_ - 1);
    };
    return (static_cast<std::uint32_t>(index(p.face)) * size_ + texel(p.t)) * size_ + texel(p.s);
  }

  std::uint32_t size_;
  std::size_t margin_, side_;
  std::vector<std::uint32_t> source_;
};

/// The depth of a texel: a reading, an estimate (with less weight), or unknown (weight 0).
struct Known {
  float weight = 0;
  float sum = 0;  ///< weight times depth
};

/// One pass of the filter.
class Pass {
 public:
  /// \param space_sigma texels  \param range_sigma of luminance in [0, 1]
  Pass(double space_sigma, double range_sigma)
      : radius_(radius(space_sigma)),
        stride_(std::max<std::size_t>(1, static_cast<std::size_t>(space_sigma / kTexelsPerSigma))) {
    for (std::size_t d = 0; d <= radius_; d += stride_) {
      space_.push_back(bell(static_cast<double>(d) / space_sigma));
    }
    for (std::size_t d = 0; d < range_.size(); ++d) {
      range_[d] = bell(static_cast<double>(d) / 255 / range_sigma);
    }
  }

  /// The weighted sum of the window around a place; weight 0 if nothing is known in it.
  Known mean(const std::vector<Known>& known, const std::vector<std::uint8_t>& luminance,
             std::size_t place, std::size_t side) const {
    const auto steps = static_cast<std::ptrdiff_t>(space_.size()) - 1;
    const auto step = static_cast<std::ptrdiff_t>(stride_);
    const int own = luminance[place];
    Known total;
    for (std::ptrdiff_t dy = -steps; dy <= steps; ++dy) {
      const std::ptrdiff_t row =
          static_cast<std::ptrdiff_t>(place) + dy * step * static_cast<std::ptrdiff_t>(side);
      Known line;
      for (std::ptrdiff_t dx = -steps; dx <= steps; ++dx) {
        const auto at = static_cast<std::size_t>(row + dx * step);
        if (known[at].weight == 0) continue;
        const float w = space_[static_cast<std::size_t>(std::abs(dx))] *
                        range_[static_cast<std::size_t>(std::abs(luminance[at] - own))];
        line.weight += w * known[at].weight;
        line.sum += w * known[at].sum;
      }
      const float w = space_[static_cast<std::size_t>(std::abs(dy))];
      total.weight += w * line.weight;
      total.sum += w * line.sum;
    }
    return total;
  }

 private:
  static float bell(double sigmas) {
    const double weight = std::exp(-.5 * sigmas * sigmas);
    return weight < 1e-25 ? 0.F : static_cast<float>(weight);  // a product of three is no denormal
  }

  std::size_t radius_, stride_;
  std::vector<float> space_;        ///< by steps of stride_
  std::array<float, 256> range_{};  ///< by difference of luminance
};

void check(const image::CubeMap<std::uint16_t>& depth, const image::CubeMap<std::uint8_t>& colour) {
  const std::uint32_t n = depth[0].width;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const auto& d = depth[k];
    const auto& c = colour[k];
    if (d.width != n || d.height != n || d.channels != 1 || c.width != n || c.height != n ||
        c.channels != 3) {
      throw ArgumentError(fmt::format(
          "fill_holes: face {}: depth {} x {} x {}, colour {} x {} x {}; allowed: {} x {} x 1 and "
          "{} x {} x 3, as the first face has them",
          k, d.width, d.height, d.channels, c.width, c.height, c.channels, n, n, n, n));
    }
  }
}

std::vector<Known> readings_of(const image::CubeMap<std::uint16_t>& depth) {
  std::vector<Known> known;
  known.reserve(kCubeFaces * depth[0].pixels.size());
  for (const auto& face : depth) {
    for (const std::uint16_t d : face.pixels) known.push_back({d == 0 ? 0.F : 1.F, 1.F * d});
  }
  return known;
}

/// Luma of Rec. 601, which weights the channels as the eye does; of each texel, 0 to 255.
std::vector<std::uint8_t> luminance_of(const image::CubeMap<std::uint8_t>& colour) {
  std::vector<std::uint8_t> result;
  for (const auto& face : colour) {
    for (std::size_t i = 0; i < face.pixels.size(); i += 3) {
      const std::uint8_t* p = &face.pixels[i];
      result.push_back(
          static_cast<std::uint8_t>((299 * p[0] + 587 * p[1] + 114 * p[2] + 500) / 1000));
    }
  }
  return result;
}

}  // namespace

image::CubeMap<std::uint16_t> fill_holes(const image::CubeMap<std::uint16_t>& depth,
                                         const image::CubeMap<std::uint8_t>& colour, int threads) {
  check(depth, colour);
  const std::size_t n = depth[0].width;
  const Layout layout(depth[0].width, radius(std::ranges::max(kPasses, {}, &Sigmas::space).space));
  std::vector<Known> known = readings_of(depth), framed;
  std::vector<std::uint8_t> luminance;
  layout.frame(luminance_of(colour), luminance);
  for (const Sigmas& sigmas : kPasses) {
    const Pass pass(sigmas.space, sigmas.range);
    layout.frame(known, framed);
    parallel_for(kCubeFaces * n, 16, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin * n; i < end * n; ++i) {
        const std::size_t face = i / (n * n), y = i / n % n, x = i % n;
        if (depth[face].pixels[y * n + x] != 0) continue;
        const Known mean = pass.mean(framed, luminance, layout.place(face, x, y), layout.side());
        if (mean.weight > 0)
          known[i] = {kEstimateWeight, kEstimateWeight * (mean.sum / mean.weight)};
      }
    });
  }
  image::CubeMap<std::uint16_t> result = depth;
  for (std::size_t i = 0; i < known.size(); ++i) {
    std::uint16_t& texel = result[i / (n * n)].pixels[i % (n * n)];
    if (texel != 0 || known[i].weight == 0) continue;
    texel = static_cast<std::uint16_t>(std::lround(known[i].sum / known[i].weight));
  }
  return result;
}

}  // namespace enfilade::scan
