#include "enfilade/draw/outlines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/objects.h"
#include "tests/support/graphs.h"

namespace enfilade::draw {
namespace EN_UNIT {

using tasks::Direction;

constexpr std::uint8_t kNorthLevel = 12;  // viewIndex of heading 0 and elevation 0

// Columns and rows between which a picture has the yellow of the line.
struct Span {
  std::size_t left = 1000000, top = 1000000, right = 0, bottom = 0, pixels = 0;
};
Span yellow(const image::Image8& picture) {
  Span span;
  for (std::size_t y = 0; y < picture.height; ++y) {
    for (std::size_t x = 0; x < picture.width; ++x) {
      const std::uint8_t* p = picture.at(x, y);
      if (p[0] != 240 || p[1] != 228 || p[2] != 66) continue;
      span = {std::min(span.left, x), std::min(span.top, y), std::max(span.right, x),
              std::max(span.bottom, y), span.pixels + 1};
    }
  }
  return span;
}

TEST(Outlines, ViewsAreThoseOfMatterSim) {
  EXPECT_NEAR(direction_of_view(0).elevation.value, -kPi / 6, 1e-12);
  EXPECT_NEAR(direction_of_view(kNorthLevel).elevation.value, 0, 1e-12);
  EXPECT_NEAR(direction_of_view(15).heading.value, kPi / 2, 1e-12);
  EXPECT_NEAR(direction_of_view(35).elevation.value, kPi / 6, 1e-12);
}

TEST(Outlines, DirectionsAndVectorsAreEachOthersInverse) {
  for (const Direction wanted : {Direction{degrees(0), degrees(0)},
                                 {degrees(200), degrees(-70)},
                                 {degrees(359), degrees(45)}}) {
    const Direction got = direction_of(unit_vector(wanted));
    EXPECT_NEAR(got.heading.value, wanted.heading.value, 1e-12);
    EXPECT_NEAR(got.elevation.value, wanted.elevation.value, 1e-12);
  }
}

// The edges of a box of the view that is drawn are where the box says.
TEST(Outlines, OfABoxLieInItsOwnViewWhereItSays) {
  image::Image8 picture(640, 480, 3);
  draw_outline(picture, outline_of_box(kNorthLevel + 3, {100, 200, 50, 80}),
               direction_of_view(kNorthLevel + 3), degrees(60));
  const Span span = yellow(picture);
  // A line is two pixels to each side.
  EXPECT_NEAR(static_cast<double>(span.left), 98, 1);
  EXPECT_NEAR(static_cast<double>(span.right), 151, 1);
  EXPECT_NEAR(static_cast<double>(span.top), 198, 1);
  EXPECT_NEAR(static_cast<double>(span.bottom), 281, 1);
}

// A box in the middle of the view to the north-north-east, seen from the view to the north: 30
// degrees to the right, at 240 tan 30 / tan 30 = 240 pixels from the middle.
TEST(Outlines, OfABoxAreMappedToOtherViews) {
  const Outline outline = outline_of_box(kNorthLevel + 1, {315, 235, 10, 10});
  const Direction centre = centre_of(outline);
  EXPECT_NEAR(to_degrees(centre.heading), 30, 0.01);
  EXPECT_NEAR(to_degrees(centre.elevation), 0, 0.01);
  image::Image8 picture(640, 480, 3);
  draw_outline(picture, outline, direction_of_view(kNorthLevel), degrees(60));
  const Span span = yellow(picture);
  EXPECT_NEAR((static_cast<double>(span.left) + static_cast<double>(span.right)) / 2, 560, 2);
  image::Image8 behind(640, 480, 3);
  draw_outline(behind, outline, direction_of_view(kNorthLevel + 7), degrees(60));
  EXPECT_EQ(behind, image::Image8(640, 480, 3));
}

// SOON's corners from heading 350 to 10 degrees: 20 degrees wide, not 340.
TEST(Outlines, OfCornersGoAcrossHeadingZero) {
  const Radians left = degrees(350), right = degrees(10), up = degrees(5), down = degrees(-5);
  const Outline outline =
      outline_of_corners({{{left, up}, {right, up}, {right, down}, {left, down}}});
  const Direction centre = centre_of(outline);
  EXPECT_NEAR(wrap_difference(centre.heading).value, 0, 1e-9);
  image::Image8 north(640, 480, 3);
  draw_outline(north, outline, {Radians(0), Radians(0)}, degrees(60));
  const Span span = yellow(north);
  const double half = 240 / std::tan(kPi / 6) * std::tan(degrees(10).value);  // 73.3 pixels
  EXPECT_NEAR(static_cast<double>(span.left), 320 - half - 2, 1.5);
  EXPECT_NEAR(static_cast<double>(span.right), 320 + half + 1, 1.5);
}

TEST(Outlines, HaveTheirLabelAbove) {
  Outline outline = outline_of_box(kNorthLevel, {200, 200, 100, 100});
  image::Image8 plain(640, 480, 3), labelled(640, 480, 3);
  draw_outline(plain, outline, {}, degrees(60));
  outline.label = "plant";
  draw_outline(labelled, outline, {}, degrees(60));
  EXPECT_LT(yellow(labelled).top, yellow(plain).top);
  EXPECT_EQ(yellow(labelled).bottom, yellow(plain).bottom);
  image::Image8 grey(4, 4, 1);
  EXPECT_THROW(draw_outline(grey, outline, {}, degrees(60)), ArgumentError);
}

tasks::ViewedObject plant() {
  tasks::ViewedObject object;
  object.id = 57;
  object.name = "plant#pot";
  object.views = {12, 13, 14};
  // Cut off at the right; whole; cut off at the left.
  object.boxes = {{500, 200, 140, 100}, {250, 200, 140, 100}, {0, 200, 140, 100}};
  return object;
}

TEST(Outlines, ShowTheBoxThatIsWholeElseTheOneThatLooksTheSameWay) {
  EXPECT_EQ(best_box(plant()), 1U);
  EXPECT_EQ(best_box(plant(), Direction{degrees(2), degrees(0)}), 1U);
  tasks::ViewedObject cut = plant();
  cut.boxes[1] = cut.boxes[2];
  EXPECT_EQ(best_box(cut, Direction{degrees(2), degrees(0)}), 0U);
  EXPECT_EQ(best_box(cut, Direction{degrees(58), degrees(0)}), 2U);
}

TEST(Outlines, OfGoalsAreAroundTheirViewpoints) {
  const graph::NavGraph graph(graph::testing::square());
  tasks::ObjectBoxes objects;
  objects.add(graph.scan(), "v1", {plant()});
  const tasks::Goal object = tasks::SeenObject{57, {ViewpointIndex(1)}};
  EXPECT_TRUE(goal_outlines(graph, object, ViewpointIndex(0), &objects).empty());
  EXPECT_TRUE(goal_outlines(graph, object, ViewpointIndex(1), nullptr).empty());
  const auto seen = goal_outlines(graph, object, ViewpointIndex(1), &objects);
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].label, "plant");
  EXPECT_TRUE(goal_outlines(graph, tasks::SeenObject{58, {}}, ViewpointIndex(1), &objects).empty());

  const Radians wide = degrees(10);
  const tasks::Box box{
      ViewpointIndex(2), {}, {{{-wide, wide}, {wide, wide}, {wide, -wide}, {-wide, -wide}}}};
  const tasks::Goal boxes = tasks::Boxes{{box, box}, {}};
  EXPECT_EQ(goal_outlines(graph, boxes, ViewpointIndex(2), nullptr).size(), 2U);
  EXPECT_TRUE(goal_outlines(graph, boxes, ViewpointIndex(1), nullptr).empty());
  EXPECT_TRUE(goal_outlines(graph, tasks::NearEnd(), ViewpointIndex(1), &objects).empty());
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
