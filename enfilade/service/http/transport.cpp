#include "enfilade/service/http/transport.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>
#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "enfilade/service/http/headers.h"

namespace enfilade::service::http {
namespace {

constexpr std::size_t kLongestTarget = 2048;
constexpr int kReadSeconds = 5;       // between two pieces of a request
constexpr int kKeepAliveSeconds = 2;  // an idle connection holds a thread for that long
constexpr int kKeepAliveRequests = 1000;

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The last address of X-Forwarded-For: the one that the proxy itself saw.
std::string forwarded_address(std::string_view header) {
  header = header.substr(header.rfind(',') + 1);  // without a comma npos + 1 = 0
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

enum class Connection { kStays, kCloses };

// Sends the body by a provider of known length, because cpp-httplib does not compress those: the
// App has compressed it already. A provider that returns false closes the connection.
void convert(Response from, httplib::Response& to, Connection connection = Connection::kStays) {
  to.status = from.status;
  for (auto& [name, value] : from.headers) to.set_header(name, value);
  const bool closes = connection == Connection::kCloses;
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
  convert(std::move(response), to, Connection::kCloses);
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
  if (codings == 1 && lower(request.get_header_value("Transfer-Encoding")) != "chunked")
    return true;
  const std::string length = request.get_header_value("Content-Length");
  constexpr std::size_t kMostDigits = 15;
  const bool digits = std::ranges::all_of(length, [](char c) { return c >= '0' && c <= '9'; });
  if (lengths == 1 && (length.empty() || length.size() > kMostDigits || !digits)) return true;
  // cpp-httplib would read the body as the next request.
  return has_body(request) && length != "0" && !may_have_body(request.method);
}

/// The body of a request. Its bytes are taken from the connection once.
class Body {
 public:
  /// \param held bytes of bodies that are in memory, of all connections
  Body(const httplib::ContentReader& reader, const ServerConfig& config,
       std::atomic<std::size_t>& held)
      : reader_(reader), config_(config), held_(held) {}
  ~Body() { held_ -= kept_; }
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  /// All of it. \throws HttpError 413 if that is more than `most` bytes; 408, 400, 503
  std::string read(std::size_t most) {
    std::string body;
    bool busy = false;
    const auto late = deadline();
    std::size_t size = 0;
    begun_ = true;
    whole_ = reader_([&](const char* data, std::size_t more) {
      size += more;
      if (size <= most && !busy) {
        kept_ += more;
        busy = (held_ += more) > kMostHeld * config_.most_submission_bytes;
        body.append(data, more);
      }
      // A body that is too large is read to its end, up to a limit, so that the client gets the
      // 413.
      return !late() && size <= 2 * config_.most_submission_bytes;
    });
    if (late()) throw HttpError(408, "the body took too long");
    if (size > most) {
      throw HttpError(413, fmt::format("the body has more than {} bytes", most));
    }
    if (!whole_) throw HttpError(400, "the body broke off");
    if (busy) throw HttpError(503, "too many large files at once; try again");
    return body;
  }

  /// Reads a body that no route asked for. \returns whether the next request begins after it
  bool finish() {
    if (!begun_) {
      try {
        read(0);
      } catch (const HttpError&) {  // of no interest
      }
    }
    return whole_;
  }

 private:
  // Bodies of the largest size that may be in memory at a time.
  static constexpr std::size_t kMostHeld = 8;

  std::function<bool()> deadline() const {
    const auto end =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(config_.body_seconds);
    return [end] { return std::chrono::steady_clock::now() > end; };
  }

  const httplib::ContentReader& reader_;
  const ServerConfig& config_;
  std::atomic<std::size_t>& held_;
  std::size_t kept_ = 0;
  bool begun_ = false, whole_ = false;
};

}  // namespace

struct Transport::Impl {
  App& app;
  ServerConfig config;
  httplib::Server server;
  int port = 0;
  std::atomic<std::size_t> held = 0;  // bytes of bodies
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
      if (end_is_unclear(from)) {
        own.method = "GET";  // an answer to HEAD has no provider that could close the connection
        refuse(400, "it is not clear where this request ends", to);
      } else if (from.path.size() > kLongestTarget) {
        // cpp-httplib matches targets with std::regex, which crashes on a long one.
        refuse(414, "the path is too long", to);
      } else {
        return httplib::Server::HandlerResponse::Unhandled;
      }
      return httplib::Server::HandlerResponse::Handled;
    });
    // What cpp-httplib itself refuses: malformed lines, unknown methods.
    server.set_error_handler([](const httplib::Request& from, httplib::Response& to) {
      const_cast<httplib::Request&>(from).ranges.clear();
      if (to.has_header("Content-Security-Policy")) return;  // ours
      refuse(to.status, "this is no acceptable request", to);
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

  void answer_with_body(const httplib::Request& from, httplib::Response& to,
                        const httplib::ContentReader& reader) {
    if (!has_body(from)) {  // cpp-httplib would wait for a body
      convert(app.handle(convert(from, config.behind_proxy)), to);
      return;
    }
    if (from.is_multipart_form_data()) {  // cpp-httplib would parse the parts
      refuse(415, "no route takes a form in parts", to);
      return;
    }
    Body body(reader, config, held);
    Response response = app.handle(convert(from, config.behind_proxy),
                                   [&body](std::size_t most) { return body.read(most); });
    convert(std::move(response), to, body.finish() ? Connection::kStays : Connection::kCloses);
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

}  // namespace enfilade::service::http
