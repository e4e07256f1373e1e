// A server: requests come by cpp-httplib. Only this file, sockets/ and client.cpp see it.
#include "enfilade/service/http/routes.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>
#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "enfilade/service/detail/hosts.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/messages.h"
#include "enfilade/service/http/sockets/connection.h"

namespace enfilade::service {
namespace http {
namespace {

constexpr std::size_t kLongestTarget = 2048;
constexpr std::size_t kLeastRoom = 1U << 20U;  // for a body; what a worker submits

/// The last entry of a list: of X-Forwarded-For the address that the proxy itself saw.
std::string last_entry(std::string_view header) {
  header = header.substr(header.rfind(',') + 1);  // without a comma npos + 1 = 0
  header.remove_prefix(std::min(header.find_first_not_of(" \t"), header.size()));
  return std::string(header);
}

Request convert(const httplib::Request& from, bool behind_proxy) {
  Request request;
  request.method = from.method == "HEAD" ? "GET" : from.method;
  request.path = from.path;
  // Not cpp-httplib's: of "?link=https://example.org/?a=1" it keeps "1".
  request.query = parse_query(from.target);
  for (const auto& [name, value] : from.headers) {
    // Lines of one name are one list (RFC 9110, 5.3): proxies may add theirs to the client's.
    const auto [at, added] = request.headers.emplace(detail::lower_case(name), value);
    if (!added) at->second += (at->first == "cookie" ? "; " : ", ") + value;
  }
  request.address = from.remote_addr;
  if (behind_proxy) {
    // What is no address stays the proxy's own: as an address of its own, each made-up text would
    // have limits of its own.
    auto client = detail::parse_address(last_entry(request.header("x-forwarded-for")));
    if (client) request.address = std::move(*client);
  }
  const auto protocol = request.headers.find("x-forwarded-proto");
  if (protocol != request.headers.end()) protocol->second = last_entry(protocol->second);
  return request;
}

enum class AfterAnswer { kStays, kCloses };

// Sends the body by a provider of known length, because cpp-httplib does not compress those: the
// App has compressed it already. A provider that returns false closes the connection.
void convert(Response from, httplib::Response& to, AfterAnswer after = AfterAnswer::kStays) {
  to.status = from.status;
  for (auto& [name, value] : from.headers) to.set_header(name, value);
  const bool closes = after == AfterAnswer::kCloses;
  if (closes) to.set_header("Connection", "close");
  if (from.body->empty()) {
    to.set_header("Content-Type", from.type);
    return;
  }
  const std::size_t size = from.body->size();
  const auto send = [body = std::move(from.body), closes](std::size_t offset, std::size_t length,
                                                          httplib::DataSink& sink) {
    // cpp-httplib 0.11 takes the end of a Range from the client as it is.
    const std::string_view rest = std::string_view(*body).substr(std::min(offset, body->size()));
    return sink.write(rest.data(), std::min(length, rest.size())) && !closes;
  };
  to.set_content_provider(size, from.type, send);
}

/// Refuses a request that does not reach the App, and closes the connection: it is not known where
/// the next request on it begins.
void refuse(int status, std::string_view message, httplib::Response& to) {
  Response response = error_response(status, message);
  add_security_headers(response);
  convert(std::move(response), to, AfterAnswer::kCloses);
}

bool may_have_body(std::string_view method) {
  return method == "POST" || method == "PUT" || method == "PATCH" || method == "DELETE";
}

bool has_body(const httplib::Request& request) {
  return request.has_header("Content-Length") || request.has_header("Transfer-Encoding");
}

/// Whether a proxy could see another end of the request than cpp-httplib does: an attacker could
/// then make it give one client's answer to another client.
bool end_is_unclear(const httplib::Request& request) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  for (const auto& [name, value] : request.headers) {
    if (std::ranges::any_of(name, blank)) return true;  // "Content-Length : 3"
  }
  const std::size_t lengths = request.get_header_value_count("Content-Length");
  const std::size_t codings = request.get_header_value_count("Transfer-Encoding");
  if (lengths + codings > 1) return true;
  if (codings == 1 &&
      detail::lower_case(request.get_header_value("Transfer-Encoding")) != "chunked")
    return true;
  const std::string length = request.get_header_value("Content-Length");
  constexpr std::size_t kMostDigits = 15;
  const bool digits = std::ranges::all_of(length, [](char c) { return c >= '0' && c <= '9'; });
  if (lengths == 1 && (length.empty() || length.size() > kMostDigits || !digits)) return true;
  // cpp-httplib would read the body as the next request.
  return has_body(request) && length != "0" && !may_have_body(request.method);
}

/// Whether cpp-httplib would find none of our handlers, and keep the body, however long, before it
/// says so: the method is one of HTTP/2, or the path has a line break, which `.*` does not match.
bool matches_no_route(const httplib::Request& request) {
  const auto control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
  return request.method == "PRI" || std::ranges::any_of(request.path, control);
}

}  // namespace

}  // namespace http

