#include "enfilade/arena/mcp.h"

#include <fmt/format.h>
#include <httplib.h>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>
#include <thread>
#include <vector>

#include "enfilade/arena/detail/texts.h"
#include "enfilade/core/errors.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostBytes = std::size_t{1} << 20U;  // of a message
constexpr const char* kSessionHeader = "Mcp-Session-Id";
constexpr const char* kStateless = "2026-07-28";
constexpr const char* kPath = "/mcp/?";  // a regular expression
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

}  // namespace

struct McpHttp::Impl {
  McpServer& server;
  McpHttpConfig config;
  httplib::Server http;
  std::mutex mutex;     // of the server and the session
  std::string session;  // empty: none has begun
  std::jthread thread;  // last: it uses the others

  Impl(McpServer& played, McpHttpConfig settings) : server(played), config(std::move(settings)) {}

  bool is_own(std::string_view host) const {
    return detail::is_same(host, config.host) || detail::is_same(host, "localhost") ||
           host == "127.0.0.1" || host == "[::1]";
  }

  /// A page of another site, or a name that was made to point here, is no assistant's.
  bool is_foreign(const httplib::Request& request) const {
    const std::string origin = request.get_header_value("Origin");
    return !is_own(host_in(request.get_header_value("Host"))) ||
           (!origin.empty() && !is_own(host_in(origin)));
  }

  /// Lets a page of this machine read the response: that page alone, whatever its port is.
  void allow_page(const httplib::Request& request, httplib::Response& response) const {
    const std::string origin = request.get_header_value("Origin");
    if (origin.empty() || is_foreign(request)) return;
    response.set_header("Access-Control-Allow-Origin", origin);
    response.set_header("Access-Control-Expose-Headers", kSessionHeader);
    response.set_header("Vary", "Origin");
  }

  /// What a browser asks before it sends a page's request.
  void preflight(const httplib::Request& request, httplib::Response& response) const {
    if (is_foreign(request)) {
      response.status = 403;
      return;
    }
    const std::string asked = request.get_header_value("Access-Control-Request-Headers");
    response.status = 204;
    response.set_header("Allow", kMethods);
    response.set_header("Access-Control-Allow-Methods", kMethods);
    response.set_header("Access-Control-Allow-Headers",
                        is_list_of_headers(asked) ? asked : kHeaders);
    response.set_header("Access-Control-Max-Age", "600");
  }

  void post(const httplib::Request& request, httplib::Response& response) {
    const auto refuse = [&response](int status, const char* text) {
      response.status = status;
      response.set_content(
          Json{
              {"jsonrpc", "2.0"}, {"id", nullptr}, {"error", {{"code", -32600}, {"message", text}}}}
              .dump(),
          "application/json");
    };
    if (is_foreign(request)) return refuse(403, "pages of other sites may not play");
    const std::scoped_lock lock(mutex);
    // Not copied, as it may be nested deeply: the server refuses that.
    const auto message = nlohmann::json::parse(request.body, nullptr, false);
    const bool begins = message.contains("method") && message["method"] == "initialize";
    const bool stateless = request.get_header_value("MCP-Protocol-Version") == kStateless;
    if (begins) {
      session = new_session();
      response.set_header(kSessionHeader, session);
    } else if (!stateless && request.has_header(kSessionHeader) &&
               request.get_header_value(kSessionHeader) != session) {
      return refuse(404, "another session has begun; initialize again");
    }
    const std::vector<std::string> said = server.handle(request.body);
    const bool takes_events =
        request.get_header_value("Accept").find("text/event-stream") != std::string::npos;
    if (said.empty()) {
      response.status = 202;
    } else if (said.size() == 1 || !takes_events) {
      response.set_content(said.front(), "application/json");
    } else {
      std::string events;  // the response last: after it the client need not listen
      for (std::size_t k = said.size(); k-- > 0;) {
        events += fmt::format("event: message\ndata: {}\n\n", said[k]);
      }
      response.set_content(events, "text/event-stream");
    }
  }

  void end(const httplib::Request& request, httplib::Response& response) {
    const std::scoped_lock lock(mutex);
    if (is_foreign(request)) {
      response.status = 403;
      return;
    }
    const bool known = !session.empty() && request.get_header_value(kSessionHeader) == session;
    if (known) session.clear();
    response.status = known ? 204 : 404;
  }
};

McpHttp::McpHttp(McpServer& server, const McpHttpConfig& config)
    : impl_(std::make_unique<Impl>(server, config)) {
  Impl& all = *impl_;
  all.http.set_payload_max_length(kMostBytes);
  all.http.set_tcp_nodelay(true);
  using Request = httplib::Request;
  using Response = httplib::Response;
  all.http.set_post_routing_handler([&all](const Request& request, Response& response) {
    all.allow_page(request, response);  // also refusals, so that a page can tell them
  });
  all.http.Post(
      kPath, [&all](const Request& request, Response& response) { all.post(request, response); });
  all.http.Delete(
      kPath, [&all](const Request& request, Response& response) { all.end(request, response); });
  all.http.Options(kPath, [&all](const Request& request, Response& response) {
    all.preflight(request, response);
  });
  all.http.Get(kPath, [](const Request&, Response& response) {
    response.status = 405;  // the server sends no unrequested messages
    response.set_header("Allow", kMethods);
  });
  const bool bound = config.port == 0
                         ? (all.config.port = all.http.bind_to_any_port(config.host)) > 0
                         : all.http.bind_to_port(config.host, config.port);
  if (!bound) {
    throw ArgumentError(fmt::format(
        "{}:{}: cannot listen there; another program does, or it is no interface of this machine",
        config.host, config.port));
  }
  all.thread = std::jthread([&all] { all.http.listen_after_bind(); });
  // Stopping a server that does not listen yet would be forgotten.
  while (!all.http.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

McpHttp::~McpHttp() { impl_->http.stop(); }

std::string McpHttp::url() const {
  return fmt::format("http://{}:{}/mcp", impl_->config.host, impl_->config.port);
}

}  // namespace enfilade::arena
