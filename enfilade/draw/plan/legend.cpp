#include "enfilade/draw/plan/legend.h"

#include <algorithm>
#include <cmath>

#include "enfilade/draw/plan/marks.h"

namespace enfilade::draw::plan {
namespace {

constexpr double kTextSize = 12.5;
constexpr double kRow = 27;
constexpr double kItemGap = 26;
constexpr double kScaleWidth = 190;  // of the bar and the arrow with their margins
constexpr double kLongestBar = 120;

// The longest of 1, 2, 5 times a power of ten metres whose bar is short enough.
double bar_length(double pixels_per_metre) {
  const double longest = kLongestBar / pixels_per_metre;
  const double power = std::pow(10, std::floor(std::log10(longest)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= longest) return factor * power;
  }
  return power;
}

std::string draw_scale(Point p, double pixels_per_metre) {
  const double metres = bar_length(pixels_per_metre);
  const double width = metres * pixels_per_metre;
  std::string out = fmt::format(
      "<rect x=\"{0}\" y=\"{1}\" width=\"{2}\" height=\"5\" fill=\"#fff\" stroke=\"{4}\"/>"
      "<rect x=\"{0}\" y=\"{1}\" width=\"{3}\" height=\"5\" fill=\"{4}\"/>\n",
      number(p.x), number(p.y), number(width), number(width / 2), kInk);
  out += text(p + Point{0, 20}, "0", 11, kInk, false, Anchor::kMiddle);
  return out + text(p + Point{width, 20}, fmt::format("{:g} m", metres), 11, kInk, false,
                    Anchor::kMiddle);
}

std::string draw_north(Point p) {
  return fmt::format(
             "<path d=\"M{}l6,17l-6,-4l-6,4z\" fill=\"#fff\" stroke=\"{}\" stroke-width=\"1.2\" "
             "stroke-linejoin=\"round\"/><path d=\"M{}v13l-6,4z\" fill=\"{}\"/>\n",
             pair(p), kInk, pair(p), kInk) +
         text(p + Point{0, -4}, "N", 11, kInk, true, Anchor::kMiddle);
}

}  // namespace

Block draw_legend(const std::vector<LegendItem>& items, Point corner, double width,
                  double pixels_per_metre) {
  Block block;
  block.svg =
      draw_north(corner + Point{12, 16}) + draw_scale(corner + Point{42, 14}, pixels_per_metre);
  const bool beside = width > 2.5 * kScaleWidth;  // else below
  const double left = beside ? kScaleWidth : 0;
  Point cursor{left, beside ? 16.0 : 16.0 + kRow + 22};
  for (const LegendItem& item : items) {
    const double item_width = item.width + 7 + text_width(item.label, kTextSize);
    if (cursor.x > left && cursor.x + item_width > width) cursor = {left, cursor.y + kRow};
    append(block.svg, "<g transform=\"translate({})\">{}</g>\n",
           pair(corner + cursor + Point{item.width / 2, 0}), item.sample);
    block.svg += text(corner + cursor + Point{item.width + 7, 4.5}, item.label, kTextSize, kInk);
    cursor.x += item_width + kItemGap;
  }
  block.height = std::max(40.0, cursor.y + 18);
  return block;
}

}  // namespace enfilade::draw::plan
