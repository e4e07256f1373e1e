#include "enfilade/arena/mcp.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/arena/detail/json_response.h"
#include "enfilade/arena/detail/message_limits.h"
#include "enfilade/arena/detail/texts.h"
#include "enfilade/core/errors.h"
#include "enfilade/net/server.h"

namespace enfilade::arena {
namespace {

using detail::json_response;
using Json = nlohmann::ordered_json;

constexpr const char* kSessionHeader = "Mcp-Session-Id";  // as it is sent
constexpr const char* kOfSession = "mcp-session-id";      // as it is received
constexpr const char* kStateless = "2026-07-28";
constexpr const char* kMethods = "POST, DELETE, OPTIONS";
/// Headers that the protocol's revisions have, for a page that does not say what it sends.
constexpr const char* kHeaders =
    "Accept, Authorization, Content-Type, Last-Event-ID, MCP-Protocol-Version, Mcp-Method, "
    "Mcp-Name, Mcp-Session-Id";

std::string new_session() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

/// "127.0.0.1" of "http://127.0.0.1:8001" and of "127.0.0.1:8001".
std::string_view host_in(std::string_view text) {
  const std::size_t scheme = text.find("://");
  if (scheme != std::string_view::npos) text.remove_prefix(scheme + 3);
  if (text.starts_with('[')) return text.substr(0, text.find(']') + 1);
  return text.substr(0, text.find(':'));
}

/// "content-type,mcp-session-id"
bool is_list_of_headers(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == ',' || c == ' ';
  });
}

net::Response refusal(int status, std::string_view text) {
  net::Response response = json_response(
      Json{{"jsonrpc", "2.0"}, {"id", nullptr}, {"error", {{"code", -32600}, {"message", text}}}}
          .dump());
  response.status = status;
  return response;
}

net::Response empty_response(int status) {
  net::Response response;
  response.status = status;
  return response;
}

}  // namespace

struct McpHttp::Impl {
  McpServer& played;
  std::string host;
  std::mutex mutex;     // of the server and the session
  std::string session;  // empty: none has begun
  net::Server server;   // last: its threads use the others

  Impl(McpServer& its_played, const McpHttpConfig& config)
      : played(its_played), host(config.host), server(settings(config)) {}

  net::ServerConfig settings(const McpHttpConfig& config) {
    net::ServerConfig its;
    its.host = config.host;
    its.port = config.port;
    its.most_body_bytes = McpServer::kMostBytes;
    its.refuse = [](const net::HttpError& error) { return refusal(error.status(), error.what()); };
    its.answer = [this](const net::Request& request, const net::BodyReader& read_body) {
      net::Response response = answer(request, read_body);
      allow_page(request, response);  // also refusals, so that a page can tell them
      return response;
    };
    return its;
  }

  bool is_own(std::string_view name) const {
    return detail::is_same(name, host) || detail::is_same(name, "localhost") ||
           name == "127.0.0.1" || name == "[::1]";
  }

  /// A page of another site, or a name that was made to point here, is no assistant's.
  bool is_foreign(const net::Request& request) const {
    const std::string_view origin = request.header("origin");
    return !is_own(host_in(request.header("host"))) ||
           (!origin.empty() && !is_own(host_in(origin)));
  }

  /// Lets a page of this machine read the response: that page alone, whatever its port is.
  void allow_page(const net::Request& request, net::Response& response) const {
    const std::string_view origin = request.header("origin");
    if (origin.empty() || is_foreign(request)) return;
    response.add_header("Access-Control-Allow-Origin", std::string(origin));
    response.add_header("Access-Control-Expose-Headers", kSessionHeader);
    response.add_header("Vary", "Origin");
  }

  /// The body is read last: nothing is unpacked for a page of another site.
  net::Response answer(const net::Request& request, const net::BodyReader& read_body) {
    if (request.path != "/mcp" && request.path != "/mcp/") return refusal(404, "POST /mcp");
    if (is_foreign(request)) return refusal(403, "pages of other sites may not play");
    if (request.method == "OPTIONS") return preflight(request);
    if (request.method == "DELETE") return end(request);
    if (request.method != "POST") {  // the server sends no unrequested messages
      net::Response response = empty_response(405);
      response.add_header("Allow", kMethods);
      return response;
    }
    try {
      return post(request, read_body ? read_body(McpServer::kMostBytes) : std::string());
    } catch (const net::HttpError& error) {
      return refusal(error.status(), error.what());
    }
  }

  /// What a browser asks before it sends a page's request.
  static net::Response preflight(const net::Request& request) {
    const std::string_view asked = request.header("access-control-request-headers");
    net::Response response = empty_response(204);
    response.add_header("Allow", kMethods);
    response.add_header("Access-Control-Allow-Methods", kMethods);
    response.add_header("Access-Control-Allow-Headers",
                        is_list_of_headers(asked) ? std::string(asked) : kHeaders);
    response.add_header("Access-Control-Max-Age", "600");
    return response;
  }

  net::Response post(const net::Request& request, const std::string& body) {
    const std::scoped_lock lock(mutex);
    // The server refuses others; not copied, as values may be nested deeply.
    const auto message = json::excess(body, detail::kMessageLimits).empty()
                             ? nlohmann::json::parse(body, nullptr, false)
                             : nlohmann::json();
    const bool begins = message.contains("method") && message["method"] == "initialize";
    const bool stateless = request.header("mcp-protocol-version") == kStateless;
    if (begins) {
      session = new_session();
    } else if (!stateless && request.headers.contains(kOfSession) &&
               request.header(kOfSession) != session) {
      return refusal(404, "another session has begun; initialize again");
    }
    const std::vector<std::string> said = played.handle(body);
    const bool takes_events =
        request.header("accept").find("text/event-stream") != std::string_view::npos;
    net::Response response;
    if (said.empty()) {
      response.status = 202;
    } else if (said.size() == 1 || !takes_events) {
      response = json_response(said.front());
    } else {
      std::string events;  // the response last: after it the client need not listen
      for (std::size_t k = said.size(); k-- > 0;) {
        events += fmt::format("event: message\ndata: {}\n\n", said[k]);
      }
      response = json_response(std::move(events));
      response.type = "text/event-stream";
    }
    if (begins) response.add_header(kSessionHeader, session);
    return response;
  }

  net::Response end(const net::Request& request) {
    const std::scoped_lock lock(mutex);
    const bool known = !session.empty() && request.header(kOfSession) == session;
    if (known) session.clear();
    return empty_response(known ? 204 : 404);
  }
};

McpHttp::McpHttp(McpServer& server, const McpHttpConfig& config)
    : impl_(std::make_unique<Impl>(server, config)) {}

McpHttp::~McpHttp() = default;

std::string McpHttp::url() const {
  return fmt::format("http://{}:{}/mcp", impl_->host, impl_->server.port());
}

}  // namespace enfilade::arena
