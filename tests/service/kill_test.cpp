// A server that is killed (SIGKILL) at random moments under load: what it acknowledged is there
// afterwards, once.
#include <gmock/gmock.h>
#include <atomic>
#include <cstdlib>
#include <map>
#include <optional>

#include "enfilade/core/rng.h"
#include "tests/support/process.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace {

constexpr std::size_t kClients = 4;

/// The program `enfilade serve` on the data of served_data.h.
class Program {
 public:
  explicit Program(std::filesystem::path root) : root_(std::move(root)) {}

  void start() {
    const auto port_file = root_ / "out";
    std::filesystem::remove(port_file);  // that of the server before
    const std::vector<std::string> words{EN_PROGRAM,
                                         "serve",
                                         root_ / "data",
                                         "--db",
                                         root_ / "service.sqlite",
                                         "--phases",
                                         root_ / "phases.json",
                                         "--port",
                                         "0",
                                         "--log",
                                         "none"};
    process_.emplace(words, port_file);
    port_ = wait_for_port(port_file);
  }
  void kill() { process_.reset(); }
  int port() const { return port_; }

 private:
  static int wait_for_port(const std::filesystem::path& file) {
    for (int k = 0; k < 2000; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (!std::filesystem::exists(file)) continue;
      const std::string said = read_file(file);
      const std::size_t colon = said.find("127.0.0.1:");
      if (colon != std::string::npos && said.back() == '\n') return std::atoi(&said[colon + 10]);
    }
    ADD_FAILURE() << "the server did not start";
    return 0;
  }

  std::filesystem::path root_;
  std::optional<tests::Process> process_;
  int port_ = 0;
};

/// Makes a team; its headers.
httplib::Headers make_team(int port, const std::string& name) {
  httplib::Client client("127.0.0.1", port);
  const auto made =
      client.Post("/api/v1/teams", nlohmann::json{{"name", name}}.dump(), "application/json");
  const auto answer = nlohmann::json::parse(made->body);
  return {{"Authorization", "Bearer " + answer.at("token").get<std::string>()}};
}

/// Hands in under new names until the server is gone. \returns the names that were acknowledged
std::vector<std::string> hand_in(int port, const httplib::Headers& team, const std::string& who) {
  httplib::Client client("127.0.0.1", port);
  client.set_keep_alive(true);
  const std::string results = testing::row_results(2);
  std::vector<std::string> acknowledged;
  for (int k = 0;; ++k) {
    const std::string method = who + "-" + std::to_string(k);
    const auto answer = client.Post("/api/v1/submissions?phase=open&method=" + method, team,
                                    results, "application/json");
    if (!answer) return acknowledged;
    if (answer->status == 202) acknowledged.push_back(method);
  }
}

std::map<std::string, int> count_methods(int port, const httplib::Headers& team) {
  httplib::Client client("127.0.0.1", port);
  std::map<std::string, int> found;
  for (std::string query;;) {  // a page of 500 at a time
    const auto answer = client.Get("/api/v1/submissions" + query, team);
    const auto list = nlohmann::json::parse(answer->body).at("submissions");
    if (list.empty()) return found;
    for (const auto& one : list) ++found[one.at("method").get<std::string>()];
    query = "?before=" + list.back().at("id").dump();
  }
}

TEST(Kill, WhatWasAcknowledgedIsThereOnce) {
  // ENFILADE_KILLS=50 is the long run; each takes a second or so.
  const char* given = std::getenv("ENFILADE_KILLS");
  const int kills = given == nullptr ? 5 : std::atoi(given);
  const tests::TemporaryFolder folder("kill");
  testing::write_served_data(folder.path());
  write_file_atomically(folder.path() / "phases.json",
                        R"({"phases": [{"name": "open", "split": "val_seen", "per_day": 1000}]})");
  Program program(folder.path());
  program.start();
  Rng rng(7);
  std::size_t acknowledged = 0;
  for (int round = 0; round < kills; ++round) {
    const httplib::Headers team = make_team(program.port(), "team " + std::to_string(round));
    std::vector<std::vector<std::string>> taken(kClients);
    std::vector<std::thread> clients;
    for (std::size_t c = 0; c < kClients; ++c) {
      clients.emplace_back([&, c, port = program.port()] {
        taken[c] = hand_in(port, team, "client" + std::to_string(c));
      });
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50 + rng.below(300)));
    program.kill();
    for (std::thread& client : clients) client.join();
    program.start();
    const auto found = count_methods(program.port(), team);
    for (const auto& methods : taken) {
      acknowledged += methods.size();
      for (const std::string& method : methods) {
        ASSERT_TRUE(found.contains(method)) << "round " << round << ": lost " << method;
      }
    }
    for (const auto& [method, times] : found) ASSERT_EQ(times, 1) << method;
  }
  EXPECT_GT(acknowledged, static_cast<std::size_t>(kills));
  RecordProperty("acknowledged", static_cast<int>(acknowledged));
}

}  // namespace
}  // namespace enfilade::service
