/// \file  A server of HTTP/1.1 whose limits hold for every request: heads, bodies, packed bodies,
/// and clients that send half a request.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "enfilade/net/messages.h"

namespace enfilade::net {

/// Address, limits and program of a server.
struct ServerConfig {
  std::string host = "127.0.0.1";  ///< interface to listen on, an address or a name
  int port = 0;                    ///< 0: any that is free
  int threads = 8;                 ///< requests that are answered at the same time
  /// Largest body that `answer` reads. There is room for four of them, two from one address.
  std::size_t most_body_bytes = 1U << 20U;
  double body_seconds = 30;  ///< longest time that a client may take to send a body
  double stop_seconds = 10;  ///< longest time that stop() leaves clients to take their responses
  /// Trust X-Forwarded-For and X-Forwarded-Proto: only behind a proxy that sets them.
  bool behind_proxy = false;
  /// Called by many threads at once. \param read_body empty if there is no body. A body that was
  /// not read ends the connection, except a small one that has arrived: it is skipped. Exceptions
  /// other than HttpError become status 500.
  std::function<Response(Request request, const BodyReader& read_body)> answer;
  /// The response to a request that is refused before `answer`, and to an exception of `answer`.
  /// Called by many threads at once.
  std::function<Response(const HttpError& error)> refuse;
  /// Called after each refusal before `answer`, to count or log it. Others wait meanwhile. The
  /// request has an address only, if its head is not whole. May be empty.
  std::function<void(const Request& request, const Response& response)> refused;
};

/// A running server, on threads of its own.
///
/// One thread reads the heads of all requests, and bodies of up to 16 KiB; only whole requests take
/// a thread of ServerConfig::threads. Larger bodies, and those of unknown length, take one while
/// they arrive. They have three quarters of the threads, and one address has half of them. Others
/// wait. So clients that send half a request leave threads for others.
///
/// - A head has at most 64 KiB, 200 lines, and 8 KiB per line. It arrives within 10 s of its first
///   byte, or within the time of a body if that is less (408).
/// - A head has one Host (HTTP/1.0: at most one) and a clear end. A folded line, a bare CR or LF, a
///   header's name with blanks, or a wrong chunk size is refused at once (400).
/// - An idle connection is closed after 5 s. When more than 1,024 connections wait, the one that
///   waits longest is closed. When 512 whole requests wait for a thread, further ones get 503. Both
///   limits are lower where the process may have few descriptors: a quarter of them is left for
///   files, and each thread has one.
/// - After a refusal further bytes of the client are read, and dropped, for some seconds.
///   Closing at once would make the client forget the response.
class Server {
 public:
  /// Binds the port and starts serving.
  /// \throws ArgumentError if the address can't be bound, or for an invalid value of `config`
  /// \throws Error, std::system_error where the system has no room for descriptors or threads
  explicit Server(ServerConfig config);
  ~Server();  ///< calls stop(), from the thread that may do so
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int port() const noexcept;  ///< the bound port; any thread
  /// Closes connections that wait, and returns when the running requests are answered, also those
  /// that are whole and wait for a thread. After ServerConfig::stop_seconds, responses to clients
  /// that do not keep up break off. A second call does nothing. Not safe from two threads at once,
  /// nor from ServerConfig::answer.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::net
