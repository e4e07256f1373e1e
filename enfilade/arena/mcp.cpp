#include "enfilade/arena/mcp.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <istream>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "enfilade/arena/detail/message_limits.h"
#include "enfilade/arena/play.h"
#include "enfilade/arena/prompt.h"
#include "enfilade/arena/wire.h"
#include "enfilade/core/base64.h"
#include "enfilade/core/detail/json.h"

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

constexpr const char* kLastWithBatches = "2025-03-26";
constexpr std::size_t kMostInBatch = 64;
constexpr std::size_t kQuotedName = 60;  // characters

constexpr const char* kInstructions =
    "You walk through a building as an instruction says, one tool call at a time. begin starts an "
    "episode and returns its instruction. Each result lists the tools and values that are possible "
    "now. An invalid call has no effect, and the result says so. stop ends the episode where the "
    "instruction leads to; then begin starts the next one.";
constexpr const char* kBegin = "begin";

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

Answer not_done(std::string text) { return {Json::array({text_block(std::move(text))}), true}; }

/// The calls that the session accepts now, a tool per line: "go_to place: B, C".
std::string possible_now(const SessionObservation& seen) {
  std::string text = "Possible now:";
  for (const ToolUse& use : seen.tools) {
    text += fmt::format("\n{}", name_of(use.tool));
    if (use.argument.empty()) continue;
    text += fmt::format(" {}: {}{}", use.argument,
                        use.list ? fmt::format("one to {} of ", kMostMoves) : "",
                        fmt::join(use.allowed, ", "));
  }
  return text;
}

Json listed(const Json& function) {
  return {{"name", function["name"]},
          {"description", function["description"]},
          {"inputSchema", function["parameters"]}};
}

bool is_stateless(const std::string& method, const Json& params) {
  return method == "server/discover" || (params.contains("_meta") && params["_meta"].is_object() &&
                                         params["_meta"].value(kVersionKey, Json()) == kStateless);
}

/// What is wrong with the parameters of a method; null: nothing.
const char* params_fault(const std::string& method, const Json& params) {
  if (!params.is_object()) return "params: an object is expected";
  if (method == "tools/call" && (!params.contains("name") || !params["name"].is_string())) {
    return "params.name: the name of a tool is expected";
  }
  if (method == "initialize" && params.contains("protocolVersion") &&
      !params["protocolVersion"].is_string()) {
    return "params.protocolVersion: a string is expected";
  }
  return nullptr;
}

}  // namespace

struct McpServer::Impl {
  Play play;
  std::string version;
  std::string revision = {};   // of the last handshake; empty: there was none
  bool listed_before = false;  // whether the tools were listed after it
  bool begun = false;          // whether an episode was begun in this process

  Impl(std::unique_ptr<World> world, const ViewSources& sights, McpConfig config)
      : play(std::move(world), sights,
             Prompt::named(config.pictures == PictureKind::kNone ? "text" : "marks"),
             {.episodes = std::move(config.episodes),
              .limits = config.limits,
              .answers = Answers::kTools,
              .pictures = config.pictures,
              .picture_size = config.picture_size,
              .folder = std::move(config.folder)}),
        version(std::move(config.version)) {}

  Json server_info() const { return {{"name", "enfilade"}, {"version", version}}; }

