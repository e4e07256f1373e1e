#include "enfilade/arena/stand_in.h"

#include <fmt/format.h>
#include <httplib.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kThreads = 64;
constexpr std::size_t kMostBytes = std::size_t{256} << 20U;
// A model's words cost about a token for four letters.
constexpr std::size_t kLettersOfToken = 4;

std::vector<Call> read_trail(const std::string& text) {
  std::vector<Call> calls;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(';', at), text.size());
    const std::string one = text.substr(at, end - at);
    const std::size_t blank = std::min(one.find(' '), one.size());
    calls.push_back({one.substr(0, blank), one.substr(std::min(blank + 1, one.size()))});
    at = end + 1;
  }
  return calls;
}

/// What a call says in the form that the request asks for.
Json message_of(const Json& request, const Call& call) {
  const std::string thought = fmt::format("The rule says {} {}.", call.tool, call.argument);
  if (request.contains("tools")) {
    Json arguments = Json::object();
    for (const Json& tool : request["tools"]) {
      const Json& function = tool["function"];
      if (function["name"] != call.tool) continue;
      for (const auto& [name, value] : function["parameters"]["properties"].items()) {
        arguments[name] = call.argument;
      }
    }
    return {
        {"role", "assistant"},
        {"content", thought},
        {"tool_calls",
         Json::array({{{"id", "call_1"},
                       {"type", "function"},
                       {"function", {{"name", call.tool}, {"arguments", arguments.dump()}}}}})}};
  }
  if (request.contains("response_format")) {
    Json argument = call.argument.empty() ? Json() : Json(call.argument);
    const Json answer{{"thought", thought}, {"tool", call.tool}, {"argument", std::move(argument)}};
    return {{"role", "assistant"}, {"content", answer.dump()}};
  }
  return {{"role", "assistant"},
          {"content", fmt::format("{}\nAction: {} {}", thought, call.tool, call.argument)}};
}

Json completion_of(const Json& request, const Json& message) {
  std::size_t letters = 0;
  for (const Json& one : request["messages"]) letters += one.dump().size();
  return {
      {"id", "stand-in"},
      {"object", "chat.completion"},
      {"model", request.value("model", "")},
      {"choices", Json::array({{{"index", 0}, {"message", message}, {"finish_reason", "stop"}}})},
      {"usage",
       {{"prompt_tokens", letters / kLettersOfToken},
        {"completion_tokens", message.dump().size() / kLettersOfToken}}}};
}

}  // namespace

struct StandIn::Impl {
  std::unique_ptr<const World> world;
  StandInConfig config;
  httplib::Server server;
  int port = 0;
  std::atomic<std::size_t> requests = 0, answers = 0, repeats = 0, now = 0, most = 0;
  std::mutex mutex;
  std::set<std::uint64_t> failed;    // requests that had their fault
  std::set<std::uint64_t> answered;  // requests that had a whole answer
  std::jthread thread;               // last: it uses the others

