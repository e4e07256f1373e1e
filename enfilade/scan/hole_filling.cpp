#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/scan/depth_skybox.h"

namespace enfilade::scan {
namespace {

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

void check(const image::CubeMap<std::uint16_t>& depth, const image::CubeMap<std::uint8_t>& colour,
           const HoleFilling& options) {
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
  for (std::size_t pass = 0; pass < options.space_sigma.size(); ++pass) {
    if (!(options.space_sigma[pass] > 0 && options.space_sigma[pass] <= 1000 &&
          options.range_sigma[pass] > 0)) {
      throw ArgumentError(fmt::format(
          "fill_holes: pass {}: sigmas {} texels and {}; allowed: above 0, at most 1000 texels",
          pass, options.space_sigma[pass], options.range_sigma[pass]));
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
                                         const image::CubeMap<std::uint8_t>& colour,
                                         const HoleFilling& options, int threads) {
  check(depth, colour, options);
  const std::size_t n = depth[0].width;
  const Layout layout(depth[0].width, radius(std::ranges::max(options.space_sigma)));
  std::vector<Known> known = readings_of(depth), framed;
  std::vector<std::uint8_t> luminance;
  layout.frame(luminance_of(colour), luminance);
  for (std::size_t k = 0; k < options.space_sigma.size(); ++k) {
    const Pass pass(options.space_sigma[k], options.range_sigma[k]);
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
