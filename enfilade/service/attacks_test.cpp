// What people might try, and what they get. docs/service.md has the table.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <atomic>

#include "enfilade/service/server.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::row_results;
using testing::Served;

std::string percent_encoded(const std::string& text) {
  std::string coded;
  for (const char c : text) coded += fmt::format("%{:02x}", static_cast<unsigned char>(c));
  return coded;
}

/// Sends bytes as they are, and gives what came back until the server closed.
std::string exchange(int port, const std::vector<std::string>& pieces, int pause_ms) {
  const int socket_of = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(socket_of, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  for (const std::string& piece : pieces) {
    if (::send(socket_of, piece.data(), piece.size(), MSG_NOSIGNAL) < 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
  }
  std::string answer;
  char buffer[4096];
  for (ssize_t n; (n = ::recv(socket_of, buffer, sizeof buffer, 0)) > 0;) {
    answer.append(buffer, static_cast<std::size_t>(n));
  }
  ::close(socket_of);
  return answer;
}

TEST(Attacks, PathsThatClimbFindNothing) {
  Served served;
  for (const char* target :
       {"/../secret.json", "/..%2fsecret.json", "/%2e%2e/secret.json",
        "/api/v1/scans/..%2f..%2fsecret", "/api/v1/scans/%2e%2e/viewpoints/v0/faces/0.jpg",
        "/api/v1/scans/row/viewpoints/..%2f..%2f..%2fsecret/faces/0.jpg",
        "/api/v1/scans/row/viewpoints/v0/faces/..%2f0.jpg", "/assets/../../secret.json",
        "/api/v1/scans/row%00/plan.svg", "/service.sqlite", "//etc/passwd",
        "/api/v1/splits/..%2f..%2fsecret/episodes"}) {
    const auto result = served.get(target);
    ASSERT_TRUE(result) << target;
    EXPECT_TRUE(result->status == 404 || result->status == 400) << target << result->status;
    EXPECT_THAT(result->body, Not(HasSubstr(served.root().string()))) << target;
  }
}

TEST(Attacks, SqlInAnyFieldIsText) {
  Served served;
  const std::string evil = "x'); DROP TABLE team; --";
  const auto team = served.team(evil);
  const std::string coded = percent_encoded(evil);
  served.submit(team, "open", row_results(3), coded);
  EXPECT_EQ(served.submit(team, coded, row_results(3))->status, 404);
  EXPECT_EQ(served.get("/api/v1/scans/" + coded)->status, 404);
  EXPECT_EQ(served.get("/api/v1/submissions/1%20OR%201=1", team)->status, 404);
  EXPECT_EQ(served.get("/api/v1/session", {{"Cookie", "enfilade_session=' OR '1'='1"}})->body,
            R"({"role":"stranger"})");
  const auto list = served.json("/api/v1/submissions", team).at("submissions");
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["team"], evil);
  EXPECT_EQ(list[0]["method"], evil);
}

TEST(Attacks, ScriptsComeBackAsTextOfATypeThatRunsNothing) {
  Served served;
  const auto team = served.team("<script>alert(1)</script>");
  served.submit(team, "open", row_results(3), "%3Cimg%20src=x%3E");
  for (const char* target : {"/api/v1/submissions", "/api/v1/splits/val_seen/episodes"}) {
    const auto result = served.get(target, team);
    EXPECT_EQ(result->get_header_value("Content-Type"), "application/json") << target;
    EXPECT_EQ(result->get_header_value("X-Content-Type-Options"), "nosniff") << target;
  }
}

TEST(Attacks, EveryAnswerHasTheHeadersThatProtectBrowsers) {
  Served served;
  for (const char* target : {"/", "/healthz", "/nothing", "/api/v1/scans/row/plan.svg",
                             "/api/v1/scans/row/viewpoints/v0/faces/0.jpg"}) {
    const auto result = served.get(target);
    for (const char* name :
         {"Content-Security-Policy", "X-Content-Type-Options", "X-Frame-Options", "Referrer-Policy",
          "Cross-Origin-Resource-Policy", "Permissions-Policy", "Cache-Control"}) {
      EXPECT_EQ(result->get_header_value_count(name), 1U) << target << " " << name;
    }
    EXPECT_THAT(result->get_header_value("Content-Security-Policy"),
                HasSubstr("default-src 'none'"));
    EXPECT_FALSE(result->has_header("Access-Control-Allow-Origin"));
  }
}

TEST(Attacks, BodiesThatAreTooLargeAreRefused) {
  ServerConfig config;
  config.most_submission_bytes = 100'000;
  Served served(config);
  const auto team = served.team("A");
  const auto huge = served.submit(team, "open", std::string(200'000, ' '));
  EXPECT_TRUE(!huge || huge->status == 413);
  const auto large = served.client().Post("/api/v1/teams", std::string(50'000, ' '), "text/plain");
  EXPECT_EQ(large->status, 413);
  EXPECT_EQ(served.get("/healthz")->status, 200);
}

TEST(Attacks, ABodyThatDripsIsCutOff) {
  ServerConfig config;
  config.body_seconds = 0.3;
  Served served(config);
  std::vector<std::string> pieces{
      "POST /api/v1/teams HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Length: "
      "1000\r\n\r\n"};
  for (int k = 0; k < 20; ++k) pieces.emplace_back("x");
  EXPECT_THAT(exchange(served.port(), pieces, 50), HasSubstr("408"));
}

TEST(Attacks, WhatIsNoHttpIsRefused) {
  Served served;
  for (const std::string line :
       {"\r\n\r\n", "GARBAGE\r\n\r\n", "GET / HTTP/9.9\r\n\r\n", "\x16\x03\x01\x02\r\n\r\n"}) {
    EXPECT_THAT(exchange(served.port(), {line}, 10), Not(HasSubstr("200 OK")));
  }
  EXPECT_EQ(served.get("/" + std::string(3000, 'a'))->status, 414);
  EXPECT_EQ(served.get("/healthz")->status, 200);
}

TEST(Attacks, ForgedExpiredAndForeignTokensOpenNothing) {
  std::atomic<std::int64_t> now{1'000'000};
  ServerConfig config;
  config.clock = [&now] { return now.load(); };
  Served served(config);
  const auto a = served.team("A");
  const auto b = served.team("B");
  const auto taken = served.submit(a, "open", row_results(3));
  const std::string own = "/api/v1/submissions/1";
  EXPECT_EQ(served.get(own)->status, 401);
  EXPECT_EQ(served.get(own, {{"Authorization", "Bearer enfilade_0000"}})->status, 401);
  EXPECT_EQ(served.get(own, {{"Authorization", "Basic QTpB"}})->status, 401);
  EXPECT_EQ(served.get(own, b)->status, 404);
  EXPECT_EQ(served.client().Delete(own, b)->status, 404);
  EXPECT_EQ(served.submit(served.organiser(), "open", row_results(3))->status, 403);
  // Tokens of the command line go by the system's clock.
  const std::string old =
      create_staff_token(served.config().database, StaffRole::kOrganiser, "old", 1);
  EXPECT_EQ(served.get("/api/v1/submissions", {{"Authorization", "Bearer " + old}})->status, 200);
  now = 10'000'000'000;
  EXPECT_EQ(served.get("/api/v1/submissions", {{"Authorization", "Bearer " + old}})->status, 401);
}

TEST(Attacks, GuessingTokensIsSlowedDown) {
  std::atomic<std::int64_t> now{1'000'000};
  ServerConfig config;
  config.clock = [&now] { return now.load(); };
  config.most_attempts = 3;
  Served served(config);
  const auto guess = [&served] {
    return served.client()
        .Post("/api/v1/session", R"({"token": "enfilade_1"})", "application/json")
        ->status;
  };
  for (int k = 0; k < 3; ++k) EXPECT_EQ(guess(), 401);
  EXPECT_EQ(guess(), 429);
  EXPECT_EQ(served.get("/healthz", {{"Authorization", "Bearer enfilade_2"}})->status, 429);
  now += 60;
  EXPECT_EQ(guess(), 401);
}

TEST(Attacks, AnotherSiteCannotUseTheCookie) {
  Served served;
  const auto team = served.team("A");
  const std::string token = team.find("Authorization")->second.substr(7);
  const auto logged_in = served.client().Post(
      "/api/v1/session", nlohmann::json{{"token", token}}.dump(), "application/json");
  const std::string set = logged_in->get_header_value("Set-Cookie");
  EXPECT_THAT(set, HasSubstr("HttpOnly"));
  EXPECT_THAT(set, HasSubstr("SameSite=Strict"));
  const std::string cookie = set.substr(0, set.find(';'));
  EXPECT_EQ(served.submit({{"Cookie", cookie}}, "open", row_results(3))->status, 403);
  EXPECT_EQ(
      served.submit({{"Cookie", cookie}, {"X-Enfilade", "1"}}, "open", row_results(3))->status,
      202);
  EXPECT_EQ(
      served.client().Delete("/api/v1/session", {{"Cookie", cookie}, {"X-Enfilade", "1"}})->status,
      200);
  EXPECT_EQ(served.get("/api/v1/session", {{"Cookie", cookie}})->body, R"({"role":"stranger"})");
}

TEST(Attacks, NoAnswerHasASecretGoal) {
  Served served;
  const auto team = served.team("A");
  auto results = nlohmann::json::parse(row_results(1));
  const auto taken = served.submit(team, "test", results.dump());
  served.scored(team, 1);
  std::string all = taken->body;
  for (const char* target :
       {"/api/v1/splits", "/api/v1/splits/test/episodes", "/api/v1/phases", "/api/v1/submissions",
        "/api/v1/submissions/1", "/api/v1/leaderboards/test", "/api/v1/leaderboards/final",
        "/api/v1/leaderboards/test?format=csv&all=1", "/secret.json",
        "/api/v1/splits/secret/episodes"}) {
    all += served.get(target, team)->body;
  }
  results[0]["trajectory"].push_back({"v5", 0, 0});  // a jump: the complaint must not help
  all += served.submit(team, "test", results.dump(), "other")->body;
  EXPECT_THAT(all, Not(HasSubstr("\"path\":")));
  EXPECT_THAT(all, Not(HasSubstr("per_episode")));
  EXPECT_THAT(all, Not(HasSubstr("\"v3\"")));  // the goal of path 1
  EXPECT_THAT(all, Not(HasSubstr("\"v4\"")));
}

TEST(Attacks, NamesThatDeceiveAreRefused) {
  Served served;
  const auto post = [&served](const std::string& body) {
    return served.client().Post("/api/v1/teams", body, "application/json")->status;
  };
  for (const char* name : {"", " a", "a\\u0000b", "a\\nb", "a\\u202eb", "a\\u0085"}) {
    EXPECT_EQ(post(std::string("{\"name\": \"") + name + "\"}"), 422) << name;
  }
  EXPECT_EQ(post("{\"name\": \"" + std::string(81, 'a') + "\"}"), 422);
  EXPECT_EQ(post("{\"name\": \"a\xff\"}"), 400);
  EXPECT_EQ(post("{\"name\": 3}"), 400);
  EXPECT_EQ(post("[]"), 400);
  EXPECT_EQ(post("{\"name\": \"Équipe 1\"}"), 201);
  EXPECT_EQ(post("{\"name\": \"équipe 1\"}"), 201);  // SQLite folds ASCII only
  EXPECT_EQ(post("{\"name\": \"A\"}"), 201);
  EXPECT_EQ(post("{\"name\": \"a\"}"), 409);
}

TEST(Attacks, AFormulaInATeamsNameIsQuotedInTheSheet) {
  Served served;
  const auto team = served.team("=HYPERLINK(1)");
  served.submit(team, "open", row_results(3));
  served.scored(team, 1);
  EXPECT_THAT(served.get("/api/v1/leaderboards/open?format=csv")->body,
              HasSubstr("\"'=HYPERLINK(1)\""));
}

}  // namespace
}  // namespace enfilade::service
