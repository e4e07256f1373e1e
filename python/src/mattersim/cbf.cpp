// Fills the holes of depth images with a cross-bilateral filter on a pyramid of three sizes, as
// the toolbox of the NYU Depth data set does (Silberman, Hoiem, Kohli, Fergus, ECCV 2012). A
// missing pixel becomes the mean of the known ones within 5 pixels, weighted by distance and by
// difference in brightness. Without known ones, it takes the value of the next smaller size. All
// images are height x width, column-major; the result may be the depth image itself.
#include <array>
#include <cmath>
#include <vector>

#include "python/src/bindings.h"

namespace enfilade::python::mattersim {
namespace {

constexpr int kRadius = 5;  // pixels, at every size
struct Sigmas {
  float place;       // pixels
  float brightness;  // of 0..1
};
// Largest size first.
constexpr std::array<Sigmas, 3> kSigmas{{{12.0F, 0.2F}, {5.0F, 0.08F}, {8.0F, 0.02F}}};

/// One size of the pyramid, column-major.
struct Level {
  int height = 0, width = 0;
  std::vector<float> depth, brightness;
  std::vector<float> filled;  // 0: not filled
  std::vector<char> missing;
  std::vector<char> usable;  // 1: known, or filled at a smaller size, so means may include it

  int size() const { return height * width; }
};

Level shrink(const Level& full, int height, int width) {
  Level level{height, width, {}, {}, {}, {}, {}};
  for (int x = 0; x < width; ++x) {
    for (int y = 0; y < height; ++y) {
      // In single precision, as in the original, for the same pixels.
      const auto fx = static_cast<int>(static_cast<float>(x) / static_cast<float>(width) *
                                       static_cast<float>(full.width));
      const auto fy = static_cast<int>(static_cast<float>(y) / static_cast<float>(height) *
                                       static_cast<float>(full.height));
      const int pixel = fy + full.height * fx;
      const auto from = static_cast<std::size_t>(pixel);
      level.depth.push_back(full.depth[from]);
      level.brightness.push_back(full.brightness[from]);
      level.missing.push_back(full.missing[from]);
      level.usable.push_back(static_cast<char>(full.missing[from] == 0));
    }
  }
  level.filled.resize(level.depth.size());
  return level;
}

// Weights over the window, column-major; they sum to 1.
std::vector<float> window_weights(float sigma) {
  std::vector<float> weights;
  float sum = 0;
  for (int a = -kRadius; a <= kRadius; ++a) {
    for (int b = -kRadius; b <= kRadius; ++b) {
      const float square = static_cast<float>(a * a + b * b);
      weights.push_back(std::exp(-square / (2 * sigma * sigma)));
      sum += weights.back();
    }
  }
  for (float& weight : weights) weight /= sum;
  return weights;
}

void fill_pixel(Level& level, const std::vector<char>& usable, const std::vector<float>& weights,
                float sigma, int pixel) {
  const int x = pixel / level.height, y = pixel % level.height;
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  float weight_sum = 0, value_sum = 0;
  std::size_t place = 0;
  // Rows in the outer loop: the order of summation determines the last bit.
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx, ++place) {
      if (x + dx < 0 || x + dx >= level.width || y + dy < 0 || y + dy >= level.height) continue;
      const int other = pixel + dy + level.height * dx;
      if (usable[at(other)] == 0) continue;
      const float difference = level.brightness[at(other)] - level.brightness[at(pixel)];
      const float likeness = std::exp(-(difference * difference) / (2 * sigma * sigma));
      weight_sum += weights[place] * likeness;
      value_sum += level.depth[at(other)] * weights[place] * likeness;
    }
  }
  if (weight_sum == 0) return;
  level.filled[at(pixel)] = value_sum / weight_sum;
  level.usable[at(pixel)] = 1;
}

