// Clocks that jump: a machine that wakes up, whose battery is empty, or whose time is corrected.
#include <gmock/gmock.h>

#include "tests/support/collecting.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::collection_body;
using testing::row_results;
using testing::Worker;

constexpr std::int64_t kDay = 24L * 3600;
constexpr const char* kText = "Walk past the table and stop at the door.";

class ClockJumps : public testing::Collecting {
 protected:
  int submit(const httplib::Headers& team, const std::string& method) {
    return served_.submit(team, "open", row_results(3), method)->status;
  }
};

TEST_F(ClockJumps, APhaseIsOpenWheneverTheClockIsBeforeItsEnd) {
  served_.restart_with(R"({"name": "open", "split": "val_seen", "ends": "1970-01-20T00:00:00Z"})");
  const auto team = served_.team("A");
  EXPECT_EQ(submit(team, "before"), 202);
  now_ += 30 * kDay;
  EXPECT_EQ(submit(team, "after"), 409);
  now_ -= 30 * kDay;
  EXPECT_EQ(submit(team, "again before"), 202);
}

TEST_F(ClockJumps, AClockThatIsSetBackGivesNoNewQuota) {
  const auto team = served_.team("A");
  for (int k = 0; k < 5; ++k) EXPECT_EQ(submit(team, std::to_string(k)), 202);
  EXPECT_EQ(submit(team, "one more"), 429);
  now_ -= 5 * kDay;
  EXPECT_EQ(submit(team, "one more"), 429);
  now_ += 6 * kDay + 1;
  EXPECT_EQ(submit(team, "one more"), 202);
}

TEST_F(ClockJumps, WorkOnATaskIsTakenAfterAnyJump) {
  json body = collection_body("pilot", "write");
  body["sources"] = json::array({{{"split", "val_seen"}}});  // nine places
  create(body);
  int submitted = 0;
  for (const std::int64_t jump : {std::int64_t{3600}, 40 * kDay, -40 * kDay, -9 * kDay}) {
    Worker one = worker("worker " + std::to_string(jump));
    const json task = one.begin();
    ASSERT_TRUE(task.is_object()) << jump;
    now_ += jump;
    if (one.visit().at("status") == 401) one.join();  // its token is valid for a day
    EXPECT_EQ(one.write(task.at("task"), kText).at("status"), 200) << jump;
    EXPECT_EQ(progress().at("submitted"), ++submitted) << jump;
    EXPECT_EQ(progress().at("leased"), 0) << jump;
  }
}

TEST_F(ClockJumps, TwoWhoHoldAPlaceByAClockThatIsSetRightBothKeepTheirWork) {
  json body = collection_body("pilot", "write");
  body["per_item"] = 1;
  create(body);
  Worker one = worker("one"), other = worker("other");
  const auto first = one.begin().at("task").get<std::int64_t>();
  now_ += 3600;  // too far: the lease is over, and another worker gets the place
  const auto second = other.begin().at("task").get<std::int64_t>();
  now_ -= 3600;  // and now both leases are good
  EXPECT_EQ(other.write(second, kText).at("status"), 200);
  EXPECT_EQ(one.write(first, kText).at("status"), 200);
  EXPECT_EQ(progress().at("submitted"), 2);
  EXPECT_EQ(progress().at("complete"), 1);
  EXPECT_TRUE(worker("third").begin().is_null());
}

TEST_F(ClockJumps, APlaceLeasedByAClockThatWasAheadIsFreeAfterOneLease) {
  json body = collection_body("pilot", "write");
  body["per_item"] = 1;
  body["lease_minutes"] = 30;
  create(body);
  now_ += 40 * kDay;
  ASSERT_TRUE(worker("gone").begin().is_object());
  now_ -= 40 * kDay;
  EXPECT_TRUE(worker("early").begin().is_null());
  now_ += 30 * 60;
  EXPECT_TRUE(worker("later").begin().is_object());
}

TEST_F(ClockJumps, WhatWasEndedStaysEnded) {
  const auto team = served_.team("A");
  const std::string token = team.find("Authorization")->second.substr(7);
  const auto log_in = [&] {
    const auto answer =
        served_.client().Post("/api/v1/session", json{{"token", token}}.dump(), "application/json");
    const std::string set = answer->get_header_value("Set-Cookie");
    return httplib::Headers{{"Cookie", set.substr(0, set.find(';'))}, {"X-Enfilade", "1"}};
  };
  const auto role = [&](const httplib::Headers& who) {
    return served_.json("/api/v1/session", who).at("role").get<std::string>();
  };
  const httplib::Headers left = log_in();
  EXPECT_EQ(role(left), "team");
  now_ += kDay;
  EXPECT_EQ(role(left), "stranger") << "a session lasts twelve hours";
  const httplib::Headers ended = log_in();
  served_.client().Delete("/api/v1/session", ended);
  revoke_tokens(served_.config().database, TokenRole::kTeam, "A");
  for (const std::int64_t jump : {-kDay, -5 * kDay, 60 * kDay}) {
    now_ += jump;
    EXPECT_EQ(role(ended), "stranger") << jump;
    EXPECT_EQ(served_.get("/api/v1/submissions", team)->status, 401) << jump;
  }
}

TEST_F(ClockJumps, NobodyIsLockedOutForLonger) {
  const auto guess = [this] {
    return served_.client()
        .Post("/api/v1/session", R"({"token": "enfilade_1"})", "application/json")
        ->status;
  };
  int status = 401;
  for (int k = 0; k < 30 && status == 401; ++k) status = guess();
  EXPECT_EQ(status, 429);
  now_ -= 7 * kDay;
  EXPECT_EQ(guess(), 401);
  now_ += 30 * kDay;
  EXPECT_EQ(guess(), 401);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
