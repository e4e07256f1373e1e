#include "enfilade/arena/mcp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "enfilade/arena/world.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/tasks/results.h"
#include "tests/support/grid_world.h"
#include "tests/support/mcp_recording.h"
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
        std::make_unique<GraphWorld>(episodes_), ViewSources(),
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
  /// The schemas of the listed tools' arguments, by name.
  std::map<std::string, json> tools() {
    std::map<std::string, json> schemas;
    const json listed = request("tools/list").at("result").at("tools");
    for (const json& one : listed) {
      EXPECT_EQ(one.at("inputSchema").at("type"), "object");
      schemas[one.at("name").get<std::string>()] = one.at("inputSchema").at("properties");
    }
    return schemas;
  }
  void initialize(const std::string& revision = "2025-11-25") {
    const json begun = request("initialize", {{"protocolVersion", revision}});
    EXPECT_EQ(begun.at("result").at("protocolVersion"), revision);
  }
  static std::string text(const json& result, std::size_t block) {
    return result.at("content").at(block).at("text").get<std::string>();
  }

  tests::TemporaryFolder folder_;
  std::shared_ptr<const tasks::EpisodeSet> episodes_;
  std::unique_ptr<McpServer> server_;
  std::vector<std::string> answers_;
  int id_ = 0;
};

TEST(McpFloor, AnAssistantMovesByActions) {
  McpServer server(testing::room().another(), {}, {.episodes = {0}, .limits = {.steps = 9}});
  const auto call = [&server](const json& params) {
    const json message{{"jsonrpc", "2.0"}, {"id", 1}, {"method", "tools/call"}, {"params", params}};
    return json::parse(server.handle(message.dump()).front()).at("result");
  };
  EXPECT_THAT(call({{"name", "begin"}}).dump(), HasSubstr("Walk east."));
  for (const json& actions :
       {json::array({"forward", "left"}), json("left, right"), json("[\"left\", \"right\"]")}) {
    EXPECT_THAT(call({{"name", "move"}, {"arguments", {{"actions", actions}}}}).dump(),
                HasSubstr("You did 2 of 2 actions"))
        << actions;
  }
  EXPECT_THAT(call({{"name", "stop"}}).dump(), HasSubstr("The episode is over"));
  EXPECT_EQ(server.done(), 1U);
}

TEST_F(Mcp, AMessageHasALargestSize) {
  std::istringstream input(std::string(3U << 20U, ' ') + "\n\nlast");
  std::string line;
  ASSERT_TRUE(McpServer::read_message(input, line));
  EXPECT_EQ(line.size(), McpServer::kMostBytes + 1);
  EXPECT_THAT(server_->handle(line).at(0), HasSubstr("a message of more than 1048576 bytes"));
  ASSERT_TRUE(McpServer::read_message(input, line));
  EXPECT_EQ(line, "");
  ASSERT_TRUE(McpServer::read_message(input, line));
  EXPECT_EQ(line, "last");
  EXPECT_FALSE(McpServer::read_message(input, line));
}

TEST_F(Mcp, AnEpisodeIsWalkedByCallsOfTools) {
  const json begun = call("begin");
  EXPECT_EQ(begun.at("isError"), false);
  EXPECT_THAT(begun.at("content")[0].at("text").get<std::string>(), HasSubstr("Go to the desk."));
  EXPECT_THAT(begun.at("content")[1].at("text").get<std::string>(),
              HasSubstr("You are at place A"));
  ASSERT_EQ(answers_.size(), 2U);
  EXPECT_EQ(json::parse(answers_[1]).at("method"), "notifications/tools/list_changed");
  const json wrong = call("go_to", {{"place", "Z"}});
  EXPECT_EQ(wrong.at("isError"), true);
  EXPECT_EQ(answers_.size(), 1U);
  EXPECT_THAT(wrong.at("content")[0].at("text").get<std::string>(),
              HasSubstr("is not one of B, C"));
  EXPECT_EQ(call("go_to", {{"place", "C"}}).at("isError"), false);
  EXPECT_EQ(call("stop").at("isError"), false);
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
  EXPECT_EQ(std::ranges::count(transcript, '\n'), 5);
}

