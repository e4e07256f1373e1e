/// \file  Memory of images, reused when Python has released it.
#pragma once
#include <nanobind/nanobind.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string>

namespace enfilade::python {

/// Makes NumPy arrays. Their memory is reused after the last view of them is gone: zeroing new
/// pages would take the system a fifth of the drawing time. Keeps the memory of the last few
/// arrays. Any thread.
class PictureMemory {
 public:
  PictureMemory();
  /// Its content is undefined. \param type "uint8", "uint16", "uint32" or "float32"
  /// \throws ArgumentError for another type; std::bad_alloc
  nanobind::object array(std::span<const std::size_t> shape, const std::string& type);

 private:
  struct Store;
  struct Block;
  std::shared_ptr<Store> store_;  // outlives this in the arrays
};

}  // namespace enfilade::python
