/// \file  Arrays that pass from C++ to Python.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace enfilade::python {

namespace nb = nanobind;

/// A view of memory that `owner` keeps, for NumPy; `T` const: read-only.
template <class T, class... Sizes>
nb::object array_of(T* data, nb::handle owner, Sizes... sizes) {
  return nb::cast(nb::ndarray<nb::numpy, T>(data, {static_cast<std::size_t>(sizes)...}, owner));
}

/// A new array that owns its numbers, of the given shape.
template <class T, class... Sizes>
nb::object owned_array(std::vector<T> values, Sizes... sizes) {
  auto* kept = new std::vector<T>(std::move(values));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return array_of(kept->data(), owner, sizes...);
}

}  // namespace enfilade::python
