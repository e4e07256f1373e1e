#include "enfilade/arena/detail/bounded_client.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <httplib.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <functional>
#include <mutex>
#include <new>
#include <span>
#include <stop_token>
#include <thread>

#include "enfilade/arena/detail/limits.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/core/base64.h"
#include "enfilade/core/detail/no_broken_pipe.h"

namespace enfilade::arena::detail {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostLines = 64U << 10U;                 // bytes: a head
constexpr std::size_t kMostBytes = kMostAnswer + (1U << 20U);  // with its head and chunks' lines
// cpp-httplib reads these lines by a regular expression, which takes stack for each character.
constexpr std::string_view kStatusLine = "HTTP/1.";
constexpr std::size_t kMostStatusLine = 2U << 10U;  // bytes

/// The present request's use of the connection.
class Use {
 public:
  ~Use() { watch(-1); }
  Use() = default;
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

  void begin() {
    const std::scoped_lock lock(mutex_);
    late_ = false;
    refusal_.clear();
    bytes_ = lines_ = line_ = 0;
    is_status_ = false;
  }
  /// A new connection, which is made by this thread. Its own number of it stays that connection's
  /// as long as it is open here.
  void watch(socket_t socket) {
    const std::scoped_lock lock(mutex_);
    if (socket_ >= 0) ::close(socket_);
    socket_ = socket < 0 ? -1 : ::fcntl(socket, F_DUPFD_CLOEXEC, 0);
    ++connection_;
    if (late_ && socket_ >= 0) ::shutdown(socket_, SHUT_RDWR);
  }
  /// Whether end() can end the present connection: not if the process has no number left for it.
  bool watches() {
    const std::scoped_lock lock(mutex_);
    return socket_ >= 0;
  }
  /// Ends whatever waits for the connection. Any thread.
  void end() {
    const std::scoped_lock lock(mutex_);
    late_ = true;
    if (socket_ >= 0) ::shutdown(socket_, SHUT_RDWR);
  }
  bool late() {
    const std::scoped_lock lock(mutex_);
    return late_;
  }

  std::size_t connection() const noexcept { return connection_; }  ///< how many there were
  /// Why a new connection is not used.
  void refuse(std::string why) { refusal_ = std::move(why); }
  const std::string& refusal() const noexcept { return refusal_; }

  void count_received(std::size_t bytes) { bytes_ += bytes; }
  /// A part of a body.
  void count_part() { lines_ = 0; }
  /// cpp-httplib reads lines by the byte, and keeps them whatever their number and length.
  void count_byte(char c) {
    ++lines_;
    if (line_ < kStatusLine.size()) {
      is_status_ = (line_ == 0 || is_status_) && c == kStatusLine[line_];
    }
    line_ = c == '\n' ? 0 : line_ + 1;
  }
  bool has_received() const noexcept { return bytes_ > 0; }
  bool has_too_many_bytes() const noexcept { return bytes_ > kMostBytes; }
  bool has_too_many_lines() const noexcept { return lines_ > kMostLines; }
  bool has_too_long_line() const noexcept { return is_status_ && line_ > kMostStatusLine; }

 private:
  std::mutex mutex_;
  int socket_ = -1;
  bool late_ = false;
  std::size_t connection_ = 0;
  std::string refusal_;
  std::size_t bytes_ = 0;  // as they came
  std::size_t lines_ = 0;  // bytes of lines, since the last part of a body
  std::size_t line_ = 0;   // bytes of the present line
  bool is_status_ = false;
};

/// The bytes of a connection, which are counted.
class Counted : public httplib::Stream {
 public:
  Counted(socket_t socket, SSL* ssl, Use& use) : socket_(socket), ssl_(ssl), use_(use) {}

  // Built with 0.11 and 0.18, whose streams have these two.
  bool is_readable() const override { return begin_ < end_ || wait(POLLIN); }
  bool is_writable() const override { return wait(POLLOUT); }

  ssize_t read(char* to, std::size_t size) override {
    if (begin_ == end_) {
      const ssize_t more = receive();
      if (more <= 0) return more;
      begin_ = 0;
      end_ = static_cast<std::size_t>(more);
      use_.count_received(end_);
    }
    const bool of_line = size == 1;
    size = std::min(size, end_ - begin_);
    std::memcpy(to, &buffer_[begin_], size);
    begin_ += size;
    if (of_line) {
      use_.count_byte(*to);
    } else {
      use_.count_part();
    }
    const bool good =
        !use_.has_too_many_bytes() && !use_.has_too_many_lines() && !use_.has_too_long_line();
    return good ? static_cast<ssize_t>(size) : -1;
  }
  ssize_t write(const char* from, std::size_t size) override {
    const int most = static_cast<int>(std::min<std::size_t>(size, 1U << 20U));
    return repeat(POLLOUT, [&] {
      return ssl_ != nullptr ? SSL_write(ssl_, from, most)
                             : ::send(socket_, from, static_cast<std::size_t>(most), MSG_NOSIGNAL);
    });
  }
  bool shake_hands() {
    return repeat(POLLIN, [this] { return static_cast<ssize_t>(SSL_connect(ssl_)); }) == 1;
  }
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  socket_t socket() const override { return socket_; }

