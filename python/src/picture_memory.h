/// \file  Memory of pictures, used again once Python has let go of it.
#pragma once
#include <nanobind/nanobind.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace enfilade::python {

/// Gives NumPy arrays whose memory comes back when the last view of them is gone, and is then given
/// again: the system's zeroing of fresh pages would take a fifth of the time of drawing on them.
/// Keeps the last few that came back. Any thread.
class PictureMemory {
 public:
  PictureMemory();
  /// What it holds is left over. \param type "uint8", "uint16", "uint32" or "float32"
  /// \throws ArgumentError for another type; std::bad_alloc
  nanobind::object array(std::span<const std::size_t> shape, const std::string& type);

 private:
  struct Store;
  struct Block;
  std::shared_ptr<Store> store_;  // outlives this in the arrays
};

}  // namespace enfilade::python
