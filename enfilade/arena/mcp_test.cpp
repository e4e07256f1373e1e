#include "enfilade/arena/mcp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "enfilade/arena/rules.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/tasks/results.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"
#include "tests/support/room_world.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using arena::testing::episodes;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class Mcp : public ::testing::Test {
 protected:
  Mcp() : folder_("mcp"), episodes_(episodes(tasks::Task::kR2r, 1)) { start(); }

  void start() {
    server_.reset();  // it has its folder alone
    server_ = std::make_unique<McpServer>(
        std::make_unique<GraphWorld>(episodes_), Sights(),
        McpConfig{.episodes = {0, 1}, .limits = {.steps = 9}, .folder = folder_.path()});
  }
  json send(const json& message) {
    answers_ = server_->handle(message.dump());
    return answers_.empty() ? json() : json::parse(answers_.front());
  }
  json request(const std::string& method, const json& params = json::object()) {
    return send({{"jsonrpc", "2.0"}, {"id", ++id_}, {"method", method}, {"params", params}});
  }
  json call(const std::string& tool, const json& arguments = json::object()) {
    return request("tools/call", {{"name", tool}, {"arguments", arguments}}).at("result");
  }
  std::vector<std::string> tools() {
    std::vector<std::string> names;
    const json listed = request("tools/list").at("result").at("tools");
    for (const json& one : listed) {
      EXPECT_EQ(one.at("inputSchema").at("type"), "object");
      names.push_back(one.at("name").get<std::string>());
    }
    return names;
  }

  tests::TemporaryFolder folder_;
  std::shared_ptr<const tasks::EpisodeSet> episodes_;
  std::unique_ptr<McpServer> server_;
  std::vector<std::string> answers_;
  int id_ = 0;
};

TEST(McpFree, AnAssistantMovesByActions) {
  McpServer server(std::make_unique<FreeWorld>(testing::room(), agents::continuous_setup("r2r-ce")),
                   {}, {.episodes = {0}, .limits = {.steps = 9}});
  const auto call = [&server](const json& params) {
    const json message{{"jsonrpc", "2.0"}, {"id", 1}, {"method", "tools/call"}, {"params", params}};
    return json::parse(server.handle(message.dump()).front()).at("result");
  };
  EXPECT_THAT(call({{"name", "begin"}}).dump(), HasSubstr("Walk east."));
  const json moved =
      call({{"name", "move"}, {"arguments", {{"actions", json::array({"forward", "left"})}}}});
  EXPECT_THAT(moved.dump(), HasSubstr("You did 2 of 2 actions and walked 0.25 m."));
  EXPECT_THAT(call({{"name", "stop"}}).dump(), HasSubstr("The episode is over"));
  EXPECT_EQ(server.done(), 1U);
}

TEST_F(Mcp, AnEpisodeIsWalkedByCallsOfTools) {
  EXPECT_EQ(tools(), std::vector<std::string>{"begin"});
  const json begun = call("begin");
  EXPECT_EQ(begun.at("isError"), false);
  EXPECT_THAT(begun.at("content")[0].at("text").get<std::string>(), HasSubstr("Go to the desk."));
  EXPECT_THAT(begun.at("content")[1].at("text").get<std::string>(),
              HasSubstr("You are at place A"));
  ASSERT_EQ(answers_.size(), 2U);
  EXPECT_EQ(json::parse(answers_[1]).at("method"), "notifications/tools/list_changed");
  EXPECT_EQ(tools(), (std::vector<std::string>{"go_to", "look", "stop"}));
  const json wrong = call("go_to", {{"place", "Z"}});
  EXPECT_EQ(wrong.at("isError"), true);
  EXPECT_EQ(answers_.size(), 1U);
  EXPECT_THAT(wrong.at("content")[0].at("text").get<std::string>(),
              HasSubstr("is not one of B, C"));
  EXPECT_EQ(call("begin").at("isError"), true);
  EXPECT_EQ(call("go_to", {{"place", "C"}}).at("isError"), false);
  EXPECT_EQ(call("stop").at("isError"), false);
  EXPECT_EQ(tools(), std::vector<std::string>{"begin"});
  EXPECT_EQ(server_->done(), 1U);
  // The next one, after a restart.
  start();
  EXPECT_THAT(call("begin").at("content")[0].at("text").get<std::string>(),
              HasSubstr("Walk two steps, 0."));
  call("stop");
  EXPECT_EQ(call("begin").at("isError"), true);
  const auto results =
      tasks::load_results(folder_.path() / "results.json", *episodes_, tasks::Coverage::kPart);
  ASSERT_EQ(results.trajectories.size(), 2U);
  EXPECT_EQ(results.trajectories[0].points.back().viewpoint.value, 1U);
  const std::string transcript = read_file(folder_.path() / "transcripts/1_0.jsonl");
  EXPECT_EQ(std::ranges::count(transcript, '\n'), 6);
}

