// Phases with secret goals: who may submit, how often, and what is shown when. What cannot be read
// from that is tested in secret_goals_attacks_test.cpp.
#include <gmock/gmock.h>
#include <atomic>
#include <cmath>
#include <optional>

#include "enfilade/core/errors.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/server.h"
#include "enfilade/service/store/database.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::row_results;

constexpr std::int64_t kEnd = 2'000'000;  // the clock begins at 1,000,000

class SecretGoals : public testing::ServedByAClock {
 protected:
  /// Serves one phase "test" with secret goals. \param fields more of them, in JSON
  void serve(const std::string& fields) {
    served_.restart_with(R"({"name": "test", "split": "test", "annotations": "secret.json")" +
                         fields + "}");
  }
  static std::string ends() { return R"(, "ends": ")" + detail::iso_time(kEnd) + '"'; }

  std::int64_t submit(const httplib::Headers& team, std::size_t moves, const std::string& method) {
    const auto taken = served_.submit(team, "test", row_results(moves), method);
    EXPECT_EQ(taken->status, 202) << taken->body;
    const auto id = json::parse(taken->body).at("id").get<std::int64_t>();
    EXPECT_EQ(served_.scored(organiser_, id).at("state"), "scored");
    return id;
  }
  json submission(std::int64_t id, const httplib::Headers& who) {
    return served_.json("/api/v1/submissions/" + std::to_string(id), who);
  }
  json leaderboard(const httplib::Headers& who = {}) {
    return served_.json("/api/v1/leaderboards/test", who);
  }
  json phase(const httplib::Headers& who = {}) {
    return served_.json("/api/v1/phases", who).at("phases")[0];
  }
  int approve(std::int64_t team, bool approved, const httplib::Headers& who) {
    return served_.client()
        .Put("/api/v1/teams/" + std::to_string(team) + "/approval", who,
             json{{"approved", approved}}.dump(), "application/json")
        ->status;
  }
};

TEST_F(SecretGoals, TeamsAreApprovedByAnOrganiser) {
  serve("");
  const auto team = served_.stranger("A");
  const auto refused = served_.submit(team, "test", row_results(3));
  EXPECT_EQ(refused->status, 403);
  EXPECT_THAT(refused->body, HasSubstr("an organiser has approved"));
  EXPECT_EQ(served_.json("/api/v1/session", team).at("approved"), false);
  const auto listed = served_.json("/api/v1/teams", organiser_).at("teams");
  ASSERT_EQ(listed.size(), 1U);
  EXPECT_EQ(listed[0].at("name"), "A");
  EXPECT_EQ(listed[0].at("approved"), false);
  const auto id = listed[0].at("id").get<std::int64_t>();
  EXPECT_EQ(approve(id, true, team), 403);
  EXPECT_EQ(approve(id, true, {}), 401);
  EXPECT_EQ(served_.get("/api/v1/teams", team)->status, 403);
  EXPECT_EQ(approve(id + 1, true, organiser_), 404);
  EXPECT_EQ(approve(id, true, organiser_), 200);
  EXPECT_EQ(served_.json("/api/v1/session", team).at("approved"), true);
  EXPECT_EQ(served_.submit(team, "test", row_results(3))->status, 202);
  EXPECT_EQ(approve(id, false, organiser_), 200);
  EXPECT_EQ(served_.submit(team, "test", row_results(2))->status, 403);
}

TEST_F(SecretGoals, TeamsAreApprovedOnTheCommandLineToo) {
  serve("");
  const auto team = served_.stranger("A");
  const auto& database = served_.config().database;
  EXPECT_THROW(set_approval(database, "B", Approval::kGiven), LookupError);
  set_approval(database, "a", Approval::kGiven);
  EXPECT_EQ(served_.submit(team, "test", row_results(3))->status, 202);
  set_approval(database, "A", Approval::kWithdrawn);
  EXPECT_EQ(served_.submit(team, "test", row_results(2))->status, 403);
}

