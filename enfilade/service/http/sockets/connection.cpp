#include "enfilade/service/http/sockets/connection.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/service/http/headers.h"
#include "enfilade/service/http/messages.h"

namespace enfilade::service::http::sockets {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kMostHead = 64U << 10U;
constexpr std::size_t kLongestLine = 8U << 10U;
constexpr double kHeadSeconds = 10;
constexpr int kQueue = 511;  // of connections that are not accepted yet, as nginx has it
constexpr milliseconds kPieceTime{5'000};      // between two pieces of a request, or of an answer
constexpr milliseconds kKeepAliveTime{2'000};  // an idle connection holds a thread for that long
constexpr int kKeepAliveRequests = 1000;
constexpr milliseconds kSlice{100};  // between two looks at whether the server stops

/// Whether the socket is ready within that time.
bool is_ready(socket_t socket, short event, milliseconds time) {
  pollfd one{socket, event, 0};
  int ready = 0;
  do {
    ready = ::poll(&one, 1, static_cast<int>(std::max(time, milliseconds{0}).count()));
  } while (ready < 0 && errno == EINTR);
  return ready > 0;
}

/// Waits in slices. \returns whether bytes came, or the end, before that time and before `stops()`
template <class Stops>
bool wait_for_bytes(socket_t socket, milliseconds time, const Stops& stops) {
  for (const auto end = Clock::now() + time; !stops() && Clock::now() < end;) {
    if (is_ready(socket, POLLIN, kSlice)) return true;
  }
  return false;
}

void tell_address(const sockaddr_storage& address, socklen_t size, std::string& ip, int& port) {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host.data(), host.size(),
                  service.data(), service.size(), NI_NUMERICHOST | NI_NUMERICSERV) == 0) {
    ip = host.data();
    port = std::atoi(service.data());
  }
}

/// The bytes of one connection, which keeps count of them.
class Connection : public httplib::Stream {
 public:
  Connection(socket_t socket, double head_seconds)
      : socket_(socket),
        head_time_(std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(head_seconds))) {}

  void begin_request() {
    in_head_ = true;
    answered_ = false;
    head_ = line_ = 0;
    head_end_ = Clock::now() + head_time_;
  }
  bool has_bytes() const noexcept { return begin_ < end_; }
  /// Whether the request was given up without an answer, for a line without an end.
  bool needs_answer() const noexcept { return too_long_ && !answered_; }

  bool is_readable() const override { return has_bytes() || is_ready(socket_, POLLIN, kPieceTime); }
  bool is_writable() const override { return is_ready(socket_, POLLOUT, kPieceTime); }

  ssize_t read(char* to, std::size_t size) override {
    if (too_long_) return -1;
    if (!has_bytes()) {
      const ssize_t more = fill();
      if (more <= 0) return more;
    }
    size = std::min(size, end_ - begin_);
    std::memcpy(to, &buffer_[begin_], size);
    begin_ += size;
    if (in_head_) {
      for (std::size_t k = 0; k < size; ++k) count_in_head(to[k]);
    } else if (size > 1 || *to == '\n') {
      line_ = 0;
    } else if (++line_ > kLongestLine) {  // cpp-httplib reads lines by the byte, and keeps them
      too_long_ = true;
    }
    return too_long_ ? -1 : static_cast<ssize_t>(size);
  }

