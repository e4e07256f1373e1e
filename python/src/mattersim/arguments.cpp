#include "python/src/mattersim/arguments.h"

namespace enfilade::python::mattersim {
namespace {

[[noreturn]] void wrong_type(PyObject* o, const char* name, const char* wanted) {
  PyErr_Clear();
  PyErr_Format(PyExc_TypeError, "%s: %R of type %s; %s is wanted", name, o,
               type_name(Py_TYPE(o)).c_str(), wanted);
  throw nb::python_error();
}

// The length of a sequence. IndexError if it is less than `wanted`.
Py_ssize_t checked_size(PyObject* o, const char* name, Py_ssize_t wanted) {
  const Py_ssize_t size = PySequence_Size(o);
  if (size < 0) throw nb::python_error();
  if (size < wanted) {
    too_short(name, static_cast<std::size_t>(size), static_cast<std::size_t>(wanted));
  }
  return size;
}

// Calls use(element) for the first `count` elements; all of them if count is -1.
template <class Use>
void for_each(PyObject* o, const char* name, Py_ssize_t count, const Use& use) {
  if (!is_list(o)) wrong_type(o, name, "a list");
  const Py_ssize_t size = checked_size(o, name, count);
  const Py_ssize_t wanted = count < 0 ? size : count;
  for (Py_ssize_t i = 0; i < wanted; ++i) {
    // use() may call methods of the element, such as __float__, which may change the list: the
    // element is held, and the next one is read only after the length is checked again.
    if (i > 0) checked_size(o, name, wanted);
    const nb::object element = own(PySequence_GetItem(o, i));
    use(element.ptr());
  }
}

// The element of an array of one; a null object for anything else. Clears the Python error.
nb::object only_element(PyObject* o) {
  PyErr_Clear();
  if (PyUnicode_Check(o) || !PyObject_HasAttrString(o, "item")) return {};
  PyObject* item = PyObject_CallMethod(o, "item", nullptr);
  if (item != nullptr) return own(item);
  PyErr_Clear();
  return {};
}

}  // namespace

bool is_text(PyObject* o) { return PyUnicode_Check(o) || PyBytes_Check(o); }

bool is_list(PyObject* o) {
  if (PyList_Check(o) || PyTuple_Check(o)) return true;
  // An array without dimensions is a sequence by its type, but has no length.
  if (is_text(o) || !PySequence_Check(o)) return false;
  if (PySequence_Size(o) >= 0) return true;
  PyErr_Clear();
  return false;
}

std::string to_text(PyObject* o, const char* name) {
  if (PyBytes_Check(o)) {
    char* data = nullptr;
    Py_ssize_t size = 0;
    if (PyBytes_AsStringAndSize(o, &data, &size) != 0) throw nb::python_error();
    return {data, static_cast<std::size_t>(size)};
  }
  if (!PyUnicode_Check(o)) wrong_type(o, name, "a str");
  Py_ssize_t size = 0;
  const char* data = PyUnicode_AsUTF8AndSize(o, &size);
  if (data == nullptr) throw nb::python_error();
  return {data, static_cast<std::size_t>(size)};
}

bool to_flag(PyObject* o, const char* name) {
  if (PyBool_Check(o)) return o == Py_True;
  if (o != Py_None &&
      !PyObject_HasAttrString(reinterpret_cast<PyObject*>(Py_TYPE(o)), "__bool__")) {
    wrong_type(o, name, "True or False");
  }
  const int value = PyObject_IsTrue(o);
  if (value < 0) throw nb::python_error();
  return value != 0;
}

double to_angle(PyObject* o, const char* name) {
  double value = PyFloat_AsDouble(o);
  if (value != -1 || PyErr_Occurred() == nullptr) return value;
  const nb::object item = only_element(o);
  if (item) value = PyFloat_AsDouble(item.ptr());
  if (!item || PyErr_Occurred() != nullptr) wrong_type(o, name, "an angle in radians");
  return value;
}

std::int64_t to_index(PyObject* o, const char* name) {
  if (PyFloat_Check(o)) wrong_type(o, name, "an int");
  PyObject* integer = PyNumber_Index(o);
  if (integer == nullptr) {
    const nb::object item = only_element(o);
    if (item && PyLong_Check(item.ptr())) integer = PyNumber_Index(item.ptr());
  }
  if (integer == nullptr) wrong_type(o, name, "an int");
  const nb::object held = own(integer);
  const std::int64_t value = PyLong_AsLongLong(integer);
  if (value == -1 && PyErr_Occurred() != nullptr) wrong_type(o, name, "an int of 64 bits");
  return value;
}

std::int64_t to_integer(PyObject* o, const char* name, std::int64_t least, std::int64_t most) {
  const std::int64_t value = to_index(o, name);
  if (value >= least && value <= most) return value;
  PyErr_Format(PyExc_TypeError, "%s: %R; an int of %lld to %lld is wanted", name, o,
               static_cast<long long>(least), static_cast<long long>(most));
  throw nb::python_error();
}

std::vector<std::string> to_texts(PyObject* o, const char* name) {
  std::vector<std::string> texts;
  for_each(o, name, -1, [&](PyObject* element) { texts.push_back(to_text(element, name)); });
  return texts;
}

void to_angles(PyObject* o, const char* name, std::size_t count, std::vector<double>& out) {
  out.clear();
  for_each(o, name, static_cast<Py_ssize_t>(count),
           [&](PyObject* element) { out.push_back(to_angle(element, name)); });
}

void to_indices(PyObject* o, const char* name, std::size_t count, std::vector<std::int64_t>& out) {
  out.clear();
  for_each(o, name, static_cast<Py_ssize_t>(count), [&](PyObject* element) {
    out.push_back(to_index(element, name));
    if (out.back() < 0) wrong_type(element, name, "an int of at least 0");
  });
}

void too_short(const char* name, std::size_t found, std::size_t wanted) {
  PyErr_Format(PyExc_IndexError, "%s: %zu elements for a batch of %zu", name, found, wanted);
  throw nb::python_error();
}

}  // namespace enfilade::python::mattersim
