#include "enfilade/arena/pictures.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <span>
#include <utility>

#include "enfilade/arena/detail/view_renderer.h"
#include "enfilade/core/errors.h"
#include "enfilade/draw/outlines.h"
#include "enfilade/image/codecs.h"

namespace enfilade::arena {
namespace {

using detail::Gaze;

constexpr int kQuality = 85;
// Conversations show the picture of the step before again.
constexpr std::size_t kKept = 8;
constexpr std::uint32_t kSmallest = 64, kLargest = 2048;
// Quarters of a strip, by how far each is turned from the heading: left, ahead, right, behind.
constexpr std::array<double, 4> kQuarters{-90, 0, 90, 180};

/// The directions that an order has pictures of, side by side.
std::vector<Gaze> gazes_of(const PictureOrder& order) {
  if (!order.strip) return {{order.from.heading, order.from.elevation}};
  std::vector<Gaze> gazes;
  for (const double turn : kQuarters) {
    gazes.push_back({wrap_heading(order.from.heading + degrees(turn)), Radians(0)});
  }
  return gazes;
}

/// Where a direction is drawn in a strip of squares of 90 degrees: in the one that looks nearest to
/// it, so that each has its place once.
draw::Mark mark_of(const NamedDirection& mark, std::span<const Gaze> gazes, double size) {
  const auto aside = [&](const Gaze& gaze) {
    return wrap_difference(mark.heading - gaze.heading).value;
  };
  const auto nearest =
      std::ranges::min_element(gazes, {}, [&](const Gaze& gaze) { return std::abs(aside(gaze)); });
  const double turn = aside(*nearest);
  const double ahead = std::cos(mark.elevation.value) * std::cos(turn);
  const double right = std::cos(mark.elevation.value) * std::sin(turn);
  const double up = std::sin(mark.elevation.value);
  const double x = std::clamp(size / 2 * (1 + right / ahead), 0.0, size - 1);
  const double y = std::clamp(size / 2 * (1 - up / ahead), 0.0, size - 1);
  return {x + size * static_cast<double>(nearest - gazes.begin()), y, mark.name};
}

}  // namespace

std::string PictureOrder::key() const {
  std::string key =
      fmt::format("{}/{}/{}/{:.4f}/{:.4f}/{}", strip ? "strip" : "view", from.scan, from.place,
                  to_degrees(from.heading), to_degrees(from.elevation), size);
  for (const NamedDirection& mark : marks) {
    key += fmt::format("/{}:{:.4f}:{:.4f}", mark.name, to_degrees(mark.heading),
                       to_degrees(mark.elevation));
  }
  return key;
}

std::vector<PictureOrder> order_pictures(const Session& session, PictureKind pictures,
                                         std::uint32_t size) {
  if (size < kSmallest || size > kLargest) {
    throw ArgumentError(
        fmt::format("size of pictures: {} pixels, {} to {}", size, kSmallest, kLargest));
  }
  std::vector<PictureOrder> orders;
  if (pictures == PictureKind::kNone || session.ending()) return orders;
  const Standpoint here = session.standpoint();
  const SessionObservation& seen = session.observation();
  const auto towards = [&here](Radians heading, Radians elevation) {
    Standpoint from = here;
    from.heading = heading;
    from.elevation = elevation;
    return from;
  };
  if (pictures == PictureKind::kStrip) {
    PictureOrder& strip = orders.emplace_back();
    strip = {{}, towards(here.heading, Radians(0)), true, size, {}};
    for (const Neighbour& place : seen.places) {
      strip.marks.push_back({place.name, wrap_heading(here.heading + place.turn), place.elevation});
    }
    return orders;
  }
  if (std::holds_alternative<Vec3d>(here.eye)) {
    orders.push_back({"ahead", here, false, size, {}});
    return orders;
  }
  for (const Neighbour& place : seen.places) {
    orders.push_back({place.name,
                      towards(wrap_heading(here.heading + place.turn), place.elevation),
                      false,
                      size,
                      {}});
  }
  return orders;
}

struct PictureMaker::Impl {
  detail::ViewRenderer sight;
  std::vector<std::uint8_t> pixels;
  std::deque<std::pair<std::string, std::string>> drawn;  // the latest at the end, by key

  std::string draw(const PictureOrder& order);
};

PictureMaker::PictureMaker(const ViewSources& sights)
    : impl_(new Impl{detail::ViewRenderer(sights), {}, {}}) {}
PictureMaker::~PictureMaker() = default;

std::string PictureMaker::draw(const PictureOrder& order) {
  std::string key = order.key();
  auto& drawn = impl_->drawn;
  const auto known = std::ranges::find_if(drawn, [&](const auto& one) { return one.first == key; });
  if (known != drawn.end()) return known->second;
  if (drawn.size() == kKept) drawn.pop_front();
  return drawn.emplace_back(std::move(key), impl_->draw(order)).second;
}

std::string PictureMaker::Impl::draw(const PictureOrder& order) {
  const std::vector<Gaze> gazes = gazes_of(order);
  const auto count = static_cast<std::uint32_t>(gazes.size());
  const std::size_t row = std::size_t{3} * order.size, each = row * order.size;
  pixels.resize(each * count);
  render::Outputs outputs;
  outputs.colour.emplace().pixels = std::as_writable_bytes(std::span(pixels));
  Camera camera = detail::camera_for(order.from, order.size);
  if (order.strip) camera.vertical_field_of_view = degrees(90);
  sight.render(camera, order.from, gazes, outputs);
  image::Image8 picture(count * order.size, order.size, 3);
  for (std::uint32_t k = 0; k < count; ++k) {
    for (std::uint32_t y = 0; y < order.size; ++y) {
      std::ranges::copy(std::span(pixels).subspan(k * each + y * row, row),
                        picture.at(std::size_t{k} * order.size, y));
    }
  }
  std::vector<draw::Mark> marks;
  for (const NamedDirection& mark : order.marks) marks.push_back(mark_of(mark, gazes, order.size));
  draw::draw_marks(picture, marks);
  const std::vector<std::uint8_t> bytes = image::encode_jpeg(picture, kQuality);
  return {bytes.begin(), bytes.end()};
}

}  // namespace enfilade::arena
