#include "enfilade/draw/floor_plan.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/draw/markup.h"
#include "enfilade/draw/plan/plan.h"
#include "enfilade/draw/plan/sheet.h"
#include "enfilade/draw/plan/trace.h"

namespace enfilade::draw {
namespace {

using plan::append;
using plan::Colour;
using plan::LegendItem;
using plan::Panel;
using plan::Point;
using plan::Step;
using plan::StoreyPlan;
using GoalKind = PlannedGoal::GoalMark;

constexpr double kRegion = 0.8;  // metres of floor around a region's viewpoints
constexpr std::array kReferenceColours{plan::kBlue, plan::kSky};
constexpr std::array kAgentColours{plan::kVermilion, plan::kPurple};

// A path as it is drawn: with its colour, its steps placed beside those of other paths.
struct Overlay {
  PathRole role = PathRole::kAgent;
  ViewpointIndex start, end;
  std::size_t length = 0;  // viewpoints
  Colour colour;
  std::string label;
  std::vector<Step> steps;

  bool has_goal() const { return role == PathRole::kReference && length > 1; }
};

void check_arguments(const graph::NavGraph& graph, const std::vector<PlannedPath>& paths,
                     const FloorPlanOptions& options) {
  const auto check_number = [](const char* name, double value) {
    if (!(value >= 0) || !std::isfinite(value)) {
      throw ArgumentError(fmt::format("{}: {}, not a finite number >= 0", name, value));
    }
  };
  check_number("pixels_per_metre", options.pixels_per_metre);
  check_number("success_distance", options.success_distance);
  const std::size_t storeys = find_storeys(graph).size();
  if (options.underlay != nullptr && options.underlay->storeys.size() != storeys) {
    throw ArgumentError(fmt::format("underlay: {} storeys, not {}, as {} has",
                                    options.underlay->storeys.size(), storeys, graph.scan()));
  }
  const auto check_viewpoints = [&graph](const std::string& whose,
                                         const std::vector<ViewpointIndex>& viewpoints) {
    for (std::size_t i = 0; i < viewpoints.size(); ++i) {
      if (viewpoints[i].at() < graph.size()) continue;
      throw ArgumentError(fmt::format("{}.viewpoints[{}]: {}, not below {}, the size of {}", whose,
                                      i, viewpoints[i].at(), graph.size(), graph.scan()));
    }
  };
  for (std::size_t p = 0; p < paths.size(); ++p) {
    if (paths[p].viewpoints.empty()) {
      throw ArgumentError(fmt::format("paths[{}]: empty, not at least one viewpoint", p));
    }
    check_viewpoints(fmt::format("paths[{}]", p), paths[p].viewpoints);
  }
  if (options.goal) check_viewpoints("goal", options.goal->viewpoints);
}

// Reference paths first, so that agents are seen over them.
std::vector<Overlay> make_overlays(const std::vector<PlannedPath>& paths) {
  std::vector<Overlay> overlays;
  for (const PathRole role : {PathRole::kReference, PathRole::kAgent}) {
    const bool reference = role == PathRole::kReference;
    const auto& colours = reference ? kReferenceColours : kAgentColours;
    std::vector<std::vector<ViewpointIndex>> routes;
    const std::size_t first = overlays.size();
    for (const PlannedPath& path : paths) {
      if (path.role != role) continue;
      const char* name = reference ? "reference path" : "agent\u2019s path";
      overlays.push_back({role,
                          path.viewpoints.front(),
                          path.viewpoints.back(),
                          path.viewpoints.size(),
                          colours[routes.size() % colours.size()],
                          path.label.empty() ? name : path.label,
                          {}});
      routes.push_back(path.viewpoints);
    }
    auto steps = plan::lanes(routes, reference ? plan::kBandWidth + 1 : 6.5);
    for (std::size_t i = 0; i < steps.size(); ++i) overlays[first + i].steps = std::move(steps[i]);
  }
  return overlays;
}

class Painter {
 public:
  Painter(const graph::NavGraph& graph, const std::vector<PlannedPath>& paths,
          const FloorPlanOptions& options)
      : graph_(graph),
        options_(options),
        plan_(plan::make_plan(graph, options.show_excluded)),
        overlays_(make_overlays(paths)),
        layout_(
            plan::arrange(plan_, success_circles(), options.underlay, options.pixels_per_metre)) {}

  std::string run() const {
    const std::size_t storeys = plan_.storeys.size();
    std::string panels;
    for (const Panel& panel : layout_.panels) panels += draw_panel(panel);
    return plan::draw_sheet(
        {.title = options_.title.empty() ? graph_.scan() : options_.title,
         .subtitle = fmt::format("{} viewpoints, {} edges, {} {}", graph_.included_count(),
                                 plan_.edges.size(), storeys, storeys == 1 ? "storey" : "storeys"),
         .notes = notes(),
         .legend = legend_items(),
         .rule = true},
        layout_, panels);
  }

