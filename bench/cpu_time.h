/// \file  Processor time, and a thread that stays on its core: figures that other programs disturb
/// least.
#pragma once
#include <sched.h>

namespace enfilade::bench {

/// Seconds of processor time that the calling thread has used.
double thread_cpu_seconds();
/// The same of all threads of the process.
double process_cpu_seconds();

/// Keeps the calling thread on the core it is on, until destroyed. Does nothing where the system
/// refuses.
class PinnedThread {
 public:
  PinnedThread();
  ~PinnedThread();
  PinnedThread(const PinnedThread&) = delete;
  PinnedThread& operator=(const PinnedThread&) = delete;

 private:
  cpu_set_t before_{};
  bool pinned_ = false;
};

}  // namespace enfilade::bench
