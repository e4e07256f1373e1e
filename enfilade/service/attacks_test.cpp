// What people might try, and what they get. docs/threats.md has the table.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <atomic>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/service/server.h"
#include "tests/support/raw_socket.h"
#include "tests/support/served_data.h"
#include "tests/support/worker.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::row_results;
using testing::Served;
using tests::connect_to;
using tests::exchange;
using tests::read_to_end;

std::string percent_encoded(const std::string& text) {
  std::string coded;
  for (const char c : text) coded += fmt::format("%{:02x}", static_cast<unsigned char>(c));
  return coded;
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

// SQLite keeps any bytes as texts, PostgreSQL does not: neither fails, nor takes a part for the
// whole.
TEST(Attacks, CharactersThatAreNoneAreRefusedOrKept) {
  Served served;
  const auto organiser = served.organiser();
  const auto body = testing::collection_body("pilot", "write").dump();
  ASSERT_EQ(
      served.client().Post("/api/v1/collections", organiser, body, "application/json")->status,
      201);
  for (const char* name : {"%ff", "pilot%00", "pilot%00x", "%c0%80", "%ed%a0%80"}) {
    const int status = served.get(std::string("/api/v1/collections/") + name, organiser)->status;
    EXPECT_TRUE(status == 404 || status == 400) << name << status;
  }
  const auto begun = testing::read_answer(served.client().Post(
      "/api/v1/sessions", R"({"split": "val_seen", "episode": "1_0"})", "application/json"));
  const httplib::Headers key{{"Enfilade-Session", begun.at("key").get<std::string>()}};
  const std::string path = "/api/v1/sessions/" + begun.at("session").dump();
  for (const char* call : {R"({"tool": "go_to", "argument": "a\u0000b"})",
                           R"({"tool": "\u0000", "argument": "a"})", R"({"said": "\u0000"})"}) {
    const int status = served.client().Post(path + "/calls", key, call, "application/json")->status;
    EXPECT_TRUE(status == 200 || status == 400 || status == 422) << call << status;
    EXPECT_EQ(served.get(path, key)->status, 200) << call;
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
  const std::string cookie = fmt::format("enfilade_session_{}=' OR '1'='1", served.port());
  EXPECT_EQ(served.get("/api/v1/session", {{"Cookie", cookie}})->body, R"({"role":"stranger"})");
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

TEST(Attacks, WhatIsRefusedBeforeItIsReadHasThemToo) {
  Served served;
  const std::string host = " HTTP/1.1\r\nHost: localhost\r\n";
  for (const std::string& request :
       {"OPTIONS /healthz" + host, "TRACE /" + host, "FOO /" + host, "GET /a%0ab" + host,
        "GET /" + std::string(3000, 'a') + host,
        "POST /api/v1/teams" + host + "Content-Type: multipart/form-data\r\nContent-Length: 0\r\n",
        "POST /api/v1/teams" + host + "Content-Length: -5\r\n",
        "GET /healthz" + host + "Folded: a\r\n b\r\n",
        "POST /api/v1/teams" + host + "Transfer-Encoding: chunked\r\n\r\n-5\r\n",
        std::string("GET /healthz HTTP/1.1\r\n"), std::string("GET /healthz HTTP/1.1\nHost: a\n"),
        std::string("GARBAGE\r\n")}) {
    const std::string answer = exchange(served.port(), {request + "\r\n"}, 10);
    EXPECT_THAT(answer, HasSubstr("HTTP/1.1 4")) << request;
    EXPECT_THAT(answer, HasSubstr("Content-Security-Policy: default-src 'none'")) << request;
    EXPECT_THAT(answer, HasSubstr("X-Content-Type-Options: nosniff")) << request;
  }
}

TEST(Attacks, APartOfAnAnswerIsNeverMoreThanTheAnswer) {
  Served served;
  const std::string whole = served.get("/api/v1/splits")->body;
  for (const char* range : {"bytes=0-200000", "bytes=10-900000", "bytes=99999999-",
                            "bytes=-99999999", "bytes=0-0,0-900000", "bytes=0-9"}) {
    EXPECT_EQ(served.get("/api/v1/splits", {{"Range", range}})->body, whole) << range;
    const auto none = served.get("/nothing", {{"Range", range}});
    EXPECT_EQ(none->status, 404) << range;
    EXPECT_LT(none->body.size(), 100U) << range;
  }
}

std::size_t count_answers(const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find("HTTP/1.1 ", at)) != std::string::npos; ++at) ++count;
  return count;
}

// Behind a proxy that keeps its connection, the second answer would be another client's.
TEST(Attacks, NoRequestHidesInAnother) {
  Served served;
  const std::string hidden =
      "GET /api/v1/phases HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  const std::string size = std::to_string(hidden.size());
  const std::string length = "Content-Length: " + size + "\r\n";
  const std::string host = " HTTP/1.1\r\nHost: localhost\r\n";
  const std::string teams = "POST /api/v1/teams" + host;
  for (const std::string& head :
       {"GET /healthz" + host + length, "HEAD /healthz" + host + length,
        "OPTIONS /healthz" + host + length, "FOO /healthz" + host + length,
        "POST /" + std::string(3000, 'a') + host + length,
        fmt::format("{}Content-Length: 0\r\n{}", teams, length),
        fmt::format("{}{}Transfer-Encoding: chunked\r\n", teams, length),
        fmt::format("{}Content-Length : {}\r\n", teams, size),
        teams + "Transfer-Encoding: x-chunked\r\n", teams + "Content-Length: -1\r\n",
        teams + "Content-Length: +0\r\n",
        teams + "Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n"}) {
    const std::string answers = exchange(served.port(), {head + "\r\n", hidden}, 50);
    EXPECT_LE(count_answers(answers), 1U) << head << answers;
    EXPECT_THAT(answers, Not(HasSubstr("phases"))) << head;
  }
  // No body, and none announced: the next request is one.
  const std::string both =
      exchange(served.port(), {"DELETE /api/v1/session" + host + "\r\n", hidden}, 50);
  EXPECT_EQ(count_answers(both), 2U) << both;
  EXPECT_EQ(
      count_answers(exchange(served.port(), {teams + "Content-Length: 3\r\n\r\n[1]", hidden}, 50)),
      2U);
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
      "POST /api/v1/teams HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: "
      "1000\r\n\r\n"};
  for (int k = 0; k < 20; ++k) pieces.emplace_back("x");
  EXPECT_THAT(exchange(served.port(), pieces, 50), HasSubstr("408"));
}

