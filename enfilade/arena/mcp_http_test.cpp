// The Model Context Protocol over HTTP: what programs and pages in browsers send, and get.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "enfilade/arena/mcp.h"
#include "enfilade/core/gzip.h"
#include "tests/support/grid_world.h"
#include "tests/support/mcp_recording.h"
#include "tests/support/memory.h"
#include "tests/support/raw_socket.h"

namespace enfilade::arena {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class McpOverHttp : public ::testing::Test {
 protected:
  McpOverHttp()
      : server_(std::make_unique<GraphWorld>(testing::episodes()), {}, {.episodes = {0}}),
        http_(server_, {.port = 0}),
        client_(http_.url().substr(0, http_.url().rfind('/'))) {}

  static std::string message(const std::string& method, const json& params = json::object()) {
    return json{{"jsonrpc", "2.0"}, {"id", 1}, {"method", method}, {"params", params}}.dump();
  }
  httplib::Result post(const std::string& body, const httplib::Headers& headers = {},
                       const std::string& path = "/mcp") {
    return client_.Post(path, headers, body, "application/json");
  }

  int port() const { return std::stoi(http_.url().substr(http_.url().rfind(':') + 1)); }

  McpServer server_;
  McpHttp http_;
  httplib::Client client_;
};

TEST_F(McpOverHttp, DeepMessagesAreRefused) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  const auto answered = post(R"({"jsonrpc": "2.0", "id": 1, "method": )" + deep + "}");
  ASSERT_TRUE(answered);
  EXPECT_THAT(answered->body, HasSubstr("more than 64 levels"));
}

TEST_F(McpOverHttp, ABodyIsUnpackedWithinItsLimits) {
  std::string bomb;  // 700 MB of blanks
  const std::string part = gzip(std::string(10'000'000, ' '), 9);
  for (int k = 0; k < 70; ++k) bomb += part;
  const httplib::Headers packed{{"Content-Encoding", "gzip"}};
  const std::size_t before = tests::memory("VmHWM:");
  for (const std::string& body : {bomb, gzip(std::string(2U << 20U, ' '), 1), part}) {
    const auto answered = post(body, packed);
    ASSERT_TRUE(answered);
    EXPECT_EQ(answered->status, 413);
  }
  EXPECT_EQ(post(std::string((1U << 20U) + 1, ' '))->status, 413);
  EXPECT_LT(tests::memory("VmHWM:"), before + (100U << 20U));
  EXPECT_EQ(post(gzip(message("ping"), 9), packed)->status, 200);
  EXPECT_EQ(post(message("ping"), {{"Content-Encoding", "br"}})->status, 415);
}

// Nothing of the body has been sent when the response is there.
TEST_F(McpOverHttp, APageOfAnotherSiteIsRefusedBeforeItsBodyIsRead) {
  for (const char* header :
       {"Host: localhost\r\nOrigin: https://example.org\r\n", "Host: example.org\r\n"}) {
    const auto answered = tests::exchange(
        port(),
        {std::string("POST /mcp HTTP/1.1\r\n") + header +
         "Connection: close\r\nContent-Encoding: gzip\r\nContent-Length: 700000\r\n\r\n"},
        0);
    EXPECT_THAT(answered, StartsWith("HTTP/1.1 403 Forbidden\r\n")) << header;
  }
}

TEST_F(McpOverHttp, WhatIsNoHttpIsRefusedAtOnce) {
  const std::string head = "POST /mcp HTTP/1.1\r\n", host = "Host: localhost\r\n";
  for (const std::string& text :
       {head + "\r\n", head + host + host + "\r\n", head + host + "A: b\r\n c\r\n\r\n",
        std::string("POST /mcp HTTP/1.1\nHost: localhost\n\n"),
        head + host + "Content-Length: -1\r\n\r\n",
        head + host + "Transfer-Encoding: chunked\r\n\r\n-5\r\n"}) {
    EXPECT_THAT(tests::exchange(port(), {text}, 0), StartsWith("HTTP/1.1 400")) << text;
  }
}

