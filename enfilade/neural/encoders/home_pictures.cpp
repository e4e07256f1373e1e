#include "enfilade/neural/encoders/home_pictures.h"

#include <ATen/ATen.h>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/render/renderer.h"

namespace enfilade::neural::encoders {
namespace {

constexpr std::size_t kPixels = std::size_t{kHomeWidth} * kHomeHeight;
constexpr std::int64_t kCells = kHomeRows * kHomeColumns;

std::vector<render::View> draw_views(const LabelledPlace& place, std::size_t n, Rng& rng) {
  // Agents look ahead most of the time.
  constexpr std::array<double, 4> kElevations{0, -30, 0, 30};
  constexpr double kShake = 5;  // degrees, either way
  const double first = rng.uniform();
  std::vector<render::View> views;
  for (std::size_t i = 0; i < n; ++i) {
    const double turn = (first + static_cast<double>(i)) / static_cast<double>(n);
    const double elevation =
        kElevations.at(i % kElevations.size()) + kShake * (2 * rng.uniform() - 1);
    views.push_back(
        {place.scan, place.viewpoint, Radians(2 * std::numbers::pi * turn), degrees(elevation)});
  }
  return views;
}

std::int64_t cell_of(std::size_t pixel) {
  const auto x = static_cast<std::int64_t>(pixel % kHomeWidth);
  const auto y = static_cast<std::int64_t>(pixel / kHomeWidth);
  return y / kHomeStride * kHomeColumns + x / kHomeStride;
}

void count_classes(std::span<const std::uint8_t> pixels, std::uint8_t* counts) {
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const std::int64_t object = pixels[p] < kObjectClasses ? pixels[p] : 0;
    ++counts[object * kCells + cell_of(p)];
  }
}

void average_distances(std::span<const float> metres, float* out) {
  std::array<float, kCells> sums{}, counts{};
  for (std::size_t p = 0; p < metres.size(); ++p) {
    if (metres[p] <= 0) continue;  // no reading
    const auto cell = static_cast<std::size_t>(cell_of(p));
    sums.at(cell) += std::log(metres[p]);
    counts.at(cell) += 1;
  }
  for (std::size_t c = 0; c < sums.size(); ++c) {
    out[c] = counts.at(c) > 0 ? sums.at(c) / counts.at(c) : std::numeric_limits<float>::quiet_NaN();
  }
}

// Memory for the pictures of one place.
struct Buffers {
  explicit Buffers(std::size_t views) : classes(views * kPixels), distances(views * kPixels) {}
  std::vector<std::uint8_t> classes;
  std::vector<float> distances;
};

render::Outputs outputs_into(std::span<std::uint8_t> colours, Buffers& buffers) {
  render::Outputs outputs;
  outputs.colour = {render::ColourFormat::kRgb8, {}, std::as_writable_bytes(colours)};
  outputs.classes = {render::ClassFormat::kUint8,
                     std::as_writable_bytes(std::span(buffers.classes))};
  outputs.depth = {render::DepthFormat::kMetresFloat32, render::DepthMeasure::kRay,
                   std::as_writable_bytes(std::span(buffers.distances))};
  return outputs;
}

}  // namespace

LabelledPictures draw_labelled(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                               std::span<const LabelledPlace> places, std::size_t views,
                               std::uint64_t seed, int threads) {
  const auto n = static_cast<std::int64_t>(places.size() * views);
  LabelledPictures pictures{at::empty({n, kHomeHeight, kHomeWidth, 3}, at::kByte),
                            at::zeros({n, kObjectClasses, kHomeRows, kHomeColumns}, at::kByte),
                            at::empty({n, 1, kHomeRows, kHomeColumns}, at::kFloat),
                            at::empty({n}, at::kLong)};
  const auto faces = std::make_shared<render::FaceCache>(
      panoramas, render::FaceCacheConfig{.threads = threads, .prefetch_thread = false});
  const auto renderer = render::make_renderer(faces, {render::Backend::kCpu, threads, {}, {}});
  Buffers buffers(views);
  auto* colours = pictures.colours.data_ptr<std::uint8_t>();
  auto* classes = pictures.classes.data_ptr<std::uint8_t>();
  auto* distances = pictures.distances.data_ptr<float>();
  auto* rooms = pictures.rooms.data_ptr<std::int64_t>();
  for (const auto& place : places) {
    Rng rng(seed, place.scan.at(), place.viewpoint.at());
    renderer->render({kHomeWidth, kHomeHeight, degrees(60)}, draw_views(place, views, rng),
                     outputs_into({colours, views * 3 * kPixels}, buffers));
    for (std::size_t v = 0; v < views; ++v) {
      count_classes(std::span(buffers.classes).subspan(v * kPixels, kPixels), classes);
      average_distances(std::span(buffers.distances).subspan(v * kPixels, kPixels), distances);
      colours += 3 * kPixels;
      classes += kObjectClasses * kCells;
      distances += kCells;
      *rooms++ = static_cast<unsigned char>(place.room);
    }
  }
  return pictures;
}

}  // namespace enfilade::neural::encoders
