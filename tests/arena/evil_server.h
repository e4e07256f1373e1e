/// \file  A server that sends bytes as they are, whatever HTTP says, and what evil ones send.
#pragma once
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace enfilade::tests {

/// A request's connection, for what answers it.
class Connection {
 public:
  Connection(int socket, std::string its_head, std::string its_body)
      : head(std::move(its_head)), body(std::move(its_body)), socket_(socket) {}

  /// False if the other end is gone.
  bool send(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  /// Sends bytes again and again, with pauses, until the other end is gone.
  void send_forever(const std::string& bytes, int pause_ms = 0) const {
    std::string many = bytes;
    while (pause_ms == 0 && many.size() < (64U << 10U)) many += bytes;
    while (send(many)) std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
  }
  /// Until the other end is gone.
  void wait() const {
    for (char c = 0; ::recv(socket_, &c, 1, 0) > 0;) {
    }
  }

  std::string head, body;  // of the request

 private:
  int socket_;
};

/// Answers each request by a function, in a thread for each connection, and closes it then.
class EvilServer {
 public:
  using Answer = std::function<void(const Connection& connection)>;
  explicit EvilServer(Answer answer)
      : answer_(std::move(answer)), listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    if (::bind(listener_, any, size) + ::listen(listener_, 64) +
            ::getsockname(listener_, any, &size) !=
        0) {
      throw std::runtime_error("no port");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      for (int socket = 0; (socket = ::accept(listener_, nullptr, nullptr)) >= 0;) {
        threads_.emplace_back([this, socket] { serve(socket); });
      }
    });
  }
  /// The clients are gone by then.
  ~EvilServer() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    for (std::thread& one : threads_) one.join();
    ::close(listener_);
  }
  EvilServer(const EvilServer&) = delete;
  EvilServer& operator=(const EvilServer&) = delete;

  std::string url(const std::string& scheme = "http") const {
    return scheme + "://127.0.0.1:" + std::to_string(port_) + "/v1";
  }
  std::atomic<bool> talks_first = false;  // answers before it reads

 private:
  void serve(int socket) {
    std::string head;
    for (char c = 0;
         !talks_first && !head.ends_with("\r\n\r\n") && ::recv(socket, &c, 1, 0) == 1;) {
      head += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    constexpr std::string_view kLength = "content-length: ";
    const std::size_t at = head.find(kLength);
    std::string body(at == std::string::npos ? 0 : std::stoul(head.substr(at + kLength.size())),
                     '\0');
    if (!body.empty()) ::recv(socket, body.data(), body.size(), MSG_WAITALL);
    if (talks_first || !head.empty()) {
      answer_(Connection(socket, std::move(head), std::move(body)));
    }
    ::shutdown(socket, SHUT_WR);
    Connection(socket, {}, {}).wait();  // else what it still sends would destroy the answer
    ::close(socket);
  }

  Answer answer_;
  int listener_;
  std::uint16_t port_ = 0;
  std::vector<std::thread> threads_;
  std::thread thread_;
};

inline std::string repeated(std::string_view part, std::size_t times) {
  std::string text;
  text.reserve(part.size() * times);
  for (; times > 0; --times) text += part;
  return text;
}

/// A whole response. \param headers each with its end
inline std::string response(std::string_view body, std::string_view status = "200 OK",
                            std::string_view headers = {}) {
  std::string text = "HTTP/1.1 ";
  text.append(status).append("\r\nContent-Type: application/json\r\nConnection: close\r\n");
  text.append(headers).append("Content-Length: ").append(std::to_string(body.size()));
  return text.append("\r\n\r\n").append(body);
}

/// An answer whose call stops, and `more` calls behind it. \param content JSON
inline std::string stop_answer(const std::string& content = "null", std::size_t more = 0) {
  const std::string call =
      R"({"id":"c","type":"function","function":{"name":"stop","arguments":"{}"}})";
  return R"({"choices":[{"message":{"role":"assistant","content":)" + content +
         R"(,"tool_calls":[)" + call + repeated("," + call, more) +
         R"(]},"finish_reason":"tool_calls"}]})";
}

}  // namespace enfilade::tests
