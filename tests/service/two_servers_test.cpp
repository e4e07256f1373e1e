// Two servers on one database: a new version beside the old one, or one that was started twice.
#include <gmock/gmock.h>
#include <array>
#include <atomic>
#include <functional>

#include "tests/service/program.h"
#include "tests/support/served_data.h"
#include "tests/support/worker.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::Program;
using testing::Worker;

class TwoServers : public ::testing::Test {
 protected:
  TwoServers() {
    testing::write_served_data(root_);
    write_file_atomically(root_ / "phases.json",
                          R"({"phases": [{"name": "open", "split": "val_seen", "per_day": 20}]})");
    for (Program& one : programs_) one.start();
  }

  Program make_program() {
    return {EN_PROGRAM,
            root_ / "data",
            database_,
            {"--phases", root_ / "phases.json", "--open-registration"}};
  }
  int port(std::size_t k) const { return programs_[k % programs_.size()].port(); }

  tests::TemporaryFolder folder_{"two_servers"};
  std::filesystem::path root_ = folder_.path();
  std::string database_ = testing::new_database(root_ / "service.sqlite");
  std::array<Program, 2> programs_{make_program(), make_program()};
};

/// Does it for 0 ... n - 1, each on a thread of its own.
void at_once(std::size_t n, const std::function<void(std::size_t)>& what) {
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < n; ++k) threads.emplace_back(what, k);
  for (std::thread& thread : threads) thread.join();
}

