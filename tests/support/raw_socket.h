/// \file  Bytes over a socket as they are, for requests that no client library would send.
#pragma once
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace enfilade::tests {

inline int connect_to(int port) {
  const int socket_of = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(socket_of, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  return socket_of;
}

/// What comes until the server closes; closes too.
inline std::string read_to_end(int socket_of) {
  std::string answer;
  char buffer[4096];
  for (ssize_t n; (n = ::recv(socket_of, buffer, sizeof buffer, 0)) > 0;) {
    answer.append(buffer, static_cast<std::size_t>(n));
  }
  ::close(socket_of);
  return answer;
}

/// Sends bytes as they are, and gives what came back until the server closed.
inline std::string exchange(int port, const std::vector<std::string>& pieces, int pause_ms) {
  const int socket_of = connect_to(port);
  for (const std::string& piece : pieces) {
    if (::send(socket_of, piece.data(), piece.size(), MSG_NOSIGNAL) < 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
  }
  return read_to_end(socket_of);
}

/// Connections that have sent the same text, and then nothing.
class HalfSent {
 public:
  HalfSent(int port, int count, const std::string& text) {
    rlimit limit{};
    ::getrlimit(RLIMIT_NOFILE, &limit);
    limit.rlim_cur = limit.rlim_max;  // both ends of each connection may be of this process
    ::setrlimit(RLIMIT_NOFILE, &limit);
    for (int k = 0; k < count; ++k) {
      sockets_.push_back(connect_to(port));
      EXPECT_EQ(::send(sockets_.back(), text.data(), text.size(), MSG_NOSIGNAL),
                static_cast<ssize_t>(text.size()));
    }
  }
  ~HalfSent() {
    for (const int one : sockets_) ::close(one);
  }
  HalfSent(const HalfSent&) = delete;
  HalfSent& operator=(const HalfSent&) = delete;

  int socket(std::size_t number) const { return sockets_[number]; }

 private:
  std::vector<int> sockets_;
};

/// GET of a path. \param seconds until the whole response was there
inline std::string timed_get(int port, const std::string& path, double& seconds) {
  const auto began = std::chrono::steady_clock::now();
  std::string response = exchange(
      port, {"GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"}, 0);
  seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return response;
}

}  // namespace enfilade::tests