void fill_level(Level& level, Sigmas sigmas) {
  const std::vector<float> weights = window_weights(sigmas.place);
  // A copy: pixels that are filled at this size must not enter its other means, only those of the
  // next larger size.
  const std::vector<char> usable = level.usable;
  for (int i = 0; i < level.size(); ++i) {
    if (level.missing[static_cast<std::size_t>(i)] != 0) {
      fill_pixel(level, usable, weights, sigmas.brightness, i);
    }
  }
}

// Fills the holes of the larger size with the values of the smaller one.
void hand_up(const Level& small, Level& large) {
  for (int i = 0; i < large.size(); ++i) {
    const auto to = static_cast<std::size_t>(i);
    if (large.missing[to] == 0) continue;
    const int x = i / large.height, y = i % large.height;
    const int sy =
        static_cast<int>(static_cast<float>(y * small.height) / static_cast<float>(large.height));
    const int sx =
        static_cast<int>(static_cast<float>(x * small.width) / static_cast<float>(large.width));
    const int pixel = sy + small.height * sx;
    const auto from = static_cast<std::size_t>(pixel);
    large.depth[to] = small.missing[from] == 0 ? small.depth[from] : small.filled[from];
    large.usable[to] = small.usable[from];
  }
}

using Picture = nb::ndarray<std::uint8_t, nb::ndim<2>, nb::f_contig, nb::device::cpu>;

using Mask = nb::ndarray<nb::ro, nb::ndim<2>, nb::f_contig, nb::device::cpu>;

template <class Other>
bool fits(const Other& other, const Picture& depth) {
  return other.shape(0) == depth.shape(0) && other.shape(1) == depth.shape(1);
}

void cbf(const Picture& depth, const Picture& intensity, const Mask& mask, const Picture& result) {
  if (mask.dtype() != nb::dtype<std::uint8_t>() && mask.dtype() != nb::dtype<bool>()) {
    throw nb::type_error("cbf: mask: uint8 or bool is wanted");
  }
  if (!fits(mask, depth) || !fits(result, depth)) {
    throw nb::value_error("cbf: depth, mask and result must have one shape");
  }
  // Of a larger one only the first values are read, as many as depth has, as in the old code.
  if (intensity.size() < depth.size()) {
    throw nb::value_error("cbf: intensity must have at least as many values as depth");
  }
  const auto* const missing = static_cast<const std::uint8_t*>(mask.data());
  const nb::gil_scoped_release unlocked;
  Level full{
      static_cast<int>(depth.shape(0)), static_cast<int>(depth.shape(1)), {}, {}, {}, {}, {}};
  for (std::size_t i = 0; i < depth.size(); ++i) {
    full.depth.push_back(static_cast<float>(depth.data()[i] / 255.0));
    full.brightness.push_back(static_cast<float>(intensity.data()[i] / 255.0));
    full.missing.push_back(static_cast<char>(missing[i] != 0));
    full.usable.push_back(static_cast<char>(missing[i] == 0));
  }
  full.filled.resize(depth.size());

  std::vector<Level> levels;
  levels.push_back(full);
  for (int k = 1; k < static_cast<int>(kSigmas.size()); ++k) {
    levels.push_back(shrink(full, full.height >> k, full.width >> k));
  }
  for (std::size_t k = levels.size(); k-- > 0;) {
    fill_level(levels[k], kSigmas[k]);
    if (k > 0 && levels[k].size() > 0) hand_up(levels[k], levels[k - 1]);
  }
  for (std::size_t i = 0; i < depth.size(); ++i) {
    result.data()[i] =
        missing[i] != 0 ? static_cast<std::uint8_t>(levels[0].filled[i] * 255) : depth.data()[i];
  }
}

}  // namespace

void bind_cbf(nb::module_& m) {
  // Not converted: `result` has to be the caller's own memory.
  m.def("cbf", cbf, nb::arg().noconvert(), nb::arg().noconvert(), nb::arg().noconvert(),
        nb::arg().noconvert(),
        "cbf(depth, intensity, mask, result): fills holes of depth; (H, W) uint8 in Fortran order, "
        "`result` is written. mask: uint8 or bool, not 0 where depth is missing.");
}

}  // namespace enfilade::python::mattersim
