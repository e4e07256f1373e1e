/// \file  References to Python objects, for code written against CPython. It uses the stable ABI,
/// so that one module serves all Pythons from 3.12 on.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <string>
#include <utility>

namespace enfilade::python {

namespace nb = nanobind;

/// Owns a new reference that CPython returned. \throws nb::python_error, the current error, for
/// null
inline nb::object own(PyObject* o) {
  if (o == nullptr) throw nb::python_error();
  return nb::steal(o);
}

/// A type's name as in CPython's own messages: "int", "numpy.ndarray". The stable ABI does not show
/// the field with it.
inline std::string type_name(PyTypeObject* type) {
  const nb::handle object(reinterpret_cast<PyObject*>(type));
  const auto name = nb::cast<std::string>(object.attr("__qualname__"));
  const auto module = nb::cast<std::string>(object.attr("__module__"));
  return module == "builtins" ? name : module + "." + name;
}

/// Puts a new reference into `slot` and releases the previous one.
inline void put(PyObject*& slot, nb::object value) noexcept {
  PyObject* old = std::exchange(slot, value.release().ptr());
  Py_XDECREF(old);
}

}  // namespace enfilade::python
