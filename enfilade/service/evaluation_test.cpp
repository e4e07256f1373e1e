// Teams, submissions and leaderboards, over real sockets.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/net/server.h"
#include "enfilade/service/client.h"
#include "enfilade/service/server.h"
#include "tests/support/refusal.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::row_results;
using testing::Served;

std::int64_t id_of(const httplib::Result& result) {
  return nlohmann::json::parse(result->body).at("id").get<std::int64_t>();
}

TEST(Evaluation, AGoodFileIsScoredOnSecretGoals) {
  Served served;
  const auto team = served.team("A team");
  const auto taken = served.submit(team, "test", row_results(3));
  ASSERT_EQ(taken->status, 202) << taken->body;
  const auto told = served.scored(team, id_of(taken));
  EXPECT_EQ(told.at("state"), "received");
  EXPECT_FALSE(told.contains("means"));
  const auto status = served.scored(served.organiser(), id_of(taken));
  EXPECT_EQ(status.at("state"), "scored");
  // Each walks the reference path of 3 m to its goal.
  EXPECT_DOUBLE_EQ(status["means"]["success"]["mean"].get<double>(), 1);
  EXPECT_DOUBLE_EQ(status["means"]["trajectory_length"]["mean"].get<double>(), 3);
  EXPECT_DOUBLE_EQ(status["means"]["nav_error"]["mean"].get<double>(), 0);
}

TEST(Evaluation, EveryFaultOfAFileIsShownAndNothingIsKept) {
  Served served;
  const auto team = served.team("A team");
  auto results = nlohmann::json::parse(row_results(2));
  results[0]["trajectory"][0][0] = "v9";
  results[1]["instr_id"] = "7_7";
  const auto refused = served.submit(team, "test", results.dump());
  EXPECT_EQ(refused->status, 422);
  EXPECT_THAT(refused->body, HasSubstr("$[0].trajectory[0]"));
  EXPECT_THAT(refused->body, HasSubstr("7_7"));
  EXPECT_EQ(served.json("/api/v1/submissions", team).at("submissions").size(), 0U);
}

/// The paths of val_seen once more as val_unseen, with ids of its own: 11_0, 11_1, 12_0, ...
/// \param phases after the one of val_seen, which is "open"
void serve_two_splits(Served& served, const std::string& phases) {
  tasks::Annotations annotations = testing::row_annotations("val_unseen", true);
  for (tasks::PathAnnotation& path : annotations.paths) path.path_id += 10;
  write_file_atomically(served.root() / "data/r2r/R2R_val_unseen.json", to_json(annotations));
  served.restart_with(R"({"name": "open", "split": "val_seen"})" + phases);
}

/// row_results() of them. \param faults whether one has no trajectory, and one leaves the graph
std::string unseen_results(std::size_t moves, bool faults = false) {
  auto results = nlohmann::json::parse(row_results(moves));
  for (auto& one : results) one["instr_id"] = "1" + one["instr_id"].get<std::string>();
  if (faults) {
    results[0].erase("trajectory");
    results[4]["trajectory"][0][0] = "v9";
  }
  return results.dump();
}

TEST(Evaluation, AFileOfAnotherSplitHasOneFaultAndThePhaseThatTakesIt) {
  Served served;
  serve_two_splits(served, R"(, {"name": "unseen", "split": "val_unseen"})");
  const auto team = served.team("A");
  for (const bool faults : {false, true}) {
    const auto refused = served.submit(team, "open", unseen_results(3, faults));
    EXPECT_EQ(refused->status, 422);
    const auto error = nlohmann::json::parse(refused->body).at("error");
    EXPECT_EQ(error.at("code"), "invalid-input");
    EXPECT_EQ(error.at("phase"), "unseen");
    ASSERT_EQ(error.at("diagnostics").size(), 1U);
    EXPECT_EQ(error["diagnostics"][0].at("code"), "other-split");
    EXPECT_EQ(error["diagnostics"][0].at("message"),
              "this is a file of val_unseen, and phase open is of val_seen; phase unseen takes it");
  }
  EXPECT_EQ(served.submit(team, "unseen", unseen_results(3))->status, 202);
}

