// What clients say of themselves and of their requests, and what of it is believed.
// docs/threats.md has the table.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <chrono>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/service/server.h"
#include "tests/support/raw_socket.h"
#include "tests/support/secret_phase.h"
#include "tests/support/served_data.h"
#include "tests/support/worker.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::row_results;
using testing::Served;
using tests::exchange;

std::string token_in(const httplib::Headers& headers) {
  return headers.find("Authorization")->second.substr(std::string("Bearer ").size());
}

/// The statuses of so many guesses at a token, each with such headers.
std::set<int> guess(Served& served, int times,
                    const std::function<httplib::Headers(int)>& headers) {
  std::set<int> statuses;
  for (int k = 0; k < times; ++k) {
    httplib::Headers sent = headers(k);
    sent.emplace("Authorization", "Bearer enfilade_" + std::to_string(k));
    statuses.insert(served.get("/api/v1/submissions", sent)->status);
  }
  return statuses;
}

TEST(ClientAttacks, AnAddressOfTheClientsOwnMakingIsNotBelieved) {
  ServerConfig config;
  config.most_attempts = 3;
  const auto made_up = [](int k) { return fmt::format("192.0.2.{}", k); };
  Served bare(config);
  EXPECT_THAT(guess(bare, 5,
                    [&](int k) {
                      return httplib::Headers{{"X-Forwarded-For", made_up(k)}};
                    }),
              ::testing::Contains(429));
  config.behind_proxy = true;
  config.public_names = {"vln.example.org"};
  Served proxied(config);
  // nginx adds what it saw to the client's own list, HAProxy as a line of its own.
  EXPECT_THAT(guess(proxied, 5,
                    [&](int k) {
                      return httplib::Headers{{"X-Forwarded-For", made_up(k) + ", 198.51.100.1"}};
                    }),
              ::testing::Contains(429));
  std::string responses;  // of requests by hand: cpp-httplib need not keep the order of lines
  for (int k = 0; k < 5; ++k) {
    responses += exchange(
        proxied.port(),
        {fmt::format("GET /api/v1/submissions HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                     "X-Forwarded-For: {}\r\nX-Forwarded-For: 198.51.100.2\r\n"
                     "Authorization: Bearer enfilade_{}\r\n\r\n",
                     made_up(k), k)},
        0);
  }
  EXPECT_THAT(responses, HasSubstr("HTTP/1.1 429"));
  EXPECT_THAT(guess(proxied, 3,
                    [](int) {
                      return httplib::Headers{{"X-Forwarded-For", "198.51.100.3"}};
                    }),
              ::testing::ElementsAre(401));  // another client is not held up
}

ServerConfig behind_gateway() {
  ServerConfig config;
  config.behind_proxy = true;
  config.public_names = {"vln.example.org"};
  config.clock = [] { return std::int64_t{1'000'000}; };  // no minute ends meanwhile
  return config;
}

httplib::Headers by_gateway(httplib::Headers headers, const std::string& address, int port) {
  headers.emplace("X-Forwarded-For", fmt::format("{}:{}", address, port));
  return headers;
}

// Gateways write the port of each connection to the address, or what they like.
TEST(ClientAttacks, LimitsHoldBehindEveryProxy) {
  ServerConfig config = behind_gateway();
  config.most_attempts = 3;
  const std::vector<std::function<std::string(int)>> entries{
      [](int k) { return fmt::format("203.0.113.7:{}", 51234 + k); },
      [](int k) { return fmt::format("192.0.2.{}, 203.0.113.8:{}", k, 51234 + k); },
      [](int k) { return fmt::format("[2001:db8::{}]:{}", k, 51234 + k); },
      [](int k) { return fmt::format("2001:db8:1::7:{}", 51234 + k); },
      [](int k) { return fmt::format("\"[2001:db8:2::7]:{}\"", 51234 + k); },
      [](int k) { return fmt::format("unknown{}", k); },
      [](int k) { return fmt::format("203.0.113.7:{0}:{0}", k); },
      [](int k) { return std::string(static_cast<std::size_t>(k), ','); }};
  for (const auto& entry : entries) {
    Served served(config);
    const auto header = [&](int k) { return httplib::Headers{{"X-Forwarded-For", entry(k)}}; };
    EXPECT_THAT(guess(served, 5, header), ::testing::Contains(429)) << entry(1);
  }
}