TEST_F(SecretGoals, RegistrationIsClosedUnlessItIsOpened) {
  EXPECT_FALSE(ServerConfig{}.open_registration);
  EXPECT_EQ(served_.json("/api/v1/phases").at("registration"), "open");
  ServerConfig config = served_.config();
  config.open_registration = false;
  config.database = testing::new_database(served_.root() / "other.sqlite");
  const Server closed(Site::open(served_.root() / "data"), config);
  httplib::Client client("127.0.0.1", closed.port());
  const auto make = [&client](const httplib::Headers& who) {
    return client.Post("/api/v1/teams", who, R"({"name": "A"})", "application/json");
  };
  EXPECT_EQ(make({})->status, 403);
  const auto token = create_token(config.database, TokenRole::kOrganiser, "Ada", std::nullopt);
  const auto made = make({{"Authorization", "Bearer " + token}});
  EXPECT_EQ(made->status, 201) << made->body;
  EXPECT_EQ(json::parse(made->body).at("approved"), true);
  EXPECT_THAT(client.Get("/api/v1/phases")->body, HasSubstr(R"("registration":"closed")"));
}

TEST_F(SecretGoals, ScoresAppearAfterTheEndOneRowForATeam) {
  serve(ends());
  const auto a = served_.team("A");
  const auto b = served_.team("B");
  const auto worse = submit(a, 0, "stays");
  const auto better = submit(a, 3, "walks");
  submit(b, 0, "stays");
  const json before = submission(better, a);
  EXPECT_EQ(before.at("state"), "received");
  EXPECT_EQ(before.at("withheld"), "until-end");
  EXPECT_FALSE(before.contains("means"));
  EXPECT_EQ(served_.get("/api/v1/leaderboards/test", a)->status, 403);
  EXPECT_EQ(leaderboard(organiser_).at("rows").size(), 2U);
  EXPECT_EQ(phase().at("ended"), false);

  now_ = kEnd;
  EXPECT_EQ(phase().at("ended"), true);
  const auto late = served_.submit(a, "test", row_results(2), "late");
  EXPECT_EQ(late->status, 409) << late->body;
  // Who got no answer may ask again.
  EXPECT_EQ(served_.submit(a, "test", row_results(3), "walks")->status, 200);
  const json rows = leaderboard().at("rows");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("method"), "walks");
  EXPECT_EQ(rows[0].at("means").at("spl"), (json{{"mean", 1.0}}));  // no interval
  EXPECT_EQ(rows[0].at("means").at("trajectory_length").at("mean"), 3.0);
  EXPECT_EQ(submission(better, a).at("means"), rows[0].at("means"));
  EXPECT_EQ(submission(worse, a).at("withheld"), "not-best");
  EXPECT_FALSE(submission(worse, a).contains("means"));
  EXPECT_THAT(served_.get("/api/v1/leaderboards/test?format=csv")->body,
              HasSubstr("\"walks\",1970-01-12T13:46:40Z,1.0,,,1.0,,,1.0,,,0.0,,"));
}

TEST_F(SecretGoals, ALadderShowsImprovementsOnly) {
  serve(R"(, "scores": "ladder", "step": 0.1, "primary": "success")" + ends());
  const auto team = served_.team("A");
  const auto first = submit(team, 0, "stays");
  EXPECT_EQ(submission(first, team).at("means"), (json{{"success", {{"mean", 0.0}}}}));
  const auto second = submit(team, 3, "walks");
  EXPECT_EQ(submission(second, team).at("means"), (json{{"success", {{"mean", 1.0}}}}));
  const auto third = submit(team, 1, "one step");  // as good, not better
  EXPECT_EQ(submission(third, team).at("withheld"), "no-improvement");
  EXPECT_FALSE(submission(third, team).contains("means"));
  const auto rows = leaderboard().at("rows");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("method"), "walks");
  EXPECT_EQ(rows[0].at("means"), (json{{"success", {{"mean", 1.0}}}}));
  // Another team has a ladder of its own.
  const auto other = served_.team("B");
  EXPECT_TRUE(submission(submit(other, 0, "stays"), other).contains("means"));
  now_ = kEnd;
  EXPECT_EQ(leaderboard().at("rows")[0].at("means").size(), 8U);
}