TEST_F(Mcp, AClientThatListsTheToolsOnceSeesAllOfThem) {
  initialize();
  const auto kept = tools();
  std::vector<std::string> names;
  for (const auto& [name, arguments] : kept) {
    names.push_back(name);
    for (const json& one : arguments) {
      EXPECT_EQ(one.at("type"), "string") << name;
      EXPECT_FALSE(one.contains("enum")) << name;
    }
  }
  EXPECT_EQ(names, (std::vector<std::string>{"back_to", "begin", "go_to", "look", "stop"}));
  EXPECT_THAT(kept.at("look").at("direction").at("description").get<std::string>(),
              HasSubstr("left, right, behind, up, down"));
  // What is possible now stands in the results.
  EXPECT_THAT(
      text(call("begin"), 1),
      HasSubstr("Possible now:\ngo_to place: B, C\nlook direction: left, right, behind, up, "
                "down\nstop"));
  EXPECT_THAT(text(call("go_to", {{"place", "C"}}), 0), HasSubstr("\nback_to place: A\n"));
  EXPECT_EQ(call("back_to", {{"place", "A"}}).at("isError"), false);
  // A client that lists again gets the values.
  const auto now = tools();
  EXPECT_EQ(now.size(), kept.size());
  EXPECT_EQ(now.at("go_to").at("place").at("enum"), json::array({"B", "C"}));
  EXPECT_EQ(now.at("back_to").at("place").at("enum"), json::array({"C"}));
  // The next connection's first list is plain again.
  initialize();
  EXPECT_EQ(tools(), kept);
}