struct Server::Impl {
  http::App app;
  ServerConfig config;
  http::sockets::BoundedServer server;
  http::sockets::BodyRoom room;
  int port = 0;
  std::thread listener;

  Impl(const std::shared_ptr<const Site>& site, const ServerConfig& its_config)
      : app(site, its_config),
        config(its_config),
        server(config.body_seconds),
        room(std::max(config.most_submission_bytes, http::kLeastRoom)) {
    configure();
    route();
    port = config.port == 0 ? server.bind_to_any_port(config.host)
                            : (server.bind_to_port(config.host, config.port) ? config.port : -1);
    if (port < 0) {
      throw ArgumentError(fmt::format(
          "{}:{}: cannot listen there; is another program using the port, or the address not of "
          "this machine?",
          config.host, config.port));
    }
    server.lengthen_queue();
    listener = std::thread([this] { server.listen_after_bind(); });
    while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  void configure() {
    const auto threads = static_cast<std::size_t>(config.threads);
    server.new_task_queue = [threads] { return new httplib::ThreadPool(threads); };
    server.set_tcp_nodelay(true);
    // cpp-httplib's own choice, SO_REUSEPORT, would let two servers share a port and its requests.
    server.set_socket_options([](socket_t socket) {
      const int on = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    });
  }

  void route() {
    server.set_pre_routing_handler([](const httplib::Request& from, httplib::Response& to) {
      auto& own = const_cast<httplib::Request&>(from);  // cpp-httplib's own object, passed as const
      // The pages request no byte ranges, and cpp-httplib 0.11 answers them wrongly.
      own.ranges.clear();
      if (http::end_is_unclear(from)) {
        own.method = "GET";  // an answer to HEAD has no provider that could close the connection
        http::refuse(400, "it is not clear where this request ends", to);
      } else if (from.path.size() > http::kLongestTarget) {
        // cpp-httplib matches targets with std::regex, which crashes on a long one.
        http::refuse(414, "the path is too long", to);
      } else if (http::matches_no_route(from)) {
        http::refuse(400, "this is no acceptable request", to);
      } else {
        return httplib::Server::HandlerResponse::Unhandled;
      }
      return httplib::Server::HandlerResponse::Handled;
    });
    // What cpp-httplib itself refuses: malformed lines, unknown methods.
    server.set_error_handler([](const httplib::Request& from, httplib::Response& to) {
      const_cast<httplib::Request&>(from).ranges.clear();
      if (to.has_header("Content-Security-Policy")) return;  // ours
      http::refuse(to.status, "this is no acceptable request", to);
    });
    const auto without_body = [this](const httplib::Request& from, httplib::Response& to) {
      http::convert(app.handle(http::convert(from, config.behind_proxy)), to);
    };
    server.Get(".*", without_body);
    server.Options(".*", without_body);  // has no route: the answer says which methods have one
    const auto with_body = [this](const httplib::Request& from, httplib::Response& to,
                                  const httplib::ContentReader& reader) {
      answer_with_body(from, to, reader);
    };
    server.Post(".*", with_body);
    server.Put(".*", with_body);
    server.Patch(".*", with_body);
    server.Delete(".*", with_body);
  }

  void answer_with_body(const httplib::Request& from, httplib::Response& to,
                        const httplib::ContentReader& reader) {
    if (!http::has_body(from)) {  // cpp-httplib would wait for a body
      http::convert(app.handle(http::convert(from, config.behind_proxy)), to);
      return;
    }
    if (from.is_multipart_form_data()) {  // cpp-httplib would parse the parts
      http::refuse(415, "no route takes a form in parts", to);
      return;
    }
    http::Request request = http::convert(from, config.behind_proxy);
    auto& own = const_cast<httplib::Request&>(from);  // as above
    http::sockets::RequestBody body(own, reader, detail::address_group(request.address), room,
                                    config.body_seconds);
    http::Response response =
        app.handle(std::move(request), [&body](std::size_t most) { return body.read(most); });
    http::convert(std::move(response), to,
                  body.finish() ? http::AfterAnswer::kStays : http::AfterAnswer::kCloses);
  }
};

Server::Server(const std::shared_ptr<const Site>& site, const ServerConfig& config) {
  check_range("port", config.port, 0, 65535);
  check_range("threads", config.threads, 1, 4096);
  impl_ = std::make_unique<Impl>(site, config);
}

Server::~Server() { stop(); }

int Server::port() const noexcept { return impl_->port; }

void Server::stop() {
  impl_->server.stop();
  if (impl_->listener.joinable()) impl_->listener.join();
}

}  // namespace enfilade::service
