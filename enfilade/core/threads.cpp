#include "enfilade/core/threads.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#if EN_WITH_TBB
#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace enfilade {
namespace {

#if EN_WITH_TBB

void run(std::size_t count, std::size_t grain, int threads, RangeBody body) {
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, grain),
        [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); },
        tbb::simple_partitioner());
  });
}

#else

// Used instead of oneTBB with thread sanitizer: Debian's oneTBB is not instrumented, so that each
// task handed over would be reported as a race.
void run(std::size_t count, std::size_t grain, int threads, RangeBody body) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    for (std::size_t begin = next.fetch_add(grain); begin < count; begin = next.fetch_add(grain)) {
      try {
        body(begin, std::min(begin + grain, count));
      } catch (...) {
        const std::scoped_lock lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::jthread> helpers;
  for (int i = 1; i < threads; ++i) helpers.emplace_back(work);
  work();
  helpers.clear();
  if (failure) std::rethrow_exception(failure);
}

#endif

}  // namespace

int available_threads() noexcept {
#if EN_WITH_TBB
  return std::max(1, tbb::info::default_concurrency());
#else
  // Read once: the standard library opens a kernel file each time, which takes as long as drawing a
  // small picture. It would also count cores that this process may not use.
  static const int kCores = [] {
    cpu_set_t allowed;
    const bool known = sched_getaffinity(0, sizeof(allowed), &allowed) == 0;
    return known ? CPU_COUNT(&allowed) : static_cast<int>(std::thread::hardware_concurrency());
  }();
  return std::max(1, kCores);
#endif
}

void parallel_for(std::size_t count, std::size_t grain, int threads, RangeBody body) {
  if (count == 0) return;
  // More threads than cores gain nothing, and oneTBB would print a warning to stderr.
  const int wanted = threads <= 0 ? available_threads() : std::min(threads, available_threads());
  if (wanted == 1 || count <= grain) {
    body(0, count);
    return;
  }
  run(count, std::max<std::size_t>(grain, 1), wanted, body);
}

}  // namespace enfilade