TEST(ClientAttacks, RequestsOfAnAddressAreCountedForAllItsPorts) {
  ServerConfig config = behind_gateway();
  config.most_attempts = 3;
  config.most_joins = 5;
  Served served(config);
  ASSERT_EQ(served.client()
                .Post("/api/v1/collections", served.organiser(),
                      testing::collection_body("pilot", "write").dump(), "application/json")
                ->status,
            201);
  int host = 0;
  for (const auto& [target, most] : std::vector<std::pair<std::string, int>>{
           {"/api/v1/teams", 3},
           {"/api/v1/session", 3},
           {"/api/v1/collections/pilot/join", 3},  // wrong keys
           {"/api/v1/collections/none/join", 5},
           {"/api/v1/sessions", 5}}) {
    const auto status = [&](int of, int port) {
      const nlohmann::json body{{"name", fmt::format("team {}", port)},
                                {"token", fmt::format("enfilade_{}", port)},
                                {"parameters", {{"key", "wrong"}}}};
      return served.client()
          .Post(target, by_gateway({}, fmt::format("203.0.113.{}", of), port), body.dump(),
                "application/json")
          ->status;
    };
    for (int k = 0; k < most; ++k) EXPECT_NE(status(host, 51234 + k), 429) << target;
    EXPECT_EQ(status(host, 51234 + most), 429) << target;
    EXPECT_NE(status(host + 1, 51234), 429) << target << ", of another client";
    host += 2;
  }
}

TEST(ClientAttacks, SubmissionsOfAnAddressAreCountedForAllItsPorts) {
  Served served(behind_gateway());
  served.restart_with(R"({"name": "open", "split": "val_seen", "per_address": 1})");
  int port = 51234;
  const auto submit = [&](const httplib::Headers& team, const std::string& address,
                          const std::string& results) {
    return served.submit(by_gateway(team, address, port++), "open", results)->status;
  };
  EXPECT_EQ(submit(served.team("A"), "203.0.113.7", row_results(3)), 202);
  EXPECT_EQ(submit(served.team("B"), "203.0.113.7", row_results(3)), 429);
  EXPECT_EQ(submit(served.team("C"), "[2001:db8::7]", row_results(3)), 202);
  EXPECT_EQ(submit(served.team("D"), "[2001:db8::8]", row_results(3)), 429) << "of one home";
  // Files with faults: 20 of a team, 100 from an address.
  for (int team = 0; team < 5; ++team) {
    const auto headers = served.team(fmt::format("team {}", team));
    for (int k = 0; k < 20; ++k) EXPECT_EQ(submit(headers, "203.0.113.8", "[]"), 422);
  }
  const auto last = served.team("last");
  EXPECT_EQ(submit(last, "203.0.113.8", "[]"), 429);
  EXPECT_EQ(submit(last, "203.0.113.9", "[]"), 422);
}

TEST(ClientAttacks, ACookieFromBeforeTheLoginStaysAStrangers) {
  Served served;
  const std::string name = fmt::format("enfilade_session_{}=", served.port());
  const std::string chosen(64, 'a');  // by somebody who put it into the victim's browser
  const httplib::Headers planted{{"Cookie", name + chosen}};
  const auto logged_in = served.client().Post(
      "/api/v1/session", planted, nlohmann::json{{"token", token_in(served.team("A"))}}.dump(),
      "application/json");
  EXPECT_EQ(logged_in->status, 200);
  EXPECT_THAT(logged_in->get_header_value("Set-Cookie"), Not(HasSubstr(chosen)));
  EXPECT_EQ(served.json("/api/v1/session", planted).at("role"), "stranger");
}

