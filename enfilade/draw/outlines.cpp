#include "enfilade/draw/outlines.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <variant>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/draw/detail/bitmap_text.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::draw {
namespace {

using detail::Rgb;
using tasks::Direction;

constexpr double kBoxWidth = 640, kBoxHeight = 480;  // pictures that boxes are of
constexpr Radians kBoxField = degrees(60);
constexpr std::size_t kPieces = 16;  // of a side: a box as wide as its picture has 5 degrees each
constexpr Rgb kLine{240, 228, 66};   // yellow of the palette of floor plans
constexpr Rgb kEdgeOfLine{20, 20, 24};

// The axes of a camera, world frame.
struct Axes {
  Vec3d right, up, forward;
};
Axes axes_of(const Direction& look) {
  const double sh = std::sin(look.heading.value), ch = std::cos(look.heading.value);
  const double se = std::sin(look.elevation.value), ce = std::cos(look.elevation.value);
  return {{ch, -sh, 0}, {-sh * se, -ch * se, ce}, {sh * ce, ch * ce, se}};
}

Vec3d normalised(Vec3d v) { return (1 / length(v)) * v; }

struct Pixel {
  double x = 0, y = 0;
};

// Draws lines of a width that suits the picture.
class Pen {
 public:
  explicit Pen(image::Image8& picture)
      : picture_(picture), radius_(std::max(1.0, std::max(picture.width, picture.height) / 320.0)) {
    if (picture.channels == 3 && !picture.pixels.empty()) return;
    throw ArgumentError(fmt::format("picture: {} x {} with {} channels; 3 channels are expected",
                                    picture.width, picture.height, picture.channels));
  }

  void line(Pixel a, Pixel b) { lines_.emplace_back(a, b); }

  // The dark edge of all lines first, so that it crosses none of them.
  void finish(const std::string& label) {
    for (const auto& [a, b] : lines_) stroke(a, b, radius_ + 1, kEdgeOfLine);
    for (const auto& [a, b] : lines_) stroke(a, b, radius_, kLine);
    write(label);
  }

 private:
  void stroke(Pixel a, Pixel b, double radius, Rgb colour) {
    if (!clip(a, b)) return;
    const double steps = std::ceil(2 * std::hypot(b.x - a.x, b.y - a.y)) + 1;
    for (double k = 0; k <= steps; ++k) {
      const double share = k / steps;
      dot({a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)}, radius, colour);
    }
  }

  // Cuts a line to a frame around the picture (Liang and Barsky); false: nothing is left.
  bool clip(Pixel& a, Pixel& b) const {
    const double border = radius_ + 2, dx = b.x - a.x, dy = b.y - a.y;
    double first = 0, last = 1;
    const auto cut = [&](double step, double room) {
      if (step == 0) return room >= 0;
      const double at = room / step;
      if (step < 0) first = std::max(first, at);
      if (step > 0) last = std::min(last, at);
      return first <= last;
    };
    const bool left = cut(-dx, a.x + border) && cut(dx, picture_.width + border - a.x) &&
                      cut(-dy, a.y + border) && cut(dy, picture_.height + border - a.y);
    if (!left) return false;
    b = {a.x + last * dx, a.y + last * dy};
    a = {a.x + first * dx, a.y + first * dy};
    return true;
  }

  void dot(Pixel p, double radius, Rgb colour) {
    // Pixels whose middles are at most a radius away.
    const auto range = [radius](double at, std::uint32_t size) {
      const auto clamped = [size](double x) {
        return static_cast<std::size_t>(std::clamp(x, 0.0, static_cast<double>(size)));
      };
      return std::pair(clamped(std::ceil(at - radius - 0.5)),
                       clamped(std::floor(at + radius - 0.5) + 1));
    };
    const auto [left, right] = range(p.x, picture_.width);
    const auto [top, bottom] = range(p.y, picture_.height);
    for (std::size_t y = top; y < bottom; ++y) {
      for (std::size_t x = left; x < right; ++x) {
        const double dx = static_cast<double>(x) + 0.5 - p.x;
        const double dy = static_cast<double>(y) + 0.5 - p.y;
        if (dx * dx + dy * dy <= radius * radius) std::ranges::copy(colour, picture_.at(x, y));
      }
    }
  }

