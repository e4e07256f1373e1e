#include "enfilade/draw/floor_plan.h"

#include <fmt/format.h>
#include <algorithm>
#include <set>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/draw/markup.h"
#include "enfilade/draw/plan/plan.h"
#include "enfilade/draw/plan/sheet.h"
#include "enfilade/draw/plan/trace.h"

namespace enfilade::draw {
namespace {

using graph::ComparedEdge;
using graph::GraphComparison;
using graph::NavGraph;
using plan::Panel;
using plan::StoreyPlan;

constexpr const char* kCommonStyle = "stroke=\"#a7acb5\"";
constexpr const char* kExtraStyle = "stroke=\"#d62728\" stroke-width=\"2.5\"";
constexpr const char* kMissingStyle =
    "stroke=\"#0072b2\" stroke-width=\"2.5\" stroke-dasharray=\"6 4\"";

void check_edges(const NavGraph& found, const GraphComparison& comparison) {
  for (const auto* edges : {&comparison.extra, &comparison.missing}) {
    for (const ComparedEdge& e : *edges) {
      if (std::max(e.a, e.b).at() < found.size()) continue;
      throw ArgumentError(fmt::format("comparison: edge {} - {}, and graph {} has {} viewpoints",
                                      e.a.at(), e.b.at(), found.scan(), found.size()));
    }
  }
}

class ComparisonPainter {
 public:
  ComparisonPainter(const NavGraph& found, const GraphComparison& comparison,
                    const ComparisonPlanOptions& options)
      : found_(found),
        comparison_(comparison),
        options_(options),
        plan_(plan::make_plan(found, false)),
        layout_(plan::arrange(plan_, {}, nullptr, 0)) {
    for (const ComparedEdge& e : comparison.extra) extra_.insert({e.a, e.b});
  }

  std::string run() const {
    std::string panels;
    for (const Panel& panel : layout_.panels) panels += draw_panel(panel);
    return plan::draw_sheet(
        {.title = options_.title.empty() ? found_.scan() : options_.title,
         .subtitle = fmt::format(
             "precision {:.3f}, recall {:.3f}, F1 {:.3f}: {} edges in both, {} extra, {} missing",
             comparison_.precision(), comparison_.recall(), comparison_.f1(), comparison_.common,
             comparison_.extra.size(), comparison_.missing.size()),
         .notes = {options_.note},
         .legend = legend_items()},
        layout_, panels);
  }

 private:
  std::string line(const Panel& panel, ViewpointIndex a, ViewpointIndex b) const {
    if (!plan_.touches(panel.storey, a, b)) return "";
    return "M" + plan::pair(panel.at(found_.position(a))) + "L" +
           plan::pair(panel.at(found_.position(b)));
  }

  static std::string path(const std::string& lines, const char* style) {
    if (lines.empty()) return "";
    return fmt::format("<path d=\"{}\" {} fill=\"none\"/>\n", lines, style);
  }

  std::string draw_panel(const Panel& panel) const {
    std::string common, extra, missing, dots;
    for (const auto& [a, b] : plan_.edges) {
      const bool is_extra = extra_.contains({std::min(a, b), std::max(a, b)});
      (is_extra ? extra : common) += line(panel, a, b);
    }
    for (const ComparedEdge& e : comparison_.missing) missing += line(panel, e.a, e.b);
    for (const ViewpointIndex v : plan_.storeys[panel.storey].viewpoints) {
      plan::append(dots, "<g><title>{} {}</title>{}</g>\n", v.at(), escape(found_.id(v)),
                   plan::dot(panel.at(found_.position(v))));
    }
    return plan::draw_caption(plan_, panel) + plan::draw_floor(plan_, panel) +
           path(common, kCommonStyle) + path(extra, kExtraStyle) + path(missing, kMissingStyle) +
           dots + (options_.label_viewpoints ? plan::draw_labels(plan_, panel) : "");
  }

  std::vector<plan::LegendItem> legend_items() const {
    using plan::line_sample;
    return {{plan::dot({}), 8, "viewpoint"},
            {line_sample(kCommonStyle), 28, "edge in both"},
            {line_sample(kExtraStyle), 28, "extra: found, and not in the truth"},
            {line_sample(kMissingStyle), 28, "missing: in the truth, and not found"}};
  }

  const NavGraph& found_;
  const GraphComparison& comparison_;
  const ComparisonPlanOptions& options_;
  StoreyPlan plan_;
  plan::PanelLayout layout_;
  std::set<std::pair<ViewpointIndex, ViewpointIndex>> extra_;
};

}  // namespace

std::string graph_comparison_svg(const NavGraph& found, const GraphComparison& comparison,
                                 const ComparisonPlanOptions& options) {
  check_edges(found, comparison);
  return ComparisonPainter(found, comparison, options).run();
}

}  // namespace enfilade::draw
