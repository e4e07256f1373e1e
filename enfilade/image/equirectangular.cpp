#include "enfilade/image/image.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"

namespace enfilade::image {
namespace {

// The picture with two more pixels on each side, so that no tap of the cubic filter needs a test:
// left and right they continue it around the seam, above and below across the poles (half a turn
// away, rows reversed).
class Source {
 public:
  explicit Source(const Image8& picture)
      : width_(picture.width),
        height_(picture.height),
        stride_((picture.width + 2 * kMargin) * 3),
        pixels_(stride_ * (picture.height + 2 * kMargin)) {
    const auto height = static_cast<std::ptrdiff_t>(height_);
    const auto margin = static_cast<std::ptrdiff_t>(kMargin);
    for (std::ptrdiff_t y = -margin; y < height + margin; ++y) {
      const bool beyond = y < 0 || y >= height;
      const std::ptrdiff_t mirrored = y < 0 ? -1 - y : 2 * height - 1 - y;
      const auto row = static_cast<std::size_t>(
          std::clamp<std::ptrdiff_t>(beyond ? mirrored : y, 0, height - 1));
      copy_row(picture, row, beyond ? width_ / 2 : 0, static_cast<std::size_t>(y + margin));
    }
  }

  double width() const { return static_cast<double>(width_); }
  double height() const { return static_cast<double>(height_); }

  // Adds weight * the colour at (u, v), where (0, 0) is the middle of the first pixel.
  // \pre u in [-0.5, width - 0.5], v in [-0.5, height - 0.5]
  void add(double u, double v, float weight, float* rgb) const {
    const double left = std::floor(u), top = std::floor(v);
    const std::array<float, 4> across = cubic(static_cast<float>(u - left));
    const std::array<float, 4> down = cubic(static_cast<float>(v - top));
    // Tap k is k - 1 pixels beyond (left, top), and kMargin further in the enlarged picture.
    const std::uint8_t* row = pixels_.data() +
                              static_cast<std::size_t>(top + (kMargin - 1)) * stride_ +
                              static_cast<std::size_t>(left + (kMargin - 1)) * 3;
    for (std::size_t i = 0; i < 4; ++i, row += stride_) {
      const float row_weight = weight * down[i];
      for (std::size_t c = 0; c < 3; ++c) {
        rgb[c] += row_weight * (across[0] * static_cast<float>(row[c]) +
                                across[1] * static_cast<float>(row[3 + c]) +
                                across[2] * static_cast<float>(row[6 + c]) +
                                across[3] * static_cast<float>(row[9 + c]));
      }
    }
  }

 private:
  static constexpr std::size_t kMargin = 2;

  // The Catmull-Rom spline, which interpolates the pixels and stays sharp.
  static std::array<float, 4> cubic(float x) {
    const float x2 = x * x, x3 = x2 * x;
    return {0.5F * (-x3 + 2 * x2 - x), 0.5F * (3 * x3 - 5 * x2 + 2), 0.5F * (-3 * x3 + 4 * x2 + x),
            0.5F * (x3 - x2)};
  }

  void copy_row(const Image8& picture, std::size_t from, std::size_t turn, std::size_t to) {
    std::uint8_t* out = pixels_.data() + to * stride_;
    for (std::size_t x = 0; x < width_ + 2 * kMargin; ++x, out += 3) {
      std::copy_n(picture.at((x + 2 * width_ - kMargin + turn) % width_, from), 3, out);
    }
  }

  std::size_t width_, height_, stride_;
  std::vector<std::uint8_t> pixels_;
};

class Cutter {
 public:
  Cutter(const Source& source, std::uint32_t size, Radians heading,
         const Mat3d& panorama_from_picture)
      : source_(source),
        heading_(heading.value),
        level_(panorama_from_picture == Mat3d()),
        picture_from_panorama_(transpose(panorama_from_picture)),
        size_(size),
        pixels_per_radian_(source.width() / (2 * kPi)) {}

  void cut_row(CubeFace face, std::size_t y, std::uint8_t* row) const {
    for (std::size_t x = 0; x < size_; ++x, row += 3) cut_texel(face, x, y, row);
  }

