// `enfilade ask` as people call it: what its options send, what it prints, and the proxy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "enfilade/core/file.h"
#include "tests/arena/evil_server.h"
#include "tests/arena/listener.h"
#include "tests/support/process.h"
#include "tests/support/served_data.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string completion(const json& message, const std::string& reason = "stop") {
  return json{{"choices", {{{"index", 0}, {"message", message}, {"finish_reason", reason}}}},
              {"usage", {{"prompt_tokens", 10}, {"completion_tokens", 5}}}}
      .dump();
}

/// A step to the first place that is offered, then stop.
std::string step_after(const httplib::Request& request) {
  const bool stops = !request.get_header_value("X-Enfilade-Calls").empty();
  const json function{{"name", stops ? "stop" : "go_to"},
                      {"arguments", stops ? "{}" : R"({"place": "B"})"}};
  const json call{{"id", "c"}, {"type", "function"}, {"function", function}};
  return completion({{"content", nullptr}, {"tool_calls", json::array({call})}});
}

class AskProgram : public ::testing::Test {
 protected:
  AskProgram() : folder_("ask_program") { service::testing::write_served_data(folder_.path()); }

  std::string file(const std::string& name) const { return folder_.path() / name; }
  /// Its exit status.
  int ask(const std::vector<std::string>& options,
          const std::map<std::string, std::string>& environment) {
    std::vector<std::string> words{EN_PROGRAM, "ask",     "--data", file("data"), "--split",
                                   "val_seen", "--model", "m",      "-o",         file("run")};
    words.insert(words.end(), options.begin(), options.end());
    Process process(words, file("said"), environment, file("errors"));
    const int status = process.wait();
    memory_ = process.most_memory();
    return status;
  }

  TemporaryFolder folder_;
  std::size_t memory_ = 0;  // bytes that the last one took
};

// Case 3 by hand, and case 1: a model that does not answer is no model that walks badly.
TEST_F(AskProgram, SendsWhatOptionsSayAndCountsResponsesWithoutACall) {
  Listener server;
  server.answer = [asked = std::map<std::string, int>()](const httplib::Request& request) mutable {
    switch (asked[request.get_header_value("X-Enfilade-Episode")]++) {
      case 0:
        return completion({{"content", ""}});
      case 1:
        return completion({{"content", "We sh"}}, "length");
      case 2:
        return completion({{"content", ""}}, "content_filter");
      default:
        return step_after(request);
    }
  };
  write_file_atomically(file("headers"), "X-Team: vln lab\n");
  const int status = ask({"--endpoint", server.url(), "--temperature", "none", "--seed", "none",
                          "--limit-field", "max_completion_tokens", "--answer-tokens", "50",
                          "--extra", R"({"reasoning_effort": "low"})", "--window", "1",
                          "--key-header", "api-key", "--headers", file("headers")},
                         {{"ENFILADE_MODEL_KEY", "sk-secret1"}});
  ASSERT_EQ(status, 0) << read_file(file("errors"));
  const std::vector<httplib::Request> requests = server.requests();
  // Five for each of six episodes, of which two have the same texts, and so the same responses.
  EXPECT_EQ(requests.size(), 25U);
  for (const httplib::Request& one : requests) {
    EXPECT_EQ(one.get_header_value("api-key"), "sk-secret1");
    EXPECT_EQ(one.get_header_value("X-Team"), "vln lab");
    EXPECT_FALSE(one.has_header("Authorization"));
    const json body = json::parse(one.body);
    for (const char* name : {"temperature", "seed", "max_tokens"}) {
      EXPECT_FALSE(body.contains(name)) << name;
    }
    EXPECT_EQ(body.at("max_completion_tokens"), 50);
    EXPECT_EQ(body.at("reasoning_effort"), "low");
    std::size_t past = 0;
    for (const json& message : body.at("messages")) past += message["role"] == "assistant" ? 1 : 0;
    EXPECT_LE(past, 1U) << "--window";
  }
  EXPECT_THAT(
      read_file(file("said")),
      HasSubstr("6 of 6 episodes are done, 6 stopped; 0 calls could not be carried out\n"
                "18 of the answers had no call: 6 empty, 6 cut off at the limit of tokens "
                "(--answer-tokens), 6 taken away by a filter\n"
                "6 episodes: older steps were left out (--window, and what the model's context "
                "holds)\n"
                "requests differ from the usual ones: max_completion_tokens takes the place of "
                "max_tokens\n"));
}

