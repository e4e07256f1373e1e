#include "enfilade/draw/plan/underlay.h"

#include <algorithm>
#include <array>
#include <ranges>

#include "enfilade/draw/plan/marks.h"

namespace enfilade::draw::plan {
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