 private:
  struct Counts {
    int across = 1, down = 1;
  };

  // Samples of a texel in each direction: one for each pixel that its edges span. Near a pole a
  // texel spans many pixels of few different colours; the bound limits the time for those.
  Counts samples(const FaceAxes& axes, Vec3d d) const {
    const double flat2 = d.x * d.x + d.z * d.z, far2 = flat2 + d.y * d.y;
    const auto count = [&](Vec3d step) {
      const double turn = std::abs(d.z * step.x - d.x * step.z) / std::max(flat2, 1e-9);
      const double rise = std::abs(flat2 * step.y - d.y * (d.x * step.x + d.z * step.z)) /
                          (far2 * std::sqrt(std::max(flat2, 1e-9)));
      constexpr double kMost = 16;
      const double pixels = std::max(turn, rise) * pixels_per_radian_ * 2 / size_;
      return static_cast<int>(std::ceil(std::clamp(pixels, 1.0, kMost)));
    };
    return {count(axes.right), count(axes.down)};
  }

  void cut_texel(CubeFace face, std::size_t x, std::size_t y, std::uint8_t* out) const {
    const auto direction = [&](double dx, double dy) {
      const Vec3d d = cube_direction(face, (static_cast<double>(x) + dx) / size_,
                                     (static_cast<double>(y) + dy) / size_);
      return level_ ? d : picture_from_panorama_ * d;
    };
    FaceAxes axes = kFaceAxes[index(face)];
    if (!level_) {
      axes.right = picture_from_panorama_ * axes.right;
      axes.down = picture_from_panorama_ * axes.down;
    }
    const Counts n = samples(axes, direction(0.5, 0.5));
    const float weight = 1.0F / static_cast<float>(n.across * n.down);
    std::array<float, 3> rgb{0.5F, 0.5F, 0.5F};  // to round
    for (int j = 0; j < n.down; ++j) {
      for (int i = 0; i < n.across; ++i) {
        add(direction((i + 0.5) / n.across, (j + 0.5) / n.down), weight, rgb.data());
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      out[c] = static_cast<std::uint8_t>(std::clamp(rgb[c], 0.0F, 255.0F));
    }
  }

  void add(Vec3d d, float weight, float* rgb) const {
    const double turn = (std::atan2(d.x, d.z) - heading_) / (2 * kPi) + 0.5;
    const double fall = std::atan2(d.y, std::sqrt(d.x * d.x + d.z * d.z)) / kPi + 0.5;
    source_.add((turn - std::floor(turn)) * source_.width() - 0.5, fall * source_.height() - 0.5,
                weight, rgb);
  }

  const Source& source_;
  double heading_;
  bool level_;  // nothing to rotate
  Mat3d picture_from_panorama_;
  std::uint32_t size_;
  double pixels_per_radian_;
};

}  // namespace

CubeMap<std::uint8_t> cube_from_equirectangular(const Image8& picture, std::uint32_t size,
                                                Radians heading, int threads,
                                                const Mat3d& panorama_from_picture) {
  const std::int64_t excess = std::int64_t{picture.width} - 2 * std::int64_t{picture.height};
  if (picture.channels != 3 || picture.width < 4 || std::abs(excess) > 1) {
    throw ArgumentError(fmt::format(
        "equirectangular picture: {} x {} pixels, {} channels; twice as wide as high, at "
        "least 4 pixels wide and 3 channels are allowed",
        picture.width, picture.height, picture.channels));
  }
  if (size == 0) size = picture.width / 4;
  const Source source(picture);
  const Cutter cutter(source, size, heading, panorama_from_picture);
  CubeMap<std::uint8_t> faces;
  for (Image8& face : faces) face = Image8(size, size, 3);
  parallel_for(kCubeFaces * std::size_t{size}, 16, threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t row = begin; row < end; ++row) {
                   const std::size_t k = row / size, y = row % size;
                   cutter.cut_row(cube_face(k), y, faces[k].at(0, y));
                 }
               });
  return faces;
}

}  // namespace enfilade::image
