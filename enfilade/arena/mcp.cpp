#include "enfilade/arena/mcp.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "enfilade/arena/detail/transcript.h"
#include "enfilade/arena/prompt.h"
#include "enfilade/arena/wire.h"
#include "enfilade/core/base64.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/folder_lock.h"

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
    "episode; then go_to, back_to and look take one of the listed values, and stop ends it where "
    "the instruction leads to. What is impossible is told and does nothing.";

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
  std::shared_ptr<const tasks::EpisodeSet> episodes;
  McpConfig config;
  GraphWorld world;
  std::unique_ptr<Painter> painter;
  Prompt prompt;
  std::unique_ptr<FolderLock> lock;
  std::unique_ptr<GraphSession> session;  // none: nothing is being walked
  std::optional<detail::Transcript> transcript;

  Impl(std::shared_ptr<const tasks::EpisodeSet> set, const dataset::Dataset* data,
       McpConfig settings)
      : episodes(std::move(set)),
        config(std::move(settings)),
        world(episodes),
        prompt(Prompt::named(config.pictures == Pictures::kNone ? "text" : "marks")) {
    validate(config.limits);
    if (config.episodes.empty()) throw ArgumentError("episodes: none");
    for (const std::size_t one : config.episodes) {
      if (one < episodes->episodes.size()) continue;
      throw ArgumentError(fmt::format("episode: {}; there are {}", one, episodes->episodes.size()));
    }
    if (config.pictures != Pictures::kNone) {
      if (data == nullptr) throw ArgumentError("pictures: there is no data set for them");
      painter = std::make_unique<Painter>(*data);
    }
    make_folder(config.folder / "transcripts");
    lock = std::make_unique<FolderLock>(config.folder / "ask.lock");
  }

  Json server_info() const { return {{"name", "enfilade"}, {"version", config.version}}; }
  std::filesystem::path file_of(std::size_t episode) const {
    return config.folder / "transcripts" /
           detail::transcript_name(episodes->episodes[episode].instruction_id);
  }
  bool is_done(std::size_t episode) const { return file_exists(file_of(episode)); }

  Json tools() const {
    if (!session) {
      const Json schema{
          {"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
      return Json::array({{{"name", "begin"},
                           {"description", "Start the next episode, and get its instruction."},
                           {"inputSchema", schema}}});
    }
    Json tools = Json::array();
    for (const Json& one : Json::parse(functions_json(session->observation()))) {
      tools.push_back({{"name", one["name"]},
                       {"description", one["description"]},
                       {"inputSchema", one["parameters"]}});
    }
    return tools;
  }

  Answer begin() {
    const auto next =
        std::ranges::find_if_not(config.episodes, [this](std::size_t e) { return is_done(e); });
    if (next == config.episodes.end()) {
      return {Json::array({text_block("All episodes are done.")}), true};
    }
    session = start_session(world, *next, config.limits);
    transcript.emplace(*session);
    Answer answer;
    answer.tools_changed = true;
    answer.content.push_back(
        text_block(prompt.start(session->observation(), Answers::kTools, config.limits)));
    show(answer);
    return answer;
  }

  /// Adds what is seen now.
  void show(Answer& answer) {
    const Observation& seen = session->observation();
    answer.content.push_back(text_block(prompt.step(seen, Answers::kTools, config.limits, {})));
    for (const PictureOrder& order :
         order_pictures(*session, config.pictures, config.picture_size)) {
      const std::string jpeg = painter->draw(order);
      std::string data;
      append_base64(std::as_bytes(std::span(jpeg)), data);
      answer.content.push_back(
          {{"type", "image"}, {"data", std::move(data)}, {"mimeType", "image/jpeg"}});
    }
  }

  Answer call(const std::string& name, const std::string& arguments) {
    if (!session) {
      if (name == "begin") return begin();
      return {Json::array({text_block("No episode is being walked; begin starts one.")}), true};
    }
    const Observation before = session->observation();
    const Reading reading = read_call(name, arguments);
    bool done = false;
    if (reading.call) {
      done = session->call(*reading.call);
    } else {
      session->misread(reading.fault);
    }
    transcript->add(before, reading.call ? &*reading.call : nullptr, *session);
    Answer answer;
    answer.error = !done;
    answer.tools_changed = done;
    if (!session->ending()) {
      show(answer);
      return answer;
    }
    write_file_atomically(file_of(session->episode()),
                          std::move(*transcript).finish(*session, *episodes));
    detail::write_results(config.folder, *episodes, config.episodes);
    answer.content.push_back(
        text_block(session->observation().told +
                   " The episode is over; begin starts the next, if there is one."));
    answer.tools_changed = true;
    session.reset();
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
    // Of the stateless revision only those who listen get it, and nobody can here.
    if (tools_changed && !stateless) {
      answers.push_back(
          Json{{"jsonrpc", "2.0"}, {"method", "notifications/tools/list_changed"}}.dump());
    }
    return answers;
  }
};

McpServer::McpServer(std::shared_ptr<const tasks::EpisodeSet> episodes,
                     const dataset::Dataset* data, McpConfig config)
    : impl_(std::make_unique<Impl>(std::move(episodes), data, std::move(config))) {}
McpServer::~McpServer() = default;

std::vector<std::string> McpServer::handle(std::string_view message) {
  return impl_->handle(message);
}

std::size_t McpServer::done() const noexcept {
  return static_cast<std::size_t>(std::ranges::count_if(
      impl_->config.episodes, [this](std::size_t e) { return impl_->is_done(e); }));
}
std::size_t McpServer::size() const noexcept { return impl_->config.episodes.size(); }

}  // namespace enfilade::arena
