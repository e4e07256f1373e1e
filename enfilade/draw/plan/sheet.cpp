#include "enfilade/draw/plan/sheet.h"

#include <fmt/format.h>
#include <cmath>

#include "enfilade/draw/markup.h"
#include "enfilade/draw/plan/marks.h"

namespace enfilade::draw::plan {

std::string open_sheet(const std::string& title, Point size) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" role=\"img\">\n<title>Floor plan: {2}</title>\n"
      "<rect width=\"{0}\" height=\"{1}\" rx=\"10\" fill=\"#fff\"/>\n"
      "<g font-family=\"'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif\">\n",
      number(std::ceil(size.x)), number(std::ceil(size.y)), escape(title));
}

std::string draw_caption(const Plan& plan, const Panel& panel) {
  const auto [name, facts] = caption(plan, panel.storey);
  const Point p = panel.corner + Point{0, 12};
  return text(p, name, 13, kInk, true) +
         text(p + Point{text_width(name, 13) + 10, 0}, facts, 12, kFaintInk);
}

std::string draw_floor(const Plan& plan, const Panel& panel) {
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

std::string draw_labels(const Plan& plan, const Panel& panel) {
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

}  // namespace enfilade::draw::plan
