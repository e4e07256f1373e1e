/// \file  A file that the system has opened.
#pragma once

namespace enfilade {

/// Closes a file descriptor in its destructor. Does nothing for a negative one, which stands for a
/// failure of open(). Not to be used by several threads at once.
class Descriptor {
 public:
  /// Takes over `number`, as open() gives it.
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor();
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  /// For system calls; negative if open() failed.
  int number() const noexcept { return number_; }

 private:
  int number_;
};

}  // namespace enfilade