 private:
  std::vector<plan::Disc> success_circles() const {
    std::vector<plan::Disc> circles;
    for (const ViewpointIndex v : circled()) circles.push_back({v, options_.success_distance});
    if (region()) {
      for (const ViewpointIndex v : options_.goal->viewpoints) circles.push_back({v, kRegion});
    }
    return circles;
  }

  std::vector<std::string> notes() const {
    std::vector<std::string> notes{options_.note};
    notes.insert(notes.end(), options_.lines.begin(), options_.lines.end());
    return notes;
  }

  bool region() const { return options_.goal && options_.goal->kind == GoalKind::kRegion; }
  bool turns() const { return options_.goal && options_.goal->kind == GoalKind::kTurningPoint; }
  // Whether success is to end near the end of the reference path.
  bool end_counts() const { return !options_.goal || turns(); }

  // What has the success distance around it.
  std::vector<ViewpointIndex> circled() const {
    std::vector<ViewpointIndex> centres;
    for (const Overlay& o : overlays_) {
      if (o.has_goal() && end_counts()) centres.push_back(o.end);
    }
    if (turns()) {
      centres.insert(centres.end(), options_.goal->viewpoints.begin(),
                     options_.goal->viewpoints.end());
    }
    return centres;
  }

  Point place(const Panel& panel, ViewpointIndex v) const { return panel.at(graph_.position(v)); }
  bool isolated(ViewpointIndex v) const {
    return std::ranges::none_of(plan_.edges, [v](auto e) { return e.a == v || e.b == v; });
  }

  std::string draw_panel(const Panel& panel) const {
    std::string out = plan::draw_caption(plan_, panel);
    out += options_.underlay == nullptr
               ? plan::draw_floor(plan_, panel)
               : plan::draw_lines(options_.underlay->storeys[panel.storey], panel);
    out += draw_region(panel);
    for (const ViewpointIndex v : circled()) out += draw_success_circle(panel, v);
    out += draw_edges(panel);
    for (const Overlay& o : overlays_) {
      if (o.role == PathRole::kReference) out += plan::draw_band(plan_, panel, o.steps, o.colour);
    }
    for (const Overlay& o : overlays_) {
      if (o.role == PathRole::kAgent) out += plan::draw_line(plan_, panel, o.steps, o.colour);
    }
    if (options_.underlay != nullptr) {
      out += plan::draw_texts(options_.underlay->storeys[panel.storey], panel);
    }
    return out + draw_viewpoints(panel) + draw_stairs(panel) + draw_goal(panel) + draw_ends(panel) +
           (options_.label_viewpoints ? plan::draw_labels(plan_, panel) : "");
  }

  std::string draw_success_circle(const Panel& panel, ViewpointIndex goal) const {
    if (plan_.storey_of[goal.at()] != panel.storey || options_.success_distance == 0) return "";
    return plan::circle(
        place(panel, goal), options_.success_distance * panel.scale,
        fmt::format("fill=\"{}\" fill-opacity=\"0.18\" stroke=\"#a89c00\" stroke-dasharray=\"3 4\"",
                    plan::hex(plan::kYellow)));
  }

  std::string draw_region(const Panel& panel) const {
    if (!region()) return "";
    std::string out;
    for (const ViewpointIndex v : options_.goal->viewpoints) {
      if (plan_.storey_of[v.at()] != panel.storey) continue;
      out += plan::region_floor(place(panel, v), kRegion * panel.scale);
    }
    return out;
  }

  // Marks on the viewpoints of the goal; a region's are its floor.
  std::string draw_goal(const Panel& panel) const {
    if (!options_.goal || region()) return "";
    std::string out;
    for (const ViewpointIndex v : options_.goal->viewpoints) {
      if (plan_.storey_of[v.at()] != panel.storey) continue;
      out += turns() ? plan::turning_mark(place(panel, v)) : plan::seen_mark(place(panel, v));
    }
    return out;
  }

  std::string draw_edges(const Panel& panel) const {
    std::string level, stairs;
    for (const auto& [a, b] : plan_.edges) {
      if (!plan_.touches(panel.storey, a, b)) continue;
      std::string& path = plan_.between_storeys(a, b) ? stairs : level;
      path += "M" + plan::pair(place(panel, a)) + "L" + plan::pair(place(panel, b));
    }
    std::string out;
    if (!level.empty()) append(out, "<path d=\"{}\" stroke=\"{}\"/>\n", level, plan::kEdge);
    if (!stairs.empty()) {
      append(out, "<path d=\"{}\" stroke=\"#6b7280\" stroke-dasharray=\"4 3\"/>\n", stairs);
    }
    return out;
  }

