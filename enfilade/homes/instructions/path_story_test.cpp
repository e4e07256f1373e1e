#include "enfilade/homes/instructions/path_story.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "enfilade/homes/instructions/naming.h"
#include "enfilade/homes/instructions/phrases.h"
#include "tests/support/graphs.h"
#include "tests/support/instructions/box_home.h"

namespace enfilade::homes::instructions {
namespace EN_UNIT {

constexpr double kPi = std::numbers::pi;

// A walk through the small home, whose plan is in testing/box_home.h.
struct Walked {
  Home home = homes::instructions::testing::small_home();
  std::shared_ptr<mesh::RayTracer> tracer = homes::instructions::testing::tracer_of(home);
  graph::NavGraph graph;
  ThingsInView sights;
  PathStory story;

  Walked(const std::vector<Vec3d>& eyes, double heading)
      : graph(graph::testing::connectivity("s", eyes, {})), sights(home, *tracer, graph, 20000) {
    std::vector<ViewpointIndex> path;
    for (std::size_t i = 0; i < eyes.size(); ++i) path.emplace_back(i);
    story = tell_path({home, graph, sights}, path, heading);
  }
};

TEST(TurnOf, HasItsBorders) {
  EXPECT_EQ(turn_of(19.9), TurnKind::kStraight);
  EXPECT_EQ(turn_of(-20.1), TurnKind::kSlight);
  EXPECT_EQ(turn_of(60.1), TurnKind::kFull);
  EXPECT_EQ(turn_of(-131), TurnKind::kAround);
}

// Out of the bedroom by its door, right along the hallway past the painting, left into the living
// room by the first door on that side.
TEST(TellPath, TellsTurnsDoorsAndThingsInOrder) {
  const Walked w({{4, -3, 1.5}, {4, 1, 1.5}, {7.5, 1, 1.5}, {7.5, 3.4, 1.5}}, kPi / 2);
  ASSERT_EQ(w.story.stretches.size(), 3U);
  const PathStretch &out = w.story.stretches[0], &hall = w.story.stretches[1],
                    &in = w.story.stretches[2];
  EXPECT_NEAR(out.turn, -90, 1e-4);  // faces east, goes north
  EXPECT_NEAR(hall.turn, 90, 1e-4);
  EXPECT_NEAR(in.turn, -90, 1e-4);
  const auto cross = std::ranges::find(out.happenings, HappeningKind::kCross, &Happening::kind);
  ASSERT_NE(cross, out.happenings.end());
  EXPECT_EQ(cross->from, 3U);
  EXPECT_EQ(cross->to, 0U);
  EXPECT_EQ(cross->opening, 3U);
  EXPECT_NEAR(cross->metres, 2.94, 1e-5);
  // The painting hangs on the wall to the right, the bench stands to the left, a little farther.
  ASSERT_EQ(hall.happenings.size(), 2U);
  EXPECT_EQ(w.home.things[hall.happenings[0].thing].noun, "painting");
  EXPECT_TRUE(hall.happenings[0].on_right);
  EXPECT_EQ(w.home.things[hall.happenings[1].thing].noun, "bench");
  EXPECT_FALSE(hall.happenings[1].on_right);
  EXPECT_EQ(in.door, 1U);
  EXPECT_TRUE(w.story.end.just_inside);
}

TEST(TellPath, CountsDoorsOnOneSideOnly) {
  // From the west end of the hallway: kitchen, then living room to the left; bedroom, then office
  // to the right.
  const Walked left({{0.4, 1, 1.5}, {7.5, 1, 1.5}, {7.5, 3.4, 1.5}}, kPi / 2);
  EXPECT_EQ(left.story.stretches.back().door, 2U);
  const Walked right({{0.4, 1, 1.5}, {4, 1, 1.5}, {4, -1.5, 1.5}}, kPi / 2);
  EXPECT_EQ(right.story.stretches.back().door, 1U);
}

TEST(TellPath, ClimbsFromStoreyToStorey) {
  const Walked w({{9, 1, 1.5}, {11, 1, 1.5}, {11, 3.6, 3}, {11, 6.2, 4.5}}, kPi / 2);
  ASSERT_EQ(w.story.stretches.size(), 2U);
  const PathStretch& flight = w.story.stretches[1];
  EXPECT_EQ(flight.climb, 1);
  EXPECT_TRUE(flight.from_storey);
  EXPECT_TRUE(flight.to_storey);
  EXPECT_EQ(w.story.end.stairs, 1);
  EXPECT_EQ(w.story.end.room, 6U);
}

TEST(TellPath, EndsBesideThingsAndInDoorways) {
  const Walked sofa({{8, 3, 1.5}, {8.5, 6.2, 1.5}}, 0);
  ASSERT_FALSE(sofa.story.end.near.empty());
  EXPECT_EQ(sofa.home.things[sofa.story.end.near[0].thing].noun, "sofa");
  EXPECT_NEAR(sofa.story.end.near[0].gap, 0.5, 1e-5);
  EXPECT_LT(sofa.story.end.near[0].bearing, -60);
  const Walked door({{4, -3, 1.5}, {4, -0.06, 1.5}}, 0);
  EXPECT_EQ(door.story.end.in_opening, 3U);
}

TEST(TellPath, DoesNotEnterWhatItsFootOnlyTouches) {
  const Walked w({{4, -2, 1.5}, {4, 0.1, 1.5}, {3, -2, 1.5}}, 0);
  for (const PathStretch& s : w.story.stretches) {
    for (const Happening& h : s.happenings) EXPECT_NE(h.kind, HappeningKind::kCross);
  }
}

TEST(Naming, TellsThingsApartOrSaysNothing) {
  const Walked w({{7, 4, 1.5}, {8, 4, 1.5}}, 0);
  const Naming naming({w.home, w.graph, w.sights});
  Rng rng(1);
  // Two armchairs: the brown leather one and the red one. One sofa.
  for (int i = 0; i < 50; ++i) {
    EXPECT_THAT(naming.thing(5, ViewpointIndex(0), Detail::kPlain, Rivals::kNearby, rng).value(),
                ::testing::AnyOf(::testing::StartsWith("brown"), ::testing::StartsWith("leather")));
    EXPECT_THAT(naming.thing(4, ViewpointIndex(0), Detail::kPlain, Rivals::kNearby, rng).value(),
                ::testing::AnyOf("sofa", "couch", "settee", "divan"));
  }
  Home twins = w.home;
  twins.things[6].colour = twins.things[5].colour;
  twins.things[6].material = twins.things[5].material;
  const Naming puzzled({twins, w.graph, w.sights});
  EXPECT_EQ(puzzled.thing(5, ViewpointIndex(0), Detail::kColour, Rivals::kNearby, rng),
            std::nullopt);
}

TEST(Phrases, ExpandChoicesAndSlots) {
  Rng rng(1);
  EXPECT_EQ(expand("go [  |]past the $thing, now", {{"thing", "red sofa"}}, rng),
            "go past the red sofa, now");
  std::set<std::string> found;
  for (int i = 0; i < 200; ++i) found.insert(expand("a|[b|c [d|e]]", {}, rng));
  EXPECT_EQ(found, (std::set<std::string>{"a", "b", "c d", "c e"}));
  Rng once(2), weighted(2);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(expand("go [a|b|b|b|c] d|e|e", {}, once), expand("go [a|3*b|c] d|2*e", {}, weighted));
  }
  EXPECT_EQ(with_article("orange sofa"), "an orange sofa");
  EXPECT_EQ(with_article("wardrobe"), "a wardrobe");
  EXPECT_EQ(sentence("turn left"), "Turn left.");
}

TEST(Phrases, JoinClausesWithoutTwoAnds) {
  Rng rng(1);
  const std::vector<std::string> parts{"turn left and go in", "stop"};
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(join_clauses({"turn left"}, ClauseLinks::kAny, rng), "turn left");
    EXPECT_EQ(join_clauses(parts, ClauseLinks::kAny, rng), "turn left and go in, then stop");
    EXPECT_THAT(join_clauses(parts, ClauseLinks::kShort, rng),
                ::testing::AnyOf("turn left and go in, stop", "turn left and go in, then stop"));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::instructions
