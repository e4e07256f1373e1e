// A server that is killed (SIGKILL) at random moments under load: what it acknowledged is there
// afterwards, once.
#include <gmock/gmock.h>
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <map>
#include <mutex>

#include "enfilade/core/rng.h"
#include "tests/service/program.h"
#include "tests/support/kills.h"
#include "tests/support/served_data.h"
#include "tests/support/worker.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::count_methods;
using testing::make_team;
using testing::Program;
using testing::Worker;
using tests::kills;

constexpr std::size_t kClients = 4;

/// What was acknowledged, or what is there: how often, by a name of the test's.
using Counts = std::map<std::string, int>;

/// What was acknowledged to one client. Any thread.
class Promises {
 public:
  void add(const std::string& name) {
    const std::scoped_lock lock(mutex_);
    ++counts_[name];
  }
  Counts counts() const {
    const std::scoped_lock lock(mutex_);
    return counts_;
  }

 private:
  mutable std::mutex mutex_;
  Counts counts_;
};

/// Each client works until the server is gone.
using Client = std::function<void(int port, std::size_t client, Promises& promises)>;

/// Kills the server at a random moment after each client has a promise, however slow the machine
/// is, and starts it again. \returns what they were promised
Counts crowd_and_kill(Program& program, Rng& rng, const Client& work) {
  std::vector<Promises> taken(kClients);
  std::vector<std::thread> clients;
  for (std::size_t c = 0; c < kClients; ++c) {
    clients.emplace_back([&, c, port = program.port()] { work(port, c, taken[c]); });
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  const auto waits = [&](const Promises& one) { return one.counts().empty(); };
  while (std::ranges::any_of(taken, waits) && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(rng.below(300)));
  program.kill();
  for (std::thread& client : clients) client.join();
  program.start();
  Counts promised;
  for (const Promises& some : taken) promised.merge(some.counts());
  return promised;
}

/// What there is may be more than what was acknowledged (an answer was lost), but nothing twice.
void expect_all_once(const Counts& promised, const Counts& found, int round) {
  for (const auto& [name, times] : promised) {
    EXPECT_TRUE(found.contains(name)) << "round " << round << ": lost " << name;
  }
  for (const auto& [name, times] : found) EXPECT_EQ(times, 1) << "round " << round << ": " << name;
}

class Kill : public ::testing::Test {
 protected:
  Kill() {
    testing::write_served_data(folder_.path());
    write_file_atomically(
        folder_.path() / "phases.json",
        R"({"phases": [{"name": "open", "split": "val_seen", "per_day": 1000}]})");
    program_.start();
  }

  tests::TemporaryFolder folder_{"kill"};
  std::string database_ = testing::new_database(folder_.path() / "service.sqlite");
  Program program_{EN_PROGRAM,
                   folder_.path() / "data",
                   database_,
                   {"--phases", folder_.path() / "phases.json", "--open-registration"}};
  Rng rng_{7};
};

/// Hands in under new names until the server is gone.
void hand_in(int port, const httplib::Headers& team, const std::string& who, Promises& promises) {
  httplib::Client client("127.0.0.1", port);
  client.set_keep_alive(true);
  const std::string results = testing::row_results(2);
  for (int k = 0;; ++k) {
    const std::string method = who + "-" + std::to_string(k);
    const auto answer = client.Post("/api/v1/submissions?phase=open&method=" + method, team,
                                    results, "application/json");
    if (!answer) return;
    if (answer->status == 202) promises.add(method);
  }
}

TEST_F(Kill, SubmissionsThatWereAcknowledgedAreThereOnce) {
  std::size_t acknowledged = 0;
  for (int round = 0; round < kills(); ++round) {
    const httplib::Headers team = make_team(program_.port(), "team " + std::to_string(round));
    const Counts promised =
        crowd_and_kill(program_, rng_, [&team](int port, std::size_t client, Promises& promises) {
          hand_in(port, team, "client" + std::to_string(client), promises);
        });
    acknowledged += promised.size();
    expect_all_once(promised, count_methods(program_.port(), team), round);
  }
  EXPECT_GE(acknowledged, kClients * static_cast<std::size_t>(kills()));
  RecordProperty("acknowledged", static_cast<int>(acknowledged));
}

/// Asks for its health until that is the answer, for a minute.
bool is_soon(int port, int status) {
  httplib::Client client("127.0.0.1", port);
  for (int k = 0; k < 600; ++k) {
    const auto answer = client.Get("/healthz");
    if (answer && answer->status == status) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return false;
}

// The server stays, and its database's server is what ends and comes again.
TEST_F(Kill, SubmissionsAreThereOnceIfTheDatabasesServerEnds) {
  if (!testing::on_postgres()) GTEST_SKIP() << "SQLite has no server";
  for (int round = 0; round < kills(); ++round) {
    const httplib::Headers team = make_team(program_.port(), "team " + std::to_string(round));
    std::vector<Counts> taken(kClients);
    std::vector<std::thread> clients;
    std::atomic<bool> over{false};
    for (std::size_t c = 0; c < kClients; ++c) {
      clients.emplace_back([&, c] {
        httplib::Client client("127.0.0.1", program_.port());
        for (int k = 0; !over; ++k) {
          const std::string method = std::to_string(c) + "-" + std::to_string(k);
          const auto answer = client.Post("/api/v1/submissions?phase=open&method=" + method, team,
                                          testing::row_results(2), "application/json");
          if (answer && answer->status == 202) ++taken[c][method];
          EXPECT_TRUE(answer && (answer->status == 202 || answer->status == 503))
              << (answer ? answer->body : "no answer");
        }
      });
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50 + rng_.below(300)));
    testing::postgres_server().crash();
    EXPECT_TRUE(is_soon(program_.port(), 503));
    testing::postgres_server().start();
    EXPECT_TRUE(is_soon(program_.port(), 200));
    over = true;
    for (std::thread& client : clients) client.join();
    Counts promised;
    for (const Counts& some : taken) promised.insert(some.begin(), some.end());
    EXPECT_FALSE(promised.empty());
    expect_all_once(promised, count_methods(program_.port(), team), round);
  }
}

/// Somebody who walks to and fro by requests, and knows what was acknowledged.
struct Walker {
  std::string path;
  httplib::Headers headers;
  int calls = 0;     ///< that were answered
  json observation;  ///< of the last answer

  /// The next call is settled by how many there were, so that one which is sent again is the same.
  json next() const {
    const json& places = observation.at("places");
    if (calls % 3 == 2) return {{"tool", "look"}, {"argument", "left"}, {"after", calls}};
    const json& place = places.at(static_cast<std::size_t>(calls) % places.size());
    return {{"tool", "go_to"}, {"argument", place.at("name")}, {"after", calls}};
  }
};

Walker begin_walk(int port, const std::string& episode) {
  httplib::Client client("127.0.0.1", port);
  const json wanted{
      {"split", "val_seen"}, {"episode", episode}, {"steps", 1000}, {"mistakes", 1000}};
  const auto answer = client.Post("/api/v1/sessions", wanted.dump(), "application/json");
  const json begun = json::parse(answer->body);
  return {"/api/v1/sessions/" + std::to_string(begun.at("session").get<int>()),
          {{"Enfilade-Session", begun.at("key").get<std::string>()}},
          0,
          begun.at("observation")};
}

/// Walks until the server is gone, or `most` calls were answered.
void walk_on(Walker& walker, int port, int most, Promises& promises) {
  httplib::Client client("127.0.0.1", port);
  client.set_keep_alive(true);
  while (walker.calls < most) {
    const auto answer = client.Post(walker.path + "/calls", walker.headers, walker.next().dump(),
                                    "application/json");
    if (!answer) return;
    ASSERT_EQ(answer->status, 200) << answer->body;
    const json state = json::parse(answer->body);
    ASSERT_EQ(state.at("calls"), walker.calls + 1);
    ++walker.calls;
    promises.add(std::to_string(walker.calls));
    walker.observation = state.at("observation");
  }
}

TEST_F(Kill, SessionsOfTheArenaGoOnWhereTheyWere) {
  constexpr int kMostCalls = 900;
  const int rounds = kills();
  std::vector<Walker> walkers;
  for (std::size_t w = 0; w < kClients; ++w) {
    walkers.push_back(begin_walk(program_.port(), w % 2 == 0 ? "1_0" : "2_0"));
  }
  int lost_answers = 0;
  for (int round = 0; round < rounds; ++round) {
    const int most = kMostCalls * (round + 1) / rounds;
    const Client work = [&](int port, std::size_t client, Promises& promises) {
      walk_on(walkers[client], port, most, promises);
    };
    crowd_and_kill(program_, rng_, work);
    for (Walker& walker : walkers) {
      httplib::Client client("127.0.0.1", program_.port());
      const json state = json::parse(client.Get(walker.path, walker.headers)->body);
      const int kept = state.at("calls").get<int>();
      // One call at most was carried out whose answer was lost; sent again, it would be refused.
      ASSERT_TRUE(kept == walker.calls || kept == walker.calls + 1) << kept << walker.calls;
      if (kept == walker.calls + 1) {
        ++lost_answers;
        EXPECT_EQ(client
                      .Post(walker.path + "/calls", walker.headers, walker.next().dump(),
                            "application/json")
                      ->status,
                  409);
      } else {
        EXPECT_EQ(state.at("observation"), walker.observation);
      }
      walker.calls = kept;
      walker.observation = state.at("observation");
    }
  }
  RecordProperty("lost_answers", lost_answers);
  // Nobody else's calls are in a session: walkers of one episode who made as many calls are where
  // a walker is whom nobody has disturbed.
  for (const Walker& walker : walkers) {
    EXPECT_GE(walker.calls, rounds);
    Walker calm = begin_walk(program_.port(),
                             &walker == walkers.data() || &walker == &walkers[2] ? "1_0" : "2_0");
    Promises calls;
    walk_on(calm, program_.port(), walker.calls, calls);
    EXPECT_EQ(calm.observation, walker.observation);
  }
}

/// Makes a collection of many places. \returns its key
std::string make_collection(int port, const httplib::Headers& organiser, const std::string& name,
                            const std::string& kind) {
  json body = testing::collection_body(name, kind);
  body["sources"] = json::array({{{"split", "val_seen"}}});
  body["per_item"] = 100;
  httplib::Client client("127.0.0.1", port);
  return testing::key_of(testing::read_answer(
      client.Post("/api/v1/collections", organiser, body.dump(), "application/json")));
}

/// Workers who do all that they get, one worker after the other, until the server is gone. \param
/// hand_in does a task and gives its name, or "" if it was not acknowledged
void work_on(int port, const std::string& collection, const std::string& key, std::size_t client,
             const std::function<std::string(Worker&, const json& task)>& hand_in,
             Promises& promises) {
  for (int k = 0;; ++k) {
    const std::string name = "worker " + std::to_string(client) + "-" + std::to_string(k);
    Worker worker(port, collection, {{"key", key}, {"worker", name}});
    if (worker.join().at("status") != 200) return;
    worker.consent();
    for (json task; (task = worker.lease().value("task", json())).is_object();) {
      const std::string done = hand_in(worker, task);
      if (!done.empty()) promises.add(done);
    }
  }
}

/// The name is the instruction.
std::string write_one(Worker& worker, const json& task) {
  const std::string text = "Walk to the door, as task " + task.at("task").dump() + " says";
  return worker.write(task.at("task"), text).at("status") == 200 ? text : "";
}

/// The name is the time of the last step, which is another in each walk.
std::string walk_one(Worker& worker, const json& task) {
  const int start = task.at("start").get<std::string>().at(1) - '0';
  json steps = testing::row_steps(start, start + 1);
  const json number = task.at("task").get<double>();
  steps[1]["seconds"] = number;
  return worker.walk(task.at("task"), steps).at("status") == 200 ? number.dump() : "";
}

/// What was handed in, by the value of a field.
Counts count_work(int port, const httplib::Headers& organiser, const std::string& collection,
                  const char* field) {
  httplib::Client client("127.0.0.1", port);
  Counts found;
  for (std::string after = "0";;) {
    const json page = testing::read_answer(
        client.Get("/api/v1/collections/" + collection + "/work?state=all&limit=200&after=" + after,
                   organiser));
    const json& work = page.at("work");
    if (work.empty()) return found;
    for (const json& one : work) {
      const json& value = one.at(field);
      ++found[value.is_string() ? value.get<std::string>() : value.dump()];
    }
    after = work.back().at("task").dump();
  }
}

TEST_F(Kill, InstructionsAndWalksThatWereAcknowledgedAreThereOnce) {
  const httplib::Headers organiser{
      {"Authorization",
       "Bearer " + create_token(database_, TokenRole::kOrganiser, "o", std::nullopt)}};
  std::size_t written = 0;
  std::size_t walked = 0;
  for (int round = 0; round < kills(); ++round) {
    const std::string write = "write-" + std::to_string(round);
    const std::string walk = "walk-" + std::to_string(round);
    const std::string write_key = make_collection(program_.port(), organiser, write, "write");
    const std::string walk_key = make_collection(program_.port(), organiser, walk, "walk");
    const Client work = [&](int port, std::size_t client, Promises& promises) {
      if (client % 2 == 0) {
        work_on(port, write, write_key, client, write_one, promises);
      } else {
        work_on(port, walk, walk_key, client, walk_one, promises);
      }
    };
    const Counts promised = crowd_and_kill(program_, rng_, work);
    Counts found = count_work(program_.port(), organiser, write, "instruction");
    written += found.size();
    const Counts walks = count_work(program_.port(), organiser, walk, "page_seconds");
    walked += walks.size();
    found.insert(walks.begin(), walks.end());
    expect_all_once(promised, found, round);
  }
  EXPECT_GT(written, 0U);
  EXPECT_GT(walked, 0U);
  RecordProperty("written", static_cast<int>(written));
  RecordProperty("walked", static_cast<int>(walked));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