 private:
  /// For as long as the request may take: Use::end() ends it.
  bool wait(short event) const {
    pollfd one{socket_, event, 0};
    int ready = 0;
    do {
      ready = ::poll(&one, 1, -1);
    } while (ready < 0 && errno == EINTR);
    return ready > 0;
  }
  /// Repeats what was interrupted.
  template <class Move>
  ssize_t repeat(short event, const Move& move) {
    for (;;) {
      ERR_clear_error();
      const ssize_t moved = move();
      if (moved >= 0 && (ssl_ == nullptr || moved > 0)) return moved;
      if (use_.late()) return -1;
      if (ssl_ != nullptr) {
        const int why = SSL_get_error(ssl_, static_cast<int>(moved));
        if (why == SSL_ERROR_ZERO_RETURN) return 0;
        if (why != SSL_ERROR_WANT_READ && why != SSL_ERROR_WANT_WRITE) return -1;
        event = why == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT;
      } else if (errno != EINTR && errno != EAGAIN) {
        return -1;
      }
      if (!wait(event)) return -1;
    }
  }
  ssize_t receive() {
    return repeat(POLLIN, [this] {
      return ssl_ != nullptr ? SSL_read(ssl_, buffer_.data(), static_cast<int>(buffer_.size()))
                             : ::recv(socket_, buffer_.data(), buffer_.size(), 0);
    });
  }

  socket_t socket_;
  SSL* ssl_;  // null: not encrypted
  Use& use_;
  std::array<char, 16U << 10U> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // of what was received and not yet read
};

struct FreeContext {
  void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
};
struct FreeTls {
  void operator()(SSL* tls) const { SSL_free(tls); }
};

/// With the system's certificates, which the server's is checked by.
std::unique_ptr<SSL_CTX, FreeContext> make_context() {
  std::unique_ptr<SSL_CTX, FreeContext> context(SSL_CTX_new(TLS_client_method()));
  if (!context) throw std::bad_alloc();
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, nullptr);
  SSL_CTX_set_default_verify_paths(context.get());
  return context;
}

bool is_address(const std::string& name) {
  in6_addr address;
  return ::inet_pton(AF_INET, name.c_str(), &address) == 1 ||
         ::inet_pton(AF_INET6, name.c_str(), &address) == 1;
}

std::string bracketed(const std::string& name) {
  return name.find(':') == std::string::npos ? name : "[" + name + "]";
}

/// A client whose responses pass through Counted. It makes TLS by itself: cpp-httplib's client of
/// TLS is a final class from 0.12 on, and its handshake has no time as a whole.
class Bounded : public httplib::ClientImpl {
 public:
  Bounded(const Host& host, const std::optional<Proxy>& proxy, Use& use)
      : ClientImpl(host.encrypted && proxy ? proxy->host : host.name,
                   host.encrypted && proxy ? proxy->port : host.port),
        host_name_(host.name),
        use_(use) {
    set_socket_options([&use](socket_t socket) { use.watch(socket); });
    if (host.encrypted) {
      context_ = make_context();
      if (proxy) tunnel_ = tunnel_request(host, *proxy);
    } else if (proxy) {
      set_proxy(proxy->host, proxy->port);
      if (!proxy->user.empty()) set_proxy_basic_auth(proxy->user, proxy->password);
    }
  }

 private:
  static std::string tunnel_request(const Host& host, const Proxy& proxy) {
    const std::string name = fmt::format("{}:{}", bracketed(host.name), host.port);
    std::string request = fmt::format("CONNECT {0} HTTP/1.1\r\nHost: {0}\r\n", name);
    if (!proxy.user.empty()) {
      const std::string login = proxy.user + ":" + proxy.password;
      request += "Proxy-Authorization: Basic ";
      append_base64(std::as_bytes(std::span(login)), request);
      request += "\r\n";
    }
    return request + "\r\n";
  }

  bool process_socket(const Socket& socket,
                      std::function<bool(httplib::Stream&)> exchange) override {
    if (!use_.watches()) {
      use_.refuse("too many open files");
      return false;
    }
    if (!context_) {
      Counted counted(socket.sock, nullptr, use_);
      return exchange(counted);
    }
    // The number of a closed connection may be another's now: use_ counts them.
    if (!tls_ || connection_ != use_.connection()) {
      tls_.reset();
      if (!connect(socket.sock)) return false;
      connection_ = use_.connection();
    }
    Counted counted(socket.sock, tls_.get(), use_);
    return exchange(counted);
  }

  /// Through the proxy, if there is one. \returns whether the server is the one that is named
  bool connect(socket_t socket) {
    if (!tunnel_.empty() && !open_tunnel(socket)) return false;
    tls_.reset(SSL_new(context_.get()));
    if (!tls_) return false;
    SSL_set_mode(tls_.get(), SSL_MODE_AUTO_RETRY);
    Counted counted(socket, tls_.get(), use_);
    if (set_name() && SSL_set_fd(tls_.get(), socket) == 1 && counted.shake_hands()) return true;
    const long why = SSL_get_verify_result(tls_.get());
    if (why != X509_V_OK) use_.refuse(X509_verify_cert_error_string(why));
    tls_.reset();
    return false;
  }

