#include "enfilade/core/threads.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <string>
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

// An arena of the calling thread, so that it runs no other thread's tasks. Kept: oneTBB 2021.8 does
// not free each arena that is given up, 7 kB, and looks through them all in each later call.
tbb::task_arena& own_arena(int threads) {
  thread_local std::map<int, tbb::task_arena> arenas;
  return arenas.try_emplace(threads, threads).first->second;
}

void run(std::size_t count, std::size_t grain, int threads, RangeBody body) {
  const auto share = [&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, grain),
        [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); },
        tbb::simple_partitioner());
  };
  // A call in a body has the same arena: while it waits, it must not run the outer call's bodies.
  own_arena(threads).execute([&] { tbb::this_task_arena::isolate(share); });
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

namespace {

std::optional<std::uint64_t> number_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::uint64_t value = 0;
  if (in >> value) return value;
  return std::nullopt;  // also for "max", no limit
}

// The value of a line "NAME: 123 kB", in bytes.
std::optional<std::uint64_t> kib_in(const std::filesystem::path& file, const std::string& name) {
  std::ifstream in(file);
  std::string word;
  while (in >> word) {
    std::uint64_t value = 0;
    if (word == name && in >> value) return value * 1024;
    in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return std::nullopt;
}

// The folder of this process's cgroup: the line "0::/its/path" names it.
std::filesystem::path own_cgroup(const std::filesystem::path& proc,
                                 const std::filesystem::path& root) {
  std::ifstream in(proc / "self/cgroup");
  std::string line;
  while (std::getline(in, line)) {
    if (line.starts_with("0::/")) return root / line.substr(4);
  }
  return root;
}

}  // namespace

std::uint64_t available_memory(const std::filesystem::path& proc,
                               const std::filesystem::path& cgroup) {
  std::uint64_t available = kib_in(proc / "meminfo", "MemAvailable:").value_or(0);
  // Inside a container the process's cgroup is often the root of what it sees.
  for (const auto& folder : {own_cgroup(proc, cgroup), cgroup}) {
    const auto limit = number_in(folder / "memory.max");
    const auto used = number_in(folder / "memory.current");
    if (!limit || !used) continue;
    const std::uint64_t left = *limit - std::min(*limit, *used);
    available = available == 0 ? left : std::min(available, left);
  }
  return available;
}

}  // namespace enfilade