TEST_F(Mcp, EachTaskListsItsTools) {
  const auto names = [](std::unique_ptr<World> world) {
    McpServer server(std::move(world), {}, {.episodes = {0}});
    const json listed = json::parse(
        server.handle(R"({"jsonrpc": "2.0", "id": 1, "method": "tools/list"})").front());
    std::vector<std::string> all;
    for (const json& one : listed.at("result").at("tools"))
      all.push_back(one.at("name").get<std::string>());
    return all;
  };
  const auto on_graph = [&names](tasks::Task task) {
    return names(std::make_unique<GraphWorld>(episodes(task)));
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(on_graph(tasks::Task::kR2rBack),
            (Names{"begin", "go_to", "back_to", "look", "turn_back", "stop"}));
  EXPECT_EQ(on_graph(tasks::Task::kReverie),
            (Names{"begin", "go_to", "back_to", "look", "answer", "stop"}));
  EXPECT_EQ(names(testing::room().another()), (Names{"begin", "move", "stop"}));
}

TEST_F(Mcp, ACallBeforeTheFirstEpisodeBeginsIt) {
  const json first = call("stop");
  EXPECT_EQ(first.at("isError"), true);
  EXPECT_THAT(text(first, 0), HasSubstr("stop was not carried out"));
  EXPECT_THAT(text(first, 1), HasSubstr("Go to the desk."));
  EXPECT_THAT(text(first, 2), HasSubstr("Possible now:"));
  EXPECT_EQ(call("go_to", {{"place", "C"}}).at("isError"), false);
  EXPECT_EQ(call("stop").at("isError"), false);
  // Sent twice, a stop does not end the next episode.
  for (int k = 0; k < 2; ++k) {
    EXPECT_THAT(text(call("stop"), 0), HasSubstr("begin starts the next one"));
  }
  EXPECT_THAT(text(call("fly"), 0), HasSubstr("There is no tool \"fly\""));
  EXPECT_EQ(server_->done(), 1U);
}

TEST_F(Mcp, BeginInAnEpisodeRepeatsItsInstruction) {
  call("begin");
  call("go_to", {{"place", "C"}});
  for (int k = 0; k < 12; ++k) {  // more than the mistakes that end an episode
    const json again = call("begin");
    EXPECT_EQ(again.at("isError"), false);
    EXPECT_EQ(answers_.size(), 1U);
    EXPECT_THAT(text(again, 0), HasSubstr("Go to the desk."));
    EXPECT_THAT(text(again, 1), HasSubstr("You are at place C"));
  }
  EXPECT_EQ(server_->done(), 0U);
}

TEST_F(Mcp, ABatchIsAnsweredByABatch) {
  const auto one = [](int id, const std::string& tool) {
    return json{{"jsonrpc", "2.0"},
                {"id", id},
                {"method", "tools/call"},
                {"params", {{"name", tool}, {"arguments", json::object()}}}};
  };
  const json notification{{"jsonrpc", "2.0"}, {"method", "notifications/initialized"}};
  const json ping{{"jsonrpc", "2.0"}, {"id", "p"}, {"method", "ping"}};
  initialize("2025-03-26");
  const json answered = send(json::array({notification, ping, one(7, "begin"), 3, one(8, "stop")}));
  ASSERT_EQ(answered.size(), 4U);
  EXPECT_EQ(answered[0].at("id"), "p");
  EXPECT_EQ(answered[1].at("id"), 7);
  EXPECT_EQ(answered[2].at("error").at("code"), -32600);
  EXPECT_THAT(text(answered[3].at("result"), 0), HasSubstr("The episode is over"));
  EXPECT_EQ(answers_.size(), 2U);  // one notification for the whole batch
  EXPECT_TRUE(send(json::array({notification})).is_null());
  json handshake{{"jsonrpc", "2.0"}, {"id", 1}, {"method", "initialize"}};
  EXPECT_THAT(send(json::array({handshake}))[0].dump(), HasSubstr("not allowed in a batch"));
  EXPECT_THAT(send(std::vector<json>(65, ping)).dump(), HasSubstr("65 messages; 1 to 64"));
  initialize("2025-06-18");
  EXPECT_THAT(send(json::array({ping})).dump(), HasSubstr("2025-06-18 has no batches"));
}

TEST(McpRecordings, RealClientsGetWhatTheyGot) {
  const auto files = testing::mcp_recordings("stdio");
  EXPECT_GE(files.size(), 3U);
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename().string());
    const auto server = testing::recorded_mcp_server();
    std::vector<json> said, recorded;
    for (const json& line : testing::read_mcp_recording(file)) {
      if (line.contains("server")) recorded.push_back(testing::shape_of(line["server"]));
      if (!line.contains("client")) continue;
      for (const std::string& one : server->handle(line["client"].dump())) {
        said.push_back(testing::shape_of(json::parse(one)));
      }
    }
    EXPECT_GE(recorded.size(), 2U);
    EXPECT_EQ(said, recorded);
  }
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
  // Without a handshake, any list may be the one that is kept.
  EXPECT_EQ(request("tools/list", {{"_meta", meta}}).at("result"), listed);
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
  for (const std::string id : {"null", "true", "1.5", "[]"}) {
    EXPECT_EQ(code(R"({"jsonrpc": "2.0", "method": "ping", "id": )" + id + "}"), -32600) << id;
  }
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": "resources/list"})"), -32601);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": "tools/call"})"), -32602);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {"name": 3}})"),
            -32602);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "method": "tools/list", "params": [1]})"), -32602);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "method": "no/such/notification"})"), 0);
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "result": {}})"), 0);  // this server asked nothing
  EXPECT_EQ(code(R"({"jsonrpc": "2.0", "id": 1, "error": {"code": 1, "message": ""}})"), 0);
  EXPECT_EQ(call("stop").at("isError"), true);
  // Whatever arguments are.
  call("begin");
  for (const json& arguments : {json("x"), json(3), json::array({1}), json{{"place", {{"a", 1}}}},
                                json{{"place", nullptr}}, json()}) {
    EXPECT_EQ(call("go_to", arguments).at("isError"), true) << arguments;
  }
}

TEST_F(Mcp, DeepAndLongMessagesAreRefused) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  std::string keys = R"("a": 0)";
  for (int k = 0; k < 10'000; ++k) keys += R"(, "a": 0)";
  const std::string start = R"({"jsonrpc": "2.0", "method": "tools/call")";
  for (const std::string& message :
       {start + R"(, "id": )" + deep + "}",
        start + R"(, "id": 1, "params": {"name": "x", )" + R"("arguments": )" + deep + "}}",
        start + R"(, "id": 1, "params": {)" + keys + "}}"}) {
    EXPECT_THAT(server_->handle(message),
                ::testing::ElementsAre(HasSubstr("a message of more than")));
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
  EXPECT_THAT(fault({.episodes = {0}, .pictures = PictureKind::kStrip}), HasSubstr("pictures"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
