/// \file  Connections with limits that cpp-httplib lacks.
#pragma once
#include <httplib.h>

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

}  // namespace enfilade::service::http::sockets