  std::string draw_viewpoints(const Panel& panel) const {
    std::string out;
    for (std::size_t i = 0; i < graph_.size(); ++i) {
      const ViewpointIndex v(i);
      if (plan_.storey_of[i] != panel.storey) continue;
      const Point p = place(panel, v);
      append(out, "<g><title>{} {}</title>{}</g>\n", i, escape(graph_.id(v)),
             !graph_.included(v) ? plan::excluded_mark(p)
             : isolated(v)       ? plan::isolated_mark(p)
                                 : plan::dot(p));
    }
    return out;
  }

  // Where the edges that leave the storey end, on another one.
  std::string draw_stairs(const Panel& panel) const {
    std::map<ViewpointIndex, bool> ends;  // whether up
    for (const auto& [a, b] : plan_.edges) {
      if (!plan_.touches(panel.storey, a, b) || !plan_.between_storeys(a, b)) continue;
      const ViewpointIndex far = plan_.storey_of[a.at()] == panel.storey ? b : a;
      ends[far] = plan_.storey_of[far.at()] > panel.storey;
    }
    std::string out;
    for (const auto& [v, up] : ends) out += plan::stairs_mark(place(panel, v), up);
    return out;
  }

  std::string draw_ends(const Panel& panel) const {
    std::string out;
    const auto here = [&](ViewpointIndex v) { return plan_.storey_of[v.at()] == panel.storey; };
    for (const Overlay& o : overlays_) {
      if (o.role == PathRole::kAgent && here(o.end)) {
        out += plan::stop_mark(place(panel, o.end), o.colour);
      }
    }
    for (const Overlay& o : overlays_) {
      if (here(o.start)) out += plan::start_mark(place(panel, o.start));
    }
    for (const Overlay& o : overlays_) {
      if (o.has_goal() && here(o.end)) out += plan::goal_mark(place(panel, o.end));
    }
    return out;
  }

  std::vector<LegendItem> legend_items() const {
    std::vector<LegendItem> items{{plan::dot({}), 8, "viewpoint"}};
    items.push_back({plan::line_sample("stroke=\"#a7acb5\""), 28, "edge"});
    add_graph_items(items);
    for (const Overlay& o : overlays_) {
      if (!o.steps.empty()) items.push_back({sample(o), 34, o.label});
    }
    add_end_items(items);
    if (options_.underlay != nullptr) {
      std::ranges::move(plan::underlay_legend(*options_.underlay), std::back_inserter(items));
      return items;
    }
    items.push_back({fmt::format("<rect x=\"-14\" y=\"-7\" width=\"28\" height=\"14\" rx=\"7\" "
                                 "fill=\"{}\" stroke=\"{}\"/>",
                                 plan::kFloor, plan::kFloorRim),
                     28, fmt::format("within {} m of an edge or viewpoint", plan::kFloorRadius)});
    return items;
  }

  void add_graph_items(std::vector<LegendItem>& items) const {
    const bool stairs = std::ranges::any_of(
        plan_.edges, [this](auto e) { return plan_.between_storeys(e.a, e.b); });
    bool excluded = false, alone = false;
    for (std::size_t i = 0; i < graph_.size(); ++i) {
      const ViewpointIndex v(i);
      if (plan_.storey_of[i] == StoreyPlan::kNowhere) continue;
      excluded = excluded || !graph_.included(v);
      alone = alone || (graph_.included(v) && isolated(v));
    }
    if (stairs) {
      items.push_back({plan::line_sample("stroke=\"#6b7280\" stroke-dasharray=\"4 3\""), 28,
                       "edge to another storey"});
      items.push_back({plan::stairs_mark({-9, 0}, true) + plan::stairs_mark({9, 0}, false), 32,
                       "its other end, above or below"});
    }
    if (alone) items.push_back({plan::isolated_mark({}), 10, "viewpoint without edges"});
    if (excluded) items.push_back({plan::excluded_mark({}), 8, "excluded"});
  }

  static std::string sample(const Overlay& o) {
    if (o.role == PathRole::kReference) {
      return fmt::format(
          "<path d=\"M-12,0h24\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\" "
          "opacity=\"0.4\"/>",
          plan::hex(o.colour), plan::kBandWidth);
    }
    return fmt::format(
        "<path d=\"M-16,0h32\" stroke=\"{0}\" stroke-width=\"{1}\"/><path d=\"M6,0l-11,5.5v-11z\" "
        "fill=\"{0}\" stroke=\"#fff\" stroke-width=\"0.8\"/>",
        plan::hex(o.colour), plan::kLineWidth);
  }