  // Above the highest point that is on the picture, or just inside of the upper edge.
  void write(const std::string& label) {
    const Pixel* top = nullptr;
    for (const auto& [a, b] : lines_) {
      const bool on = a.x >= 0 && a.x < picture_.width && a.y >= 0 && a.y < picture_.height;
      if (on && (top == nullptr || a.y < top->y)) top = &a;
    }
    if (label.empty() || top == nullptr) return;
    const std::uint32_t scale = std::clamp(picture_.width / 320U, 1U, 3U), pad = 2 * scale;
    const std::string text = detail::cut_text(label, picture_.width - 2 * pad, scale);
    const std::uint32_t wide = detail::text_pixels(text, scale) + 2 * pad;
    const std::uint32_t high = detail::kLetterHeight * scale + 2 * pad;
    const auto place = [](double wanted, std::uint32_t size, std::uint32_t room) {
      const double most = room > size ? room - size : 0;
      return static_cast<std::uint32_t>(std::clamp(wanted, 0.0, most));
    };
    const std::uint32_t x = place(top->x, wide, picture_.width);
    const std::uint32_t y = place(top->y - high - 2 * radius_, high, picture_.height);
    detail::fill(picture_, x, y, wide, high, kEdgeOfLine);
    detail::draw_text(picture_, x + pad, y + pad, text, kLine, scale);
  }

  image::Image8& picture_;
  double radius_;
  std::vector<std::pair<Pixel, Pixel>> lines_;
};

// How many edges of its picture a box touches, within the two pixels by which boxes end early.
int touched_edges(const std::array<std::int32_t, 4>& box) {
  constexpr std::int32_t kNear = 2;
  return (box[0] <= kNear ? 1 : 0) + (box[1] <= kNear ? 1 : 0) +
         (box[0] + box[2] >= kBoxWidth - kNear ? 1 : 0) +
         (box[1] + box[3] >= kBoxHeight - kNear ? 1 : 0);
}

std::vector<Outline> outlines_of(const tasks::SeenObject& goal, std::string_view scan,
                                 std::string_view viewpoint, const tasks::ObjectBoxes* objects,
                                 const std::optional<Direction>& towards) {
  std::vector<Outline> outlines;
  if (objects == nullptr) return outlines;
  for (const tasks::ViewedObject& object : objects->at(scan, viewpoint)) {
    if (object.id != goal.id || !object.visible()) continue;
    const std::size_t k = best_box(object, towards);
    outlines.push_back(outline_of_box(object.views[k], object.boxes[k]));
    outlines.back().label = object.name.substr(0, object.name.find('#'));
  }
  return outlines;
}

}  // namespace

Direction direction_of_view(std::uint8_t view) {
  EN_CHECK_LT(view, kViews);
  return {degrees(30.0 * (view % 12)), degrees(30.0 * (view / 12) - 30.0)};
}

Vec3d unit_vector(const Direction& direction) { return axes_of(direction).forward; }

Direction direction_of(Vec3d v) {
  return {wrap_heading(Radians(std::atan2(v.x, v.y))),
          Radians(std::atan2(v.z, std::hypot(v.x, v.y)))};
}

Outline outline_of_box(std::uint8_t view, const std::array<std::int32_t, 4>& box) {
  const Axes camera = axes_of(direction_of_view(view));
  const double focal = kBoxHeight / 2 / std::tan(kBoxField.value / 2);
  const double left = box[0], top = box[1], right = left + box[2], bottom = top + box[3];
  const std::array<Pixel, 4> corners{{{left, top}, {right, top}, {right, bottom}, {left, bottom}}};
  Outline outline;
  for (std::size_t i = 0; i < 4; ++i) {
    const Pixel a = corners[i], b = corners[(i + 1) % 4];
    for (std::size_t k = 0; k < kPieces; ++k) {
      const double share = static_cast<double>(k) / kPieces;
      const double x = a.x + share * (b.x - a.x) - kBoxWidth / 2;
      const double y = kBoxHeight / 2 - (a.y + share * (b.y - a.y));
      outline.rim.push_back(normalised(x * camera.right + y * camera.up + focal * camera.forward));
    }
  }
  return outline;
}

Outline outline_of_corners(const std::array<Direction, 4>& corners) {
  Outline outline;
  for (std::size_t i = 0; i < 4; ++i) {
    const Direction& a = corners[i];
    const Direction& b = corners[(i + 1) % 4];
    const Radians turn = wrap_difference(b.heading - a.heading);
    const std::size_t pieces =
        kPieces * (1 + static_cast<std::size_t>(std::abs(turn.value) / kPi * 4));
    for (std::size_t k = 0; k < pieces; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(pieces);
      outline.rim.push_back(unit_vector(
          {a.heading + share * turn, a.elevation + share * (b.elevation - a.elevation)}));
    }
  }
  return outline;
}