  /// Small pieces wait for the next one, or flush(): the head of an answer goes with its body, in
  /// one packet where both fit.
  ssize_t write(const char* from, std::size_t size) override {
    answered_ = true;
    if (waiting_ + size <= waiting_bytes_.size()) {
      std::memcpy(&waiting_bytes_[waiting_], from, size);
      waiting_ += size;
      return static_cast<ssize_t>(size);
    }
    return send_with_waiting({from, size}) ? static_cast<ssize_t>(size) : -1;
  }
  bool flush() { return waiting_ == 0 || send_with_waiting({}); }

  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    if (::getpeername(socket_, reinterpret_cast<sockaddr*>(&address), &size) == 0) {
      tell_address(address, size, ip, port);
    }
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    if (::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) == 0) {
      tell_address(address, size, ip, port);
    }
  }
  socket_t socket() const override { return socket_; }

 private:
  bool send_with_waiting(std::string_view last) {
    std::array<iovec, 2> pieces{{{waiting_bytes_.data(), std::exchange(waiting_, 0)},
                                 {const_cast<char*>(last.data()), last.size()}}};
    msghdr message{};
    message.msg_iov = pieces.data();
    message.msg_iovlen = pieces.size();
    while (pieces[0].iov_len + pieces[1].iov_len > 0) {
      const ssize_t sent = ::sendmsg(socket_, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && errno != EAGAIN && errno != EINTR) return false;
      if (sent < 0 && errno == EAGAIN && !is_writable()) return false;
      auto done = static_cast<std::size_t>(std::max<ssize_t>(sent, 0));
      for (iovec& piece : pieces) {
        const std::size_t of_piece = std::min(done, piece.iov_len);
        piece.iov_base = static_cast<char*>(piece.iov_base) + of_piece;
        piece.iov_len -= of_piece;
        done -= of_piece;
      }
    }
    return true;
  }

  ssize_t fill() {
    if (!flush()) return -1;  // "100 Continue", which the client waits for
    milliseconds time = kPieceTime;
    if (in_head_) {
      time = std::min(time, std::chrono::duration_cast<milliseconds>(head_end_ - Clock::now()));
      if (time <= milliseconds{0}) return -1;
    }
    ssize_t more = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (more < 0 && (errno == EAGAIN || errno == EINTR)) {
      if (!is_ready(socket_, POLLIN, time)) return -1;
      more = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    }
    begin_ = 0;
    end_ = static_cast<std::size_t>(std::max<ssize_t>(more, 0));
    return more;
  }

  /// The head ends with an empty line.
  void count_in_head(char c) {
    if (++head_ > kMostHead) too_long_ = true;
    if (c == '\n') {
      in_head_ = line_ > 0;
      line_ = 0;
    } else if (c != '\r' && ++line_ > kLongestLine) {
      too_long_ = true;
    }
  }

  socket_t socket_;
  std::array<char, 16U << 10U> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // of what was received and not yet read
  std::array<char, 4U << 10U> waiting_bytes_;
  std::size_t waiting_ = 0;  // of what is to be sent
  bool in_head_ = true, too_long_ = false, answered_ = false;
  std::size_t head_ = 0;  // bytes
  std::size_t line_ = 0;  // bytes of the current line
  Clock::duration head_time_;
  Clock::time_point head_end_;
};

/// cpp-httplib closes the connection without a word if the first line of a request has no end.
void refuse_line(Connection& connection) {
  Response response = error_response(414, "the path is too long");
  add_security_headers(response);
  std::string text = fmt::format(
      "HTTP/1.1 414 URI Too Long\r\nConnection: close\r\nContent-Type: {}\r\nContent-Length: "
      "{}\r\n",
      response.type, response.body->size());
  for (const auto& [name, value] : response.headers) text += fmt::format("{}: {}\r\n", name, value);
  text += "\r\n" + *response.body;
  connection.write(text.data(), text.size());
  connection.flush();
}

/// Reads and forgets what the client still sends. Closing at once would tell it that the connection
/// broke, and make it forget the answer that it has not looked at.
template <class Stops>
void read_on(socket_t socket, double seconds, const Stops& stops) {
  ::shutdown(socket, SHUT_WR);
  std::array<char, 16U << 10U> forgotten;
  for (const auto end = Clock::now() + std::chrono::duration<double>(seconds);
       Clock::now() < end;) {
    if (!wait_for_bytes(socket, kKeepAliveTime, stops)) return;
    if (::recv(socket, forgotten.data(), forgotten.size(), 0) <= 0) return;
  }
}

}  // namespace

void BoundedServer::lengthen_queue() { ::listen(svr_sock_, kQueue); }

// A template, so that only the form that the installed cpp-httplib has is compiled: 0.18
// takes the addresses that 0.11 asks the connection for.
template <class Self>
bool BoundedServer::answer_request(Self& self, httplib::Stream& connection, bool last,
                                   bool& closed) {
  if constexpr (requires { self.process_request(connection, last, closed, nullptr); }) {
    return self.process_request(connection, last, closed, nullptr);
  } else {
    std::string remote, local;
    int remote_port = 0, local_port = 0;
    connection.get_remote_ip_and_port(remote, remote_port);
    connection.get_local_ip_and_port(local, local_port);
    return self.process_request(connection, remote, remote_port, local, local_port, last, closed,
                                nullptr);
  }
}

bool BoundedServer::process_and_close_socket(socket_t socket) {
  const auto stops = [this] { return svr_sock_ == INVALID_SOCKET; };
  Connection connection(socket, std::min(kHeadSeconds, body_seconds_));
  bool good = true, closed = false;
  for (int left = kKeepAliveRequests; good && !closed && left > 0 && !stops(); --left) {
    if (!connection.has_bytes() && !wait_for_bytes(socket, kKeepAliveTime, stops)) break;
    connection.begin_request();
    good = answer_request(*this, connection, left == 1, closed);
    good = connection.flush() && good;
  }
  if (connection.needs_answer()) refuse_line(connection);
  if (!good) read_on(socket, body_seconds_, stops);
  ::shutdown(socket, SHUT_RDWR);
  ::close(socket);
  return good;
}

}  // namespace enfilade::service::http::sockets
