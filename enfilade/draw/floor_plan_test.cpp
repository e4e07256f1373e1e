#include "enfilade/draw/floor_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>

#include "enfilade/core/errors.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/graphs.h"

namespace enfilade::draw {
namespace EN_UNIT {

using graph::NavGraph;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

// Whether all tags close in the order in which they opened: what an XML reader refuses first.
bool well_formed(const std::string& svg) {
  std::vector<std::string> open;
  const std::regex tag("<(/?)([a-z]+)((?:\\s+[a-zA-Z:-]+=\"[^\"<]*\")*)\\s*(/?)>");
  const std::sregex_iterator end;
  std::size_t last = 0;
  for (std::sregex_iterator it(svg.begin(), svg.end(), tag); it != end; ++it) {
    const std::string between = svg.substr(last, static_cast<std::size_t>(it->position()) - last);
    if (between.find_first_of("<>") != std::string::npos) return false;
    last = static_cast<std::size_t>(it->position() + it->length());
    if ((*it)[1].length() > 0) {
      if (open.empty() || open.back() != (*it)[2]) return false;
      open.pop_back();
    } else if ((*it)[4].length() == 0) {
      open.push_back((*it)[2]);
    }
  }
  return open.empty() && last > 0;
}

std::vector<ViewpointIndex> route(std::initializer_list<std::size_t> places) {
  std::vector<ViewpointIndex> path;
  for (const std::size_t place : places) path.emplace_back(place);
  return path;
}

// Four viewpoints below, four above them, and an edge 3 - 4 up from one to the other.
NavGraph two_storeys() {
  return NavGraph(
      graph::testing::connectivity("two",
                                   {{0, 0, 1.5},
                                    {2, 0, 1.5},
                                    {2, 2, 1.5},
                                    {0, 2, 1.5},
                                    {0, 4, 4.5},
                                    {2, 4, 4.5},
                                    {2, 6, 4.5},
                                    {0, 6, 4.5}},
                                   {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 6}, {6, 7}}));
}

struct Place {
  double x = 0, y = 0;
};
// Where the viewpoint with this id stands on its panel.
Place place_of(const std::string& svg, const std::string& id) {
  std::smatch found;
  const std::regex dot(id + "</title><circle cx=\"([0-9.]+)\" cy=\"([0-9.]+)\"");
  if (!std::regex_search(svg, found, dot)) {
    ADD_FAILURE() << "no dot of " << id;
    return {};
  }
  return {std::stod(found[1]), std::stod(found[2])};
}

TEST(FloorPlan, DrawsToScaleWithNorthUp) {
  FloorPlanOptions options;
  options.pixels_per_metre = 50;
  const std::string svg = floor_plan_svg(NavGraph(graph::testing::square()), {}, options);
  EXPECT_TRUE(well_formed(svg));
  const Place south_west = place_of(svg, "v0"), north_east = place_of(svg, "v2");
  // Coordinates are written to a tenth of a pixel.
  EXPECT_NEAR(north_east.x - south_west.x, 100, 0.1);
  EXPECT_NEAR(north_east.y - south_west.y, -100, 0.1);
  EXPECT_THAT(svg, HasSubstr(">2 m<")) << "the longest scale bar that fits";
  EXPECT_THAT(svg, HasSubstr("4 viewpoints, 4 edges, 1 storey<"));
}

TEST(FloorPlan, DrawsEdgesBetweenStoreysOnBoth) {
  const std::string svg = floor_plan_svg(two_storeys());
  EXPECT_TRUE(well_formed(svg));
  EXPECT_THAT(svg, HasSubstr("Storey 1"));
  EXPECT_THAT(svg, HasSubstr("Storey 2"));
  EXPECT_THAT(svg, Not(HasSubstr("Storey 3")));
  EXPECT_THAT(svg, HasSubstr("floor at 3.0 m, 4 viewpoints"));
  const std::string up = "M0,-4.4", down = "M0,4.4", dashed = "stroke-dasharray=\"4 3\"";
  EXPECT_EQ(occurrences(svg, up), 2U) << "on the lower storey and in the legend";
  EXPECT_EQ(occurrences(svg, down), 2U);
  EXPECT_EQ(occurrences(svg, dashed), 3U);
}

TEST(FloorPlan, MarksExcludedAndIsolatedViewpoints) {
  scan::Connectivity c = graph::testing::square();
  c.entries[0].included = false;
  c.entries[1].unobstructed.clear();
  c.entries[2].unobstructed = {ViewpointIndex(3)};
  const NavGraph graph(c);
  const std::string svg = floor_plan_svg(graph);
  EXPECT_THAT(svg, HasSubstr(">excluded<"));
  EXPECT_THAT(svg, HasSubstr(">viewpoint without edges<"));
  EXPECT_THAT(svg, HasSubstr("v0</title>"));
  FloorPlanOptions options;
  options.show_excluded = false;
  const std::string without = floor_plan_svg(graph, {}, options);
  EXPECT_THAT(without, Not(HasSubstr("v0</title>")));
  EXPECT_THAT(without, Not(HasSubstr(">excluded<")));
}

TEST(FloorPlan, DrawsPathsWithTheirEnds) {
  const std::string svg =
      floor_plan_svg(two_storeys(), {{PathRole::kReference, route({0, 1, 2, 3, 4}), "the way"},
                                     {PathRole::kAgent, route({0, 0, 1, 2, 1}), ""}});
  EXPECT_TRUE(well_formed(svg));
  EXPECT_THAT(svg, HasSubstr(">the way<"));
  EXPECT_THAT(svg, HasSubstr(">agent\u2019s path<"));
  EXPECT_THAT(svg, HasSubstr("goal, 3 m around it"));
  EXPECT_THAT(svg, HasSubstr("agent stops"));
  EXPECT_EQ(occurrences(svg, "stroke-dasharray=\"3 4\""), 1U)
      << "a circle on the goal's storey only";
  EXPECT_EQ(occurrences(svg, "opacity=\"0.4\""), 3U) << "a band on both storeys and the legend";
}

TEST(FloorPlan, ShowsNoGoalWhereItIsHidden) {
  const std::string svg =
      floor_plan_svg(two_storeys(), {{PathRole::kReference, route({0}), "hidden"}});
  EXPECT_THAT(svg, Not(HasSubstr("goal")));
  EXPECT_THAT(svg, Not(HasSubstr(">hidden<"))) << "there is no band to explain";
  EXPECT_THAT(svg, HasSubstr(">start<"));
}

TEST(FloorPlan, EscapesWhatItQuotes) {
  scan::Connectivity c = graph::testing::square("<scan>");
  c.entries[0].id = "a&b<c>\"";
  FloorPlanOptions options;
  options.note = "turn <left> & go";
  options.label_viewpoints = true;
  const std::string svg =
      floor_plan_svg(NavGraph(c), {{PathRole::kAgent, route({0, 1}), "</svg>\x01"}}, options);
  EXPECT_TRUE(well_formed(svg));
  EXPECT_THAT(svg, HasSubstr("&lt;scan&gt;"));
  EXPECT_THAT(svg, HasSubstr("a&amp;b&lt;c&gt;&quot;"));
  EXPECT_THAT(svg, HasSubstr("turn &lt;left&gt; &amp; go"));
  EXPECT_EQ(occurrences(svg, "</svg>"), 1U);
}

TEST(FloorPlan, RefusesWhatItCannotDraw) {
  const NavGraph graph(graph::testing::square());
  EXPECT_THAT(
      [&] {
        floor_plan_svg(graph, {{PathRole::kAgent, route({0, 4}), ""}});
      },
      ThrowsMessage<ArgumentError>(HasSubstr("paths[0].viewpoints[1]: 4, not below 4")));
  EXPECT_THAT(
      [&] {
        floor_plan_svg(graph, {{PathRole::kAgent, {}, ""}});
      },
      ThrowsMessage<ArgumentError>(HasSubstr("paths[0]: empty")));
  FloorPlanOptions options;
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    options.pixels_per_metre = bad;
    EXPECT_THAT([&] { floor_plan_svg(graph, {}, options); },
                ThrowsMessage<ArgumentError>(HasSubstr("pixels_per_metre")));
  }
}

