// Two servers on one database: a new version beside the old one, or one that was started twice.
#include <gmock/gmock.h>
#include <array>
#include <atomic>
#include <functional>

#include "tests/service/program.h"
#include "tests/support/served_data.h"
#include "tests/support/worker.h"

namespace enfilade::service {
namespace {

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

  Program make_program(const std::string& name) {
    return {EN_PROGRAM,
            {root_ / "data", "--db", database_, "--phases", root_ / "phases.json",
             "--open-registration"},
            root_ / name};
  }
  int port(std::size_t k) const { return programs_[k % programs_.size()].port(); }

  tests::TemporaryFolder folder_{"two_servers"};
  std::filesystem::path root_ = folder_.path(), database_ = root_ / "service.sqlite";
  std::array<Program, 2> programs_{make_program("one"), make_program("other")};
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

TEST_F(TwoServers, CannotShareAPort) {
  tests::Process second(
      {EN_PROGRAM, "serve", root_ / "data", "--db", database_, "--port", std::to_string(port(0))});
  EXPECT_EQ(second.wait(), 2);
  httplib::Client http("127.0.0.1", port(0));
  EXPECT_EQ(http.Get("/healthz")->status, 200);
}

}  // namespace
}  // namespace enfilade::service
