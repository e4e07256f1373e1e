/// \file  A counted reference to a Python object, for code that is written against CPython.
#pragma once
#include <Python.h>

#include <utility>

namespace enfilade::python {

/// Thrown where a Python error is set already.
struct PythonErrorIsSet {};

/// Owns one reference, or none. Needs the GIL, also to be destroyed.
class Object {
 public:
  Object() = default;
  /// Takes over a new reference. \throws PythonErrorIsSet for null
  static Object own(PyObject* o) {
    if (o == nullptr) throw PythonErrorIsSet();
    Object result;
    result.object_ = o;
    return result;
  }
  static Object share(PyObject* o) {
    Py_XINCREF(o);
    Object result;
    result.object_ = o;
    return result;
  }
  Object(const Object& other) : object_(other.object_) { Py_XINCREF(object_); }
  Object(Object&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Object& operator=(Object other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Object() { Py_XDECREF(object_); }

  PyObject* get() const noexcept { return object_; }
  PyObject* release() noexcept { return std::exchange(object_, nullptr); }
  explicit operator bool() const noexcept { return object_ != nullptr; }

 private:
  PyObject* object_ = nullptr;
};

/// Lets go of what `slot` held and puts a new reference there.
inline void put(PyObject*& slot, Object value) noexcept {
  PyObject* old = std::exchange(slot, value.release());
  Py_XDECREF(old);
}

}  // namespace enfilade::python
