#include "enfilade/service/detail/answer_limits.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <algorithm>
#include <condition_variable>
#include <cstddef>

namespace enfilade::service::detail {
namespace {

// The system counts for us, so the bytes of one pause may come in addition.
constexpr std::chrono::milliseconds kPause{20};

/// By the system's count; 0 where it has none.
std::uint64_t received_by(int socket) {
  tcp_info info{};
  socklen_t size = sizeof info;
  const bool good = ::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) == 0;
  return good ? info.tcpi_bytes_received : 0;
}

}  // namespace

AnswerLimits::AnswerLimits(std::chrono::duration<double> time, std::uint64_t bytes)
    : latest_(std::chrono::steady_clock::now() +
              std::chrono::duration_cast<std::chrono::steady_clock::duration>(time)),
      most_bytes_(bytes),
      looking_([this](const std::stop_token& stop) { look(stop); }) {}

AnswerLimits::~AnswerLimits() {
  looking_.request_stop();
  looking_.join();
  if (socket_ >= 0) ::close(socket_);
}

void AnswerLimits::watch(int socket) {
  const std::scoped_lock lock(mutex_);
  if (socket_ >= 0) ::close(socket_);
  socket_ = ::dup(socket);
  if (passed_ != Passed::kNone) ::shutdown(socket_, SHUT_RDWR);
}

void AnswerLimits::look(const std::stop_token& stop) {
  std::condition_variable_any none;
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested() && passed_ == Passed::kNone) {
    none.wait_until(lock, stop, std::min(std::chrono::steady_clock::now() + kPause, latest_),
                    [] { return false; });
    if (socket_ >= 0 && received_by(socket_) > most_bytes_) end(Passed::kBytes);
    if (std::chrono::steady_clock::now() >= latest_) end(Passed::kTime);
  }
}

void AnswerLimits::end(Passed passed) {
  if (passed_ != Passed::kNone) return;
  passed_ = passed;
  if (socket_ >= 0) ::shutdown(socket_, SHUT_RDWR);
}

}  // namespace enfilade::service::detail