TEST(ClientAttacks, OverTlsNothingIsSentWithoutIt) {
  ServerConfig config;
  config.behind_proxy = true;
  config.public_names = {"vln.example.org"};
  Served served(config);
  const std::string body = nlohmann::json{{"token", token_in(served.team("A"))}}.dump();
  // The client's own word for it, then the proxy's. By hand: cpp-httplib need not keep their order.
  const auto log_in = [&](const char* first, const char* second) {
    return exchange(
        served.port(),
        {fmt::format("POST /api/v1/session HTTP/1.1\r\nHost: vln.example.org\r\n"
                     "Connection: close\r\nX-Enfilade: 1\r\nContent-Type: application/json\r\n"
                     "X-Forwarded-Proto: {}\r\nX-Forwarded-Proto: {}\r\n"
                     "Content-Length: {}\r\n\r\n{}",
                     first, second, body.size(), body)},
        0);
  };
  const std::string encrypted = log_in("http", "https");
  EXPECT_THAT(encrypted, HasSubstr("Set-Cookie: "));
  EXPECT_THAT(encrypted, HasSubstr("; Secure"));
  EXPECT_THAT(encrypted, HasSubstr("Strict-Transport-Security: max-age="));
  const std::string open = log_in("https", "http");
  EXPECT_THAT(open, HasSubstr("Set-Cookie: "));
  EXPECT_THAT(open, Not(HasSubstr("Secure")));
  EXPECT_THAT(open, Not(HasSubstr("Strict-Transport-Security")));
  for (const char* name : {"\r\nServer:", "\r\nX-Powered-By:"}) {
    EXPECT_THAT(encrypted, Not(HasSubstr(name)));
  }
}

TEST(ClientAttacks, SecretsOpenNothingInAnotherPlace) {
  Served served;
  const auto team = served.team("A");
  const std::string token = token_in(team);
  const auto logged_in = served.client().Post(
      "/api/v1/session", nlohmann::json{{"token", token}}.dump(), "application/json");
  const std::string set = logged_in->get_header_value("Set-Cookie");
  const std::string cookie = set.substr(0, set.find(';'));
  const std::string name = cookie.substr(0, cookie.find('=') + 1);
  const std::string list = "/api/v1/submissions";
  ASSERT_EQ(served.get(list, {{"Cookie", cookie}})->status, 200);
  EXPECT_EQ(served.get(list, {{"Cookie", name + token}})->status, 401);
  EXPECT_EQ(served.get(list, {{"Authorization", "Bearer " + cookie.substr(name.size())}})->status,
            401);
  // Addresses are kept in histories and logs.
  for (const char* parameter : {"token", "access_token", "authorization", "key"}) {
    EXPECT_EQ(served.get(fmt::format("{}?{}={}", list, parameter, token))->status, 401);
  }
  for (const char* header : {"X-Api-Key", "X-Auth-Token", "Proxy-Authorization", "X-Enfilade"}) {
    EXPECT_EQ(served.get(list, {{header, "Bearer " + token}})->status, 401) << header;
  }
  const httplib::Headers two{{"Authorization", "Bearer " + token},
                             {"Authorization", "Bearer enfilade_0"}};
  EXPECT_EQ(served.get(list, two)->status, 401);
}

TEST(ClientAttacks, FieldsThatAreNotTheClientsToSetAreIgnored) {
  Served served;
  const auto made = served.client().Post(
      "/api/v1/teams",
      R"({"name": "A", "approved": true, "role": "organiser", "id": 77, "token": "enfilade_mine",)"
      R"( "created": "2001-01-01T00:00:00Z"})",
      "application/json");
  const auto team = nlohmann::json::parse(made->body);
  EXPECT_EQ(team.at("approved"), false);
  EXPECT_NE(team.at("id"), 77);
  EXPECT_NE(team.at("token"), "enfilade_mine");
  const httplib::Headers headers{
      {"Authorization", "Bearer " + team.at("token").get<std::string>()}};
  EXPECT_EQ(served.json("/api/v1/session", headers).at("role"), "team");
  EXPECT_EQ(served.submit(headers, "test", row_results(3))->status, 403);
  const std::string approval = fmt::format("/api/v1/teams/{}/approval", team.at("id").get<int>());
  EXPECT_EQ(
      served.client().Put(approval, headers, R"({"approved": true})", "application/json")->status,
      403);
}