TEST_F(SecretGoals, AStepIsBeatenByAStep) {
  serve(R"(, "scores": "ladder", "step": 0.2, "primary": "success")");
  const auto team = served_.team("A");
  // Of six episodes one more succeeds each time: 0, 1/6, 2/6, ...
  const json good = json::parse(row_results(3));
  json results = json::parse(row_results(0));
  std::vector<json> shown;
  for (std::size_t k = 0; k < 4; ++k) {
    if (k > 0) results[k - 1] = good[k - 1];
    const auto taken = served_.submit(team, "test", results.dump(), "m");
    const auto id = json::parse(taken->body).at("id").get<std::int64_t>();
    served_.scored(team, id);
    shown.push_back(submission(id, team).value("means", json()));
  }
  EXPECT_EQ(shown[0], (json{{"success", {{"mean", 0.0}}}}));
  EXPECT_TRUE(shown[1].is_null());                            // 0.167 is less than 0.2 better
  EXPECT_EQ(shown[2], (json{{"success", {{"mean", 0.4}}}}));  // 0.333 to steps of 0.2
  EXPECT_TRUE(shown[3].is_null());                            // 0.5 is less than 0.6
}

TEST_F(SecretGoals, RowsWaitUntilAllIsScored) {
  serve(ends());
  const auto team = served_.team("A");
  submit(team, 0, "stays");
  const auto waits = submit(team, 3, "walks");
  served_.stop();
  // As a server that was killed leaves it, and so for a while.
  testing::run_sql(
      served_.config().database,
      "UPDATE submission SET state = 'queued', score = NULL WHERE id = " + std::to_string(waits));
  std::optional<testing::FrozenSubmissions> frozen;
  frozen.emplace(served_.config().database, "x");
  served_.start();
  now_ = kEnd;
  EXPECT_EQ(served_.get("/api/v1/leaderboards/test")->status, 403);
  frozen.reset();
  served_.scored(organiser_, waits);
  EXPECT_EQ(leaderboard().at("rows")[0].at("method"), "walks");
}

TEST_F(SecretGoals, AnEndThatWasShownStays) {
  serve(ends());
  const auto team = served_.team("A");
  const auto id = submit(team, 0, "stays");
  now_ = kEnd;
  EXPECT_EQ(leaderboard().at("rows").size(), 1U);
  now_ = kEnd - 1000;  // the clock was wrong, and is set right
  EXPECT_EQ(served_.submit(team, "test", row_results(3))->status, 409);
  serve("");  // the organiser takes the end away
  EXPECT_EQ(phase().at("ended"), true);
  EXPECT_EQ(served_.submit(team, "test", row_results(3))->status, 409);
  // Nor does another of the team's files come up in the row's place.
  EXPECT_EQ(served_.client().Delete("/api/v1/submissions/" + std::to_string(id), team)->status,
            409);
  EXPECT_EQ(leaderboard().at("rows").size(), 1U);
}

TEST_F(SecretGoals, RowsOfTeamsWithoutApprovalAreNotShown) {
  serve(ends());
  const auto team = served_.team("A");
  submit(team, 3, "walks");
  now_ = kEnd;
  EXPECT_EQ(leaderboard().at("rows").size(), 1U);
  set_approval(served_.config().database, "A", Approval::kWithdrawn);
  EXPECT_EQ(leaderboard().at("rows").size(), 0U);
  EXPECT_EQ(leaderboard(organiser_).at("rows").size(), 1U);
}

TEST_F(SecretGoals, ATeamHasItsLimitOverAllTime) {
  serve(R"(, "per_team": 2)");
  const auto team = served_.team("A");
  const auto first = submit(team, 0, "a");
  submit(team, 1, "b");
  EXPECT_EQ(served_.client().Delete("/api/v1/submissions/" + std::to_string(first), team)->status,
            200);
  now_ += 10L * 365 * 24 * 3600;
  const auto refused = served_.submit(team, "test", row_results(2), "c");
  EXPECT_EQ(refused->status, 429);
  EXPECT_THAT(refused->body, HasSubstr("at most 2 submissions of a team in all"));
  EXPECT_EQ(served_.submit(team, "test", row_results(1), "b")->status, 200);
}

TEST_F(SecretGoals, AnAddressHasItsLimits) {
  serve(R"(, "per_address_day": 2, "per_address": 3)");
  const auto status = [&](const httplib::Headers& team, const char* method) {
    return served_.submit(team, "test", row_results(1), method)->status;
  };
  const auto a = served_.team("A");
  const auto b = served_.team("B");
  EXPECT_EQ(status(a, "1"), 202);
  EXPECT_EQ(status(b, "1"), 202);
  EXPECT_EQ(status(b, "2"), 429);
  now_ += 24 * 3600 + 1;
  EXPECT_EQ(status(b, "2"), 202);
  now_ += 24 * 3600 + 1;
  EXPECT_EQ(status(a, "2"), 429);
  // The database does not tell whose address it was.
  store::Database db(served_.config().database);
  const auto addresses = db.select<std::string>("SELECT DISTINCT address FROM attempt");
  ASSERT_EQ(addresses.size(), 1U);
  EXPECT_EQ(addresses[0].size(), 64U);
}

