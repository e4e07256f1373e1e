// Conversations with real servers, as they were: what each refused, sent and left out is played
// again, and every episode must end as it did.
//
// ENFILADE_RECORD=URL ENFILADE_RECORD_AS=NAME (with ENFILADE_RECORD_SERVER, the program and its
// version, _MODEL, _ANSWERS and _TOKENS) makes a recording instead, of the server at URL.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/arena/ask.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"
#include "tests/arena/listener.h"
#include "tests/support/grid_world.h"
#include "tests/support/run_ends.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

fs::path recordings() { return fs::path(EN_SOURCE_DIR) / "tests/arena/recordings"; }

/// The names of a request's fields, the form of its answers, and who says its messages.
Json form_of(const Json& request) {
  Json form = Json::array();
  for (const auto& [name, value] : request.items()) form.push_back(name);
  if (request.contains("response_format")) form.push_back(request["response_format"]["type"]);
  for (const Json& one : request["messages"]) form.push_back(one["role"]);
  return form;
}

/// Listens on this machine, and plays a recording, or hands requests on and keeps them.
class Server {
 public:
  explicit Server(Json recording, std::string real = {})
      : recording_(std::move(recording)), real_(std::move(real)) {
    for (const Json& one : recording_["exchanges"]) {
      by_episode_[one["episode"].get<std::string>()].push_back(one);
    }
    server_.Post("/v1/chat/completions",
                 [this](const httplib::Request& request, httplib::Response& response) {
                   real_.empty() ? play(request, response) : record(request, response);
                 });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~Server() {
    server_.stop();
    thread_.join();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::string host() const { return "http://127.0.0.1:" + std::to_string(port_); }
  std::string url() const { return host() + "/v1"; }
  const Json& recording() const { return recording_; }

 private:
  void play(const httplib::Request& request, httplib::Response& response) {
    const std::scoped_lock lock(mutex_);
    std::vector<Json>& left = by_episode_[request.get_header_value("X-Enfilade-Episode")];
    if (left.empty()) {
      response.status = 404;
      response.set_content("not recorded", "text/plain");
      return;
    }
    const Json one = left.front();
    left.erase(left.begin());
    EXPECT_EQ(form_of(Json::parse(request.body)), form_of(one["request"]));
    reply(one, response);
  }

  void record(const httplib::Request& request, httplib::Response& response) {
    const std::scoped_lock lock(mutex_);
    httplib::Client client(real_);
    client.set_read_timeout(600);
    const auto begin = std::chrono::steady_clock::now();
    const auto result = client.Post("/v1/chat/completions", request.body, "application/json");
    if (!result) {
      response.status = 502;
      return;
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    const std::string type = result->get_header_value("Content-Type");
    const Json body = Json::parse(result->body, nullptr, false);
    const Json one{{"episode", request.get_header_value("X-Enfilade-Episode")},
                   {"request", Json::parse(request.body)},
                   {"status", result->status},
                   {"content_type", type},
                   {"headers", kept(result->headers)},
                   {"seconds", std::round(seconds.count() * 100) / 100},
                   {"body", body.is_discarded() ? Json(result->body) : body}};
    recording_["exchanges"].push_back(one);
    reply(one, response);
  }

  /// The headers of a response, but for those that differ each time.
  static Json kept(const httplib::Headers& headers) {
    Json all = Json::object();
    for (const auto& [name, value] : headers) {
      if (!is_one_of(name, {"Date", "Set-Cookie"})) all[name] = value;
    }
    return all;
  }

  static void reply(const Json& one, httplib::Response& response) {
    response.status = one["status"].get<int>();
    const Json& body = one["body"];
    response.set_content(body.is_string() ? body.get<std::string>() : body.dump(),
                         one["content_type"].get<std::string>().c_str());
    // Those of a connection and of its bytes are made anew. Older recordings have none.
    const Json headers = one.value("headers", Json::object());
    for (const auto& [name, value] : headers.items()) {
      if (!is_one_of(name, {"Content-Type", "Content-Length", "Content-Encoding",
                            "Transfer-Encoding", "Connection", "Keep-Alive"})) {
        response.set_header(name, value.get<std::string>());
      }
    }
  }

  static bool is_one_of(const std::string& name, const std::set<std::string>& names) {
    const auto lower = [](unsigned char c) { return std::tolower(c); };
    return std::ranges::any_of(names, [&](const std::string& one) {
      return std::ranges::equal(one, name, {}, lower, lower);
    });
  }

  Json recording_;
  std::string real_;
  std::map<std::string, std::vector<Json>> by_episode_;
  std::mutex mutex_;
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
};

/// A run of three short episodes of the grid.
arena::AskReport run(const Server& server) {
  const Json& recording = server.recording();
  const TemporaryFolder folder("recorded");
  const auto episodes = arena::testing::episodes(tasks::Task::kR2r, 1);
  arena::AskConfig config;
  config.chat.model = recording["model"].get<std::string>();
  config.chat.most_tokens = recording["most_tokens"].get<int>();
  if (!recording["answers"].is_null()) {
    config.answers = find_enum<arena::Answers>(recording["answers"].get<std::string>());
  }
  config.limits = {.steps = 3, .mistakes = 2};
  config.first_wait = 0.01;
  config.attempts = 2;
  const auto endpoint = arena::make_http_endpoint({.url = server.url(), .timeout = 600});
  arena::AnswerCache cache(folder.path() / "cache");
  std::vector<std::size_t> which(episodes->episodes.size());
  std::iota(which.begin(), which.end(), 0U);
  auto report = arena::ask(arena::GraphWorld(episodes), {}, which, arena::Prompt::named("text"),
                           config, endpoint.get(), cache, folder.path() / "run");
  arena::testing::expect_explained(folder.path() / "run", report);
  return report;
}

/// What became of a run: the same each time.
Json outcome_of(const arena::AskReport& report) {
  Json endings = Json::object(), unanswered = Json::object();
  for (const auto& [ending, count] : report.endings) endings[std::string(name_of(ending))] = count;
  for (const auto& [flaw, count] : report.unanswered) {
    unanswered[std::string(enum_name(flaw))] = count;
  }
  return {{"answers", enum_name(report.answers)},
          {"adjusted", report.adjusted},
          {"endings", endings},
          {"unanswered", unanswered},
          {"mistakes", report.mistakes},
          {"refused", report.refused},
          {"given_up", report.given_up.size()},
          {"shortened", report.shortened}};
}

TEST(RecordedServers, ArePlayedAgain) {
  std::size_t played = 0;
  for (const auto& file : fs::directory_iterator(recordings())) {
    if (file.path().extension() != ".json") continue;
    const Json recording = Json::parse(read_file(file.path()));
    const Server server(recording);
    const auto report = run(server);
    EXPECT_EQ(outcome_of(report), recording["outcome"]) << file.path();
    EXPECT_EQ(report.done + report.given_up.size(), report.episodes) << file.path();
    ++played;
  }
  EXPECT_GT(played, 0U) << recordings();
}

TEST(RecordedServers, KeepHeadersThatStayTheSame) {
  Listener real;
  real.status = 429;
  real.headers = {{"Retry-After", "0"}, {"Set-Cookie", "a=1"}, {"Date", "today"}};
  const std::string body = R"({"model": "m", "messages": []})";
  const auto ask = [&body](const Server& server) {
    return httplib::Client(server.host()).Post("/v1/chat/completions", body, "application/json");
  };
  const Server recorder({{"exchanges", Json::array()}}, real.host());
  EXPECT_EQ(ask(recorder)->get_header_value("Retry-After"), "0");
  const Json headers = recorder.recording()["exchanges"][0]["headers"];
  EXPECT_EQ(headers["Retry-After"], "0");
  EXPECT_FALSE(headers.contains("Set-Cookie") || headers.contains("Date")) << headers;
  const Server player(recorder.recording());
  const auto played = ask(player);
  EXPECT_EQ(played->status, 429);
  EXPECT_EQ(played->body, "{}");
  EXPECT_EQ(played->get_header_value("Retry-After"), "0");
  EXPECT_EQ(played->get_header_value_count("Content-Type"), 1U);
}

TEST(RecordedServers, AreRecorded) {
  const std::string real = variable("ENFILADE_RECORD"), name = variable("ENFILADE_RECORD_AS");
  if (real.empty() || name.empty()) GTEST_SKIP() << "ENFILADE_RECORD names no server";
  const std::string model = variable("ENFILADE_RECORD_MODEL");
  const std::string answers = variable("ENFILADE_RECORD_ANSWERS");
  const std::string tokens = variable("ENFILADE_RECORD_TOKENS");
  const Server server({{"server", variable("ENFILADE_RECORD_SERVER")},
                       {"model", model},
                       {"answers", answers.empty() ? Json() : Json(answers)},
                       {"most_tokens", parse_number<int>(tokens).value_or(32)},
                       {"exchanges", Json::array()}},
                      real);
  const auto report = run(server);
  Json recording = server.recording();
  recording["outcome"] = outcome_of(report);
  write_file_atomically(recordings() / (name + ".json"), recording.dump(1) + "\n");
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