  void add_goal_item(std::vector<LegendItem>& items) const {
    if (!options_.goal) return;
    const std::string& label = options_.goal->label;
    if (region()) {
      items.push_back({plan::region_floor({}, 10), 20, label});
    } else if (turns()) {
      items.push_back({plan::turning_mark({}), 20, label});
    } else {
      items.push_back({plan::seen_mark({}), 16, label});
    }
  }

  void add_end_items(std::vector<LegendItem>& items) const {
    add_goal_item(items);
    if (overlays_.empty()) return;
    items.push_back({plan::start_mark({}), 18, "start"});
    const auto goal = std::ranges::find_if(overlays_, &Overlay::has_goal);
    if (goal != overlays_.end()) {
      items.push_back({plan::goal_mark({}), 20,
                       end_counts()
                           ? fmt::format("goal, {:g} m around it", options_.success_distance)
                           : "end of the reference path"});
    }
    const auto agent = std::ranges::find(overlays_, PathRole::kAgent, &Overlay::role);
    if (agent != overlays_.end()) {
      items.push_back({plan::stop_mark({}, agent->colour), 28, "agent stops"});
    }
  }

  const graph::NavGraph& graph_;
  const FloorPlanOptions& options_;
  StoreyPlan plan_;
  std::vector<Overlay> overlays_;
  plan::PanelLayout layout_;
};

}  // namespace

std::string floor_plan_svg(const graph::NavGraph& graph, const std::vector<PlannedPath>& paths,
                           const FloorPlanOptions& options) {
  check_arguments(graph, paths, options);
  return Painter(graph, paths, options).run();
}

namespace {

constexpr double kWindow = 1.2;  // floors of one storey differ by less (steps, sloping ground)
constexpr double kApart = 1.8;   // storeys are farther apart: people stand in the lower one
constexpr double kCore = 0.25;   // around the median floor; stairs have few viewpoints so level
constexpr double kLeastShare = 0.03;
constexpr double kLeastViewpoints = 3;

struct Mode {
  double floor = 0;
  std::size_t count = 0;
};

// The window of kWindow metres that holds most of the sorted floors, kApart from each of `taken`
// and with `least` of its floors about at its median; of equally full ones the lowest.
Mode densest_window(const std::vector<double>& floors, const std::vector<double>& taken,
                    std::size_t least) {
  Mode best;
  for (std::size_t begin = 0, end = 0; begin < floors.size(); ++begin) {
    while (end < floors.size() && floors[end] - floors[begin] <= kWindow) ++end;
    const std::size_t count = end - begin;
    const double floor = floors[begin + count / 2];
    if (count <= best.count) continue;
    const auto near = [&](double f) { return std::abs(f - floor) <= kCore; };
    if (std::ranges::any_of(taken, [&](double t) { return std::abs(floor - t) < kApart; }) ||
        static_cast<std::size_t>(std::ranges::count_if(floors, near)) < least) {
      continue;
    }
    best = {floor, count};
  }
  return best;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

}  // namespace

std::vector<GraphStorey> find_storeys(const graph::NavGraph& graph) {
  std::vector<double> sorted;
  std::vector<std::pair<ViewpointIndex, double>> floors;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    if (!graph.included(v)) continue;
    floors.emplace_back(v, static_cast<double>(graph.position(v).z) - graph.height(v));
    sorted.push_back(floors.back().second);
  }
  std::ranges::sort(sorted);
  const auto least = static_cast<std::size_t>(
      std::ceil(std::max(kLeastViewpoints, kLeastShare * static_cast<double>(sorted.size()))));
  std::vector<double> modes;  // the largest storey has no least number of viewpoints
  for (Mode mode = densest_window(sorted, modes, 0); mode.count > 0;
       mode = densest_window(sorted, modes, least)) {
    modes.push_back(mode.floor);
  }
  std::ranges::sort(modes);
  std::vector<GraphStorey> storeys;
  for (const double mode : modes) storeys.push_back({mode, {}});
  std::vector<std::vector<double>> members(modes.size());
  for (const auto& [v, floor] : floors) {
    const std::size_t s = nearest_storey(storeys, floor);
    storeys[s].viewpoints.push_back(v);
    members[s].push_back(floor);
  }
  for (std::size_t s = 0; s < storeys.size(); ++s) storeys[s].floor = median(members[s]);
  return storeys;
}

std::size_t nearest_storey(const std::vector<GraphStorey>& storeys, double floor) {
  const auto nearest = std::ranges::min_element(
      storeys, {}, [floor](const GraphStorey& s) { return std::abs(s.floor - floor); });
  return static_cast<std::size_t>(nearest - storeys.begin());
}

}  // namespace enfilade::draw
