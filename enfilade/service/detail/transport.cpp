#include "enfilade/service/detail/transport.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <thread>
#include <utility>

namespace enfilade::service::detail {
namespace {

constexpr std::size_t kLongestTarget = 2048;
constexpr int kReadSeconds = 5;       // between two pieces of a request
constexpr int kKeepAliveSeconds = 2;  // an idle connexion holds a thread for that long
constexpr int kKeepAliveRequests = 1000;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The last address of X-Forwarded-For: the one that the proxy itself saw.
std::string forwarded_address(std::string_view header) {
  const std::size_t comma = header.rfind(',');
  if (comma != std::string_view::npos) header.remove_prefix(comma + 1);
  header.remove_prefix(std::min(header.find_first_not_of(' '), header.size()));
  return std::string(header);
}

Request convert(const httplib::Request& from, bool behind_proxy) {
  Request request;
  request.method = from.method == "HEAD" ? "GET" : from.method;
  request.path = from.path;
  for (const auto& [name, value] : from.params) request.query.emplace(name, value);
  for (const auto& [name, value] : from.headers) request.headers.emplace(lower(name), value);
  request.address = from.remote_addr;
  if (behind_proxy && !request.header("x-forwarded-for").empty()) {
    request.address = forwarded_address(request.header("x-forwarded-for"));
  }
  return request;
}

// By a provider of known length, as that is what cpp-httplib does not compress by itself: the App
// has done so where it pays.
void convert(Response from, httplib::Response& to) {
  to.status = from.status;
  for (auto& [name, value] : from.headers) to.set_header(name, value);
  if (from.body->empty()) {
    to.set_header("Content-Type", from.type);
    return;
  }
  const std::size_t size = from.body->size();
  to.set_content_provider(size, from.type,
                          [body = std::move(from.body)](std::size_t offset, std::size_t length,
                                                        httplib::DataSink& sink) {
                            return sink.write(body->data() + offset, length);
                          });
}

}  // namespace

struct Transport::Impl {
  App& app;
  ServerConfig config;
  httplib::Server server;
  int port = 0;
  std::thread listener;

  Impl(App& its_app, const ServerConfig& its_config) : app(its_app), config(its_config) {
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
    listener = std::thread([this] { server.listen_after_bind(); });
    while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  void configure() {
    const auto threads = static_cast<std::size_t>(config.threads);
    server.new_task_queue = [threads] { return new httplib::ThreadPool(threads); };
    server.set_keep_alive_timeout(kKeepAliveSeconds);
    server.set_keep_alive_max_count(kKeepAliveRequests);
    server.set_read_timeout(kReadSeconds);
    server.set_write_timeout(kReadSeconds);
    server.set_payload_max_length(config.most_submission_bytes);
    server.set_tcp_nodelay(true);
    // cpp-httplib's own choice, SO_REUSEPORT, would let two servers share a port and its requests.
    server.set_socket_options([](socket_t socket) {
      const int on = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    });
  }

  void route() {
    // cpp-httplib matches targets with std::regex, which a long one would take down.
    server.set_pre_routing_handler([](const httplib::Request& from, httplib::Response& to) {
      if (from.path.size() <= kLongestTarget) return httplib::Server::HandlerResponse::Unhandled;
      convert(error_response(414, "long-path", "the path is too long"), to);
      return httplib::Server::HandlerResponse::Handled;
    });
    // What cpp-httplib itself refuses: bodies that are too large, lines that are no HTTP.
    server.set_error_handler([](const httplib::Request&, httplib::Response& to) {
      if (to.body.empty() && to.status >= 400 && !to.has_header("Content-Security-Policy")) {
        to.set_content(*error_response(to.status, "refused", "this is no acceptable request").body,
                       "application/json");
      }
    });
    server.Get(".*", [this](const httplib::Request& from, httplib::Response& to) {
      convert(app.handle(convert(from, config.behind_proxy)), to);
    });
    const auto with_body = [this](const httplib::Request& from, httplib::Response& to,
                                  const httplib::ContentReader& reader) {
      answer_with_body(from, to, reader);
    };
    server.Post(".*", with_body);
    server.Put(".*", with_body);
    server.Patch(".*", with_body);
    server.Delete(".*", with_body);
  }

  // Reads all of the body, or the rest would be taken for the next request; keeps no more of it
  // than the route wants to see.
  void answer_with_body(const httplib::Request& from, httplib::Response& to,
                        const httplib::ContentReader& reader) {
    Request request = convert(from, config.behind_proxy);
    const std::size_t most = app.most_bytes(request.method, request.path);
    const auto begin = std::chrono::steady_clock::now();
    const std::chrono::duration<double> allowed(config.body_seconds);
    bool late = false;
    const bool whole = reader([&](const char* data, std::size_t size) {
      late = std::chrono::steady_clock::now() - begin > allowed;
      if (request.body.size() <= most) request.body.append(data, size);
      return !late;
    });
    if (late) {
      convert(error_response(408, "slow-body", "the body took too long"), to);
    } else if (!whole) {
      convert(error_response(to.status >= 400 ? to.status : 400, "bad-body",
                             to.status == 413 ? "the body is too large" : "the body broke off"),
              to);
    } else {
      convert(app.handle(std::move(request)), to);
    }
  }
};

Transport::Transport(App& app, const ServerConfig& config)
    : impl_(std::make_unique<Impl>(app, config)) {}

Transport::~Transport() { stop(); }

int Transport::port() const noexcept { return impl_->port; }

void Transport::stop() {
  impl_->server.stop();
  if (impl_->listener.joinable()) impl_->listener.join();
}

}  // namespace enfilade::service::detail
