/// \file  The parts of the extension module, and how arrays pass between Python and C++.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <span>

namespace enfilade::python {

namespace nb = nanobind;

/// One value an agent (or view); other types of numbers are converted, others' memory is read as
/// is.
template <class T>
using Row = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

template <class T>
std::span<const T> span_of(const Row<T>& row) {
  return {row.data(), row.size()};
}

/// A view of memory that `owner` keeps, for NumPy; `T` const: read-only.
template <class T, class... Sizes>
nb::object array_of(T* data, nb::handle owner, Sizes... sizes) {
  return nb::cast(nb::ndarray<nb::numpy, T>(data, {static_cast<std::size_t>(sizes)...}, owner));
}

void bind_features(nb::module_& module);
void bind_graphs(nb::module_& module);
void bind_dataset(nb::module_& module);
void bind_simulator(nb::module_& module);
void bind_renderer(nb::module_& module);
void bind_r2r(nb::module_& module);
void bind_environment(nb::module_& module);

}  // namespace enfilade::python
