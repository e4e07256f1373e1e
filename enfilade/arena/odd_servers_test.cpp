// Servers as they are: what they refuse, want back, leave empty, and what becomes of the run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/arena/ask.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"
#include "tests/support/run_ends.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using tests::refusal;
namespace fs = std::filesystem;

[[noreturn]] void refuse_with(int status, const json& body) {
  const std::string text = body.is_string() ? body.get<std::string>() : body.dump();
  throw EndpointError(status, "status " + std::to_string(status) + ": " + text, {}, text);
}
json error_of(const std::string& text) {
  return {{"error", {{"message", text}, {"type", "invalid_request_error"}}}};
}

json completion_of(const json& message, const std::string& reason = "stop") {
  return {{"choices", {{{"index", 0}, {"message", message}, {"finish_reason", reason}}}},
          {"usage", {{"prompt_tokens", 10}, {"completion_tokens", 5}}}};
}

/// Earlier answers of the conversation.
std::vector<json> past_answers(const json& request) {
  std::vector<json> past;
  for (const json& one : request["messages"]) {
    if (one["role"] == "assistant") past.push_back(one);
  }
  return past;
}

/// Two steps to the first place that is offered, then stop: by a tool, or in JSON, or as text.
json answer_to(const json& request, std::size_t step) {
  const std::string tool = step < 2 ? "go_to" : "stop";
  json message{{"role", "assistant"}, {"content", nullptr}};
  if (request.contains("tools")) {
    json arguments = json::object();
    for (const json& one : request["tools"]) {
      const json& function = one["function"];
      if (function["name"] != tool || tool == "stop") continue;
      arguments["place"] = function["parameters"]["properties"]["place"]["enum"][0];
    }
    message["tool_calls"] = {{{"id", "c" + std::to_string(step)},
                              {"type", "function"},
                              {"function", {{"name", tool}, {"arguments", arguments.dump()}}}}};
  } else {
    message["content"] = R"({"thought": "t", "tool": "stop", "argument": null})";
    if (!request.contains("response_format")) message["content"] = "I am there.\nAction: stop";
  }
  return message;
}

/// An answer with a call in parts: its argument comes in two, the usage last.
std::string events_of(const json& message) {
  const json& call = message["tool_calls"][0];
  const auto arguments = call["function"]["arguments"].get<std::string>();
  const auto event = [](const json& delta, const json& reason) {
    const json choice{{"index", 0}, {"delta", delta}, {"finish_reason", reason}};
    return "data: " + json{{"choices", json::array({choice})}}.dump() + "\n\n";
  };
  const auto part = [&event](json of_call) {
    of_call["index"] = 0;
    return event({{"tool_calls", json::array({of_call})}}, nullptr);
  };
  json head = call;
  head["function"]["arguments"] = "";
  return event({{"role", "assistant"}, {"content", nullptr}}, nullptr) + part(head) +
         part({{"function", {{"arguments", arguments.substr(0, 1)}}}}) +
         part({{"function", {{"arguments", arguments.substr(1)}}}}) +
         event(json::object(), "tool_calls") +
         "data: {\"choices\":[],\"usage\":{\"prompt_tokens\":10,\"completion_tokens\":5}}\n\n"
         "data: [DONE]\n\n";
}

/// A server by a function of the request and the number of accepted calls.
class Server : public Endpoint {
 public:
  using Answer = std::function<json(const json& request, const RequestOrigin& origin)>;
  explicit Server(Answer answer) : answer_(std::move(answer)) {}
  std::string post(std::string_view body, const RequestOrigin& origin) override {
    const json request = json::parse(body);
    {
      const std::scoped_lock lock(mutex_);
      requests.push_back(request);
    }
    const json made = answer_(request, origin);
    return made.dump();
  }
  std::vector<json> requests;

 private:
  Answer answer_;
  std::mutex mutex_;
};

class OddServers : public ::testing::Test {
 protected:
  OddServers() : folder_("odd_servers"), episodes_(testing::episodes(tasks::Task::kR2r, 3)) {
    which_.resize(episodes_->episodes.size());
    std::iota(which_.begin(), which_.end(), 0U);
    config_.chat.model = "m";
    config_.first_wait = 0.001;
    config_.attempts = 2;
  }

