#include "enfilade/arena/pictures.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "enfilade/core/errors.h"
#include "enfilade/draw/picture_marks.h"
#include "enfilade/image/codecs.h"
#include "enfilade/render/renderer.h"

namespace enfilade::arena {
namespace {

constexpr int kQuality = 85;
constexpr std::uint32_t kSmallest = 64, kLargest = 2048;
// Quarters of a strip, by how far each is turned from the heading: left, ahead, right, behind.
constexpr std::array<double, 4> kQuarters{-90, 0, 90, 180};

std::vector<render::View> views_of(const PictureOrder& order) {
  const GraphPose& pose = order.pose;
  if (!order.strip) {
    return {{pose.location.scan, pose.location.viewpoint, pose.heading, pose.elevation}};
  }
  std::vector<render::View> views;
  for (const double turn : kQuarters) {
    views.push_back({pose.location.scan, pose.location.viewpoint,
                     wrap_heading(pose.heading + degrees(turn)), Radians(0)});
  }
  return views;
}

/// Where a direction is drawn in a strip of squares of 90 degrees: in the one that looks nearest to
/// it, so that each has its place once.
draw::Mark mark_of(const NamedDirection& mark, std::span<const render::View> views, double size) {
  const auto aside = [&](const render::View& view) {
    return wrap_difference(mark.heading - view.heading).value;
  };
  const auto nearest = std::ranges::min_element(
      views, {}, [&](const render::View& view) { return std::abs(aside(view)); });
  const double turn = aside(*nearest);
  const double ahead = std::cos(mark.elevation.value) * std::cos(turn);
  const double right = std::cos(mark.elevation.value) * std::sin(turn);
  const double up = std::sin(mark.elevation.value);
  const double x = std::clamp(size / 2 * (1 + right / ahead), 0.0, size - 1);
  const double y = std::clamp(size / 2 * (1 - up / ahead), 0.0, size - 1);
  return {x + size * static_cast<double>(nearest - views.begin()), y, mark.name};
}

}  // namespace

std::string PictureOrder::key(const graph::GraphSet& graphs) const {
  const graph::NavGraph& graph = graphs.graph(pose.location.scan);
  std::string key = fmt::format("{}/{}/{}/{:.4f}/{:.4f}/{}", strip ? "strip" : "view", graph.scan(),
                                graph.id(pose.location.viewpoint), to_degrees(pose.heading),
                                to_degrees(pose.elevation), size);
  for (const NamedDirection& mark : marks) {
    key += fmt::format("/{}:{:.4f}:{:.4f}", mark.name, to_degrees(mark.heading),
                       to_degrees(mark.elevation));
  }
  return key;
}

std::vector<PictureOrder> order_pictures(const GraphSession& session, Pictures pictures,
                                         std::uint32_t size) {
  if (size < kSmallest || size > kLargest) {
    throw ArgumentError(
        fmt::format("size of pictures: {} pixels, {} to {}", size, kSmallest, kLargest));
  }
  std::vector<PictureOrder> orders;
  if (pictures == Pictures::kNone || session.ending()) return orders;
  const GraphPose pose = session.pose();
  const Observation& seen = session.observation();
  if (pictures == Pictures::kStrip) {
    PictureOrder& strip = orders.emplace_back();
    strip = {{}, {pose.location, pose.heading, Radians(0)}, true, size, {}};
    for (const Place& place : seen.places) {
      strip.marks.push_back({place.name, wrap_heading(pose.heading + place.turn), place.elevation});
    }
    return orders;
  }
  for (const Place& place : seen.places) {
    orders.push_back({place.name,
                      {pose.location, wrap_heading(pose.heading + place.turn), place.elevation},
                      false,
                      size,
                      {}});
  }
  return orders;
}

struct Painter::Impl {
  std::unique_ptr<render::Renderer> renderer;
  std::vector<std::uint8_t> pixels;
};

Painter::Painter(const dataset::Dataset& data) : impl_(std::make_unique<Impl>()) {
  impl_->renderer = render::make_renderer(data.faces(), {.threads = 1});
}
Painter::~Painter() = default;

std::string Painter::draw(const PictureOrder& order) {
  const std::vector<render::View> views = views_of(order);
  const auto count = static_cast<std::uint32_t>(views.size());
  const std::size_t row = std::size_t{3} * order.size, each = row * order.size;
  impl_->pixels.resize(each * count);
  render::Outputs outputs;
  outputs.colour.emplace().pixels = std::as_writable_bytes(std::span(impl_->pixels));
  const Camera camera{order.size, order.size, order.strip ? degrees(90) : degrees(60)};
  impl_->renderer->render(camera, views, outputs);
  image::Image8 picture(count * order.size, order.size, 3);
  std::vector<draw::Mark> marks;
  for (std::uint32_t k = 0; k < count; ++k) {
    for (std::uint32_t y = 0; y < order.size; ++y) {
      std::ranges::copy(std::span(impl_->pixels).subspan(k * each + y * row, row),
                        picture.at(std::size_t{k} * order.size, y));
    }
  }
  for (const NamedDirection& mark : order.marks) marks.push_back(mark_of(mark, views, order.size));
  draw::draw_marks(picture, marks);
  const std::vector<std::uint8_t> bytes = image::encode_jpeg(picture, kQuality);
  return {bytes.begin(), bytes.end()};
}

}  // namespace enfilade::arena