TEST(Evaluation, AFileOfNoOtherSplitHasItsFaultsOneByOne) {
  Served served;
  serve_two_splits(served, R"(, {"name": "unseen", "split": "val_unseen",
                               "ends": "2001-01-01T00:00:00Z"})");
  const auto team = served.team("A");
  auto mixed = nlohmann::json::parse(row_results(3));
  mixed[0]["instr_id"] = "11_0";
  auto unknown = nlohmann::json::parse(row_results(3));
  for (auto& one : unknown) one["instr_id"] = "9" + one["instr_id"].get<std::string>();
  for (const auto& file : {mixed.dump(), unknown.dump(), unseen_results(3)}) {  // that has ended
    const auto refused = served.submit(team, "open", file);
    EXPECT_EQ(refused->status, 422);
    EXPECT_THAT(refused->body, HasSubstr("unknown-instr-id"));
    EXPECT_THAT(refused->body, Not(HasSubstr("other-split")));
    EXPECT_FALSE(nlohmann::json::parse(refused->body)["error"].contains("phase"));
  }
}

// The public file of the split has the same ids, so the answer tells nothing of the goals.
TEST(Evaluation, ThatAFileIsOfASecretSplitDependsOnItsIdsAlone) {
  Served served;
  serve_two_splits(served, "");
  served.restart_with(R"({"name": "unseen", "split": "val_unseen"},
    {"name": "test", "split": "test", "annotations": "secret.json"})");
  const auto team = served.team("A");
  const auto told = [&](const std::string& results) {
    return served.submit(team, "unseen", results)->body;
  };
  const std::string at_the_goals = told(row_results(3));
  EXPECT_EQ(nlohmann::json::parse(at_the_goals).at("error").at("phase"), "test");
  EXPECT_EQ(told(row_results(0)), at_the_goals);
  EXPECT_EQ(told(row_results(2)), at_the_goals);
}

TEST(Evaluation, TheSameFileAgainIsTheSameSubmission) {
  Served served;
  const auto team = served.team("A team");
  const auto first = served.submit(team, "test", row_results(3));
  const auto again = served.submit(team, "test", row_results(3));
  EXPECT_EQ(again->status, 200);
  EXPECT_EQ(id_of(first), id_of(again));
  EXPECT_NE(id_of(first), id_of(served.submit(team, "test", row_results(3), "other")));
}

TEST(Evaluation, AMethodMayHaveLinks) {
  Served served;
  const auto team = served.team("A team");
  const auto taken =
      served.submit(team, "open", row_results(3),
                    "m&paper=https://example.org/p&code=https://example.org/c%3Fx=1");
  ASSERT_EQ(taken->status, 202) << taken->body;
  served.scored(team, id_of(taken));
  const auto row = served.json("/api/v1/leaderboards/open").at("rows").at(0);
  EXPECT_EQ(row.at("paper"), "https://example.org/p");
  EXPECT_EQ(row.at("code"), "https://example.org/c?x=1");
  const auto plain = served.submit(team, "open", row_results(2), "other");
  EXPECT_FALSE(served.scored(team, id_of(plain)).contains("paper"));
}

TEST(Evaluation, LinksThatCouldDoHarmAreRefused) {
  Served served;
  const auto team = served.team("A team");
  for (const char* link : {"http://example.org", "javascript:alert(1)", "https://", "https:///x",
                           "HTTPS://example.org", "https://example.org/%22onclick", "https://a%20b",
                           "https://a%0Ab", "//example.org", "https://%C3%A9.org"}) {
    const auto refused =
        served.submit(team, "open", row_results(3), std::string("m&paper=") + link);
    EXPECT_EQ(refused->status, 422) << link << refused->body;
    EXPECT_THAT(refused->body, HasSubstr("paper: ")) << link;
  }
}

TEST(Evaluation, ALeaderboardHasEachTeamsBest) {
  Served served;
  const auto a = served.team("A");
  const auto b = served.team("B");
  const auto c = served.team("C");
  served.scored(c, id_of(served.submit(c, "open", row_results(0), "stays")));
  served.scored(a, id_of(served.submit(a, "open", row_results(0), "stays too")));
  served.scored(a, id_of(served.submit(a, "open", row_results(1), "one step")));
  served.scored(b, id_of(served.submit(b, "open", row_results(3), "walks")));
  const auto rows = served.json("/api/v1/leaderboards/open").at("rows");
  ASSERT_EQ(rows.size(), 3U);
  // 2 m from the goal is a success, and SPL doesn't punish a short way: equal, so the earlier
  // first.
  EXPECT_EQ(rows[0]["method"], "one step");
  EXPECT_EQ(rows[1]["method"], "walks");
  EXPECT_EQ(rows[2]["method"], "stays");
  EXPECT_EQ(served.json("/api/v1/leaderboards/open?all=1").at("rows").size(), 4U);
  const std::string csv = served.get("/api/v1/leaderboards/open?format=csv")->body;
  EXPECT_THAT(csv, HasSubstr("team,method,created,spl,spl_low,spl_high,success,"));
  EXPECT_THAT(csv, HasSubstr("\"B\",\"walks\","));
}

