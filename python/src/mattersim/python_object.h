/// \file  References to Python objects, for code that is written against CPython.
#pragma once
#include <nanobind/nanobind.h>

#include <utility>

namespace enfilade::python {

namespace nb = nanobind;

/// Owns a new reference that CPython returned. \throws nb::python_error, the error that is set, for
/// null
inline nb::object own(PyObject* o) {
  if (o == nullptr) throw nb::python_error();
  return nb::steal(o);
}

/// Puts a new reference into `slot` and releases the one that was there.
inline void put(PyObject*& slot, nb::object value) noexcept {
  PyObject* old = std::exchange(slot, value.release().ptr());
  Py_XDECREF(old);
}

}  // namespace enfilade::python