// A monitor that asks every second must not think that the server is gone.
TEST(Attacks, HealthIsAnsweredBesideHundredsOfHalfSentRequests) {
  Served served;
  const std::string head = "POST /api/v1/teams HTTP/1.1\r\nHost: localhost\r\n";
  for (const std::string& half :
       {std::string("GET /healthz HTTP/1.1\r\nHost: loc"), head + "Content-Length: 50\r\n\r\n{",
        head + "Transfer-Encoding: chunked\r\n\r\n5\r\n{"}) {
    const tests::HalfSent others(served.port(), 600, half);
    double seconds = 0;
    EXPECT_THAT(tests::timed_get(served.port(), "/healthz", seconds), HasSubstr(" 200 OK"));
    EXPECT_LT(seconds, 5) << half;  // others wait for 10 s for a head, and 30 s for a body
  }
}

TEST(Attacks, ABodyThatBreaksOffIsNotTaken) {
  Served served;
  const std::string head =
      "POST /api/v1/teams HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n";
  const std::string body = R"({"name": "A"})";
  const auto cut = [&](const std::string& headers, const std::string& part) {
    const int socket_of = connect_to(served.port());
    const std::string sent = head + headers + "\r\n" + part;
    EXPECT_EQ(::send(socket_of, sent.data(), sent.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(sent.size()));
    ::shutdown(socket_of, SHUT_WR);
    return read_to_end(socket_of);
  };
  const std::string chunk = fmt::format("{:x}\r\n{}\r\n", body.size(), body);
  EXPECT_THAT(cut("Content-Length: 100\r\n", body), Not(HasSubstr(" 201 ")));
  EXPECT_THAT(cut("Transfer-Encoding: chunked\r\n", chunk), Not(HasSubstr(" 201 ")));
  EXPECT_THAT(cut("Transfer-Encoding: chunked\r\n", chunk + "FFFFFFFFFFFFFFFFF\r\n"),
              Not(HasSubstr(" 201 ")));
  const auto made = served.client().Post("/api/v1/teams", body, "application/json");
  EXPECT_EQ(made->status, 201) << made->body;  // the name is still free
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
  const std::string old = create_token(served.config().database, TokenRole::kOrganiser, "old", 1);
  EXPECT_EQ(served.get("/api/v1/submissions", {{"Authorization", "Bearer " + old}})->status, 200);
  now = 10'000'000'000;
  EXPECT_EQ(served.get("/api/v1/submissions", {{"Authorization", "Bearer " + old}})->status, 401);
}

TEST(Attacks, RevokedTokensOpenNothingNorDoTheirSessions) {
  Served served;
  const auto team = served.team("A");
  const auto other = served.team("B");
  const std::string token = team.find("Authorization")->second.substr(7);
  const auto logged_in = served.client().Post(
      "/api/v1/session", nlohmann::json{{"token", token}}.dump(), "application/json");
  const std::string set = logged_in->get_header_value("Set-Cookie");
  const httplib::Headers cookie{{"Cookie", set.substr(0, set.find(';'))}};
  const auto organiser = served.organiser();
  const auto& database = served.config().database;
  const std::string list = "/api/v1/submissions";
  EXPECT_EQ(revoke_tokens(database, TokenRole::kOrganiser, "A"), 0);  // a team of that name
  EXPECT_EQ(served.get(list, team)->status, 200);
  EXPECT_EQ(revoke_tokens(database, TokenRole::kTeam, "a"), 1);
  EXPECT_EQ(served.get(list, team)->status, 401);
  EXPECT_EQ(served.get(list, cookie)->status, 401);
  EXPECT_EQ(served.get(list, other)->status, 200);
  const std::string fresh = create_token(database, TokenRole::kTeam, "A", std::nullopt);
  EXPECT_EQ(served.get(list, {{"Authorization", "Bearer " + fresh}})->status, 200);
  EXPECT_EQ(revoke_tokens(database, TokenRole::kOrganiser, "organiser"), 1);
  EXPECT_EQ(served.get(list, organiser)->status, 401);
  EXPECT_THROW(create_token(database, TokenRole::kTeam, "C", std::nullopt), LookupError);
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
  served.scored(served.organiser(), 1);
  std::string all = taken->body;
  for (const char* target :
       {"/api/v1/splits", "/api/v1/splits/test/episodes", "/api/v1/phases", "/api/v1/submissions",
        "/api/v1/submissions/1", "/api/v1/submissions/1/method", "/api/v1/submissions/1/breakdown",
        "/api/v1/submissions/1/episodes/1_0",
        "/api/v1/leaderboards/test/comparison?first=1&second=1", "/api/v1/leaderboards/test",
        "/api/v1/leaderboards/final", "/api/v1/leaderboards/test?format=csv&all=1", "/secret.json",
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

TEST(Attacks, AnotherSiteCannotLogAVisitorInNorMakeTeams) {
  Served served;
  const auto team = served.team("A");
  const std::string token =
      nlohmann::json{{"token", team.find("Authorization")->second.substr(7)}}.dump();
  const auto log_in = [&](const char* site) {
    return served.client()
        .Post("/api/v1/session", {{"Sec-Fetch-Site", site}}, token, "text/plain")
        ->status;
  };
  EXPECT_EQ(log_in("cross-site"), 403);
  EXPECT_EQ(log_in("same-site"), 403);
  EXPECT_EQ(log_in("same-origin"), 200);
  const auto made = served.client().Post("/api/v1/teams", {{"Sec-Fetch-Site", "cross-site"}},
                                         R"({"name": "B"})", "text/plain");
  EXPECT_EQ(made->status, 403);
}

TEST(Attacks, MeansDoNotTellOneEpisodesError) {
  std::atomic<std::int64_t> now{1'000'000};
  ServerConfig config;
  config.clock = [&now] { return now.load(); };
  Served served(config);
  served.restart_with(R"({"name": "open", "split": "val_seen"},
    {"name": "test", "split": "test", "annotations": "secret.json",
     "ends": "1970-01-20T00:00:00Z"})");
  const auto team = served.team("A");
  const auto organiser = served.organiser();
  auto results = nlohmann::json::parse(row_results(3));
  results[0]["trajectory"].erase(3);  // one of six stops 1 m before its goal
  for (const char* phase : {"open", "test"}) served.submit(team, phase, results.dump());
  const auto error = [&](int id, const httplib::Headers& who) {
    served.scored(organiser, id);
    const std::string target = "/api/v1/submissions/" + std::to_string(id);
    return served.json(target, who).at("means").at("nav_error").at("mean").get<double>();
  };
  EXPECT_DOUBLE_EQ(error(1, team), 1.0 / 6);  // open goals
  EXPECT_DOUBLE_EQ(error(2, organiser), 1.0 / 6);
  EXPECT_FALSE(served.json("/api/v1/submissions/2", team).contains("means"));
  now = 10'000'000;  // the phase has ended
  EXPECT_DOUBLE_EQ(error(2, team), 0.2);
  const auto row = served.json("/api/v1/leaderboards/test").at("rows")[0].at("means");
  EXPECT_DOUBLE_EQ(row.at("nav_error").at("mean").get<double>(), 0.2);
  EXPECT_EQ(row.at("spl").at("mean"),
            std::round(row.at("spl").at("mean").get<double>() * 100) / 100);
}

TEST(Attacks, NamesThatDeceiveAreRefused) {
  ServerConfig config;
  config.most_attempts = 100;
  Served served(config);
  const auto post = [&served](const std::string& body) {
    return served.client().Post("/api/v1/teams", body, "application/json")->status;
  };
  for (const char* name :
       {"", " a", "a\\u0000b", "a\\nb", "a\\u202eb", "a\\u0085", "a\\u200bb", "\\ufeffa",
        "a\\u00adb", "\\u3164", "a\\u00a0b", "a\\u2028", "\\udb40\\udc41a"}) {
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
  EXPECT_EQ(post("{\"name\": \"テスト \u0422\"}"), 201);
}

TEST(Attacks, AFormulaInATeamsNameIsQuotedInTheSheet) {
  Served served;
  const auto team = served.team("=HYPERLINK(1)");
  served.submit(team, "open", row_results(3));
  served.scored(team, 1);
  EXPECT_THAT(served.get("/api/v1/leaderboards/open?format=csv")->body,
              HasSubstr("\"'=HYPERLINK(1)\""));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