TEST(Evaluation, AWithdrawnSubmissionLeavesTheLeaderboard) {
  Served served;
  const auto team = served.team("A");
  const auto id = std::to_string(id_of(served.submit(team, "open", row_results(3))));
  served.scored(team, std::stoll(id));
  EXPECT_EQ(served.client().Delete("/api/v1/submissions/" + id, team)->status, 200);
  EXPECT_EQ(served.client().Delete("/api/v1/submissions/" + id, team)->status, 409);
  EXPECT_EQ(served.json("/api/v1/leaderboards/open").at("rows").size(), 0U);
}

TEST(Evaluation, AHistoryComesInPages) {
  Served served;
  const auto team = served.team("A");
  for (int k = 0; k < 3; ++k) {
    served.submit(team, "open", row_results(3), "m" + std::to_string(k));
  }
  const auto all = served.json("/api/v1/submissions", team).at("submissions");
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0]["method"], "m2");
  const auto rest = served.json("/api/v1/submissions?before=2", team).at("submissions");
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_EQ(rest[0]["method"], "m0");
}

TEST(Evaluation, ADayHasItsLimit) {
  std::atomic<std::int64_t> now{1'000'000};
  ServerConfig config;
  config.clock = [&now] { return now.load(); };
  Served served(config);
  const auto team = served.team("A");
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(served.submit(team, "open", row_results(3), "m" + std::to_string(k))->status, 202);
  }
  EXPECT_EQ(served.submit(team, "open", row_results(3), "m5")->status, 429);
  EXPECT_EQ(served.submit(served.team("B"), "open", row_results(3), "m5")->status, 202);
  now += 24 * 3600 + 1;
  EXPECT_EQ(served.submit(team, "open", row_results(3), "m5")->status, 202);
}

TEST(Evaluation, ScoresOfAHiddenPhaseAreTheOrganisers) {
  Served served;
  const auto team = served.team("A");
  const auto id = id_of(served.submit(team, "final", row_results(3)));
  const auto organiser = served.organiser();
  EXPECT_TRUE(served.scored(organiser, id).contains("means"));
  const auto own = served.scored(team, id);
  EXPECT_EQ(own.at("state"), "received");
  EXPECT_EQ(own.at("withheld"), "hidden");
  EXPECT_FALSE(own.contains("means"));
  EXPECT_EQ(served.get("/api/v1/leaderboards/final", team)->status, 403);
  const auto rows = served.json("/api/v1/leaderboards/final", organiser).at("rows");
  EXPECT_EQ(rows.size(), 1U);
}

TEST(Evaluation, WhatWaitsIsScoredAfterARestart) {
  Served served;
  const auto team = served.team("A");
  const auto id = id_of(served.submit(team, "open", row_results(3)));
  served.stop();
  // As a server that was killed before it came to it would leave it.
  testing::run_sql(served.config().database,
                   "UPDATE submission SET state = 'queued', score = NULL");
  served.start();
  EXPECT_EQ(served.scored(team, id).at("state"), "scored");
}

