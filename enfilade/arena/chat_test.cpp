#include "enfilade/arena/chat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "enfilade/arena/endpoint.h"
#include "enfilade/arena/world.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"

namespace enfilade::arena {
namespace EN_UNIT {

using arena::testing::episodes;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using tests::refusal;

std::string completion(const json& message) {
  return json{{"choices", {{{"message", message}}}},
              {"usage", {{"prompt_tokens", 120}, {"completion_tokens", 7}}}}
      .dump();
}

json tool_call(const std::string& name, const json& arguments, const std::string& id = "x") {
  return {{"id", id},
          {"type", "function"},
          {"function", {{"name", name}, {"arguments", arguments.dump()}}}};
}

class ChatTest : public ::testing::Test {
 protected:
  GraphWorld world_{episodes()};
  std::unique_ptr<GraphSession> session_ = world_.start_on_graph(0);
  Prompt prompt_ = Prompt::parse(
      "pictures: strip\nkept_pictures: 1\n---\nStart: {{instruction}}\n---\nAt {{here}}. {{told}}",
      "p", "p");

  /// Asks, and takes an answer as the driver does. \returns the request
  json exchange(Chat& chat, const json& message) {
    const auto pictures = order_pictures(*session_, prompt_.pictures(), 64);
    std::vector<std::string> keys;
    for (const auto& one : pictures) keys.push_back(one.key());
    json request = json::parse(chat.ask(session_->observation(), pictures, keys));
    const std::string body = completion(message);
    const ChatAnswer answer = chat.read(body);
    if (answer.reading.call) {
      session_->call(*answer.reading.call);
    } else {
      session_->misread(answer.reading.fault);
    }
    chat.close(body, answer, session_->observation());
    return request;
  }
};

TEST_F(ChatTest, ToolsAreCalledAndToldInTheProtocol) {
  Chat chat(prompt_, {.model = "m", .most_tokens = 50}, {.answers = Answers::kTools}, {});
  const json first = exchange(
      chat,
      {{"content", "East."},
       {"tool_calls",
        {tool_call("go_to", {{"place", "C"}}, "one"), tool_call("stop", json::object(), "two")}}});
  EXPECT_EQ(first.at("model"), "m");
  EXPECT_EQ(first.at("temperature"), 0);
  EXPECT_EQ(first.at("seed"), 1);
  EXPECT_EQ(first.at("max_tokens"), 50);
  EXPECT_EQ(first.at("tool_choice"), "required");
  EXPECT_EQ(first.at("tools")[0].at("function").at("name"), "go_to");
  ASSERT_EQ(first.at("messages").size(), 2U);
  EXPECT_EQ(first.at("messages")[0],
            (json{{"role", "system"}, {"content", "Start: Go to the desk."}}));
  const json content = first.at("messages")[1].at("content");
  EXPECT_EQ(content[0].at("text"), "At A.");
  EXPECT_THAT(content[1].at("image_url").at("url").get<std::string>(),
              HasSubstr("enfilade-picture:strip/grid/v0/"));

  const json second = exchange(chat, {{"content", "No tool."}});
  const json& messages = second.at("messages");
  ASSERT_EQ(messages.size(), 6U);
  EXPECT_EQ(messages[2].at("tool_calls").size(), 2U);
  EXPECT_EQ(
      messages[3],
      (json{{"role", "tool"}, {"tool_call_id", "one"}, {"content", "You went to C, 4.0 m."}}));
  EXPECT_EQ(messages[4].at("content"), "Nothing was done: one call at a time.");
  EXPECT_EQ(messages[5].at("content")[0].at("text"), "At C.");  // it was told by the tool

  const json third = exchange(chat, {{"content", nullptr}, {"tool_calls", json::array()}});
  EXPECT_EQ(third.at("messages").back().at("content")[0].at("text"),
            "At C. Nothing was done: no tool was called.");
  // Pictures of one observation back are sent again, older ones are not.
  EXPECT_TRUE(third.at("messages")[1].at("content").is_string());
  EXPECT_TRUE(third.at("messages")[5].at("content").is_array());
  EXPECT_EQ(session_->mistakes(), 2U);
}

TEST_F(ChatTest, JsonAndTextAreAskedForAndRead) {
  Chat with_json(prompt_, {.model = "m", .seed = std::nullopt}, {.answers = Answers::kJson}, {});
  const json request = exchange(
      with_json, {{"content", R"({"thought": "East.", "tool": "go_to", "argument": "C"})"}});
  EXPECT_EQ(request.at("response_format").at("type"), "json_schema");
  EXPECT_FALSE(request.contains("tools"));
  EXPECT_FALSE(request.contains("seed"));
  EXPECT_EQ(session_->observation().here, "C");
  Chat with_object(prompt_, {.model = "m"},
                   {.answers = Answers::kJson, .json = JsonForm::kObjectOfSchema}, {});
  const json object = exchange(with_object, {{"content", "no JSON"}}).at("response_format");
  EXPECT_EQ(object.at("type"), "json_object");
  EXPECT_TRUE(object.at("schema").at("properties").contains("tool"));
  Chat with_text(prompt_, {.model = "m"}, {.answers = Answers::kText}, {});
  const json plain = exchange(with_text, {{"content", "Back.\nAction: back_to A"}});
  EXPECT_FALSE(plain.contains("response_format"));
  EXPECT_THAT(plain.at("messages")[1].at("content")[0].at("text").get<std::string>(),
              HasSubstr("back_to <place: A>"));
  EXPECT_EQ(session_->observation().here, "A");
}

TEST_F(ChatTest, OfTheLastStepAloneIfThePromptSaysSo) {
  prompt_ = Prompt::parse(
      "memory: last\nanswers: text\n---\nS\n---\n{{#history}}{{call}}: {{told}} {{/history}}", "p",
      "p");
  Chat chat(prompt_, {.model = "m"}, {.answers = Answers::kText}, {});
  exchange(chat, {{"content", "Action: go_to C"}});
  const json second = exchange(chat, {{"content", "Action: stop"}});
  ASSERT_EQ(second.at("messages").size(), 2U);
  EXPECT_THAT(second.at("messages")[1].at("content").get<std::string>(),
              HasSubstr("go_to C: You went to C, 4.0 m."));
}

// Golden: a change of a usual request loses the caches of all earlier runs.
TEST_F(ChatTest, UsualRequestsHaveTheirKeys) {
  Chat chat(prompt_, {.model = "m", .most_tokens = 50}, {}, {});
  const auto key = [&] { return AnswerCache::key_of(chat.ask(session_->observation(), {}, {})); };
  EXPECT_EQ(key(), "87d32c754e4410c24ad1823c38c158dd");
  exchange(chat, {{"content", nullptr},
                  {"refusal", nullptr},
                  {"tool_calls", {tool_call("go_to", {{"place", "C"}}, "one")}}});
  EXPECT_EQ(key(), "29e29fcf436d3a0e9a97458318ab3c35");
}

TEST_F(ChatTest, PartsOfTheContentAreReadAndSentBack) {
  Chat chat(prompt_, {.model = "m"}, {.answers = Answers::kText}, {});
  const json parts{{{"type", "thinking"}, {"thinking", "hm"}, {"signature", "s"}},
                   {{"type", "text"}, {"text", "East.\n"}},
                   {{"type", "text"}, {"text", "Action: go_to C"}}};
  exchange(chat, {{"content", parts}});
  EXPECT_EQ(session_->observation().here, "C");
  const json second = exchange(chat, {{"content", "Action: stop"}});
  EXPECT_EQ(second.at("messages")[2].at("content"), parts);
}

TEST_F(ChatTest, OlderStepsAreLeftOut) {
  Chat chat(prompt_, {.model = "m"}, {}, {});
  for (int k = 0; k < 4; ++k) {
    exchange(chat,
             {{"content", "Turn."}, {"tool_calls", {tool_call("look", {{"direction", "left"}})}}});
  }
  const auto ask = [&] {
    return json::parse(chat.ask(session_->observation(), {}, {})).at("messages").size();
  };
  const auto again = [&] { return json::parse(chat.request()).at("messages"); };
  EXPECT_EQ(ask(), 2U + 4 * 3);
  EXPECT_TRUE(chat.shorten());
  EXPECT_EQ(again().size(), 2U + 2 * 3);
  EXPECT_EQ(chat.left_out(), 2U);
  EXPECT_TRUE(chat.shorten());
  EXPECT_EQ(again()[1].at("role"), "user") << "whole steps are left out";
  EXPECT_TRUE(chat.shorten());
  ASSERT_EQ(again().size(), 2U);
  EXPECT_THAT(again()[1].at("content").dump(), HasSubstr("You")) << "feedback came by the tool";
  EXPECT_FALSE(chat.shorten());
  Chat last(prompt_, {.model = "m", .window = 1}, {.answers = Answers::kText}, {});
  exchange(last, {{"content", "Action: look left"}});
  exchange(last, {{"content", "Action: look left"}});
  EXPECT_EQ(exchange(last, {{"content", "Action: look left"}}).at("messages").size(), 4U);
}

TEST_F(ChatTest, TheSystemsTextMayBeTheUsers) {
  Chat chat(prompt_, {.model = "m"}, {.answers = Answers::kText, .system = false}, {});
  exchange(chat, {{"content", "Action: look left"}});
  const json messages = exchange(chat, {{"content", "Action: stop"}}).at("messages");
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_EQ(messages[0].at("role"), "user");
  EXPECT_THAT(messages[0].at("content")[0].at("text").get<std::string>(),
              HasSubstr("Start: Go to the desk.\n\nAt A."));
}

TEST_F(ChatTest, StreamsAskForTheCountOfTokens) {
  Chat chat(prompt_, {.model = "m"}, {.stream = true}, {});
  const json request = json::parse(chat.ask(session_->observation(), {}, {}));
  EXPECT_EQ(request.at("stream"), true);
  EXPECT_EQ(request.at("stream_options"), (json{{"include_usage", true}}));
}

TEST_F(ChatTest, UsageIsRead) {
  const Chat chat(prompt_, {.model = "m"}, {.answers = Answers::kText}, {});
  const ChatAnswer answer = chat.read(completion({{"content", "Action: stop"}}));
  EXPECT_EQ(answer.prompt_tokens, 120);
  EXPECT_EQ(answer.answer_tokens, 7);
  EXPECT_EQ(
      chat.read(R"({"choices": [{"message": {"content": "x"}}], "usage": null})").prompt_tokens, 0);
}

TEST_F(ChatTest, WhatIsNoCompletionIsAFaultOfTheServer) {
  const Chat chat(prompt_, {.model = "m"}, {.answers = Answers::kTools}, {});
  for (const char* body : {"", "<html>", "[]", "{}", R"({"choices": []})", R"({"choices": [3]})",
                           R"({"choices": [{"text": "x"}]})"}) {
    EXPECT_THAT(refusal<InvalidInput>([&] { chat.read(body); }), HasSubstr("no-chat-completion"))
        << body;
  }
  // A model that writes calls of a wrong form has made a mistake, and no more.
  for (const json& calls : {json("x"), json{3}, json{{{"function", 3}}},
                            json{{{"function", {{"name", 3}}}}}, json{tool_call("go_to", 5)}}) {
    const ChatAnswer answer = chat.read(completion({{"content", ""}, {"tool_calls", calls}}));
    EXPECT_FALSE(answer.reading.call) << calls;
    EXPECT_FALSE(answer.reading.fault.empty()) << calls;
  }
  EXPECT_THAT(refusal<ArgumentError>([&] { Chat(prompt_, {}, {.answers = Answers::kTools}, {}); }),
              HasSubstr("model: empty"));
}

TEST_F(ChatTest, PicturesAreFilledIn) {
  Chat chat(prompt_, {.model = "m"}, {.answers = Answers::kTools}, {});
  const auto pictures = order_pictures(*session_, prompt_.pictures(), 64);
  const std::string request = chat.ask(session_->observation(), pictures, {"a/key"});
  EXPECT_NE(chat.find_picture("a/key"), nullptr);
  EXPECT_EQ(chat.find_picture("another"), nullptr);
  const json filled = json::parse(with_pictures(request, [](std::string_view key) {
    EXPECT_EQ(key, "a/key");
    return std::string("\xff\xd8\x01", 3);
  }));
  EXPECT_EQ(filled.at("messages")[1].at("content")[1].at("image_url").at("url"),
            "data:image/jpeg;base64,/9gB");
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
