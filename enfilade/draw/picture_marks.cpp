#include "enfilade/draw/picture_marks.h"

#include <algorithm>
#include <cmath>

#include "enfilade/draw/detail/bitmap_text.h"

namespace enfilade::draw {
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
