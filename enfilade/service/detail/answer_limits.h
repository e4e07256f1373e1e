/// \file  Limits of a server's answer that hold from the first byte to the last. A client of HTTP
/// has limits of a body; but a proxy's answer, a handshake and a head may have no end either.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <stop_token>
#include <thread>

namespace enfilade::service::detail {

/// From its construction on. What is beyond a limit shuts the connection down, and so ends whatever
/// waits for it.
class AnswerLimits {
 public:
  enum class Passed : std::uint8_t { kNone, kTime, kBytes };

  /// \param bytes that are received on one connection
  AnswerLimits(std::chrono::duration<double> time, std::uint64_t bytes);
  ~AnswerLimits();
  AnswerLimits(const AnswerLimits&) = delete;
  AnswerLimits& operator=(const AnswerLimits&) = delete;

  /// A new connection, before it is made, in place of the former one. It stays the caller's.
  void watch(int socket);
  /// The first limit that was passed.
  Passed passed() const noexcept { return passed_; }

 private:
  void look(const std::stop_token& stop);
  void end(Passed passed);

  std::chrono::steady_clock::time_point latest_;
  std::uint64_t most_bytes_;
  std::mutex mutex_;
  int socket_ = -1;  // a number of its own, so no one else closes it and uses it again
  std::atomic<Passed> passed_ = Passed::kNone;
  std::jthread looking_;  // last: it uses the others
};

}  // namespace enfilade::service::detail