TEST_F(Mcp, BothRevisionsAreSpoken) {
  const json old = request("initialize", {{"protocolVersion", "2025-06-18"},
                                          {"capabilities", json::object()},
                                          {"clientInfo", {{"name", "c"}, {"version", "1"}}}});
  EXPECT_EQ(old.at("result").at("protocolVersion"), "2025-06-18");
  EXPECT_EQ(
      request("initialize", {{"protocolVersion", "1999-01-01"}}).at("result").at("protocolVersion"),
      "2025-11-25");
  EXPECT_TRUE(send({{"jsonrpc", "2.0"}, {"method", "notifications/initialized"}}).is_null());
  EXPECT_EQ(request("ping").at("result"), json::object());

  const json discovered = request("server/discover").at("result");
  EXPECT_EQ(discovered.at("supportedVersions"), json::array({"2026-07-28"}));
  EXPECT_EQ(discovered.at("resultType"), "complete");
  const json meta{{"io.modelcontextprotocol/protocolVersion", "2026-07-28"},
                  {"io.modelcontextprotocol/clientCapabilities", json::object()}};
  const json listed = request("tools/list", {{"_meta", meta}}).at("result");
  EXPECT_EQ(listed.at("resultType"), "complete");
  EXPECT_EQ(listed.at("ttlMs"), 0);
  request("tools/call", {{"name", "begin"}, {"_meta", meta}});
  EXPECT_EQ(answers_.size(), 1U);
}

TEST_F(Mcp, WhatIsNoRequestGetsAnError) {
  const auto code = [this](const std::string& text) {
    const auto answers = server_->handle(text);
    return answers.empty() ? 0 : json::parse(answers[0]).at("error").at("code").get<int>();
  };
  EXPECT_EQ(code("{"), -32700);
  EXPECT_EQ(code("[]"), -32600);
  EXPECT_EQ(code(R"({"jsonrpc": "1.0", "id": 1, "method": "ping"})"), -32600);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": 3})"), -32600);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": "resources/list"})"), -32601);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": "tools/call"})"), -32602);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {"name": 3}})"),
            -32602);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": "tools/list", "params": [1]})"), -32602);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "method": "no/such/notification"})"), 0);
  EXPECT_EQ(call("stop").at("isError"), true);
  // Whatever arguments are.
  call("begin");
  for (const json& arguments : {json("x"), json(3), json::array({1}), json{{"place", {{"a", 1}}}},
                                json{{"place", nullptr}}, json()}) {
    EXPECT_EQ(call("go_to", arguments).at("isError"), true) << arguments;
  }
}

TEST_F(Mcp, NothingTellsWhereTheGoalIs) {
  std::string all;
  for (const json& one :
       {call("begin"), call("go_to", {{"place", "C"}}), call("look", {{"direction", "left"}})}) {
    all += one.dump();
  }
  for (const char* secret : {"v4", "v1", "grid", "distance_to"})
    EXPECT_THAT(all, Not(HasSubstr(secret)));
}

TEST_F(Mcp, ConfigurationsAreChecked) {
  const auto fault = [this](McpConfig config) {
    config.folder = folder_.path() / "other";
    return tests::refusal<ArgumentError>(
        [&] { McpServer(std::make_unique<GraphWorld>(episodes_), {}, config); });
  };
  EXPECT_THAT(fault({}), HasSubstr("episodes: none"));
  EXPECT_THAT(fault({.episodes = {9}}), HasSubstr("episode: 9; there are 3"));
  EXPECT_THAT(fault({.episodes = {0}, .pictures = Pictures::kStrip}), HasSubstr("pictures"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
