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

#include "enfilade/core/gzip.h"
#include "enfilade/core/numbers.h"
#include "enfilade/service/detail/texts.h"
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

/// \param ask getpeername() or getsockname()
void tell_address(socket_t socket, int (*ask)(int, sockaddr*, socklen_t*), std::string& ip,
                  int& port) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  auto* plain = reinterpret_cast<sockaddr*>(&address);
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (ask(socket, plain, &size) != 0 ||
      getnameinfo(plain, size, host.data(), host.size(), service.data(), service.size(),
                  NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return;
  }
  ip = host.data();
  port = std::atoi(service.data());
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
    tell_address(socket_, ::getpeername, ip, port);
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    tell_address(socket_, ::getsockname, ip, port);
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

// JSON packs to a tenth, and what is made for it to a thousandth. Below that many bytes the ratio
// is of no interest.
constexpr std::size_t kMostRatio = 200;
constexpr std::size_t kAnyRatio = 64U << 10U;
constexpr std::size_t kMedium = 1U << 20U;

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

bool BodyRoom::take(const std::string& address, std::size_t bytes) {
  const std::scoped_lock lock(mutex_);
  const auto own = by_address_.find(address);
  const std::size_t before = own == by_address_.end() ? 0 : own->second;
  if (bytes > kBodies * largest_ - taken_ || bytes > kBodiesOfAddress * largest_ - before) {
    return false;
  }
  taken_ += bytes;
  by_address_[address] = before + bytes;
  return true;
}

void BodyRoom::give_back(const std::string& address, std::size_t bytes) {
  const std::scoped_lock lock(mutex_);
  taken_ -= bytes;
  const auto own = by_address_.find(address);
  own->second -= bytes;
  if (own->second == 0) by_address_.erase(own);
}

std::unique_lock<std::mutex> BodyRoom::wait_for_turn(std::size_t bytes) {
  return std::unique_lock(turns_[bytes > kMedium ? 1 : 0]);
}

namespace {

/// Unpacks a body as it is sent.
class Unpacking {
 public:
  /// Passes what comes out to take(). What that throws ends it.
  void add(std::string_view piece, const Gunzip::Take& take) {
    packed_ += piece.size();
    const auto take_checked = [&](std::string_view more) {
      unpacked_ += more.size();
      if (unpacked_ > kAnyRatio && unpacked_ / kMostRatio > packed_) {
        throw HttpError(413,
                        fmt::format("the body unpacks to more than {} times its size", kMostRatio));
      }
      take(more);
    };
    try {
      gunzip_.add(piece, take_checked);
    } catch (const HttpError&) {
      throw;
    } catch (const Error& error) {  // of gunzip_
      throw HttpError(400, error.what());
    }
  }
  void check_ended() const {
    if (!gunzip_.ended()) throw HttpError(400, "the compressed body broke off");
  }

 private:
  std::size_t packed_ = 0, unpacked_ = 0;
  Gunzip gunzip_;
};

}  // namespace

RequestBody::RequestBody(httplib::Request& request, const httplib::ContentReader& reader,
                         std::string address, BodyRoom& room, double seconds)
    : reader_(reader),
      room_(room),
      address_(std::move(address)),
      coding_(detail::lower_case(request.get_header_value("Content-Encoding"))),
      length_(parse_number<std::size_t>(request.get_header_value("Content-Length"))),
      seconds_(seconds) {
  request.headers.erase("Content-Encoding");
}

RequestBody::~RequestBody() { keep_room(0); }

void RequestBody::take_room(std::size_t bytes) {
  if (!room_.take(address_, bytes)) {
    throw HttpError(503, "too many large bodies at once; try again");
  }
  taken_ += bytes;
}

void RequestBody::keep_room(std::size_t bytes) {
  if (taken_ <= bytes) return;
  room_.give_back(address_, taken_ - bytes);
  taken_ = bytes;
}

// Gives the body's bytes to take(), as they are sent. What that throws ends it.
void RequestBody::read_pieces(const std::function<void(std::string_view)>& take) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds_);
  const auto late = [end] { return std::chrono::steady_clock::now() > end; };
  whole_ = reader_([&](const char* data, std::size_t more) {
    if (late()) return false;
    take({data, more});
    return true;
  });
  if (whole_) return;
  if (late()) throw HttpError(408, "the body took too long");
  throw HttpError(400, "the body broke off");
}

std::string RequestBody::read(std::size_t most) {
  begun_ = true;
  const bool plain = coding_.empty() || coding_ == "identity";
  if (!plain && coding_ != "gzip") {
    throw HttpError(415, "Content-Encoding: neither gzip nor identity");
  }
  const auto check = [most](std::size_t bytes) {
    if (bytes > most) throw HttpError(413, fmt::format("the body has more than {} bytes", most));
  };
  std::string body;
  std::optional<Unpacking> packed;
  if (!plain) packed.emplace();
  const auto expect = [&](std::size_t bytes) {
    if (bytes <= kSmallBody) return;
    take_room(bytes - taken_);
    body.reserve(bytes);  // takes memory only where it is written to
  };
  if (plain && length_) {
    check(*length_);
    expect(*length_);
  }
  const auto take = [&](std::string_view piece) {
    const std::size_t size = body.size() + piece.size();
    check(size);
    // A body whose size is not known is expected to be the largest.
    if (size > kSmallBody && size > taken_) expect(most);
    body += piece;
  };
  read_pieces([&](std::string_view piece) {
    // A packed file whose header is missing, as of one that a person chose in a form.
    if (!packed && body.size() < kGzipMark.size() &&
        (body + std::string(piece.substr(0, kGzipMark.size()))).starts_with(kGzipMark)) {
      packed.emplace().add(std::exchange(body, {}), take);
    }
    if (packed) {
      packed->add(piece, take);
    } else {
      take(piece);
    }
  });
  if (packed) packed->check_ended();
  keep_room(body.size());
  if (body.size() > kSmallBody) turn_ = room_.wait_for_turn(body.size());
  return body;
}

bool RequestBody::finish() {
  if (!begun_ && coding_.empty() && length_ && *length_ <= kSmallBody) {
    try {
      read(kSmallBody);
    } catch (const HttpError&) {  // of no interest
    }
  }
  return whole_;
}

}  // namespace enfilade::service::http::sockets
