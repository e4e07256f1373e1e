/// \file  Enfilade's exceptions as Python's, and a guard against calls from a second thread while
/// the first has released the GIL.
#pragma once
#include <atomic>

#include "enfilade/core/errors.h"

namespace enfilade::python {

/// Raises Enfilade's C++ exceptions as the classes of enfilade/_errors.py.
/// \throws nb::python_error
void bind_errors();

/// A call in the wrong order or from a second thread: Python's RuntimeError.
class WrongOrder : public Error {
 public:
  using Error::Error;
};

/// Held during a call on an object that one thread at a time may use.
class Busy {
 public:
  /// \throws WrongOrder if the flag is held
  explicit Busy(std::atomic_flag& flag) : flag_(flag) {
    if (flag_.test_and_set()) {
      throw WrongOrder("this object is at work in another thread; give each thread its own");
    }
  }
  ~Busy() { flag_.clear(); }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  std::atomic_flag& flag_;
};

}  // namespace enfilade::python