TEST(FloorPlan, DrawsWhateverGraphThereIs) {
  EXPECT_TRUE(well_formed(floor_plan_svg(NavGraph(scan::Connectivity{}))));
  scan::Connectivity c = graph::testing::square();
  for (auto& entry : c.entries) entry.included = false;
  EXPECT_TRUE(well_formed(floor_plan_svg(NavGraph(c)))) << "excluded viewpoints only";
  const NavGraph same(graph::testing::connectivity("s", {{0, 0, 0}, {0, 0, 0}}, {{0, 1}}));
  EXPECT_TRUE(well_formed(floor_plan_svg(same, {{PathRole::kAgent, route({0, 1, 0}), ""}})));
  const NavGraph far(graph::testing::connectivity("f", {{-1e6, 0, 0}, {1e6, 9, 0}}, {{0, 1}}));
  const std::string svg = floor_plan_svg(far);
  EXPECT_TRUE(well_formed(svg));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(FloorPlan, FitsEachRealBuildingOnASheet) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real graphs";
  const auto graphs = graph::GraphSet::open(data->connectivity());
  const std::regex size("width=\"([0-9.]+)\" height=\"([0-9.]+)\"");
  for (std::size_t s = 0; s < graphs->size(); ++s) {
    const NavGraph& graph = graphs->graph(ScanIndex(s));
    const std::string svg = floor_plan_svg(graph);
    std::smatch found;
    ASSERT_TRUE(std::regex_search(svg, found, size)) << graph.scan();
    // 1400 x 1000 for the panels, and the title, legend and borders.
    EXPECT_LE(std::stod(found[1]), 1400 + 52) << graph.scan();
    EXPECT_LE(std::stod(found[2]), 1000 + 250) << graph.scan();
    EXPECT_EQ(occurrences(svg, "</title>"), graph.size() + 1) << graph.scan();
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
