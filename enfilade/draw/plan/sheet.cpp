#include "enfilade/draw/plan/sheet.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <ranges>
#include <utility>

#include "enfilade/draw/markup.h"
#include "enfilade/draw/plan/trace.h"

namespace enfilade::draw::plan {
namespace {

constexpr double kBorder = 26;   // around everything, pixels
constexpr double kHeading = 62;  // title and subtitle
constexpr double kTitleSize = 21;
constexpr double kNoteSize = 14;
constexpr double kNoteLine = 20;
constexpr double kNarrowest = 560;  // room for a title and two columns of legend
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

// SVG text and its height, pixels.
struct Block {
  std::string svg;
  double height = 0;
};

// Scale bar and north arrow on the left, items beside them in as many rows as needed.
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

std::string draw_heading(const Sheet& sheet, const std::vector<std::string>& note) {
  Point p{kBorder, kBorder + 16};
  std::string out = text(p, sheet.title, kTitleSize, kInk, true);
  p.y += 22;
  out += text(p, sheet.subtitle, 13, kFaintInk);
  p.y += 3;
  for (const std::string& line : note) {
    p.y += kNoteLine;
    out += text(p, line, kNoteSize, kInk);
  }
  return out;
}

}  // namespace

std::string draw_sheet(const Sheet& sheet, const PanelLayout& layout, const std::string& panels) {
  const double width =
      std::max({layout.size.x, kNarrowest, 1.15 * text_width(sheet.title, kTitleSize)});
  std::vector<std::string> note;
  for (const std::string& one : sheet.notes) {
    for (std::string& line : wrap(one, kNoteSize, width)) note.push_back(std::move(line));
  }
  const double top = kBorder + kHeading + kNoteLine * static_cast<double>(note.size());
  const double legend_top = top + layout.size.y + 20;
  const Block legend = draw_legend(sheet.legend, {kBorder, legend_top}, width, layout.scale);
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" role=\"img\">\n<title>Floor plan: {2}</title>\n"
      "<rect width=\"{0}\" height=\"{1}\" rx=\"10\" fill=\"#fff\"/>\n"
      "<g font-family=\"'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif\">\n",
      number(std::ceil(width + 2 * kBorder)),
      number(std::ceil(legend_top + legend.height + kBorder - 10)), escape(sheet.title));
  out += draw_heading(sheet, note);
  append(out, "<g transform=\"translate({})\">\n{}</g>\n", pair({kBorder, top}), panels);
  if (sheet.rule) {
    append(out, "<path d=\"M{}h{}\" stroke=\"#e2e4e8\"/>\n", pair({kBorder, legend_top - 12}),
           number(width));
  }
  return out + legend.svg + "</g>\n</svg>\n";
}

std::string draw_caption(const StoreyPlan& plan, const Panel& panel) {
  const auto [name, facts] = caption(plan, panel.storey);
  const Point p = panel.corner + Point{0, 12};
  return text(p, name, 13, kInk, true) +
         text(p + Point{text_width(name, 13) + 10, 0}, facts, 12, kFaintInk);
}

std::string draw_floor(const StoreyPlan& plan, const Panel& panel) {
  const auto place = [&](ViewpointIndex v) { return pair(panel.at(plan.graph.position(v))); };
  std::string path;
  for (const ViewpointIndex v : plan.storeys[panel.storey].viewpoints) {
    path += "M" + place(v) + "h0";
  }
  for (const auto& [a, b] : plan.edges) {
    if (plan.storey_of[a.at()] != panel.storey || plan.between_storeys(a, b)) continue;
    path += "M" + place(a) + "L" + place(b);
  }
  if (path.empty()) return "";
  const double width = 2 * kFloorRadius * panel.scale;
  return fmt::format(
      "<g fill=\"none\" stroke-linecap=\"round\"><path d=\"{0}\" stroke=\"{1}\" "
      "stroke-width=\"{2}\"/><path d=\"{0}\" stroke=\"{3}\" stroke-width=\"{4}\"/></g>\n",
      path, kFloorRim, number(width + 3), kFloor, number(width));
}

std::string draw_labels(const StoreyPlan& plan, const Panel& panel) {
  std::string out =
      "<g font-size=\"10\" fill=\"#111\" stroke=\"#fff\" stroke-width=\"2.5\" "
      "stroke-linejoin=\"round\" paint-order=\"stroke\">\n";
  for (std::size_t i = 0; i < plan.graph.size(); ++i) {
    if (plan.storey_of[i] != panel.storey) continue;
    const Point p = panel.at(plan.graph.position(ViewpointIndex(i))) + Point{5, -5};
    append(out, "<text x=\"{}\" y=\"{}\">{}</text>\n", number(p.x), number(p.y), i);
  }
  return out + "</g>\n";
}

namespace {

using Kind = UnderlayLine::Kind;

struct Look {
  Kind kind;
  const char* name;
  const char* attributes;  // of the lines
};
// In the order in which they are drawn. What is harder to pass is darker and broader.
constexpr std::array<Look, 5> kLooks{
    {{Kind::kThing, "furniture", "stroke=\"#c9b79a\" stroke-width=\"0.8\""},
     {Kind::kStairs, "stairs", "stroke=\"#b08968\" stroke-width=\"0.8\""},
     {Kind::kWindow, "window", "stroke=\"#56b4e9\" stroke-width=\"2.2\""},
     {Kind::kDoor, "door", "stroke=\"#b5651d\" stroke-width=\"1.6\""},
     {Kind::kWall, "wall", "stroke=\"#4b5058\" stroke-width=\"2.2\""}}};

}  // namespace

std::string draw_lines(const UnderlayStorey& storey, const Panel& panel) {
  std::string out = "<g fill=\"none\" stroke-linecap=\"round\">\n";
  for (const Look& look : kLooks) {
    std::string path;
    for (const UnderlayLine& line : storey.lines) {
      if (line.kind != look.kind) continue;
      path += "M" + pair(panel.at(line.from)) + "L" + pair(panel.at(line.to));
    }
    if (!path.empty()) append(out, "<path d=\"{}\" {}/>\n", path, look.attributes);
  }
  return out + "</g>\n";
}

std::string draw_texts(const UnderlayStorey& storey, const Panel& panel) {
  constexpr double kSize = 11;
  if (storey.texts.empty()) return "";
  std::string out =
      "<g stroke=\"#fff\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\">\n";
  for (const UnderlayText& name : storey.texts) {
    out += text(panel.at(name.at) + Point{0, kSize / 3}, name.text, kSize, kInk, false,
                Anchor::kMiddle);
  }
  return out + "</g>\n";
}

std::vector<LegendItem> underlay_legend(const PlanUnderlay& underlay) {
  std::vector<LegendItem> items;
  for (const auto& look : std::views::reverse(kLooks)) {
    const bool there = std::ranges::any_of(underlay.storeys, [&](const UnderlayStorey& storey) {
      return std::ranges::find(storey.lines, look.kind, &UnderlayLine::kind) != storey.lines.end();
    });
    if (!there) continue;
    items.push_back({line_sample(look.attributes), 28, look.name});
  }
  return items;
}

}  // namespace enfilade::draw::plan