TEST_F(McpOverHttp, HalfSentRequestsDoNotKeepOthersWaiting) {
  const std::string head = "POST /mcp HTTP/1.1\r\nHost: localhost\r\n";
  for (const std::string& half :
       {std::string("POST /mcp HTTP/1.1\r\n"), head + "Content-Length: 50\r\n\r\n{",
        head + "Transfer-Encoding: chunked\r\n\r\n5\r\n{"}) {
    const tests::HalfSent others(port(), 600, half);
    double seconds = 0;
    EXPECT_THAT(tests::timed_get(port(), "/mcp", seconds), StartsWith("HTTP/1.1 405"));
    EXPECT_LT(seconds, 5) << half;  // about 10 if they did
  }
}

TEST_F(McpOverHttp, APageOfThisMachineMayCall) {
  const std::string page = "http://localhost:6274";
  const httplib::Headers headers{
      {"Origin", page},
      {"Access-Control-Request-Method", "POST"},
      {"Access-Control-Request-Headers", "content-type,mcp-protocol-version,mcp-session-id"}};
  for (const char* path : {"/mcp", "/mcp/"}) {
    const auto asked = client_.Options(path, headers);
    ASSERT_TRUE(asked);
    EXPECT_EQ(asked->status, 204);
    EXPECT_EQ(asked->get_header_value("Access-Control-Allow-Origin"), page);
    EXPECT_EQ(asked->get_header_value("Access-Control-Allow-Headers"),
              "content-type,mcp-protocol-version,mcp-session-id");
    EXPECT_THAT(asked->get_header_value("Access-Control-Allow-Methods"), HasSubstr("POST"));
    EXPECT_EQ(asked->get_header_value("Vary"), "Origin");
  }
  // Without a list the protocol's headers are allowed; and what is no list is not repeated.
  for (const char* list : {"", "*", "a\tb"}) {
    const auto asked =
        client_.Options("/mcp", {{"Origin", page}, {"Access-Control-Request-Headers", list}});
    EXPECT_THAT(asked->get_header_value("Access-Control-Allow-Headers"),
                HasSubstr("Mcp-Session-Id"));
  }
  const auto begun = post(message("initialize"), {{"Origin", page}}, "/mcp/");
  ASSERT_TRUE(begun);
  EXPECT_EQ(begun->status, 200);
  EXPECT_EQ(begun->get_header_value("Access-Control-Allow-Origin"), page);
  EXPECT_EQ(begun->get_header_value("Access-Control-Expose-Headers"), "Mcp-Session-Id");
  EXPECT_FALSE(begun->get_header_value("Mcp-Session-Id").empty());
  // Refusals too can be read by the page.
  const auto gone = post(message("ping"), {{"Origin", page}, {"Mcp-Session-Id", "another"}});
  EXPECT_EQ(gone->status, 404);
  EXPECT_EQ(gone->get_header_value("Access-Control-Allow-Origin"), page);
  const auto listened = client_.Get("/mcp", {{"Origin", page}});
  EXPECT_EQ(listened->status, 405);
  EXPECT_EQ(listened->get_header_value("Access-Control-Allow-Origin"), page);
}

TEST_F(McpOverHttp, PagesOfOtherSitesMayNot) {
  for (const char* page : {"https://example.org", "http://localhost.example.org", "null",
                           "http://localhost@example.org", "http://127.0.0.1.example.org:6274"}) {
    const auto asked = client_.Options("/mcp", {{"Origin", page}});
    EXPECT_EQ(asked->status, 403) << page;
    EXPECT_FALSE(asked->has_header("Access-Control-Allow-Origin")) << page;
    const auto called = post(message("ping"), {{"Origin", page}});
    EXPECT_EQ(called->status, 403) << page;
    EXPECT_FALSE(called->has_header("Access-Control-Allow-Origin")) << page;
  }
  EXPECT_EQ(client_.Options("/mcp", {{"Host", "example.org"}})->status, 403);
}

