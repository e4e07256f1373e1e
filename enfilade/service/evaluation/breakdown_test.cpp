// Pages of methods: what a team says of one, its scores in parts, two compared; over real sockets.
#include "enfilade/service/evaluation/breakdown.h"

#include <gmock/gmock.h>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/annotations.h"
#include "tests/support/served_data.h"

namespace enfilade::service::evaluation {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::row_results;
using testing::Served;

/// Three paths of two instructions each: 11 and 12 in "row", 3 m and 1 m long, 13 in "wing", 5 m.
tasks::Annotations three_lengths() {
  tasks::Annotations annotations{"val_unseen", "", {}};
  for (std::int64_t id = 11; id <= 13; ++id) {
    tasks::PathAnnotation path{id, id == 13 ? "wing" : "row", Radians(1.5), {}, 3.0, {}};
    const std::size_t moves = id == 11 ? 3 : id == 12 ? 1 : 5;
    for (std::size_t v = 0; v <= moves; ++v) path.path.push_back("v" + std::to_string(v));
    path.instructions = {"Walk to the end of path " + std::to_string(id) + ".", "Go <b>on</b>."};
    annotations.paths.push_back(path);
  }
  return annotations;
}

/// A results file of them. \param moves along each path
std::string walks(const std::vector<std::size_t>& moves) {
  auto file = json::array();
  for (std::size_t k = 0; k < 3; ++k) {
    for (const char* number : {"_0", "_1"}) {
      auto trajectory = json::array();
      for (std::size_t v = 0; v <= moves[k]; ++v) {
        trajectory.push_back({"v" + std::to_string(v), 1.5, 0.0});
      }
      file.push_back({{"instr_id", std::to_string(11 + k) + number}, {"trajectory", trajectory}});
    }
  }
  return file.dump();
}

class Methods : public testing::ServedByAClock {
 protected:
  static constexpr std::int64_t kEnd = 2'000'000;

  Methods() {
    write_file_atomically(served_.root() / "data/r2r/R2R_val_unseen.json",
                          to_json(three_lengths()));
  }

  /// \param more phases after the open one of val_unseen
  void serve(const std::string& more = "") {
    served_.restart_with(R"({"name": "unseen", "split": "val_unseen"})" + more);
  }
  static std::string secret(const std::string& fields) {
    return R"(, {"name": "test", "split": "test", "annotations": "secret.json")" + fields + "}";
  }
  static std::string ends() { return R"(, "ends": ")" + detail::iso_time(kEnd) + '"'; }