TEST(ClientAttacks, NoHeaderMakesAnotherMethodOrAnotherPathOfARequest) {
  Served served;
  const auto team = served.team("A");
  served.submit(team, "open", row_results(3));
  served.scored(team, 1);
  const std::string own = "/api/v1/submissions/1";
  for (const char* name : {"X-HTTP-Method-Override", "X-HTTP-Method", "X-Method-Override"}) {
    httplib::Headers headers = team;
    headers.emplace(name, "DELETE");
    served.get(own, headers);
    served.get(own + "?_method=DELETE", headers);
    served.client().Post(own, headers, "_method=DELETE", "application/x-www-form-urlencoded");
  }
  EXPECT_EQ(served.json(own, team).at("state"), "scored");
  for (const char* name : {"X-Original-URL", "X-Rewrite-URL", "X-Forwarded-Prefix"}) {
    EXPECT_EQ(served.get("/nothing", {{name, "/api/v1/phases"}})->status, 404) << name;
  }
}

TEST(ClientAttacks, AnothersSubmissionLooksLikeOneThatIsNotThere) {
  Served served;
  served.submit(served.team("A"), "open", row_results(3));
  const auto other = served.team("B");
  const auto there = served.get("/api/v1/submissions/1", other);
  const auto not_there = served.get("/api/v1/submissions/99", other);
  EXPECT_EQ(there->status, 404);
  EXPECT_EQ(not_there->status, 404);
  EXPECT_EQ(there->body, not_there->body);
}

TEST(ClientAttacks, ABrowserIsAllowedNothingForAnotherSite) {
  Served served;
  for (const char* method : {"GET", "PUT", "DELETE", "PATCH"}) {
    const httplib::Headers asked{{"Origin", "https://evil.example"},
                                 {"Access-Control-Request-Method", method},
                                 {"Access-Control-Request-Headers", "authorization, x-enfilade"},
                                 {"Access-Control-Request-Private-Network", "true"}};
    const auto answer = served.client().Options("/api/v1/session", asked);
    EXPECT_EQ(answer->status, 405);
    for (const auto& [name, value] : answer->headers) {
      EXPECT_THAT(name, Not(::testing::StartsWith("Access-Control-"))) << value;
    }
  }
}

// A proxy may go by the one, and the server by the other.
TEST(ClientAttacks, ARequestHasOneHost) {
  Served served;
  const auto answer = [&served](const std::string& target, const std::string& hosts) {
    return exchange(served.port(),
                    {"GET " + target + " HTTP/1.1\r\n" + hosts + "Connection: close\r\n\r\n"}, 10);
  };
  const std::string own = "Host: localhost\r\n", evil = "Host: evil.example\r\n";
  EXPECT_THAT(answer("/api/v1/scans", own), HasSubstr(" 200 "));
  for (const std::string& hosts : {own + evil, evil + own, own + own}) {
    EXPECT_THAT(answer("/api/v1/scans", hosts), HasSubstr(" 400 ")) << hosts;
  }
  EXPECT_THAT(answer("/api/v1/scans", "Host: evil.example.\r\n"), HasSubstr(" 421 "));
  EXPECT_THAT(answer("/api/v1/scans", "Host: localhost\tevil.example\r\n"), HasSubstr(" 400 "));
  EXPECT_THAT(answer("http://evil.example/api/v1/scans", own), Not(HasSubstr(" 200 ")));
}

TEST(ClientAttacks, LineBreaksMakeNoHeaders) {
  Served served;
  const auto team = served.team("A");
  const std::string evil = "x%0d%0aSet-Cookie:%20planted=1%0d%0a%0d%0a<script>";
  EXPECT_EQ(served.submit(team, "open", row_results(3), evil)->status, 422);
  for (const std::string& target :
       {"/" + evil, "/api/v1/scans/" + evil, "/api/v1/leaderboards/open?format=" + evil,
        "/api/v1/leaderboards/" + evil, "/api/v1/collections/" + evil,
        "/collect?collection=" + evil}) {
    const auto result = served.get(target);
    EXPECT_FALSE(result->has_header("Set-Cookie")) << target;
    EXPECT_EQ(result->get_header_value_count("Content-Security-Policy"), 1U) << target;
  }
}