// What takes the most memory of evil_servers_test, in a process of its own.
TEST_F(AskProgram, NoAnswerTakesALotOfMemoryOrEndsTheProgram) {
  const std::string answers[] = {
      response(stop_answer(R"("sk-secret1 )" + std::string(30U << 20U, 'a') + '"')),
      response(stop_answer("null", 120'000)),
      response(R"({"choices":[{})" + repeated(",{\"a\":[{}]}", 31'000) + "]}"),
  };
  for (const std::string& answer : answers) {
    EvilServer server([&answer](const Connection& to) { to.send(answer); });
    EXPECT_EQ(ask({"--endpoint", server.url(), "--attempts", "2", "--longest-wait", "0"},
                  {{"ENFILADE_MODEL_KEY", "sk-secret1"}}),
              1)
        << read_file(file("errors"));
    EXPECT_THAT(read_file(file("errors")), HasSubstr("no answer in 2 attempts"));
    EXPECT_THAT(read_file(file("errors")), HasSubstr("(left for the next run)"));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    EXPECT_LT(memory_, 300U << 20U);
#endif
  }
}

TEST_F(AskProgram, SaysAloudThatItWaits) {
  EvilServer server([](const Connection& to) {
    to.send(response("{}", "503 Busy", "Retry-After: 99999999\r\n"));
  });
  EXPECT_EQ(ask({"--endpoint", server.url(), "--attempts", "2", "--longest-wait", "0.01"}, {}), 1);
  EXPECT_THAT(read_file(file("errors")),
              HasSubstr("the server asks for a wait of 99999999 s; the next attempt is in 0.01 s"));
}

TEST_F(AskProgram, WritesWhatTheRunCost) {
  Listener server;
  server.answer = step_after;
  write_file_atomically(file("prices"), R"({"m": {"prompt": 100000, "answer": 0}})");
  const auto usage = [this] { return json::parse(read_file(file("run/usage.json"))); };
  ASSERT_EQ(ask({"--endpoint", server.url(), "--prices", file("prices")}, {}), 0)
      << read_file(file("errors"));
  const json first = usage();
  const auto answers = first.at("answers").get<double>();
  EXPECT_GT(answers, 0);
  EXPECT_EQ(first.at("prompt_tokens"), 10 * answers);
  EXPECT_EQ(first.at("answer_tokens"), 5 * answers);
  EXPECT_EQ(first.at("requests"), answers);
  EXPECT_GT(first.at("seconds").get<double>(), 0);
  EXPECT_DOUBLE_EQ(first.at("money").get<double>(), answers);  // 10 tokens of a tenth
  ASSERT_EQ(ask({"--replay"}, {}), 0) << read_file(file("errors"));
  json again = usage();
  EXPECT_FALSE(again.contains("money")) << "no prices were given";
  again["money"] = first.at("money");
  EXPECT_EQ(again, first) << "the cache has the time of each answer";
}

TEST_F(AskProgram, ReadsEveryFileBeforeItAsks) {
  Listener server;
  struct Row {
    const char* prices;
    int status;
    const char* says;
  };
  const Row rows[] = {{R"({"m": {"prompt": -1e308, "answer": 1}})", 3, "not a number of 0 or more"},
                      {R"({"m": {"prompt": 1, "answer": 1)", 3, "bad-price"},
                      {R"({"other": {"prompt": 1, "answer": 1}})", 2, "has no \"m\""}};
  for (const Row& row : rows) {
    write_file_atomically(file("prices"), row.prices);
    EXPECT_EQ(ask({"--endpoint", server.url(), "--prices", file("prices")}, {}), row.status);
    EXPECT_THAT(read_file(file("errors")), HasSubstr(row.says));
  }
  write_file_atomically(file("prices"), std::string(300'000, '['));
  EXPECT_EQ(ask({"--endpoint", server.url(), "--prices", file("prices")}, {}), 3);
  write_file_atomically(file("p.txt"), "---\nGo.\n---\n{{> /etc/passwd}}\n");
  EXPECT_EQ(ask({"--endpoint", server.url(), "--prompt", file("p.txt")}, {}), 3);
  EXPECT_TRUE(server.requests().empty());
}

// Case 13: neither host exists; the proxy would know them.
TEST_F(AskProgram, GoesThroughTheProxyForAnswersAndForCaptions) {
  Listener proxy;
  proxy.answer = [](const httplib::Request& request) {
    const bool describes = request.target.find("captions.invalid") != std::string::npos;
    return describes ? completion({{"content", "A long row."}}) : step_after(request);
  };
  const int status =
      ask({"--endpoint", "http://model.invalid/v1", "--subset", "2", "--words", "captions",
           "--captioner", "http://captions.invalid/v1", "--picture-size", "64"},
          {{"HTTP_PROXY", proxy.host()}, {"http_proxy", ""}, {"NO_PROXY", ""}, {"no_proxy", ""}});
  ASSERT_EQ(status, 0) << read_file(file("errors"));
  std::set<std::string> targets;
  for (const httplib::Request& one : proxy.requests()) targets.insert(one.target);
  EXPECT_THAT(targets, ElementsAre(StartsWith("http://captions.invalid"),
                                   StartsWith("http://model.invalid")));
  EXPECT_THAT(proxy.requests().back().body, HasSubstr("A long row."));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
