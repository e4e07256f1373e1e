#include "enfilade/arena/mcp.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "enfilade/arena/play.h"
#include "enfilade/arena/prompt.h"
#include "enfilade/arena/wire.h"
#include "enfilade/core/base64.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

// Revisions that begin with a handshake, the newest last; and the one that does not.
constexpr std::array<std::string_view, 4> kHandshakes{"2024-11-05", "2025-03-26", "2025-06-18",
                                                      "2025-11-25"};
constexpr std::string_view kStateless = "2026-07-28";
constexpr const char* kVersionKey = "io.modelcontextprotocol/protocolVersion";
constexpr const char* kServerKey = "io.modelcontextprotocol/serverInfo";

enum ErrorCode : int {
  kParseError = -32700,
  kInvalidRequest = -32600,
  kNoMethod = -32601,
  kInvalidParams = -32602,
};

constexpr const char* kInstructions =
    "You walk through a building as an instruction says, one tool call at a time. begin starts an "
    "episode; then the tools take the listed values, and stop ends it where the instruction leads "
    "to. An invalid call has no effect, and the response says so.";

Json text_block(std::string text) { return {{"type", "text"}, {"text", std::move(text)}}; }

Json failed(const Json& id, int code, std::string message) {
  return {
      {"jsonrpc", "2.0"}, {"id", id}, {"error", {{"code", code}, {"message", std::move(message)}}}};
}

/// What an assistant gets from a call.
struct Answer {
  Json content = Json::array();
  bool error = false;
  bool tools_changed = false;
};

}  // namespace

struct McpServer::Impl {
  Play play;
  std::string version;

  Impl(std::unique_ptr<World> world, Sights sights, McpConfig config)
      : play(std::move(world), std::move(sights),
             Prompt::named(config.pictures == Pictures::kNone ? "text" : "marks"),
             {.episodes = std::move(config.episodes),
              .limits = config.limits,
              .answers = Answers::kTools,
              .pictures = config.pictures,
              .picture_size = config.picture_size,
              .folder = std::move(config.folder)}),
        version(std::move(config.version)) {}

  Json server_info() const { return {{"name", "enfilade"}, {"version", version}}; }