TEST(Evaluation, ScoringGoesOnAfterAFailureOfTheDatabase) {
  std::atomic<int> failures{0};
  ServerConfig config;
  config.log = [&failures](const RequestRecord& record) {
    if (record.method == "SCORE" && record.fault == "the disk is full") ++failures;
  };
  Served served(config);
  const auto team = served.team("A");
  std::optional<testing::FrozenSubmissions> frozen;
  frozen.emplace(served.config().database, "the disk is full");
  const auto id = id_of(served.submit(team, "open", row_results(3)));
  for (int k = 0; k < 1000 && failures == 0; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_GT(failures, 0);
  EXPECT_EQ(served.json("/api/v1/submissions/" + std::to_string(id), team).at("state"), "queued");
  frozen.reset();
  EXPECT_EQ(served.scored(team, id).at("state"), "scored");
}

TEST(Evaluation, TheClientHandsIn) {
  Served served;
  const std::string token = served.team("A").find("Authorization")->second.substr(7);
  const std::string server = "http://127.0.0.1:" + std::to_string(served.port());
  Client client(server, token);
  SubmissionStatus status = client.submit("open", "my method", row_results(3));
  EXPECT_EQ(status.method, "my method");
  for (int k = 0; k < 1000 && status.state == "queued"; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    status = client.status(status.id);
  }
  EXPECT_EQ(status.state, "scored");
  EXPECT_DOUBLE_EQ(status.means.at("success"), 1);
  EXPECT_THROW(client.submit("open", "my method", "[]"), InvalidInput);
  EXPECT_THAT(tests::refusal([&] { client.submit("none", "my method", "[]"); }),
              HasSubstr("status 404: no phase of this name"));
  EXPECT_THAT(tests::refusal([&] { Client(server, "wrong").status(1); }), HasSubstr("401"));
  EXPECT_THAT(tests::refusal([] { Client("http://127.0.0.1:1", "x").status(1); }),
              HasSubstr("cannot be reached"));
}

// 17 MiB are 20 kB of gzip.
TEST(Evaluation, TheClientTakesNoAnswerWithoutAnEnd) {
  net::ServerConfig config;
  config.answer = [](const net::Request& request, const net::BodyReader& /*none*/) {
    net::Response response;
    const std::string text(17U << 20U, ' ');
    const bool packed = request.path.ends_with('2');
    if (packed) response.add_header("Content-Encoding", "gzip");
    response.body = std::make_shared<const std::string>(packed ? gzip(text, 9) : text);
    return response;
  };
  config.refuse = [](const net::HttpError&) { return net::Response(); };
  const net::Server server(config);
  Client client("http://127.0.0.1:" + std::to_string(server.port()), "token");
  for (const int id : {1, 2}) {
    EXPECT_THAT(tests::refusal([&] { client.status(id); }),
                HasSubstr("its answer has more than 16 MiB"));
  }
}

/// Answers one request with a head that has no end.
class EndlessHead {
 public:
  /// \param pause after each piece of it
  EndlessHead(std::string piece, std::chrono::milliseconds pause)
      : piece_(std::move(piece)), pause_(pause) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    auto* any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(::bind(listening_, any, sizeof address), 0);
    EXPECT_EQ(::listen(listening_, 1), 0);
    socklen_t size = sizeof address;
    EXPECT_EQ(::getsockname(listening_, any, &size), 0);
    port_ = ntohs(address.sin_port);
    answering_ = std::jthread([this] { answer(); });
  }
  ~EndlessHead() {
    ::shutdown(client_, SHUT_RDWR);  // it may wait for a client that reads no more
    answering_.join();
    ::close(client_);
    ::close(listening_);
  }
  EndlessHead(const EndlessHead&) = delete;
  EndlessHead& operator=(const EndlessHead&) = delete;

  std::string address() const { return "http://127.0.0.1:" + std::to_string(port_); }

 private:
  void answer() {
    client_ = ::accept(listening_, nullptr, nullptr);
    std::string sent = "HTTP/1.1 200 OK\r\n";
    while (::send(client_, sent.data(), sent.size(), MSG_NOSIGNAL) > 0) {
      std::this_thread::sleep_for(pause_);
      sent = piece_;
    }
  }

  std::string piece_;
  std::chrono::milliseconds pause_;
  int listening_ = ::socket(AF_INET, SOCK_STREAM, 0);
  int port_ = 0;
  std::atomic<int> client_ = -1;
  std::jthread answering_;
};

TEST(Evaluation, TheClientTakesNoHeadWithoutAnEnd) {
  const auto ask = [](const std::string& address, double seconds) {
    return tests::refusal([&] { Client(address, "token", seconds).status(1); });
  };
  const EndlessHead slow("x", std::chrono::milliseconds(100));
  EXPECT_THAT(ask(slow.address(), 1), HasSubstr("its answer took more than 1 s"));
  const EndlessHead large("X: " + std::string(1000, 'x') + "\r\n", {});
  // cpp-httplib 0.18 ends such a head by a limit of its own.
  EXPECT_THAT(ask(large.address(), 60),
              AnyOf(HasSubstr("its answer has more than 16 MiB"),
                    HasSubstr("cannot be reached: Failed to read connection")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