  std::int64_t submit(const httplib::Headers& team, const std::string& phase,
                      const std::string& results, const std::string& method = "method") {
    const auto taken = served_.submit(team, phase, results, method);
    EXPECT_EQ(taken->status, 202) << taken->body;
    const auto id = json::parse(taken->body).at("id").get<std::int64_t>();
    EXPECT_EQ(served_.scored(organiser_, id).at("state"), "scored");
    return id;
  }
  static std::string address(std::int64_t id, const std::string& what) {
    return "/api/v1/submissions/" + std::to_string(id) + "/" + what;
  }
  httplib::Result describe(std::int64_t id, const json& said, const httplib::Headers& who) {
    return served_.client().Put(address(id, "method"), who, said.dump(), "application/json");
  }
  json compare(std::int64_t first, std::int64_t second, const std::string& phase = "unseen") {
    return served_.json("/api/v1/leaderboards/" + phase + "/comparison?first=" +
                        std::to_string(first) + "&second=" + std::to_string(second));
  }
};

TEST_F(Methods, AreDescribedByTheirTeam) {
  serve();
  const auto a = served_.team("A"), b = served_.team("B");
  const auto id = submit(a, "unseen", walks({3, 0, 0}));
  const json said{{"description", "A *map* of <b>all</b>\nthat was seen."},
                  {"bibtex", "@article{a, title={b}}"},
                  {"paper", "https://example.org/p"},
                  {"weights", "open"}};
  EXPECT_EQ(describe(id, said, b)->status, 403);
  EXPECT_EQ(describe(id, said, {})->status, 401);
  const auto kept = describe(id, said, a);
  ASSERT_EQ(kept->status, 200) << kept->body;
  const json shown = served_.json(address(id, "method"));  // a stranger
  EXPECT_EQ(shown.at("description"), said["description"]);
  EXPECT_EQ(shown.at("bibtex"), said["bibtex"]);
  EXPECT_EQ(shown.at("paper"), "https://example.org/p");
  EXPECT_FALSE(shown.contains("code"));
  EXPECT_EQ(shown.at("own"), false);
  EXPECT_EQ(shown.at("broken_down"), true);
  EXPECT_EQ(served_.json(address(id, "method"), a).at("own"), true);
  const json row = served_.json("/api/v1/leaderboards/unseen").at("rows").at(0);
  EXPECT_EQ(row.at("weights"), "open");
  EXPECT_FALSE(row.contains("walks_public"));
  // What is left out is empty again.
  EXPECT_EQ(describe(id, json::object(), a)->status, 200);
  EXPECT_EQ(served_.json(address(id, "method")).at("description"), "");
  EXPECT_FALSE(served_.json(address(id, "method")).contains("weights"));
}

TEST_F(Methods, TakeNoTextOrLinkThatCouldDoHarm) {
  serve();
  const auto team = served_.team("A");
  const auto id = submit(team, "unseen", walks({3, 0, 0}));
  const std::string most(MethodDescription::kLongest, 'x');
  EXPECT_EQ(describe(id, {{"description", most}, {"bibtex", most}}, team)->status, 200);
  for (const json& bad : {json{{"description", most + "x"}}, json{{"bibtex", most + "x"}},
                          json{{"description", "a\u202eb"}}, json{{"paper", "javascript:alert(1)"}},
                          json{{"code", "http://example.org"}}}) {
    const auto refused = describe(id, bad, team);
    EXPECT_EQ(refused->status, 422) << bad.dump().substr(0, 80);
    EXPECT_THAT(refused->body, HasSubstr(bad.items().begin().key()));
  }
  for (const json& bad : {json{{"weights", "half"}}, json{{"walks_public", "yes"}},
                          json{{"description", 1}}, json::array()}) {
    EXPECT_EQ(describe(id, bad, team)->status, 400) << bad;
  }
  EXPECT_LT(describe(id, {{"weights", most}}, team)->body.size(), 300U);
  EXPECT_EQ(served_.json(address(id, "method")).at("description"), most);
}

TEST_F(Methods, OthersSeeOnlyThoseThatTheLeaderboardShows) {
  serve();
  const auto team = served_.team("A");
  const auto id = submit(team, "unseen", walks({3, 0, 0}));
  EXPECT_EQ(served_.get(address(id, "method"))->status, 200);
  EXPECT_EQ(served_.get(address(id + 1, "method"))->status, 404);
  const std::string shown = served_.get(address(id + 1, "method"))->body;
  served_.client().Delete("/api/v1/submissions/" + std::to_string(id), team);
  EXPECT_EQ(served_.get(address(id, "method"))->body, shown) << "as if it were not there";
  EXPECT_EQ(served_.get(address(id, "breakdown"))->status, 404);
  EXPECT_EQ(served_.json(address(id, "method"), team).at("state"), "withdrawn");
  EXPECT_EQ(served_.get(address(id, "breakdown"), team)->status, 403);
}

TEST_F(Methods, AreBrokenDownByBuildingAndPathLength) {
  serve();
  const auto id = submit(served_.team("A"), "unseen", walks({3, 0, 0}));
  const json parts = served_.json(address(id, "breakdown"));
  const json& buildings = parts.at("buildings");
  ASSERT_EQ(buildings.size(), 2U);
  EXPECT_EQ(buildings[0].at("scan"), "row");
  EXPECT_EQ(buildings[0].at("episodes"), 4);
  EXPECT_EQ(buildings[0].at("groups"), 2);
  // 1 m from its goal is a success.
  EXPECT_EQ(buildings[0].at("means").at("success").at("mean"), 1);
  EXPECT_EQ(buildings[0]["means"]["nav_error"]["mean"], 0.5);
  EXPECT_EQ(buildings[1].at("scan"), "wing");
  EXPECT_EQ(buildings[1]["means"]["success"]["mean"], 0);
  EXPECT_EQ(buildings[1]["means"]["nav_error"]["mean"], 5);
  const json& lengths = parts.at("lengths");
  ASSERT_EQ(lengths.size(), 3U);
  EXPECT_EQ(lengths[0].at("least"), 1);
  EXPECT_EQ(lengths[0].at("most"), 2);
  EXPECT_EQ(lengths[2].at("least"), 5);
  EXPECT_EQ(lengths[2]["means"]["success"]["mean"], 0);
  // The parts together are the whole.
  const double whole =
      served_.json(address(id, "method"))["means"]["success"]["mean"].get<double>();
  for (const json* list : {&buildings, &lengths}) {
    double sum = 0;
    for (const json& part : *list) {
      sum += part["episodes"].get<double>() * part["means"]["success"]["mean"].get<double>();
    }
    EXPECT_DOUBLE_EQ(sum / 6, whole);
  }
}

TEST_F(Methods, ShowTrajectoriesIfTheirTeamDoes) {
  serve();
  const auto team = served_.team("A");
  const auto id = submit(team, "unseen", walks({3, 0, 1}));
  EXPECT_FALSE(served_.json(address(id, "breakdown")).contains("worst"));
  EXPECT_EQ(served_.get(address(id, "episodes/13_0"))->status, 403);
  EXPECT_TRUE(served_.json(address(id, "breakdown"), team).contains("worst"));
  EXPECT_EQ(describe(id, {{"walks_public", true}}, team)->status, 200);
  EXPECT_EQ(served_.json("/api/v1/leaderboards/unseen").at("rows").at(0).at("walks_public"), true);
  const json worst = served_.json(address(id, "breakdown")).at("worst");
  ASSERT_EQ(worst.size(), 6U);
  EXPECT_EQ(worst[0].at("episode"), "13_0");  // the only failures, in the order of the file
  EXPECT_EQ(worst[1].at("episode"), "13_1");
  EXPECT_EQ(worst[0].at("scan"), "wing");
  EXPECT_EQ(worst[0].at("instruction"), "Walk to the end of path 13.");
  EXPECT_EQ(worst[0].at("path"), (json{"v0", "v1", "v2", "v3", "v4", "v5"}));
  EXPECT_EQ(worst[0].at("trajectory"), json::parse(R"([["v0", 1.5, 0], ["v1", 1.5, 0]])"));
  EXPECT_EQ(worst[0].at("values").at("success"), 0);
  EXPECT_EQ(worst[0]["values"]["nav_error"], 4);
  EXPECT_EQ(worst[2].at("episode"), "12_0") << "1 m away, the others 0";
  EXPECT_EQ(served_.json(address(id, "episodes/13_0")), worst[0]);
  const auto unknown = served_.get(address(id, "episodes/14_0"));
  EXPECT_EQ(unknown->status, 404);
  EXPECT_THAT(unknown->body, HasSubstr(R"(has no episode \"14_0\")"));
}

TEST_F(Methods, AreComparedEpisodeByEpisode) {
  serve();
  const auto a = served_.team("A"), b = served_.team("B");
  const auto first = submit(a, "unseen", walks({0, 0, 0}));
  const auto second = submit(b, "unseen", walks({3, 0, 5}));
  const json found = compare(first, second);
  EXPECT_EQ(found.at("episodes"), 6);
  EXPECT_EQ(found.at("groups"), 3);
  EXPECT_EQ(found.at("better"), 4);
  EXPECT_EQ(found.at("worse"), 0);
  const json& success = found.at("means").at("success");
  EXPECT_DOUBLE_EQ(success.at("first").get<double>(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(success.at("second").get<double>(), 1);
  EXPECT_DOUBLE_EQ(success.at("difference").get<double>(), 2.0 / 3);
  // One path of three has no difference, and is all of a draw once in 27.
  EXPECT_NEAR(success.at("p").get<double>(), 2.0 / 27, 0.035);
  EXPECT_LE(success.at("low").get<double>(), success.at("difference").get<double>());
  EXPECT_EQ(success.at("high"), 1);
  EXPECT_DOUBLE_EQ(found["means"]["nav_error"]["difference"].get<double>(), -8.0 / 3);
  const json turned = compare(second, first)["means"]["success"];
  EXPECT_DOUBLE_EQ(turned.at("difference").get<double>(), -2.0 / 3);
  EXPECT_EQ(turned.at("p"), success["p"]);
  const json same = compare(first, first)["means"]["spl"];
  EXPECT_EQ(same.at("difference"), 0);
  EXPECT_EQ(same.at("p"), 1);
}

TEST_F(Methods, OfTwoPhasesAreNotCompared) {
  serve(R"(, {"name": "open", "split": "val_seen"})");
  const auto team = served_.team("A");
  const auto here = submit(team, "unseen", walks({0, 0, 0}));
  const auto there = submit(team, "open", row_results(3));
  EXPECT_THAT(compare(here, there).dump(), HasSubstr("second: no such row of this phase"));
  EXPECT_THAT(compare(here, 99).dump(), HasSubstr("no such submission"));
  const auto half = served_.get("/api/v1/leaderboards/unseen/comparison?first=1");
  EXPECT_EQ(half->status, 400);
  EXPECT_THAT(half->body, HasSubstr("second: must be there"));
}

TEST_F(Methods, OfSecretGoalsShowNothingThatTheLeaderboardDoesNot) {
  serve(secret(ends()));
  const auto a = served_.team("A"), b = served_.team("B");
  const auto good = submit(a, "test", row_results(3));
  const auto worse = submit(a, "test", row_results(0), "stays");
  const auto other = submit(b, "test", row_results(0));
  for (const auto id : {good, worse, other}) {
    for (const char* what : {"method", "breakdown", "episodes/1_0"}) {
      EXPECT_EQ(served_.get(address(id, what))->status, 404) << id << what;
    }
    EXPECT_EQ(served_.get(address(id, "breakdown"), organiser_)->status, 403);
  }
  EXPECT_THAT(compare(good, other, "test").dump(), HasSubstr("no such submission"));
  const json own = served_.json(address(good, "method"), a);
  EXPECT_EQ(own.at("state"), "received");
  EXPECT_EQ(own.at("broken_down"), false);
  EXPECT_FALSE(own.contains("means"));
  EXPECT_EQ(served_.get(address(good, "method"), b)->status, 404);
  EXPECT_EQ(served_.get(address(good, "breakdown"), a)->status, 403);
  EXPECT_EQ(describe(good, {{"walks_public", true}}, a)->status, 409);
  EXPECT_EQ(describe(good, {{"description", "Ours."}}, a)->status, 200);

  now_ = kEnd + 1;
  const json shown = served_.json(address(good, "method"));
  EXPECT_EQ(shown.at("description"), "Ours.");
  EXPECT_EQ(shown.at("broken_down"), false);
  EXPECT_FALSE(shown.at("means").at("spl").contains("low"));
  EXPECT_EQ(served_.get(address(worse, "method"))->status, 404) << "another stands for its team";
  for (const auto& who : {httplib::Headers{}, a, organiser_}) {
    EXPECT_EQ(served_.get(address(good, "breakdown"), who)->status, 403);
    EXPECT_EQ(served_.get(address(good, "episodes/1_0"), who)->status, 403);
  }
  const json found = compare(other, good, "test");
  EXPECT_EQ(found.at("means").at("success").at("difference"), 1);
  EXPECT_THAT(found.dump(), Not(HasSubstr("\"p\"")));
  EXPECT_THAT(found.dump(), Not(HasSubstr("low")));
  EXPECT_FALSE(found.contains("better"));
  EXPECT_THAT(compare(worse, good, "test").dump(), HasSubstr("no such submission"));
}

TEST(PublishedRows, HaveTheirFiguresByColumn) {
  Phase phase;
  phase.split = "val_unseen";
  const auto rows = published_json(phase, 2349, false);
  const auto found = std::ranges::find_if(rows, [](const auto& row) {
    return row["agent"] == "NaviLLM" && row["source"] == "README of zd11024/NaviLLM";
  });
  ASSERT_NE(found, rows.end());
  EXPECT_EQ((*found)["means"].dump(), R"({"spl":{"mean":0.59},"success":{"mean":0.67}})");
  EXPECT_TRUE(published_json(phase, 2349, true).empty());
}

}  // namespace EN_UNIT
}  // namespace enfilade::service::evaluation
