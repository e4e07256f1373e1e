/// \file  Connections with limits that cpp-httplib lacks, and bodies of requests: read within
/// limits of their own, and of all of them together.
#pragma once
#include <httplib.h>
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace enfilade::service::http::sockets {

/// Wraps cpp-httplib's server over connections of our own. cpp-httplib 0.11 does not limit lines
/// and headers. It lets a client send them a byte at a time for ever. It closes a connection while
/// the client still sends, so that the client may never see the response. Here:
/// - the head of a request has at most 64 KiB. It arrives within 10 s of its first byte, or within
///   the time of a body if that is less;
/// - a line (of the head, or the length of a chunk) has at most 8 KiB;
/// - after a response that ends its connection, further bytes of the client are read, and dropped,
///   for some seconds.
class BoundedServer : public httplib::Server {
 public:
  /// \param body_seconds  longest time that a client may take to send a body, and to go on sending
  /// one after the answer
  explicit BoundedServer(double body_seconds) : body_seconds_(body_seconds) {}

  /// Lets more clients connect at the same moment than cpp-httplib's 5; the others would have to
  /// try again after a second. \pre bound
  void lengthen_queue();

 private:
  bool process_and_close_socket(socket_t socket) override;
  template <class Self>
  static bool answer_request(Self& self, httplib::Stream& connection, bool last, bool& closed);

  double body_seconds_;
};

/// Bodies up to this many bytes are not counted: with one thread each, they are few. Pages and
/// scripts send them all the time.
inline constexpr std::size_t kSmallBody = 16U << 10U;

/// Memory for the larger bodies of all requests. Any thread may use it at any time.
class BodyRoom {
 public:
  /// \param largest  body that a route takes. There is room for four such bodies, two of them from
  /// one address: no client can take it all
  explicit BodyRoom(std::size_t largest) : largest_(largest) {}

  /// Takes room for a body. \returns whether there was enough
  bool take(const std::string& address, std::size_t bytes);
  void give_back(const std::string& address, std::size_t bytes);

  /// Waits until no other body of that kind is parsed, because that takes several times the body's
  /// bytes. There are two kinds: up to 1 MiB, and larger. So workers need not wait while a results
  /// file is checked.
  /// \returns the turn, which ends with it
  std::unique_lock<std::mutex> wait_for_turn(std::size_t bytes);

 private:
  static constexpr std::size_t kBodies = 4;
  static constexpr std::size_t kBodiesOfAddress = 2;

  std::size_t largest_;
  std::mutex mutex_;
  std::size_t taken_ = 0;
  std::map<std::string, std::size_t> by_address_;
  std::array<std::mutex, 2> turns_;
};

/// The body of a request. Its bytes are taken from the connection once. Belongs to one thread; its
/// room and its turn end with it.
class RequestBody {
 public:
  /// \param request  loses its Content-Encoding: cpp-httplib would unpack the body, however large
  /// \param address  of the client  \param seconds  longest time that the body may take
  /// \pre reader and room outlive *this
  RequestBody(httplib::Request& request, const httplib::ContentReader& reader, std::string address,
              BodyRoom& room, double seconds);
  ~RequestBody();
  RequestBody(const RequestBody&) = delete;
  RequestBody& operator=(const RequestBody&) = delete;

  /// All of it, unpacked, also without Content-Encoding if it begins as gzip does. Waits for a turn
  /// if it is large.
  /// \throws HttpError
  /// - 413 for more than `most` bytes, or a body that unpacks to more than 200 times its size
  /// - 503 if there is no room (both without reading on)
  /// - 408, 400; 415 for an encoding other than gzip
  std::string read(std::size_t most);
  /// Reads a small body that no route needs. \returns whether the next request begins after it
  bool finish();

 private:
  void take_room(std::size_t bytes);
  void keep_room(std::size_t bytes);
  void read_pieces(const std::function<void(std::string_view)>& take);

  const httplib::ContentReader& reader_;
  BodyRoom& room_;
  std::string address_, coding_;
  std::optional<std::size_t> length_;  // as it is sent, if that is said
  double seconds_;
  std::size_t taken_ = 0;  // room, in bytes
  bool begun_ = false, whole_ = false;
  std::unique_lock<std::mutex> turn_;
};

}  // namespace enfilade::service::http::sockets
