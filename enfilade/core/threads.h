/// \file  Loops over all cores.
#pragma once
#include <cstddef>
#include <memory>
#include <type_traits>

namespace enfilade {

/// A callable passed by reference: no allocation, no ownership; valid while the callable lives.
class RangeBody {
 public:
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

/// Cores that this process may use, at least 1.
int available_threads() noexcept;

/// Calls body(begin, end) for ranges that cover 0 .. count-1 once each, at most `grain` items a
/// range (or all in one call if a single thread runs). Returns when all are done.
/// `threads`: 0 = all available, 1 = on the caller. Bodies must not depend on the split: results
/// may not change with the number of threads. With several threads the call may allocate.
/// \throws the exception of one failing body, on the caller, after the others have ended.
void parallel_for(std::size_t count, std::size_t grain, int threads, RangeBody body);

}  // namespace enfilade