TEST_F(TwoServers, ShareTheLimitsOfATeamAndScoreEachFileOnce) {
  const httplib::Headers team = testing::make_team(port(0), "A");
  std::atomic<int> taken{0}, limited{0};
  at_once(4, [&](std::size_t client) {
    httplib::Client http("127.0.0.1", port(client));
    for (int k = 0; k < 8; ++k) {
      const std::string method = std::to_string(client) + "-" + std::to_string(k);
      const auto answer = http.Post("/api/v1/submissions?phase=open&method=" + method, team,
                                    testing::row_results(2), "application/json");
      if (answer && answer->status == 202) ++taken;
      if (answer && answer->status == 429) ++limited;
    }
  });
  EXPECT_EQ(taken, 20);
  EXPECT_EQ(limited, 12);
  httplib::Client http("127.0.0.1", port(1));
  for (int id = 1; id <= 20; ++id) {
    json status;
    for (int k = 0; k < 1000; ++k) {
      status = json::parse(http.Get("/api/v1/submissions/" + std::to_string(id), team)->body);
      if (status.at("state") != "queued") break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(status.at("state"), "scored") << status;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const auto found = testing::count_methods(port(k), team);
    EXPECT_EQ(found.size(), 20U);
    for (const auto& [method, times] : found) EXPECT_EQ(times, 1) << method;
  }
}

TEST_F(TwoServers, GiveNoPlaceTwice) {
  constexpr int kPerItem = 10;
  constexpr int kItems = 3;  // paths of val_seen
  const httplib::Headers organiser{
      {"Authorization",
       "Bearer " + create_token(database_, TokenRole::kOrganiser, "o", std::nullopt)}};
  json body = testing::collection_body("pilot", "write");
  body["sources"] = json::array({{{"split", "val_seen"}}});
  body["per_item"] = kPerItem;
  httplib::Client http("127.0.0.1", port(0));
  const json made = testing::read_answer(
      http.Post("/api/v1/collections", organiser, body.dump(), "application/json"));
  const std::string key = testing::key_of(made);
  std::atomic<int> written{0};
  at_once(8, [&](std::size_t client) {
    for (int k = 0; k < 3; ++k) {
      const std::string name = std::to_string(client) + "-" + std::to_string(k);
      Worker worker(port(client), "pilot", {{"key", key}, {"worker", name}});
      worker.join();
      worker.consent();
      for (json task; (task = worker.lease().value("task", json())).is_object();) {
        const std::string text = "Walk to the door, as task " + task.at("task").dump() + " says";
        if (worker.write(task.at("task"), text).at("status") == 200) ++written;
      }
    }
  });
  EXPECT_EQ(written, kPerItem * kItems);  // of the 72 that 24 workers could have done
  const json progress =
      testing::read_answer(http.Get("/api/v1/collections/pilot", organiser)).at("progress");
  EXPECT_EQ(progress.at("submitted"), kPerItem * kItems);
  EXPECT_EQ(progress.at("complete"), kItems);
}

TEST_F(TwoServers, ShareWorkersTeamsAndLeaderboards) {
  const httplib::Headers organiser{
      {"Authorization",
       "Bearer " + create_token(database_, TokenRole::kOrganiser, "o", std::nullopt)}};
  httplib::Client one("127.0.0.1", port(0)), other("127.0.0.1", port(1));
  const json made = testing::read_answer(one.Post("/api/v1/collections", organiser,
                                                  testing::collection_body("pilot", "write").dump(),
                                                  "application/json"));
  // Comes to one, and hands in to the other.
  Worker worker(port(0), "pilot", {{"key", testing::key_of(made)}, {"worker", "w"}});
  const json task = worker.begin();
  ASSERT_TRUE(task.is_object());
  worker.go_on_at(port(1));
  EXPECT_EQ(worker.write(task.at("task"), "Walk to the door.").at("status"), 200);
  EXPECT_EQ(testing::read_answer(one.Get("/api/v1/collections/pilot", organiser))
                .at("progress")
                .at("submitted"),
            1);
  // A team of one, and its row on the other's leaderboard.
  const httplib::Headers team = testing::make_team(port(0), "A");
  ASSERT_EQ(one.Post("/api/v1/submissions?phase=open&method=m", team, testing::row_results(2),
                     "application/json")
                ->status,
            202);
  json rows;
  for (int k = 0; k < 1000 && rows.empty(); ++k) {
    rows = json::parse(other.Get("/api/v1/leaderboards/open")->body).at("rows");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("team"), "A");
}

// The calls of a session of the arena come to one and the other in turn.
TEST_F(TwoServers, ShareSessionsOfTheArena) {
  const json wanted{{"split", "val_seen"}, {"episode", "1_0"}, {"steps", 100}, {"mistakes", 100}};
  const json begun =
      testing::read_answer(httplib::Client("127.0.0.1", port(0))
                               .Post("/api/v1/sessions", wanted.dump(), "application/json"));
  const httplib::Headers key{{"Enfilade-Session", begun.at("key").get<std::string>()}};
  const std::string path = "/api/v1/sessions/" + begun.at("session").dump();
  json observation = begun.at("observation");
  for (std::size_t calls = 0; calls < 12; ++calls) {
    httplib::Client client("127.0.0.1", port(calls / 2));
    const json call{{"tool", "go_to"},
                    {"argument", observation.at("places").at(0).at("name")},
                    {"after", calls}};
    const json state =
        testing::read_answer(client.Post(path + "/calls", key, call.dump(), "application/json"));
    ASSERT_EQ(state.at("status"), 200) << state;
    EXPECT_EQ(state.at("calls"), calls + 1);
    observation = state.at("observation");
    httplib::Client another("127.0.0.1", port(calls / 2 + 1));
    EXPECT_EQ(json::parse(another.Get(path, key)->body).at("observation"), observation);
  }
  // Of calls that come to both at once, each is there once, or refused.
  std::atomic<int> taken{0};
  at_once(8, [&](std::size_t client) {
    httplib::Client http("127.0.0.1", port(client));
    for (int k = 0; k < 5; ++k) {
      const auto answer = http.Post(path + "/calls", key, R"({"tool": "look", "argument": "left"})",
                                    "application/json");
      ASSERT_TRUE(answer && (answer->status == 200 || answer->status == 409)) << answer->body;
      if (answer->status == 200) ++taken;
    }
  });
  EXPECT_GT(taken, 0);
  for (std::size_t k = 0; k < 2; ++k) {
    httplib::Client http("127.0.0.1", port(k));
    EXPECT_EQ(json::parse(http.Get(path, key)->body).at("calls"), 12 + taken);
  }
}

TEST_F(TwoServers, OneScoresWhatTheOtherHasLeft) {
  const httplib::Headers team = testing::make_team(port(0), "A");
  httplib::Client("127.0.0.1", port(0))
      .Post("/api/v1/submissions?phase=open&method=m", team, testing::row_results(2),
            "application/json");
  httplib::Client http("127.0.0.1", port(1));
  const auto is_scored_soon = [&] {
    for (int k = 0; k < 400; ++k) {
      const auto answer = http.Get("/api/v1/submissions/1", team);
      if (json::parse(answer->body).at("state") == "scored") return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  };
  ASSERT_TRUE(is_scored_soon());
  programs_[0].kill();
  testing::run_sql(database_, "UPDATE submission SET state = 'queued', score = NULL");
  EXPECT_TRUE(is_scored_soon());
}

TEST_F(TwoServers, CannotShareAPort) {
  tests::Process second(
      {EN_PROGRAM, "serve", root_ / "data", "--db", database_, "--port", std::to_string(port(0))});
  EXPECT_EQ(second.wait(), 2);
  httplib::Client http("127.0.0.1", port(0));
  EXPECT_EQ(http.Get("/healthz")->status, 200);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
