#include "enfilade/arena/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "enfilade/arena/detail/texts.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/errors.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"
#include "tests/support/room_world.h"

namespace enfilade::arena {
namespace EN_UNIT {

using arena::testing::episodes;
using arena::testing::room;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using tests::refusal;

std::vector<std::string> names_of_places(const SessionObservation& seen) {
  std::vector<std::string> names;
  for (const Neighbour& place : seen.places) names.push_back(place.name);
  return names;
}

std::vector<std::string> tools_of(const SessionObservation& seen) {
  std::vector<std::string> names;
  for (const ToolUse& use : seen.tools) names.emplace_back(name_of(use.tool));
  return names;
}

tasks::Trajectory trajectory_of(const Session& session) {
  return std::get<tasks::Trajectory>(session.walked());
}

class GraphSessions : public ::testing::Test {
 protected:
  GraphWorld world_{episodes()};
  std::unique_ptr<GraphSession> session_ = world_.start_on_graph(0, {.steps = 6, .mistakes = 3});
  const SessionObservation& seen_ = session_->observation();
};

TEST_F(GraphSessions, ThePlacesAroundHaveNamesAnglesAndDistances) {
  EXPECT_EQ(seen_.instruction, "Go to the desk.");
  EXPECT_EQ(seen_.here, "A");
  EXPECT_NEAR(to_degrees(seen_.heading), 0, 1e-9);  // the simulator snaps it to a twelfth
  ASSERT_EQ(seen_.places.size(), 2U);
  EXPECT_EQ(seen_.places[0].name, "B");  // straight on to the north, met first
  EXPECT_NEAR(to_degrees(seen_.places[0].turn), 0, 1e-6);
  EXPECT_NEAR(to_degrees(seen_.places[1].turn), 90, 1e-6);
  EXPECT_NEAR(seen_.places[1].distance, 4, 1e-6);
  EXPECT_FALSE(seen_.places[0].visited);
  EXPECT_FALSE(seen_.places[0].seen_before);
  EXPECT_THAT(tools_of(seen_), ElementsAre("go_to", "look", "stop"));
  EXPECT_EQ(seen_.told, "");
  EXPECT_EQ(session_->episode_id(), "1_0");
}

TEST_F(GraphSessions, NamesStayAndTheMapGrows) {
  ASSERT_TRUE(session_->call({"go_to", "C"}));  // v1, in the east
  EXPECT_EQ(seen_.here, "C");
  EXPECT_NEAR(to_degrees(seen_.heading), 90, 1e-9);
  EXPECT_EQ(seen_.told, "You went to C, 4.0 m.");
  // v4 to the left, v2 straight on, v0 behind.
  ASSERT_EQ(seen_.places.size(), 3U);
  for (const Neighbour& place : seen_.places) {
    EXPECT_EQ(place.visited, place.name == "A");
    EXPECT_EQ(place.seen_before, place.name == "A");
  }
  ASSERT_EQ(seen_.map.size(), 2U);
  EXPECT_EQ(seen_.map[0].name, "A");
  EXPECT_THAT(seen_.map[0].leads_to, ElementsAre("B", "C"));
  EXPECT_EQ(seen_.map[1].name, "C");
  EXPECT_EQ(seen_.map[1].leads_to.size(), 3U);
  EXPECT_THAT(tools_of(seen_), ElementsAre("go_to", "back_to", "look", "stop"));
  ASSERT_TRUE(session_->call({"go_to", names_of_places(seen_)[1]}));
  ASSERT_TRUE(session_->call({"back_to", "A"}));
  EXPECT_EQ(seen_.here, "A");
  EXPECT_EQ(seen_.told, "You went to A, 8.0 m.");
  ASSERT_TRUE(session_->call({" LOOK", "\nRight\r\n"}));
  EXPECT_EQ(session_->last_call().tool, "look");
  EXPECT_EQ(session_->last_call().argument, "right") << "not as the caller wrote it";
  EXPECT_TRUE(seen_.places[0].seen_before);
  ASSERT_TRUE(session_->call({"stop", ""}));
  EXPECT_EQ(session_->ending(), Ending::kStopped);
  std::vector<std::size_t> walked;
  const tasks::Trajectory trajectory = trajectory_of(*session_);
  for (const auto& point : trajectory.points) walked.push_back(point.viewpoint.at());
  EXPECT_EQ(walked.size(), 5U);  // there, on, and back through v1
  EXPECT_EQ(walked.front(), 0U);
  EXPECT_EQ(walked[1], 1U);
  EXPECT_EQ(walked[3], 1U);
  EXPECT_EQ(walked.back(), 0U);
}

TEST_F(GraphSessions, LookingTurnsAndWalksNowhere) {
  ASSERT_TRUE(session_->call({"look", "right"}));
  EXPECT_NEAR(to_degrees(seen_.heading), 90, 1e-9);
  EXPECT_THAT(names_of_places(seen_), ElementsAre("B", "C"));
  EXPECT_NEAR(to_degrees(seen_.places[0].turn), -90, 1e-6);
  EXPECT_FALSE(seen_.places[0].seen_before);  // it is the same visit
  for (int k = 0; k < 2; ++k) ASSERT_TRUE(session_->call({"look", "up"}));
  EXPECT_NEAR(to_degrees(seen_.elevation), 30, 1e-9);
  ASSERT_TRUE(session_->call({"look", "behind"}));
  EXPECT_NEAR(to_degrees(seen_.heading), 270, 1e-9);
  EXPECT_EQ(seen_.elevation.value, 0);
  EXPECT_EQ(trajectory_of(*session_).points.size(), 1U);
  EXPECT_EQ(seen_.step, 4U);
}

TEST_F(GraphSessions, WhatIsImpossibleIsToldAndDoesNothing) {
  EXPECT_FALSE(session_->call({"go_to", "D"}));
  EXPECT_EQ(seen_.told, "Nothing was done: go_to: place \"D\" is not one of B, C.");
  EXPECT_FALSE(session_->call({"fly", "B"}));
  EXPECT_EQ(seen_.told, "Nothing was done: there is no \"fly\" here, but go_to, look, stop.");
  EXPECT_EQ(seen_.step, 0U);
  EXPECT_EQ(session_->mistakes(), 2U);
  EXPECT_TRUE(session_->call({"go_to", " b\n"}));  // a model's way to write B
  EXPECT_FALSE(session_->call({"stop", "now"}));
  EXPECT_EQ(seen_.told, "Nothing was done: stop has no argument.");
  EXPECT_FALSE(session_->ending());
  session_->misread("no line begins with \"Action:\"");
  EXPECT_THAT(seen_.told, HasSubstr("no line begins"));
  EXPECT_FALSE(session_->call({"", ""}));
  EXPECT_EQ(session_->ending(), Ending::kMistakes);  // three in a row
  EXPECT_EQ(session_->mistakes(), 5U);
  EXPECT_TRUE(seen_.tools.empty());
  EXPECT_FALSE(session_->call({"stop", ""}));
  EXPECT_EQ(session_->ending(), Ending::kMistakes);
  EXPECT_EQ(trajectory_of(*session_).points.size(), 2U);
}

TEST_F(GraphSessions, StepsAreLimited) {
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(session_->call({"look", "left"})) << k;
  EXPECT_EQ(session_->ending(), Ending::kOutOfSteps);
}

TEST_F(GraphSessions, TheSameCallsGiveTheSame) {
  GraphWorld other(episodes());
  const auto twin = other.start_on_graph(0);
  for (const Call& call : std::vector<Call>{{"go_to", "C"}, {"look", "left"}, {"go_to", "Q"}}) {
    EXPECT_EQ(session_->call(call), twin->call(call));
    EXPECT_EQ(twin->observation().told, seen_.told);
    EXPECT_EQ(names_of_places(twin->observation()), names_of_places(seen_));
  }
}

TEST(Sessions, OfReverieNameAnObject) {
  GraphWorld world(episodes(tasks::Task::kReverie));
  const auto session = world.start_on_graph(0);
  const SessionObservation& seen = session->observation();
  EXPECT_TRUE(seen.things.empty());
  EXPECT_THAT(tools_of(seen), ElementsAre("go_to", "look", "stop"));
  ASSERT_TRUE(session->call({"go_to", "C"}));
  ASSERT_EQ(seen.things.size(), 1U);  // what no picture shows cannot be named
  EXPECT_EQ(seen.things[0].category, "desk");
  EXPECT_NEAR(to_degrees(seen.things[0].turn), 0, 1);
  EXPECT_FALSE(session->call({"answer", "2"}));
  ASSERT_TRUE(session->call({"answer", "1"}));
  EXPECT_EQ(session->ending(), Ending::kStopped);
  EXPECT_EQ(trajectory_of(*session).object, "7");
}

TEST(Sessions, RefuseWhatTheyCannotBe) {
  GraphWorld world(episodes());
  EXPECT_THAT(refusal<ArgumentError>([&] { world.start_on_graph(1); }),
              HasSubstr("episode: 1; there are 1"));
  EXPECT_THAT(refusal<ArgumentError>([&] { world.start_on_graph(0, {.steps = 0}); }),
              HasSubstr("limits.steps: 0"));
  EXPECT_THAT(refusal<ArgumentError>([] { GraphWorld(nullptr); }), HasSubstr("episodes"));
}

TEST(Sessions, NamesAreLetters) {
  EXPECT_EQ(detail::letters(0), "A");
  EXPECT_EQ(detail::letters(25), "Z");
  EXPECT_EQ(detail::letters(26), "AA");
  EXPECT_EQ(detail::letters(27 * 26 - 1), "ZZ");
  EXPECT_EQ(detail::letters(27 * 26), "AAA");
  for (std::uint32_t k = 0; k < 1000; ++k) {
    EXPECT_EQ(detail::number_of_letters(detail::letters(k)), k);
  }
}

TEST(ContinuousSessions, MoveBySeveralActionsAtOnce) {
  const auto session = room().start(0);
  const SessionObservation& seen = session->observation();
  EXPECT_EQ(seen.instruction, "Walk east.");
  ASSERT_EQ(seen.tools.size(), 2U);
  EXPECT_THAT(seen.tools[0].allowed, ElementsAre("forward", "left", "right"));
  ASSERT_TRUE(session->call({"move", "forward, forward,left"}));
  EXPECT_EQ(seen.told, "You did 3 of 3 actions and walked 0.50 m.");
  EXPECT_NEAR(to_degrees(seen.heading), 75, 1e-6);
  EXPECT_FALSE(session->call({"move", "forward,forward,forward,forward,forward"}));
  EXPECT_THAT(seen.told, HasSubstr("1 to 4 are possible"));
  EXPECT_FALSE(session->call({"move", "up"}));
  ASSERT_TRUE(session->call({"stop", ""}));
  const auto walk = std::get<tasks::ContinuousResult>(session->walked());
  EXPECT_THAT(walk.actions, ElementsAre(1, 1, 2, 0));
  EXPECT_EQ(walk.positions.size(), 5U);
  EXPECT_NEAR(walk.positions.back().x, 1.5, 1e-5);
  EXPECT_TRUE(walk.stopped());
  const Standpoint last = session->standpoint();
  EXPECT_EQ(last.scan, "room");
  EXPECT_EQ(last.place.substr(0, 9), "1.500000/");
  EXPECT_NEAR(std::get<Vec3d>(last.eye).z, 1.25, 0.01);
}

TEST(ContinuousSessions, WallsAreToldAndTheBenchmarksActionsAreLimited) {
  FloorWorld world = room(0, "rxr-ce");
  const auto session = world.start(0, {.steps = 1000, .mistakes = 3});
  const SessionObservation& seen = session->observation();
  EXPECT_THAT(seen.tools[0].allowed, ElementsAre("forward", "left", "right", "up", "down"));
  for (int k = 0; k < 6; ++k) session->call({"move", "forward,forward,forward,forward"});
  EXPECT_THAT(seen.told, HasSubstr("a wall was in the way 4 times"));
  int calls = 6;
  while (!session->ending() && calls < 1000) {
    session->call({"move", "left,left,left,left"});
    ++calls;
  }
  EXPECT_EQ(session->ending(), Ending::kOutOfSteps);
  EXPECT_EQ(calls, 125);  // 500 actions
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