TEST_F(McpOverHttp, AProgramThatIsNoPageGetsNoSuchHeaders) {
  const auto asked = client_.Options("/mcp");
  EXPECT_EQ(asked->status, 204);
  EXPECT_FALSE(asked->has_header("Access-Control-Allow-Origin"));
  EXPECT_FALSE(post(message("ping"))->has_header("Access-Control-Allow-Origin"));
}

TEST_F(McpOverHttp, EventsAreForClientsThatAcceptThem) {
  const std::string begin = message("tools/call", {{"name", "begin"}});
  const auto events = post(begin, {{"Accept", "application/json, text/event-stream"}});
  EXPECT_EQ(events->get_header_value("Content-Type"), "text/event-stream");
  EXPECT_THAT(events->body, StartsWith("event: message\ndata: "));
  EXPECT_THAT(events->body, HasSubstr("list_changed"));
  const auto plain =
      post(message("tools/call", {{"name", "look"}, {"arguments", {{"direction", "left"}}}}),
           {{"Accept", "application/json"}});
  EXPECT_EQ(plain->get_header_value("Content-Type"), "application/json");
  EXPECT_EQ(json::parse(plain->body).at("result").at("isError"), false);
}

/// The messages of a body: JSON, or a stream of events.
std::vector<json> messages_of(const httplib::Response& response) {
  if (response.body.empty()) return {};
  if (!response.get_header_value("Content-Type").starts_with("text/event-stream")) {
    return {testing::shape_of(json::parse(response.body))};
  }
  std::vector<json> messages;
  std::istringstream lines(response.body);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("data: ")) {
      messages.push_back(testing::shape_of(json::parse(line.substr(6))));
    }
  }
  return messages;
}

TEST(McpRecordings, RealClientsGetWhatTheyGotOverHttp) {
  const auto files = testing::mcp_recordings("http");
  EXPECT_GE(files.size(), 3U);
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename().string());
    const auto server = testing::recorded_mcp_server();
    const McpHttp http(*server, {.port = 0});
    httplib::Client client(http.url().substr(0, http.url().rfind('/')));
    std::map<std::string, std::string> sessions;  // the recorded ones, and those of this test
    for (const json& line : testing::read_mcp_recording(file)) {
      if (!line.contains("request")) continue;
      const json& asked = line["request"];
      const json& recorded = line["response"];
      httplib::Request request;
      request.method = asked["method"].get<std::string>();
      request.path = asked["path"].get<std::string>();
      if (!asked["body"].is_null()) request.body = asked["body"].dump();
      for (const auto& [name, value] : asked["headers"].items()) {
        const auto text = value.get<std::string>();
        request.set_header(name, sessions.contains(text) ? sessions[text] : text);
      }
      const auto response = client.send(request);
      ASSERT_TRUE(response) << line;
      EXPECT_EQ(response->status, recorded["status"]) << line;
      for (const auto& [name, value] : recorded["headers"].items()) {
        if (name != "mcp-session-id") {
          EXPECT_EQ(response->get_header_value(name), value.get<std::string>()) << line;
        } else {
          sessions[value.get<std::string>()] = response->get_header_value(name);
        }
      }
      std::vector<json> messages;
      for (const json& one : recorded["messages"]) messages.push_back(testing::shape_of(one));
      EXPECT_EQ(messages_of(*response), messages) << line;
    }
  }
}

TEST_F(McpOverHttp, BatchesAreOfTheRevisionThatHasThem) {
  const auto begin = [this](const std::string& revision) {
    return post(message("initialize", {{"protocolVersion", revision}}))
        ->get_header_value("Mcp-Session-Id");
  };
  const std::string batch = "[" + message("ping") + "," + message("tools/list") + "]";
  const auto answered = post(batch, {{"Mcp-Session-Id", begin("2025-03-26")}});
  EXPECT_EQ(json::parse(answered->body).size(), 2U);
  const std::string quiet = R"([{"jsonrpc": "2.0", "method": "notifications/initialized"}])";
  EXPECT_EQ(post(quiet)->status, 202);
  const auto refused = post(batch, {{"Mcp-Session-Id", begin("2025-11-25")}});
  EXPECT_EQ(json::parse(refused->body).at("error").at("code"), -32600);
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
