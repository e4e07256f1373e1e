#include "enfilade/draw/top_down.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "enfilade/core/errors.h"
#include "tests/support/made_meshes.h"

namespace enfilade::draw {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;

mesh::FloorPolygons floor_of(mesh::Mesh made) {
  const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(std::move(made)));
  return mesh::make_floor_polygons(tracer);
}

TEST(TopDown, FindsStoreys) {
  const auto one = find_floor_levels(floor_of(mesh::testing::Maker().room(0, 0, 5, 4).mesh));
  ASSERT_EQ(one.size(), 1U);
  EXPECT_NEAR(one[0], 0, 0.25);
  const auto two = find_floor_levels(floor_of(mesh::testing::two_storeys().mesh));
  ASSERT_EQ(two.size(), 2U);
  EXPECT_NEAR(two[1] - two[0], 3, 0.25);
  EXPECT_THROW(find_floor_levels({}), ArgumentError);
}

TEST(TopDown, DrawsFloorAndLines) {
  const std::vector<WalkedLine> lines{
      {PathRole::kReference, {{1, 1, 0}, {4, 1, 0}}, ""},
      {PathRole::kAgent, {{1, 1, 0}, {2, 1, 0}, {2, 3, 0}}, "seq2seq <b>"}};
  const std::string svg =
      top_down_svg(floor_of(mesh::testing::Maker().room(0, 0, 5, 4).mesh), lines,
                   {.title = "room & more", .note = "Walk to the wall."});
  EXPECT_THAT(svg, HasSubstr("<polygon"));
  EXPECT_THAT(svg, HasSubstr("room &amp; more"));
  EXPECT_THAT(svg, HasSubstr("seq2seq &lt;b&gt;"));
  EXPECT_THAT(svg, HasSubstr("reference path"));
  EXPECT_THAT(svg, Not(HasSubstr("floor at")));  // there is one storey
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray"));
}

TEST(TopDown, RefusesWhatCannotBeDrawn) {
  const mesh::FloorPolygons floor = floor_of(mesh::testing::Maker().room(0, 0, 5, 4).mesh);
  EXPECT_THROW(top_down_svg(floor, {{PathRole::kAgent, {}, ""}}), ArgumentError);
  EXPECT_THROW(top_down_svg(floor, {{PathRole::kAgent, {{std::nan(""), 0, 0}}, ""}}),
               ArgumentError);
  EXPECT_THROW(top_down_svg(floor, {}, {.success_distance = -1}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
