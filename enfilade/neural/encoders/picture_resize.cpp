#include "enfilade/neural/encoders/transformer_encoder.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <algorithm>
#include <cmath>

#include "enfilade/core/check.h"

namespace enfilade::neural::encoders {
namespace {

constexpr int kBits = 22;  // Pillow's, of the weights of 8-bit pictures

// Keys's cubic convolution with a = -0.5.
double bicubic(double x) {
  constexpr double kA = -0.5;
  x = std::abs(x);
  if (x < 1) return ((kA + 2) * x - (kA + 3)) * x * x + 1;
  if (x < 2) return (((x - 5) * x + 8) * x - 4) * kA;
  return 0;
}

std::int32_t rounded(std::int32_t sum) {
  constexpr std::int32_t kHalf = 1 << (kBits - 1), kBrightest = 255;
  return std::clamp((sum + kHalf) >> kBits, 0, kBrightest);
}

}  // namespace

PictureResize::PictureResize(const Camera& from, std::uint32_t shorter, std::uint32_t crop)
    : from_(from), crop_(crop) {
  EN_CHECK_LE(crop, shorter);
  const std::size_t least = std::min(from.width, from.height);
  const auto side = [&](std::size_t pixels) { return shorter * pixels / least; };
  columns_ = taps(from.width, side(from.width), crop);
  rows_ = taps(from.height, side(from.height), crop);
}

std::vector<PictureResize::ResizeTaps> PictureResize::taps(std::size_t from, std::size_t to,
                                                           std::size_t crop) {
  const double scale = static_cast<double>(from) / static_cast<double>(to);
  const double wide = std::max(scale, 1.0);  // pictures that grow are interpolated
  const double reach = 2 * wide;
  // torchvision rounds as Python does, halves to the even number.
  const double margin = std::nearbyint(static_cast<double>(to - crop) / 2);
  std::vector<ResizeTaps> all(crop);
  for (std::size_t i = 0; i < crop; ++i) {
    const double centre = (static_cast<double>(i) + margin + 0.5) * scale;
    const auto first = static_cast<std::size_t>(std::max(0.0, centre - reach + 0.5));
    const auto end = std::min(from, static_cast<std::size_t>(std::max(0.0, centre + reach + 0.5)));
    std::vector<double> weights;
    double sum = 0;
    for (std::size_t x = first; x < end; ++x) {
      weights.push_back(bicubic((static_cast<double>(x) - centre + 0.5) / wide));
      sum += weights.back();
    }
    all[i].first = first;
    for (const double weight : weights) {
      all[i].weights.push_back(
          static_cast<std::int32_t>(std::round(weight / sum * double{1 << kBits})));
    }
  }
  return all;
}

// First along the rows, then along the columns.
void PictureResize::resize_plane(std::span<const float> plane, std::span<float> out) const {
  const std::size_t width = from_.width;
  std::vector<std::int32_t> bytes(width), narrow(from_.height * crop_), sums(crop_);
  for (std::size_t y = 0; y < from_.height; ++y) {
    const auto row = plane.subspan(y * width, width);
    std::ranges::transform(row, bytes.begin(),
                           [](float v) { return static_cast<std::int32_t>(v + 0.5F); });
    for (std::size_t i = 0; i < crop_; ++i) {
      const ResizeTaps& taps = columns_[i];
      std::int32_t sum = 0;
      for (std::size_t t = 0; t < taps.weights.size(); ++t) {
        sum += taps.weights[t] * bytes[taps.first + t];
      }
      narrow[y * crop_ + i] = rounded(sum);
    }
  }
  for (std::size_t i = 0; i < crop_; ++i) {
    std::ranges::fill(sums, 0);
    for (std::size_t t = 0; t < rows_[i].weights.size(); ++t) {
      const auto row = std::span(narrow).subspan((rows_[i].first + t) * crop_, crop_);
      for (std::size_t x = 0; x < crop_; ++x) sums[x] += rows_[i].weights[t] * row[x];
    }
    for (std::size_t x = 0; x < crop_; ++x) {
      out[i * crop_ + x] = static_cast<float>(rounded(sums[x]));
    }
  }
}

at::Tensor PictureResize::apply(std::span<const float> pictures, std::size_t n) const {
  const std::size_t from = std::size_t{from_.width} * from_.height, to = crop_ * crop_;
  EN_CHECK_EQ(pictures.size(), n * 3 * from);
  const auto side = static_cast<std::int64_t>(crop_);
  at::Tensor out = at::empty({static_cast<std::int64_t>(n), 3, side, side}, at::kFloat);
  const std::span<float> numbers(out.data_ptr<float>(), n * 3 * to);
  at::parallel_for(0, static_cast<std::int64_t>(3 * n), 1, [&](std::int64_t a, std::int64_t b) {
    for (auto i = static_cast<std::size_t>(a); i < static_cast<std::size_t>(b); ++i) {
      resize_plane(pictures.subspan(i * from, from), numbers.subspan(i * to, to));
    }
  });
  return out;
}

}  // namespace enfilade::neural::encoders
