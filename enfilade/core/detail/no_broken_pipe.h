/// \file  A signal that libraries of networks leave to their callers. Internal.
#pragma once
#include <pthread.h>
#include <signal.h>
#include <ctime>

namespace enfilade::detail {

/// Keeps SIGPIPE from the thread that makes it, until it ends there. OpenSSL writes without
/// MSG_NOSIGNAL, so a connection that was shut down would end the program.
class NoBrokenPipe {
 public:
  NoBrokenPipe() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoBrokenPipe() {
    constexpr timespec kNow{};
    while (sigismember(&before_, SIGPIPE) == 0 && sigtimedwait(&pipe_, nullptr, &kNow) > 0) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoBrokenPipe(const NoBrokenPipe&) = delete;
  NoBrokenPipe& operator=(const NoBrokenPipe&) = delete;

 private:
  sigset_t pipe_{}, before_{};
};

}  // namespace enfilade::detail