  /// The name that the server's certificate must have: without it any valid one would do.
  bool set_name() {
    if (is_address(host_name_)) {
      return X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(tls_.get()), host_name_.c_str()) == 1;
    }
    // SSL_set_tlsext_host_name(), which has a cast of C.
    return SSL_set1_host(tls_.get(), host_name_.c_str()) == 1 &&
           SSL_ctrl(tls_.get(), SSL_CTRL_SET_TLSEXT_HOSTNAME, TLSEXT_NAMETYPE_host_name,
                    host_name_.data()) == 1;
  }

  /// The proxy's answer is a head alone.
  bool open_tunnel(socket_t socket) {
    Counted proxy(socket, nullptr, use_);
    for (std::string_view rest = tunnel_; !rest.empty();) {
      const ssize_t sent = proxy.write(rest.data(), rest.size());
      if (sent <= 0) return false;
      rest.remove_prefix(static_cast<std::size_t>(sent));
    }
    std::string head;
    while (!head.ends_with("\r\n\r\n")) {
      char c = 0;
      if (proxy.read(&c, 1) != 1) return false;
      head += c;
    }
    const bool good = head.starts_with("HTTP/1.") && head.substr(8, 2) == " 2";
    if (!good) use_.refuse("the proxy: " + head.substr(0, head.find('\r')));
    return good;
  }

  std::string host_name_, tunnel_;  // the second is the request to the proxy; empty: none
  Use& use_;
  std::unique_ptr<SSL_CTX, FreeContext> context_;  // null: not encrypted
  std::unique_ptr<SSL, FreeTls> tls_;
  std::size_t connection_ = 0;
};

}  // namespace

struct BoundedClient::Impl {
  double seconds;
  std::string host = {};  // the header, where the library would not write it so
  Use use = {};
  std::unique_ptr<httplib::ClientImpl> client = {};  // uses `use`
};

BoundedClient::BoundedClient(const Host& host, const std::optional<Proxy>& proxy, double seconds)
    : impl_(new Impl{seconds}) {
  impl_->client = std::make_unique<Bounded>(host, proxy, impl_->use);
  if (host.encrypted) {
    const bool usual = host.port == 443;
    impl_->host = bracketed(host.name) + (usual ? "" : fmt::format(":{}", host.port));
  }
  httplib::ClientImpl& client = *impl_->client;
  const auto time = std::chrono::microseconds(static_cast<std::int64_t>(seconds * 1e6));
  client.set_keep_alive(true);
  client.set_connection_timeout(time);
  client.set_read_timeout(time);
  client.set_write_timeout(time);
  client.set_tcp_nodelay(true);
}

BoundedClient::~BoundedClient() = default;

Response BoundedClient::post(const std::string& target, const Headers& headers,
                             std::string_view body) {
  Use& use = impl_->use;
  use.begin();
  const auto time = std::chrono::duration<double>(impl_->seconds);
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(time);
  const std::jthread alarm([&use, end](const std::stop_token& stop) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any().wait_until(lock, stop, end, [] { return false; });
    if (!stop.stop_requested()) use.end();
  });
  const enfilade::detail::NoBrokenPipe no_broken_pipe;
  Response response;
  bool is_too_large = false;
  httplib::Request request;
  request.method = "POST";
  request.path = target;
  for (const auto& [name, value] : headers) request.headers.emplace(name, value);
  if (!impl_->host.empty() && !request.has_header("Host")) {
    request.headers.emplace("Host", impl_->host);
  }
  request.body = body;
  request.content_receiver = [&](const char* data, std::size_t size, std::uint64_t, std::uint64_t) {
    is_too_large = response.body.size() + size > kMostAnswer;
    if (!is_too_large) response.body.append(data, size);
    return !is_too_large;
  };
  const std::size_t connection = use.connection();
  httplib::Result result = impl_->client->send(request);
  // A server may end a connection that was idle, which only its use shows where it is encrypted.
  const bool was_ended = !result && result.error() != httplib::Error::Connection &&
                         !use.has_received() && connection > 0 && use.connection() == connection;
  if (was_ended && !use.late()) result = impl_->client->send(request);
  if (!result || use.late()) {  // a body without a length ends with its connection
    const std::string why =
        use.late() ? fmt::format("no whole answer in {} s", impl_->seconds)
        : use.has_too_long_line()
            ? fmt::format("a first line of more than {} KiB", kMostStatusLine >> 10U)
        : use.has_too_many_lines() ? fmt::format("a head of more than {} KiB", kMostLines >> 10U)
        : is_too_large || use.has_too_many_bytes()
            ? fmt::format("an answer of more than {} MiB", kMostAnswer >> 20U)
        : !use.refusal().empty() ? use.refusal()
                                 : httplib::to_string(result.error());
    throw EndpointError(0, why);
  }
  response.status = result->status;
  response.type = result->get_header_value("Content-Type");
  response.retry_after = result->get_header_value("Retry-After");
  return response;
}

}  // namespace enfilade::arena::detail