TEST_F(SecretGoals, FilesWithFaultsAreLimitedToo) {
  serve("");
  const auto team = served_.team("A");
  for (int k = 0; k < 20; ++k) {
    EXPECT_EQ(
        served_.submit(team, "test", "[]" + std::string(static_cast<std::size_t>(k), ' '))->status,
        422);
  }
  const auto refused = served_.submit(team, "test", row_results(3));
  EXPECT_EQ(refused->status, 429);
  EXPECT_THAT(refused->body, HasSubstr("at most 20 files with faults of a team in 24 hours"));
  now_ += 24 * 3600 + 1;
  EXPECT_EQ(served_.submit(team, "test", row_results(3))->status, 202);
  // Files with faults were no submissions, and their addresses are gone.
  EXPECT_EQ(served_.json("/api/v1/submissions", team).at("submissions").size(), 1U);
  store::Database db(served_.config().database);
  EXPECT_EQ(db.find_number("SELECT count(*) FROM attempt"), 1);
}

TEST_F(SecretGoals, APhaseTakesSoManyTeams) {
  serve(R"(, "teams": 1)");
  const auto a = served_.team("A");
  EXPECT_EQ(served_.submit(a, "test", row_results(3))->status, 202);
  EXPECT_EQ(served_.submit(served_.team("B"), "test", row_results(3))->status, 403);
  EXPECT_EQ(served_.submit(a, "test", row_results(2))->status, 202);
}

TEST_F(SecretGoals, NearCopiesAreToldToOrganisersOnly) {
  serve("");
  const auto a = served_.team("A");
  const auto b = served_.team("B");
  const auto first = submit(a, 3, "walks");
  json results = json::parse(row_results(3));
  results[4]["trajectory"].erase(3);
  const auto taken = served_.submit(b, "test", results.dump(), "nearly");
  const auto near = json::parse(taken->body).at("id").get<std::int64_t>();
  served_.scored(organiser_, near);
  const auto apart = submit(b, 1, "one step");
  EXPECT_EQ(submission(near, organiser_).at("near_copy"), (json{{"of", first}, {"differing", 1}}));
  EXPECT_FALSE(submission(near, b).contains("near_copy"));
  EXPECT_FALSE(submission(apart, organiser_).contains("near_copy"));
  EXPECT_EQ(phase(organiser_).at("near_copies"), 1);
  EXPECT_FALSE(phase(b).contains("near_copies"));
}

TEST_F(SecretGoals, WhatIsGivenAwayIsToldInBits) {
  serve(R"(, "teams": 2, "per_team": 4, "scores": "ladder"}, {"name": "again", "split": "test",
           "annotations": "./secret.json", "scores": "hidden")");
  const json told = phase().at("leakage");
  // Three goals among the five viewpoints in reach of each start.
  EXPECT_EQ(told.at("goal_bits"), 7);
  EXPECT_EQ(told.at("phases"), (json{"test", "again"}));
  // Of a team: log2 C(104, 4), a best of 4, 6 shares of 101 values and 301 distances. Twice.
  EXPECT_EQ(told.at("most_bits"),
            std::ceil(2 * (std::log2(4'598'126) + 2 + 6 * std::log2(101) + std::log2(301))));
  EXPECT_FALSE(told.contains("used_bits"));
  EXPECT_EQ(phase(organiser_).at("leakage").at("used_bits"), 0);
  EXPECT_THAT(served_.get("/api/v1/phases", organiser_)->body, Not(HasSubstr("-0")));
  submit(served_.team("A"), 3, "walks");
  EXPECT_EQ(phase(organiser_).at("leakage").at("used_bits"), std::ceil(std::log2(101)));
  const auto phases = served_.json("/api/v1/phases", organiser_).at("phases");
  EXPECT_EQ(phases[1].at("leakage").at("used_bits"), std::ceil(std::log2(101)));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
