#include "enfilade/arena/stand_in.h"

#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "enfilade/arena/detail/json_response.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/net/server.h"

namespace enfilade::arena {
namespace {

using detail::json_response;
using Json = nlohmann::ordered_json;

constexpr int kThreads = 128;  // half of them read long prompts of one address
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

net::Response refusal(int status, const std::string& text) {
  net::Response response = json_response(Json{{"error", {{"message", text}}}}.dump());
  response.status = status;
  return response;
}

}  // namespace

struct StandIn::Impl {
  std::unique_ptr<const World> world;
  StandInConfig config;
  std::atomic<std::size_t> requests = 0, answers = 0, repeats = 0, now = 0, most = 0;
  std::mutex mutex;
  std::set<std::uint64_t> failed;     // requests that had their fault
  std::set<std::uint64_t> answered;   // requests that had a whole answer
  std::optional<net::Server> server;  // last: its threads use the others

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

  net::Response answer(const net::Request& request, const net::BodyReader& read_body) {
    if (request.method != "POST" || request.path != "/v1/chat/completions") {
      return refusal(404, "POST /v1/chat/completions");
    }
    const std::string body = read_body ? read_body(kMostBytes) : std::string();
    ++requests;
    const std::size_t present = ++now;
    for (std::size_t known = most;
         present > known && !most.compare_exchange_weak(known, present);) {
    }
    net::Response response = respond(request, body);
    --now;
    return response;
  }

  net::Response respond(const net::Request& request, const std::string& body) {
    if (!config.key.empty() && request.header("authorization") != "Bearer " + config.key) {
      return refusal(401, fmt::format("wrong key: {}", request.header("authorization")));
    }
    if (config.most_answers > 0 && answers >= config.most_answers) return refusal(503, "stopping");
    const Json asked = Json::parse(body, nullptr, false);
    if (!asked.is_object() || !asked.contains("messages")) return refusal(400, "no messages");
    if (asked.contains("tools") && !config.with_tools) return refusal(400, "no tools here");
    const auto fault = fault_of(body);
    if (fault == StandInFault::kServerError) return refusal(500, "out of order");
    if (fault == StandInFault::kRateLimit) {
      net::Response response = refusal(429, "too many requests");
      response.add_header("Retry-After", "0");
      return response;
    }
    if (fault == StandInFault::kSilence) {
      std::this_thread::sleep_for(std::chrono::duration<double>(config.silence));
    }
    const std::string origin(request.header("x-enfilade-episode"));
    if (origin.starts_with("caption/")) {
      ++answers;
      const Json caption{
          {"role", "assistant"},
          {"content", fmt::format("View {:08x} of a room.",
                                  stream_of(origin.data(), origin.size()) & 0xFFFFFFFFU)}};
      return json_response(completion_of(asked, caption).dump());
    }
    Call call;
    try {
      call = next_call(origin, read_trail(std::string(request.header("x-enfilade-calls"))));
    } catch (const Error& error) {
      return refusal(400, error.what());
    }
    if (fault == StandInFault::kUnknownPlace) call = {"go_to", "QQ"};
    Json message = message_of(asked, call);
    if (fault == StandInFault::kNoCall)
      message = {{"role", "assistant"}, {"content", "Let me see."}};
    Json completion = completion_of(asked, message);
    if (fault == StandInFault::kNoChoice) completion["choices"] = Json::array();
    std::string said =
        fault == StandInFault::kNotJson ? "<html>Bad gateway</html>" : completion.dump();
    if (fault == StandInFault::kCutOff) said.resize(said.size() / 2);
    const bool whole = fault != StandInFault::kNoChoice && fault != StandInFault::kNotJson &&
                       fault != StandInFault::kCutOff;
    if (whole) {
      ++answers;
      const std::scoped_lock lock(mutex);
      if (!answered.insert(stream_of(body.data(), body.size())).second) ++repeats;
    }
    return json_response(std::move(said));
  }
};

StandIn::StandIn(std::unique_ptr<const World> world, const StandInConfig& config)
    : impl_(std::make_unique<Impl>()) {
  Impl& all = *impl_;
  all.world = std::move(world);
  all.config = config;
  net::ServerConfig its;
  its.threads = kThreads;
  its.most_body_bytes = kMostBytes;
  its.refuse = [](const net::HttpError& error) { return refusal(error.status(), error.what()); };
  its.answer = [&all](const net::Request& request, const net::BodyReader& read_body) {
    return all.answer(request, read_body);
  };
  all.server.emplace(std::move(its));
}

StandIn::~StandIn() = default;

std::string StandIn::url() const {
  return fmt::format("http://127.0.0.1:{}/v1", impl_->server->port());
}
std::size_t StandIn::requests() const { return impl_->requests; }
std::size_t StandIn::answers() const { return impl_->answers; }
std::size_t StandIn::repeats() const { return impl_->repeats; }
std::size_t StandIn::most_at_once() const { return impl_->most; }

}  // namespace enfilade::arena
