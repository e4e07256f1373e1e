/// \file  Bodies of requests, read within limits of their own, and of all of them together.
#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "enfilade/net/connections/head.h"
#include "enfilade/net/messages.h"

namespace enfilade::net::connections {

/// Whether the socket is ready for an event of poll() within that time.
bool is_ready(int socket, short event, std::chrono::milliseconds time);
/// Waits up to 5 s for a client that takes nothing. \returns whether all was sent
/// \param gives_up asked while the client takes nothing, at least once a second; empty: never
bool send_all(int socket, std::string_view text, const std::function<bool()>& gives_up = {});

/// Memory for the bodies of all requests that are larger than kSmallBody. Any thread may use it at
/// any time.
class BodyRoom {
 public:
  /// \param largest  body that a route takes. There is room for four such bodies, two of them from
  /// one address: no client can take it all
  explicit BodyRoom(std::size_t largest) : largest_(largest) {}

  /// Takes room for a body. \returns whether there was enough
  bool take(const std::string& address, std::size_t bytes);
  void give_back(const std::string& address, std::size_t bytes);

 private:
  static constexpr std::size_t kBodies = 4;
  static constexpr std::size_t kBodiesOfAddress = 2;

  std::size_t largest_;
  std::mutex mutex_;
  std::size_t taken_ = 0;
  std::map<std::string, std::size_t> by_address_;
};

/// The body of a request. Its bytes are taken from the connection once. Belongs to one thread; its
/// room ends with it.
class RequestBody {
 public:
  /// \param bytes that were received behind the head; later those of the next request
  /// \param address  of the client  \param seconds  longest time that the body may take
  /// \pre head, bytes and room outlive *this
  RequestBody(int socket, const Head& head, std::string& bytes, std::string address, BodyRoom& room,
              double seconds);
  ~RequestBody();
  RequestBody(const RequestBody&) = delete;
  RequestBody& operator=(const RequestBody&) = delete;

  /// All of it, as of BodyReader; unpacked also without Content-Encoding if it begins as gzip does.
  /// \throws HttpError
  std::string read(std::size_t most);
  /// Skips a body that was received and that no route needs.
  /// \returns whether the next request begins after it
  bool finish();

 private:
  using Take = std::function<void(std::string_view)>;

  void take_room(std::size_t bytes);
  void keep_room(std::size_t bytes);
  void receive();
  void pass_on(std::size_t size, const Take& take);
  std::string_view read_line();
  void read_chunks(const Take& take);
  void read_pieces(const Take& take);

  int socket_;
  const Head& head_;
  std::string& bytes_;
  std::size_t used_ = 0;  // of bytes_
  std::string address_, coding_;
  BodyRoom& room_;
  std::chrono::steady_clock::time_point end_;
  std::size_t taken_ = 0;  // room, in bytes
  bool begun_ = false, whole_ = false;
};

}  // namespace enfilade::net::connections