TEST(ClientAttacks, PathsInOtherSpellingsClimbNowhere) {
  Served served;
  for (const char* target :
       {"/..%5c..%5csecret.json", "/%252e%252e/secret.json", "/..%252fsecret.json",
        "/%c0%ae%c0%ae/secret.json", "/%e0%80%ae%e0%80%ae/secret.json", "/..;/secret.json",
        "/assets/..;/..;/secret.json", "/assets/%5c..%5c..%5csecret.json", "/./../secret.json",
        "/assets//../../secret.json", "/api/v1/scans/row/viewpoints/v0%2f..%2f..%2fv1/faces/0.jpg",
        "/api/v1/scans/row/viewpoints/v0/faces/0.jpg%00.png", "/file:///etc/passwd"}) {
    const auto result = served.get(target);
    ASSERT_TRUE(result) << target;
    EXPECT_TRUE(result->status == 404 || result->status == 400) << target << result->status;
    EXPECT_THAT(result->body, Not(HasSubstr("path_id"))) << target;
  }
}

TEST(ClientAttacks, WhateverASpreadsheetWouldRunIsQuoted) {
  ServerConfig config;
  Served served(config);
  const std::string starts = "=+-@";
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const auto team = served.team(starts.substr(k, 1) + "SUM(1)");
    served.submit(team, "open", row_results(3));
    served.scored(team, static_cast<std::int64_t>(k) + 1);
  }
  const std::string sheet = served.get("/api/v1/leaderboards/open?format=csv")->body;
  for (const char start : starts) {
    EXPECT_THAT(sheet, HasSubstr(fmt::format("\"'{}SUM(1)\"", start)));
  }
}

// Each is as long as a head may be.
TEST(ClientAttacks, HeadersOfThousandsOfPartsAreAnsweredAtOnce) {
  Served served;
  const auto repeated = [](const std::string& part) {
    std::string text;
    while (text.size() + part.size() < 8000) text += part;
    return text;
  };
  const auto begin = std::chrono::steady_clock::now();
  for (const httplib::Headers& headers :
       {httplib::Headers{{"Cookie", repeated("a=b; ")}},
        httplib::Headers{{"If-None-Match", repeated("\"a\", ")}},
        httplib::Headers{{"Accept-Encoding", repeated("gzip;q=0.1, ")}},
        httplib::Headers{{"Accept", repeated("text/html;q=0.5, ")}},
        httplib::Headers{{"X-Forwarded-For", repeated("10.0.0.1, ")}}}) {
    EXPECT_EQ(served.get("/api/v1/scans", headers)->status, 200);
  }
  EXPECT_EQ(served.get("/api/v1/scans?" + repeated("a=b&").substr(0, 1500))->status, 200);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(3));
}

TEST(ClientAttacks, NoPageIsLargerThanTheLargest) {
  Served served;
  const std::string episodes = "/api/v1/splits/val_seen/episodes?";
  for (const char* query :
       {"limit=501", "limit=0", "limit=-1", "limit=1e9", "limit=99999999999999999999",
        "limit=", "limit=0x10", "offset=-1", "offset=1000000001", "offset=9223372036854775808"}) {
    EXPECT_EQ(served.get(episodes + query)->status, 400) << query;
  }
  EXPECT_EQ(served.json(episodes + "limit=500&offset=1000000000").at("episodes").size(), 0U);
}

// Lengths, tags and compression could tell what bodies do not.
TEST(ClientAttacks, BeforeTheEndHeadersDoNotDependOnTheGoalsEither) {
  std::set<std::string> told;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    testing::Target target(testing::draw_goals(seed), testing::kEnds);
    const auto team = target.served().team("A");
    target.submit(team, {}, "m");
    std::string all;
    for (const char* page :
         {"/api/v1/phases", "/api/v1/submissions/1", "/api/v1/submissions/1/method",
          "/api/v1/submissions/1/breakdown",
          "/api/v1/leaderboards/test/comparison?first=1&second=1", "/api/v1/leaderboards/test",
          "/api/v1/splits/hidden/episodes?limit=500"}) {
      httplib::Headers asked = team;
      asked.emplace("Accept-Encoding", "gzip");
      const auto answer = target.served().get(page, asked);
      for (const auto& [name, value] : answer->headers) all += name + ": " + value + "\n";
    }
    told.insert(all);
  }
  EXPECT_EQ(told.size(), 1U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