  Json tools() const {
    if (play.session() == nullptr) {
      const Json schema{
          {"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
      return Json::array({{{"name", "begin"},
                           {"description", "Start the next episode, and get its instruction."},
                           {"inputSchema", schema}}});
    }
    Json tools = Json::array();
    for (const Json& one : Json::parse(functions_json(play.session()->observation()))) {
      tools.push_back({{"name", one["name"]},
                       {"description", one["description"]},
                       {"inputSchema", one["parameters"]}});
    }
    return tools;
  }

  Answer begin() {
    if (!play.begin()) return {Json::array({text_block("All episodes are done.")}), true};
    Answer answer;
    answer.tools_changed = true;
    answer.content.push_back(text_block(play.start_text()));
    show(answer);
    return answer;
  }

  /// Adds what is seen now.
  void show(Answer& answer) {
    answer.content.push_back(text_block(play.step_text()));
    for (const std::string& jpeg : play.draw()) {
      std::string data;
      append_base64(std::as_bytes(std::span(jpeg)), data);
      answer.content.push_back(
          {{"type", "image"}, {"data", std::move(data)}, {"mimeType", "image/jpeg"}});
    }
  }

  Answer call(const std::string& name, const std::string& arguments) {
    if (play.session() == nullptr) {
      if (name == "begin") return begin();
      return {Json::array({text_block("No episode is being walked; begin starts one.")}), true};
    }
    const Outcome outcome = play.call(read_call(name, arguments));
    Answer answer;
    answer.error = !outcome.carried_out;
    answer.tools_changed = outcome.carried_out || outcome.ending;
    if (!outcome.ending) {
      show(answer);
    } else {
      answer.content.push_back(text_block(
          outcome.told + " The episode is over; begin starts the next, if there is one."));
    }
    return answer;
  }

  Json result_of(const std::string& method, const Json& params, bool& tools_changed) {
    if (method == "initialize") {
      const std::string wanted = params.value("protocolVersion", "");
      const bool known = std::ranges::find(kHandshakes, wanted) != kHandshakes.end();
      return {{"protocolVersion", known ? wanted : std::string(kHandshakes.back())},
              {"capabilities", {{"tools", {{"listChanged", true}}}}},
              {"serverInfo", server_info()},
              {"instructions", kInstructions}};
    }
    if (method == "server/discover") {
      return {{"supportedVersions", Json::array({kStateless})},
              {"capabilities", {{"tools", {{"listChanged", true}}}}},
              {"instructions", kInstructions},
              {"ttlMs", 0},
              {"cacheScope", "private"}};
    }
    if (method == "ping") return Json::object();
    if (method == "tools/list") {
      return {{"tools", tools()}, {"ttlMs", 0}, {"cacheScope", "private"}};
    }
    const auto arguments = params.find("arguments");
    const Answer answer = call(
        params["name"].get<std::string>(),
        arguments == params.end() || arguments->is_null() ? std::string("{}") : arguments->dump());
    tools_changed = answer.tools_changed;
    return {{"content", answer.content}, {"isError", answer.error}};
  }

  std::vector<std::string> handle(std::string_view message) {
    const Json request = Json::parse(message, nullptr, false);
    if (request.is_discarded()) return {failed(nullptr, kParseError, "no JSON").dump()};
    const bool good = request.is_object() && request.value("jsonrpc", Json()) == "2.0" &&
                      request.contains("method") && request["method"].is_string();
    Json id = request.is_object() && request.contains("id") ? request["id"] : Json();
    if (!id.is_string() && !id.is_number_integer()) id = nullptr;
    if (!good) return {failed(id, kInvalidRequest, "no request of JSON-RPC 2.0").dump()};
    if (id.is_null()) return {};  // a notification: none of them changes anything here
    const auto method = request["method"].get<std::string>();
    constexpr std::array<std::string_view, 5> kMethods{"initialize", "server/discover", "ping",
                                                       "tools/list", "tools/call"};
    if (std::ranges::find(kMethods, method) == kMethods.end()) {
      return {failed(id, kNoMethod, "no such method").dump()};
    }
    const Json params = request.value("params", Json::object());
    const bool fits =
        params.is_object() &&
        (method != "tools/call" || (params.contains("name") && params["name"].is_string())) &&
        (method != "initialize" || !params.contains("protocolVersion") ||
         params["protocolVersion"].is_string());
    if (!fits) return {failed(id, kInvalidParams, "params do not fit the method").dump()};
    bool tools_changed = false;
    Json result = result_of(method, params, tools_changed);
    const bool stateless =
        method == "server/discover" || (params.contains("_meta") && params["_meta"].is_object() &&
                                        params["_meta"].value(kVersionKey, Json()) == kStateless);
    if (stateless) {
      result["resultType"] = "complete";
      result["_meta"] = {{kServerKey, server_info()}};
    }
    std::vector<std::string> answers{
        Json{{"jsonrpc", "2.0"}, {"id", id}, {"result", std::move(result)}}.dump()};
    // In the stateless revision only listeners get it, and this server has none.
    if (tools_changed && !stateless) {
      answers.push_back(
          Json{{"jsonrpc", "2.0"}, {"method", "notifications/tools/list_changed"}}.dump());
    }
    return answers;
  }
};

McpServer::McpServer(std::unique_ptr<World> world, Sights sights, McpConfig config)
    : impl_(std::make_unique<Impl>(std::move(world), std::move(sights), std::move(config))) {}
McpServer::~McpServer() = default;

std::vector<std::string> McpServer::handle(std::string_view message) {
  return impl_->handle(message);
}

std::size_t McpServer::done() const noexcept { return impl_->play.done(); }
std::size_t McpServer::size() const noexcept { return impl_->play.size(); }

}  // namespace enfilade::arena
