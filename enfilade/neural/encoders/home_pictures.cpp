#include "enfilade/neural/encoders/home_pictures.h"

#include <ATen/ATen.h>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

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

// Draws the same number of views at each place.
class Drawing {
 public:
  Drawing(const std::shared_ptr<const scan::PanoramaSet>& panoramas, std::size_t views,
          Radians vfov, int threads)
      : camera_{kHomeWidth, kHomeHeight, vfov},
        renderer_(render::make_renderer(
            std::make_shared<render::FaceCache>(
                panoramas, render::FaceCacheConfig{.threads = threads, .prefetch_thread = false}),
            {render::Backend::kCpu, threads, {}, {}})),
        views_(views),
        classes_(views * kPixels),
        distances_(views * kPixels) {}

  // \param row of the first view's labels and, if there are any, colours
  void draw(std::span<const render::View> views, char room, std::size_t row,
            LabelledPictures& pictures) {
    render::Outputs outputs;
    if (pictures.colours.defined()) {
      auto* const colours = pictures.colours.data_ptr<std::uint8_t>() + row * 3 * kPixels;
      outputs.colour = {render::ColourFormat::kRgb8,
                        {},
                        std::as_writable_bytes(std::span(colours, views_ * 3 * kPixels))};
    }
    outputs.classes = {render::ClassFormat::kUint8, std::as_writable_bytes(std::span(classes_))};
    outputs.depth = {render::DepthFormat::kMetresFloat32, render::DepthMeasure::kRay,
                     std::as_writable_bytes(std::span(distances_))};
    renderer_->render(camera_, views, outputs);
    constexpr std::size_t kLabels = kObjectClasses * kCells;
    for (std::size_t v = 0; v < views_; ++v) {
      count_classes(std::span(classes_).subspan(v * kPixels, kPixels),
                    pictures.classes.data_ptr<std::uint8_t>() + (row + v) * kLabels);
      average_distances(std::span(distances_).subspan(v * kPixels, kPixels),
                        pictures.distances.data_ptr<float>() + (row + v) * kCells);
      pictures.rooms.data_ptr<std::int64_t>()[row + v] = static_cast<unsigned char>(room);
    }
  }

 private:
  Camera camera_;
  std::unique_ptr<render::Renderer> renderer_;
  std::size_t views_;
  std::vector<std::uint8_t> classes_;  // of the pixels of one place
  std::vector<float> distances_;
};

LabelledPictures empty_labels(std::size_t pictures) {
  const auto n = static_cast<std::int64_t>(pictures);
  return {{},
          at::zeros({n, kObjectClasses, kHomeRows, kHomeColumns}, at::kByte),
          at::empty({n, 1, kHomeRows, kHomeColumns}, at::kFloat),
          at::empty({n}, at::kLong)};
}

}  // namespace

std::vector<LabelledPlace> places_of(const scan::PanoramaSet& panoramas,
                                     std::span<const std::string> scans, const RoomOf& room) {
  std::vector<LabelledPlace> places;
  for (const std::string& name : scans) {
    const ScanIndex index = panoramas.at(name);
    const scan::PanoramaSource& source = panoramas.source(index);
    for (std::size_t v = 0; v < source.size(); ++v) {
      const scan::PanoramaPose& pose = source.poses()[v];
      const std::size_t faces =
          source.face_sizes(ViewpointIndex(v))[scan::index(scan::Layer::kColour)];
      if (!pose.included || faces == 0) continue;
      places.push_back({index, ViewpointIndex(v), room ? room(name, pose.viewpoint) : '-'});
    }
  }
  return places;
}

void thin_out(std::vector<LabelledPlace>& places, std::size_t most) {
  if (places.size() <= most) return;
  std::vector<LabelledPlace> kept;
  for (std::size_t i = 0; i < most; ++i) kept.push_back(places[i * places.size() / most]);
  places = std::move(kept);
}

LabelledPictures draw_labelled(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                               std::span<const LabelledPlace> places, std::size_t views,
                               std::uint64_t seed, int threads) {
  LabelledPictures pictures = empty_labels(places.size() * views);
  pictures.colours = at::empty({pictures.rooms.numel(), kHomeHeight, kHomeWidth, 3}, at::kByte);
  Drawing drawing(panoramas, views, degrees(60), threads);
  std::size_t row = 0;
  for (const LabelledPlace& place : places) {
    Rng rng(seed, place.scan.at(), place.viewpoint.at());
    drawing.draw(draw_views(place, views, rng), place.room, row, pictures);
    row += views;
  }
  return pictures;
}

LabelledPictures label_views(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                             std::span<const LabelledPlace> places, Radians vfov, int threads) {
  LabelledPictures pictures = empty_labels(places.size() * render::kDiscreteViews);
  Drawing drawing(panoramas, render::kDiscreteViews, vfov, threads);
  std::size_t row = 0;
  for (const LabelledPlace& place : places) {
    drawing.draw(render::discrete_views(place.scan, place.viewpoint), place.room, row, pictures);
    row += render::kDiscreteViews;
  }
  return pictures;
}

}  // namespace enfilade::neural::encoders