  AskReport run(Endpoint* endpoint, const std::string& name = "run",
                const std::string& cache = "cache", const std::string& prompt = "text") {
    AnswerCache answers(folder_.path() / cache);
    AskReport report = ask(GraphWorld(episodes_), {}, which_, Prompt::named(prompt), config_,
                           endpoint, answers, folder_.path() / name);
    testing::expect_explained(folder_.path() / name, report);
    return report;
  }
  json run_file(const std::string& name = "run") const {
    return json::parse(read_file(folder_.path() / name / "run.json"));
  }
  /// Results, transcripts and settings, by name.
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> all;
    for (const auto& one : fs::recursive_directory_iterator(folder_.path() / name)) {
      if (!one.is_regular_file()) continue;
      all[fs::relative(one.path(), folder_.path() / name).string()] = read_file(one.path());
    }
    return all;
  }
  void expect_replay(const std::string& name = "run") {
    run(nullptr, name + "-again");
    EXPECT_EQ(files(name + "-again"), files(name));
  }

  tests::TemporaryFolder folder_;
  std::shared_ptr<const tasks::EpisodeSet> episodes_;
  std::vector<std::size_t> which_;
  AskConfig config_;
};

// Case 3: reasoning models of OpenAI, and servers that refuse fields that they do not know.
TEST_F(OddServers, ParametersThatAreRefusedAreLeftOutOnce) {
  config_.chat.most_tokens = 500;
  Server server([](const json& request, const RequestOrigin& origin) {
    if (request.contains("temperature"))
      refuse_with(400, error_of("temperature: only 1 is supported"));
    if (request.contains("max_tokens")) {
      refuse_with(400, error_of("max_tokens: use max_completion_tokens"));
    }
    if (request.contains("seed")) {
      refuse_with(422, {{"detail", {{{"loc", {"body", "seed"}}, {"msg", "not permitted"}}}}});
    }
    return completion_of(answer_to(request, origin.calls.size()));
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.done, which_.size());
  EXPECT_EQ(report.answers, Answers::kTools);
  EXPECT_EQ(report.endings.at(Ending::kStopped), which_.size());
  EXPECT_THAT(report.adjusted, ElementsAre("temperature is left out", "seed is left out",
                                           "max_completion_tokens takes the place of max_tokens"));
  EXPECT_EQ(server.requests.size(), report.ledger.answers + 3) << "each is refused once";
  const json kept = run_file();
  EXPECT_EQ(kept.at("temperature"), nullptr);
  EXPECT_EQ(kept.at("seed"), nullptr);
  EXPECT_EQ(kept.at("most_tokens"), 500);
  EXPECT_EQ(kept.at("limit_field"), "max_completion_tokens");
  EXPECT_EQ(kept.at("asked"), (json{{"temperature", 0.0}, {"seed", 1}}));
  expect_replay();
  // The folder knows how the run asks; what is asked for is compared, not what is sent.
  fs::remove(folder_.path() / "run/transcripts/1_0.jsonl");
  EXPECT_EQ(run(&server, "run", "other-cache").done, which_.size());
  EXPECT_FALSE(server.requests.back().contains("temperature"));
  config_.chat.temperature.reset();
  EXPECT_THAT(refusal<InvalidInput>([&] { run(&server); }),
              HasSubstr("$.temperature: 0.0, and null"));
}

TEST_F(OddServers, ParametersAreLeftOutByHand) {
  config_.chat = {.model = "m", .temperature = {}, .seed = {}, .most_tokens = 5};
  config_.chat.extra = R"({"reasoning_effort": "low", "tool_choice": null})";
  config_.limit_field = LimitField::kMaxCompletionTokens;
  Server server([](const json& request, const RequestOrigin& origin) {
    return completion_of(answer_to(request, origin.calls.size()));
  });
  EXPECT_EQ(run(&server).done, which_.size());
  for (const char* name : {"temperature", "seed", "max_tokens", "tool_choice"}) {
    EXPECT_FALSE(server.requests[0].contains(name)) << name;
  }
  EXPECT_EQ(server.requests[0].at("max_completion_tokens"), 5);
  EXPECT_EQ(server.requests[0].at("reasoning_effort"), "low");
  config_.chat.extra = R"({"reasoning_effort": "high"})";
  EXPECT_THAT(refusal<InvalidInput>([&] { run(&server); }), HasSubstr("$.extra"));
  config_.chat.extra = "[";
  EXPECT_THAT(refusal<ArgumentError>([&] { run(&server); }), HasSubstr("extra: no JSON object"));
}

TEST_F(OddServers, TheFormOfAnswersIsFoundStepByStep) {
  Server server([](const json& request, const RequestOrigin& origin) {
    if (request.contains("tools")) refuse_with(500, error_of("tools are not supported"));
    if (request.contains("response_format")) {
      refuse_with(500, {{"error",
                         {{"message",
                           "[{'type': 'literal_error', 'loc': ('body', "
                           "'response_format', 'type')}]"},
                          {"type", "internal_server_error"}}}});
    }
    return completion_of(answer_to(request, origin.calls.size()));
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.answers, Answers::kText);
  EXPECT_EQ(report.done, which_.size());
  EXPECT_EQ(server.requests.size(), which_.size() + 4);
  expect_replay();
  // By hand it stays, as far as JSON without a schema goes.
  config_.answers = Answers::kJson;
  Server plain([](const json& request, const RequestOrigin&) -> json {
    if (request.contains("response_format")) refuse_with(400, error_of("no response_format"));
    return completion_of({{"content", R"({"thought": "t", "tool": "stop", "argument": null})"}});
  });
  EXPECT_EQ(run(&plain, "json", "json-cache").answers, Answers::kJson);
  EXPECT_EQ(run_file("json").at("response_format"), "none");
}

TEST_F(OddServers, AServerThatInsistsOnStreamingIsStreamedFrom) {
  Server server([](const json& request, const RequestOrigin& origin) {
    if (!request.value("stream", false)) refuse_with(400, error_of("stream must be set to true"));
    if (request.contains("stream_options")) refuse_with(422, error_of("unknown: stream_options"));
    return json::parse(join_events(events_of(answer_to(request, origin.calls.size()))));
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.endings.at(Ending::kStopped), which_.size());
  EXPECT_EQ(report.mistakes, 0U);
  EXPECT_THAT(report.adjusted, ElementsAre("responses are streamed"));
  EXPECT_EQ(server.requests.size(), report.ledger.answers + 2) << "each is refused once";
  EXPECT_EQ(report.ledger.answer_tokens, 5 * static_cast<int>(report.ledger.answers));
  EXPECT_EQ(run_file().at("stream"), true);
  EXPECT_EQ(run_file().at("stream_usage"), false);
  expect_replay();
}

TEST_F(OddServers, AnotherRefusalIsToldInTheServersWordsAndKeepsNoRun) {
  Server server([](const json&, const RequestOrigin&) -> json {
    refuse_with(404, error_of("The model m does not exist"));
  });
  EXPECT_THAT(refusal<InvalidInput>([&] { run(&server); }),
              HasSubstr("The model m does not exist"));
  EXPECT_EQ(server.requests.size(), 1U);
  EXPECT_FALSE(fs::exists(folder_.path() / "run/run.json"));
  // The corrected call works in the same folder.
  config_.chat.model = "other";
  Server good([](const json& request, const RequestOrigin& origin) {
    return completion_of(answer_to(request, origin.calls.size()));
  });
  EXPECT_EQ(run(&good).done, which_.size());
}

TEST_F(OddServers, ACorrectedCallIsNoOtherRunBeforeTheFirstTranscript) {
  Server server([](const json& request, const RequestOrigin& origin) {
    if (!origin.calls.empty()) refuse_with(401, error_of("the key has expired"));
    return completion_of(answer_to(request, 0));
  });
  EXPECT_THAT(refusal<InvalidInput>([&] { run(&server); }), HasSubstr("the key has expired"));
  EXPECT_EQ(run_file().at("model"), "m");
  config_.chat.model = "other";
  Server good([](const json& request, const RequestOrigin& origin) {
    return completion_of(answer_to(request, origin.calls.size()));
  });
  EXPECT_EQ(run(&good).done, which_.size());
  EXPECT_EQ(run_file().at("model"), "other");
}

// A limit of answers that is larger than the context, say, is refused in the words of a
// conversation that is too long.
TEST_F(OddServers, ARefusalOfEveryFirstStepIsOfTheSettings) {
  config_.chat.most_tokens = 5000;
  Server server([](const json&, const RequestOrigin&) -> json {
    refuse_with(400, error_of("max_tokens is too large; the maximum context length is 4096"));
  });
  EXPECT_THAT(refusal<InvalidInput>([&] { run(&server); }), HasSubstr("max_tokens is too large"));
  EXPECT_EQ(server.requests.size(), 3U);
  EXPECT_FALSE(fs::exists(folder_.path() / "run/run.json"));
  EXPECT_TRUE(fs::is_empty(folder_.path() / "run/transcripts"));
  // Nothing of it is cached: the server may be the one at fault.
  Server good([](const json& request, const RequestOrigin& origin) {
    return completion_of(answer_to(request, origin.calls.size()));
  });
  EXPECT_EQ(run(&good).endings.at(Ending::kStopped), which_.size());
}

TEST_F(OddServers, AFilteredFirstStepProvesNoForm) {
  Server server([](const json& request, const RequestOrigin& origin) {
    if (origin.episode.ends_with("/1_0")) {
      refuse_with(400, {{"error", {{"code", "content_filter"}, {"message", "was filtered"}}}});
    }
    if (request.contains("temperature")) refuse_with(400, error_of("no temperature"));
    return completion_of(answer_to(request, origin.calls.size()));
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.endings.at(Ending::kRefused), 1U);
  EXPECT_EQ(report.endings.at(Ending::kStopped), which_.size() - 1);
  EXPECT_THAT(report.adjusted, ElementsAre("temperature is left out"));
  expect_replay();
}

// Case 2: the conversation outgrows the window of the model.
TEST_F(OddServers, AConversationThatIsTooLongEndsOneEpisodeOrIsShortened) {
  Server server([](const json& request, const RequestOrigin& origin) {
    if (past_answers(request).size() > 1) {
      refuse_with(400, error_of("the request exceeds the available context size"));
    }
    return completion_of(answer_to(request, origin.calls.size()));
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.done, which_.size());
  EXPECT_EQ(report.endings.at(Ending::kStopped), which_.size());
  EXPECT_EQ(report.shortened, which_.size());
  expect_replay();

  config_.shorten = false;
  const AskReport ended = run(&server, "ended");
  EXPECT_EQ(ended.done, which_.size());
  EXPECT_EQ(ended.endings.at(Ending::kRefused), which_.size());
  ASSERT_EQ(ended.refused.size(), which_.size());
  EXPECT_THAT(ended.refused[0], HasSubstr("context-too-long: the request exceeds the available"));
  EXPECT_EQ(ended.mistakes, 0U);
  EXPECT_THAT(
      read_file(folder_.path() / "ended/transcripts/1_0.jsonl"),
      HasSubstr(R"({"ending":"refused","steps":2,"mistakes":0,"reason":"context-too-long)"));
  expect_replay("ended");
  const std::size_t before = server.requests.size();
  EXPECT_EQ(run(&server, "ended").done, which_.size());
  EXPECT_EQ(server.requests.size(), before) << "the wall is not met again";

  config_.chat.window = 1;
  const AskReport window = run(&server, "window", "window-cache");
  EXPECT_EQ(window.endings.at(Ending::kStopped), which_.size());
  EXPECT_EQ(run_file("window").at("window"), 1);
}

/// Answers what it has not read.
class Deaf : public Endpoint {
 public:
  std::string post(std::string_view, const RequestOrigin&) override {
    ++requests;
    return R"({"choices":[{"message":{"content":"Hm."}}]})";
  }
  int requests = 0;
};

TEST_F(OddServers, AConversationHasALargestSize) {
  const Prompt prompt =
      Prompt::parse("---\n" + std::string(17'000'000, 'a') + "\n---\nGo.\n", "p.txt", "p");
  AnswerCache cache(folder_.path() / "cache");
  Deaf server;
  const AskReport report =
      ask(GraphWorld(episodes_), {}, {0}, prompt, config_, &server, cache, folder_.path() / "run");
  EXPECT_THAT(report.refused,
              ElementsAre("1_0: context-too-long: the conversation has more than 16 MiB"));
  EXPECT_EQ(server.requests, 1) << "the first step, which finds the form";
}

TEST_F(OddServers, AFilterEndsOneEpisodeAndOthersGoOn) {
  Server server([](const json& request, const RequestOrigin& origin) {
    if (origin.episode.ends_with("/1_0")) {
      refuse_with(400, {{"error", {{"code", "content_filter"}, {"message", "was filtered"}}}});
    }
    return completion_of(answer_to(request, origin.calls.size()));
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.done, which_.size());
  EXPECT_EQ(report.endings.at(Ending::kRefused), 1U);
  EXPECT_THAT(report.refused, ElementsAre("1_0: filter: was filtered"));
  expect_replay();
}

TEST_F(OddServers, AnEpisodeWithoutAnAnswerIsLeftAndComesLast) {
  bool broken = true;
  Server server([&broken](const json& request, const RequestOrigin& origin) {
    if (broken && origin.episode.ends_with("/1_0")) refuse_with(500, "out of order");
    return completion_of(answer_to(request, origin.calls.size()));
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.done, which_.size() - 1);
  ASSERT_EQ(report.given_up.size(), 1U);
  EXPECT_THAT(report.given_up[0], HasSubstr("1_0: no answer in 2 attempts"));
  EXPECT_TRUE(fs::exists(folder_.path() / "run/left.json"));
  fs::remove(folder_.path() / "run/transcripts/2_0.jsonl");
  server.requests.clear();
  broken = false;
  EXPECT_EQ(run(&server, "run", "other-cache").done, which_.size());
  EXPECT_FALSE(fs::exists(folder_.path() / "run/left.json"));
  EXPECT_THAT(server.requests.front().dump(), HasSubstr("Walk two steps, 0."));
}

TEST_F(OddServers, AnEpisodeInFlightIsNotLeftIfTheRunEnds) {
  config_.parallel = 2;
  config_.attempts = 6;
  config_.first_wait = 30;
  which_ = {0, 1};
  std::atomic<bool> waits = false;
  Server server([&waits](const json& request, const RequestOrigin& origin) {
    if (origin.episode.ends_with("/1_0")) {
      if (origin.calls.empty()) return completion_of(answer_to(request, 0));
      waits = true;
      refuse_with(503, "busy");
    }
    while (!waits) std::this_thread::yield();
    refuse_with(401, error_of("the key has expired"));
  });
  EXPECT_THAT(refusal<InvalidInput>([&] { run(&server); }), HasSubstr("the key has expired"));
  EXPECT_FALSE(fs::exists(folder_.path() / "run/left.json"));
}

// Case 5: servers that want the reasoning back, and one that refuses what it has sent.
TEST_F(OddServers, AnswersAreSentBackAsTheyCame) {
  Server server([](const json& request, const RequestOrigin& origin) {
    for (const json& one : past_answers(request)) {
      if (!one.contains("reasoning_content")) {
        refuse_with(400, error_of("reasoning_content must be passed back"));
      }
      EXPECT_FALSE(one.contains("refusal"));
      EXPECT_FALSE(one.contains("annotations"));
      EXPECT_EQ(one.at("reasoning"), "");
      EXPECT_EQ(one.at("reasoning_details"), (json{{{"signature", "abc"}}}));
      EXPECT_EQ(one.at("tool_calls")[0].at("extra_content"), "s");
    }
    json message = answer_to(request, origin.calls.size());
    message["reasoning_content"] = "hm";
    message["reasoning"] = "";
    message["reasoning_details"] = {{{"signature", "abc"}}};
    message["refusal"] = nullptr;
    message["annotations"] = json::array();
    message["tool_calls"][0]["extra_content"] = "s";
    return completion_of(message);
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.endings.at(Ending::kStopped), which_.size());
  expect_replay();
  Server strict([](const json& request, const RequestOrigin& origin) {
    for (const json& one : past_answers(request)) {
      if (one.contains("reasoning_content")) {
        refuse_with(422, error_of("Extra inputs: reasoning_content"));
      }
    }
    json message = answer_to(request, origin.calls.size());
    message["reasoning_content"] = "hm";
    return completion_of(message);
  });
  EXPECT_EQ(run(&strict, "strict", "strict-cache").endings.at(Ending::kStopped), which_.size());
}

TEST_F(OddServers, AnEmptyAnswerIsNotSentBackEmpty) {
  Server server([](const json& request, const RequestOrigin& origin) {
    const std::vector<json> past = past_answers(request);
    for (const json& one : past) {
      if (one.contains("tool_calls")) continue;
      if (one.at("content") == "" || one.at("content").empty()) {
        refuse_with(400, error_of("messages: a text must not be empty"));
      }
    }
    if (past.empty()) return completion_of({{"content", ""}});
    if (past.size() == 1) return completion_of({{"content", json::array()}});
    return completion_of(answer_to(request, origin.calls.size()));
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.endings.at(Ending::kStopped), which_.size());
  EXPECT_EQ(report.unanswered.at(AnswerFlaw::kEmpty), 2 * which_.size());
}

// Case 4, and what never was an answer.
TEST_F(OddServers, ReasoningBeforeTheAnswerIsRead) {
  config_.answers = Answers::kJson;
  Server server([](const json&, const RequestOrigin&) {
    return completion_of({{"content",
                           "<think>Draft: {\"tool\": \"look\"}. Better stop.</think>\n"
                           R"({"thought": "t", "tool": "stop", "argument": null})"}});
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.mistakes, 0U);
  EXPECT_EQ(report.endings.at(Ending::kStopped), which_.size());
}

TEST_F(OddServers, WhatNeverAnswersIsNoMistake) {
  config_.limits.mistakes = 2;
  which_ = {0, 1, 2, 3};
  Server server([](const json&, const RequestOrigin& origin) {
    if (origin.episode.ends_with("/1_0")) return completion_of({{"content", ""}});
    if (origin.episode.ends_with("/2_0")) return completion_of({{"content", "We sh"}}, "length");
    if (origin.episode.ends_with("/2_1")) {
      return completion_of({{"content", nullptr}, {"refusal", "I must not."}});
    }
    return completion_of({{"content", "I fly."}});
  });
  const AskReport report = run(&server);
  EXPECT_EQ(report.endings.at(Ending::kMistakes), 1U) << "words that are no call";
  EXPECT_EQ(report.mistakes, 2U);
  EXPECT_THAT(report.refused, ElementsAre("1_0: no-answer: empty", "2_0: no-answer: length",
                                          "2_1: no-answer: refusal"));
  EXPECT_EQ(report.unanswered,
            (std::map<AnswerFlaw, std::size_t>{
                {AnswerFlaw::kEmpty, 2}, {AnswerFlaw::kLength, 2}, {AnswerFlaw::kRefusal, 2}}));
  EXPECT_THAT(read_file(folder_.path() / "run/transcripts/2_0.jsonl"),
              HasSubstr(R"("flaw":"length")"));
}

TEST(HeaderFiles, AreRead) {
  const tests::TemporaryFolder folder("headers");
  const fs::path file = folder.path() / "h.txt";
  write_file_atomically(file, "\xEF\xBB\xBF# ours\r\nX-Team: vln : a\r\n\r\napi-key:secret\n");
  const auto headers = load_headers(file);
  ASSERT_EQ(headers.size(), 2U);
  EXPECT_EQ(headers[0], (std::pair<std::string, std::string>("X-Team", "vln : a")));
  EXPECT_EQ(headers[1].second, "secret");
  for (const char* text : {"secret", "Bearer secret: x"}) {
    write_file_atomically(file, text);
    EXPECT_EQ(refusal<InvalidInput>([&] { load_headers(file); }).find("secret"), std::string::npos);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
