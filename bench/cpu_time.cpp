#include "bench/cpu_time.h"

#include <sched.h>
#include <ctime>

namespace enfilade::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

double thread_cpu_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double process_cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

PinnedThread::PinnedThread() {
  cpu_set_t one;
  CPU_ZERO(&one);
  const int core = sched_getcpu();
  if (core < 0 || sched_getaffinity(0, sizeof before_, &before_) != 0) return;
  CPU_SET(static_cast<unsigned>(core), &one);
  pinned_ = sched_setaffinity(0, sizeof one, &one) == 0;
}

PinnedThread::~PinnedThread() {
  if (pinned_) sched_setaffinity(0, sizeof before_, &before_);
}

}  // namespace enfilade::bench
