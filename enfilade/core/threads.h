/// \file  Parallel loops, and what this process may use of the machine: cores, memory.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <type_traits>

namespace enfilade {

/// Reference to a callable. Does not allocate or own; valid as long as the callable exists.
class RangeBody {
 public:
  /// From any callable (begin, end). Keeps a reference: the callable must outlive the loop.
  template <class F>
    requires(!std::is_same_v<std::remove_cvref_t<F>, RangeBody>)
  RangeBody(const F& body)  // NOLINT(google-explicit-constructor): made for call sites
      : object_(std::addressof(body)), call_([](const void* object, std::size_t a, std::size_t b) {
          (*static_cast<const F*>(object))(a, b);
        }) {}
  void operator()(std::size_t begin, std::size_t end) const { call_(object_, begin, end); }

 private:
  const void* object_;
  void (*call_)(const void*, std::size_t, std::size_t);
};

/// Number of cores that this process may use, at least 1.
int available_threads() noexcept;
/// `threads`; all cores if it is not positive.
inline int threads_or_all(int threads) noexcept {
  return threads > 0 ? threads : available_threads();
}

/// Calls body(begin, end) for ranges that cover 0 .. count-1 once, with at most `grain` items each
/// (or all in one call if there is one thread). Returns when all calls have returned.
/// \param threads 0: all cores; 1: the calling thread. Results must not depend on how the range is
/// split. With several threads the call may allocate.
/// \throws the exception of one failing call, in the calling thread, after the others have ended
void parallel_for(std::size_t count, std::size_t grain, int threads, RangeBody body);

/// Bytes that are free, or can be freed without swapping. The smaller of the machine's
/// (MemAvailable) and those left to the process's cgroup (version 2, as in a container). 0 if the
/// system does not report it.
/// \param proc, cgroup the system's folders; other folders in tests
std::uint64_t available_memory(const std::filesystem::path& proc = "/proc",
                               const std::filesystem::path& cgroup = "/sys/fs/cgroup");

}  // namespace enfilade