std::size_t best_box(const tasks::ViewedObject& object, const std::optional<Direction>& towards) {
  EN_CHECK(object.visible());
  const auto rank = [&](std::size_t k) -> std::tuple<int, double> {
    const std::array<std::int32_t, 4>& box = object.boxes[k];
    if (towards) {
      return {touched_edges(box),
              -dot(unit_vector(direction_of_view(object.views[k])), unit_vector(*towards))};
    }
    return {touched_edges(box), std::hypot(box[0] + 0.5 * box[2] - kBoxWidth / 2,
                                           box[1] + 0.5 * box[3] - kBoxHeight / 2)};
  };
  std::size_t best = 0;
  for (std::size_t k = 1; k < object.views.size(); ++k) {
    if (rank(k) < rank(best)) best = k;
  }
  return best;
}

std::vector<Outline> goal_outlines(const graph::NavGraph& graph, const tasks::Goal& goal,
                                   ViewpointIndex viewpoint, const tasks::ObjectBoxes* objects,
                                   const std::optional<Direction>& towards) {
  if (const auto* object = std::get_if<tasks::SeenObject>(&goal)) {
    return outlines_of(*object, graph.scan(), graph.id(viewpoint), objects, towards);
  }
  std::vector<Outline> outlines;
  if (const auto* boxes = std::get_if<tasks::Boxes>(&goal)) {
    for (const tasks::Box& box : boxes->boxes) {
      if (box.viewpoint == viewpoint) outlines.push_back(outline_of_corners(box.corners));
    }
  }
  return outlines;
}

Direction centre_of(const Outline& outline) {
  EN_CHECK(!outline.rim.empty());
  Vec3d sum;
  for (const Vec3d& one : outline.rim) sum += one;
  return direction_of(sum);
}

void draw_outline(image::Image8& picture, const Outline& outline, const Direction& look,
                  Radians vertical_field_of_view) {
  Pen pen(picture);
  const Axes camera = axes_of(look);
  const double focal = picture.height / 2.0 / std::tan(vertical_field_of_view.value / 2);
  constexpr double kNearest = 0.02;  // what is farther aside than 89 degrees is on no picture
  const auto pixel = [&](Vec3d v) -> std::optional<Pixel> {
    const double ahead = dot(v, camera.forward);
    if (ahead < kNearest) return std::nullopt;
    return Pixel{picture.width / 2.0 + focal * dot(v, camera.right) / ahead,
                 picture.height / 2.0 - focal * dot(v, camera.up) / ahead};
  };
  for (std::size_t k = 0; k < outline.rim.size(); ++k) {
    const auto a = pixel(outline.rim[k]), b = pixel(outline.rim[(k + 1) % outline.rim.size()]);
    if (a && b) pen.line(*a, *b);
  }
  pen.finish(outline.label);
}

namespace {

using detail::Rgb;

constexpr Rgb kPlate{24, 24, 28};
constexpr Rgb kLight{255, 255, 255};
// A letter is 7 dots high. Models read letters of 4 % of a picture's height; people too.
constexpr std::uint32_t kHeightsOfDot = 170;

/// Where a plate begins whose middle should be at `middle`.
std::uint32_t begin_of(double middle, std::uint32_t size, std::uint32_t most) {
  const double first = std::round(middle - size / 2.0);
  return static_cast<std::uint32_t>(std::clamp(first, 0.0, static_cast<double>(most - size)));
}

void draw_mark(image::Image8& picture, const Mark& mark, std::uint32_t scale) {
  const std::uint32_t rim = std::max(1U, scale / 2), blank = 2 * scale;
  const std::uint32_t width = detail::text_pixels(mark.text, scale) + 2 * (rim + blank);
  const std::uint32_t height = detail::kLetterHeight * scale + 2 * (rim + blank);
  if (width > picture.width || height > picture.height) return;
  const std::uint32_t x = begin_of(mark.x, width, picture.width);
  const std::uint32_t y = begin_of(mark.y, height, picture.height);
  detail::fill(picture, x, y, width, height, kLight);
  detail::fill(picture, x + rim, y + rim, width - 2 * rim, height - 2 * rim, kPlate);
  // Capitals are two dots less high than what kLetterHeight counts.
  detail::draw_text(picture, x + rim + blank, y + rim + blank + scale, mark.text, kLight, scale);
}

}  // namespace

void draw_marks(image::Image8& picture, std::span<const Mark> marks) {
  const std::uint32_t scale = std::max(1U, picture.height / kHeightsOfDot);
  for (const Mark& mark : marks) {
    const bool inside =
        mark.x >= 0 && mark.y >= 0 && mark.x < picture.width && mark.y < picture.height;
    if (inside) draw_mark(picture, mark, scale);
  }
}

}  // namespace enfilade::draw