  /// The rule's call for an episode in which this was done.
  Call next_call(const std::string& episode, const std::vector<Call>& done) const {
    const auto found = world->find(episode.substr(episode.rfind('/') + 1));
    if (!found) throw LookupError("no episode " + episode);
    const std::unique_ptr<World> own = world->another();
    const auto session = own->start(*found, {.steps = 100'000, .mistakes = 1});
    const auto follower = own->follow(config.rule, *session, config.seed);
    for (const Call& call : done) {
      follower();  // so that it knows how far it is
      if (!session->call(call)) throw ArgumentError("calls that cannot be carried out");
    }
    return follower();
  }

  /// The fault of a request, if it has one now.
  std::optional<StandInFault> fault_of(const std::string& body) {
    if (config.faults.empty()) return std::nullopt;
    const std::uint64_t hash = stream_of(body.data(), body.size());
    if (hash % config.one_in != 0) return std::nullopt;
    const StandInFault fault = config.faults[hash / config.one_in % config.faults.size()];
    if (fault == StandInFault::kUnknownPlace || fault == StandInFault::kNoCall) return fault;
    const std::scoped_lock lock(mutex);
    if (!failed.insert(hash).second) return std::nullopt;
    return fault;
  }

  void answer(const httplib::Request& request, httplib::Response& response) {
    ++requests;
    const std::size_t present = ++now;
    for (std::size_t known = most;
         present > known && !most.compare_exchange_weak(known, present);) {
    }
    respond(request, response);
    --now;
  }

  void respond(const httplib::Request& request, httplib::Response& response) {
    const auto refuse = [&response](int status, const std::string& text) {
      response.status = status;
      response.set_content(Json{{"error", {{"message", text}}}}.dump(), "application/json");
    };
    if (!config.key.empty() &&
        request.get_header_value("Authorization") != "Bearer " + config.key) {
      return refuse(401, "wrong key: " + request.get_header_value("Authorization"));
    }
    if (config.most_answers > 0 && answers >= config.most_answers) return refuse(503, "stopping");
    const Json asked = Json::parse(request.body, nullptr, false);
    if (!asked.is_object() || !asked.contains("messages")) return refuse(400, "no messages");
    if (asked.contains("tools") && !config.with_tools) return refuse(400, "no tools here");
    const auto fault = fault_of(request.body);
    if (fault == StandInFault::kServerError) return refuse(500, "out of order");
    if (fault == StandInFault::kRateLimit) {
      response.set_header("Retry-After", "0");
      return refuse(429, "too many requests");
    }
    if (fault == StandInFault::kSilence) {
      std::this_thread::sleep_for(std::chrono::duration<double>(config.silence));
    }
    const std::string origin = request.get_header_value("X-Enfilade-Episode");
    if (origin.starts_with("caption/")) {
      ++answers;
      const Json caption{
          {"role", "assistant"},
          {"content", fmt::format("View {:08x} of a room.",
                                  stream_of(origin.data(), origin.size()) & 0xFFFFFFFFU)}};
      return response.set_content(completion_of(asked, caption).dump(), "application/json");
    }
    Call call;
    try {
      call = next_call(origin, read_trail(request.get_header_value("X-Enfilade-Calls")));
    } catch (const Error& error) {
      return refuse(400, error.what());
    }
    if (fault == StandInFault::kUnknownPlace) call = {"go_to", "QQ"};
    Json message = message_of(asked, call);
    if (fault == StandInFault::kNoCall)
      message = {{"role", "assistant"}, {"content", "Let me see."}};
    Json completion = completion_of(asked, message);
    if (fault == StandInFault::kNoChoice) completion["choices"] = Json::array();
    std::string body =
        fault == StandInFault::kNotJson ? "<html>Bad gateway</html>" : completion.dump();
    if (fault == StandInFault::kCutOff) body.resize(body.size() / 2);
    response.set_content(body, "application/json");
    const bool whole = fault != StandInFault::kNoChoice && fault != StandInFault::kNotJson &&
                       fault != StandInFault::kCutOff;
    if (!whole) return;
    ++answers;
    const std::scoped_lock lock(mutex);
    if (!answered.insert(stream_of(request.body.data(), request.body.size())).second) ++repeats;
  }
};

StandIn::StandIn(std::unique_ptr<const World> world, const StandInConfig& config)
    : impl_(std::make_unique<Impl>()) {
  Impl& all = *impl_;
  all.world = std::move(world);
  all.config = config;
  all.server.new_task_queue = [] {
    return new httplib::ThreadPool(kThreads);
  };  // httplib deletes it
  all.server.set_payload_max_length(kMostBytes);
  all.server.set_tcp_nodelay(true);
  all.server.set_keep_alive_max_count(1'000'000);
  all.server.Post("/v1/chat/completions",
                  [&all](const httplib::Request& request, httplib::Response& response) {
                    all.answer(request, response);
                  });
  all.port = all.server.bind_to_any_port("127.0.0.1");
  if (all.port <= 0) throw Error("no free port of 127.0.0.1");
  all.thread = std::jthread([&all] { all.server.listen_after_bind(); });
  // Stopping a server that does not listen yet would be forgotten.
  while (!all.server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

StandIn::~StandIn() { impl_->server.stop(); }

std::string StandIn::url() const { return fmt::format("http://127.0.0.1:{}/v1", impl_->port); }
std::size_t StandIn::requests() const { return impl_->requests; }
std::size_t StandIn::answers() const { return impl_->answers; }
std::size_t StandIn::repeats() const { return impl_->repeats; }
std::size_t StandIn::most_at_once() const { return impl_->most; }

}  // namespace enfilade::arena