  /// \param current whether values that are possible at this step are enumerated
  Json tools(bool current) const {
    const Json no_arguments{
        {"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
    Json tools =
        Json::array({{{"name", kBegin},
                      {"description",
                       "Start the next episode, and get its instruction. In an episode, get the "
                       "instruction and the current observation again."},
                      {"inputSchema", no_arguments}}});
    const Json now = current && play.session() != nullptr
                         ? Json::parse(functions_json(play.session()->observation()))
                         : Json::array();
    for (const Json& plain : Json::parse(plain_functions_json(play.tools()))) {
      const auto found = std::ranges::find_if(
          now, [&plain](const Json& one) { return one["name"] == plain["name"]; });
      tools.push_back(listed(found == now.end() ? plain : *found));
    }
    return tools;
  }

  Answer begin() {
    Answer answer;
    if (play.session() != nullptr) {
      answer.content.push_back(text_block("This episode is in progress.\n\n" + play.start_text()));
    } else if (play.begin()) {
      begun = answer.tools_changed = true;
      answer.content.push_back(text_block(play.start_text()));
    } else {
      return not_done("All episodes are done.");
    }
    show(answer);
    return answer;
  }

  /// Adds what is seen now.
  void show(Answer& answer) {
    answer.content.push_back(
        text_block(play.step_text() + "\n\n" + possible_now(play.session()->observation())));
    for (const std::string& jpeg : play.draw()) {
      std::string data;
      append_base64(std::as_bytes(std::span(jpeg)), data);
      answer.content.push_back(
          {{"type", "image"}, {"data", std::move(data)}, {"mimeType", "image/jpeg"}});
    }
  }

  /// A call of a tool while no episode is in progress.
  Answer call_outside(const std::string& name) {
    const bool known = std::ranges::any_of(
        play.tools(), [&name](const ToolUse& one) { return name_of(one.tool) == name; });
    if (!known) {
      return not_done(fmt::format("There is no tool {:?}; {} starts an episode.",
                                  std::string_view(name).substr(0, kQuotedName), kBegin));
    }
    // A stop that is sent twice must not end the next episode too.
    if (begun) return not_done("No episode is in progress; begin starts the next one.");
    Answer answer = begin();
    if (answer.error) return answer;
    answer.error = true;
    answer.content.insert(
        answer.content.begin(),
        text_block(
            fmt::format("{} was not carried out: the first episode begins with this call.", name)));
    return answer;
  }

  Answer call(const std::string& name, const std::string& arguments) {
    if (name == kBegin) return begin();
    if (play.session() == nullptr) return call_outside(name);
    const PlayOutcome outcome = play.call(read_call(name, arguments));
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
      revision = known ? wanted : std::string(kHandshakes.back());
      listed_before = false;
      return {{"protocolVersion", revision},
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
      // An assistant that keeps its first list must not be bound to the values of one step. Without
      // a handshake, each list may be the first.
      const bool current = !is_stateless(method, params) && std::exchange(listed_before, true);
      return {{"tools", tools(current)}, {"ttlMs", 0}, {"cacheScope", "private"}};
    }
    const auto arguments = params.find("arguments");
    const Answer answer = call(
        params["name"].get<std::string>(),
        arguments == params.end() || arguments->is_null() ? std::string("{}") : arguments->dump());
    tools_changed = answer.tools_changed;
    return {{"content", answer.content}, {"isError", answer.error}};
  }

  /// The response to a message; null for a notification or a response.
  Json respond(const Json& request, bool in_batch, bool& notify) {
    const bool good = request.is_object() && request.value("jsonrpc", Json()) == "2.0";
    const bool has_method = good && request.contains("method") && request["method"].is_string();
    Json id = request.is_object() && request.contains("id") ? request["id"] : Json();
    if (!id.is_string() && !id.is_number_integer()) id = nullptr;
    if (good && !request.contains("method") &&
        (request.contains("result") || request.contains("error"))) {
      return nullptr;  // this server sends no requests
    }
    if (!has_method) return failed(id, kInvalidRequest, "no request of JSON-RPC 2.0");
    if (id.is_null() && request.contains("id")) {
      return failed(nullptr, kInvalidRequest, "id: a text or a whole number is expected");
    }
    if (id.is_null()) return nullptr;  // a notification: none of them changes anything here
    const auto method = request["method"].get<std::string>();
    constexpr std::array<std::string_view, 5> kMethods{"initialize", "server/discover", "ping",
                                                       "tools/list", "tools/call"};
    if (std::ranges::find(kMethods, method) == kMethods.end()) {
      return failed(id, kNoMethod, "no such method");
    }
    if (in_batch && method == "initialize") {
      return failed(id, kInvalidRequest, "initialize is not allowed in a batch");
    }
    Json params = request.value("params", Json());
    if (params.is_null()) params = Json::object();
    if (const char* fault = params_fault(method, params)) return failed(id, kInvalidParams, fault);
    bool tools_changed = false;
    Json result = result_of(method, params, tools_changed);
    // In the stateless revision only listeners are notified, and this server has none.
    const bool stateless = is_stateless(method, params);
    notify = notify || (tools_changed && !stateless);
    if (stateless) {
      result["resultType"] = "complete";
      result["_meta"] = {{kServerKey, server_info()}};
    }
    return {{"jsonrpc", "2.0"}, {"id", id}, {"result", std::move(result)}};
  }

  Json respond_to_batch(const Json& batch, bool& notify) {
    if (revision > kLastWithBatches) {
      return failed(
          nullptr, kInvalidRequest,
          fmt::format("revision {} has no batches; {} has them", revision, kLastWithBatches));
    }
    if (batch.empty() || batch.size() > kMostInBatch) {
      return failed(
          nullptr, kInvalidRequest,
          fmt::format("a batch of {} messages; 1 to {} are allowed", batch.size(), kMostInBatch));
    }
    Json responses = Json::array();
    for (const Json& one : batch) {
      Json response = respond(one, true, notify);
      if (!response.is_null()) responses.push_back(std::move(response));
    }
    return responses.empty() ? Json() : responses;
  }
};

McpServer::McpServer(std::unique_ptr<World> world, const ViewSources& sights, McpConfig config)
    : impl_(std::make_unique<Impl>(std::move(world), sights, std::move(config))) {}
McpServer::~McpServer() = default;

bool McpServer::read_message(std::istream& from, std::string& message) {
  message.clear();
  auto& bytes = *from.rdbuf();
  constexpr int kEnd = std::char_traits<char>::eof();
  int byte = bytes.sbumpc();
  const bool any = byte != kEnd;
  for (; byte != kEnd && byte != '\n'; byte = bytes.sbumpc()) {
    if (message.size() <= kMostBytes) message += static_cast<char>(byte);
  }
  return any;
}

std::vector<std::string> McpServer::handle(std::string_view message) {
  if (message.size() > kMostBytes) {
    return {
        failed(nullptr, kInvalidRequest, fmt::format("a message of more than {} bytes", kMostBytes))
            .dump()};
  }
  if (const std::string found = json::excess(message, detail::kMessageLimits); !found.empty()) {
    return {failed(nullptr, kInvalidRequest, "a message of " + found).dump()};
  }
  const Json parsed = Json::parse(message, nullptr, false);
  if (parsed.is_discarded()) return {failed(nullptr, kParseError, "no JSON").dump()};
  bool notify = false;
  const Json response = parsed.is_array() ? impl_->respond_to_batch(parsed, notify)
                                          : impl_->respond(parsed, false, notify);
  std::vector<std::string> answers;
  if (!response.is_null()) answers.push_back(response.dump());
  if (notify) {
    answers.push_back(
        Json{{"jsonrpc", "2.0"}, {"method", "notifications/tools/list_changed"}}.dump());
  }
  return answers;
}

std::size_t McpServer::done() const noexcept { return impl_->play.done(); }
std::size_t McpServer::size() const noexcept { return impl_->play.size(); }

}  // namespace enfilade::arena
