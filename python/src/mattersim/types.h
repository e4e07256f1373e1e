/// \file  MatterSim's value types as Python objects: SimState, ViewPoint, Mat.
///
/// Written against CPython rather than nanobind because old code reads fifty attributes per step: a
/// member that holds a Python object is read without a call. All functions need the GIL.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <cstddef>
#include <cstdint>
#include <memory>
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

namespace enfilade::python::mattersim {

/// MatterSim.ViewPoint. Every field is filled, except `point`, which is made at first read.
struct ViewPointObject {
  PyObject_HEAD PyObject* viewpoint_id;  // str
  PyObject* ix;                          // int: index in the connectivity file
  PyObject *x, *y, *z;                   // float: metres, world frame
  PyObject* rel_heading;                 // float: radians, right positive
  PyObject* rel_elevation;               // float: radians, up positive
  PyObject* rel_distance;                // float: metres
  PyObject* point;                       // list [x, y, z], as in v0.1; null until it is read
};

/// MatterSim.SimState. In v0.2 its simulator changes it at each action; in v0.1 it is a copy.
struct SimStateObject {
  PyObject_HEAD PyObject* scan_id;
  PyObject* step;
  PyObject* rgb;    // null: not drawn
  PyObject* depth;  // likewise
  PyObject* location;
  PyObject* heading;
  PyObject* elevation;
  PyObject* view_index;
  PyObject* navigable;          // list
  std::uint32_t width, height;  // of v0.2's black images if nothing is drawn
  bool is_copy;                 // v0.1
};

/// Pixels with their owner: shape (height, width, channels), row 0 on top, no padding.
struct Pixels {
  std::shared_ptr<std::byte[]> memory;  ///< may hold other images too
  std::size_t offset = 0;               ///< bytes
  std::uint32_t width = 0, height = 0, channels = 0;
  std::uint32_t value_bytes = 1;  ///< 1: uint8, 2: uint16

  std::byte* data() const { return memory.get() + offset; }
  std::size_t bytes() const { return std::size_t{width} * height * channels * value_bytes; }
};

/// Makes the three types, once per process, and adds them to the module. -1 with a Python error
/// set.
int add_types(PyObject* module);

/// The constant attributes of a viewpoint, as Python objects.
struct ViewpointNames {
  nb::object viewpoint_id, ix, x, y, z;
};
struct Relative {
  double heading = 0, elevation = 0, distance = 0;
};

nb::object make_viewpoint(const ViewpointNames& names, const Relative& relative);
/// Sets rel_* to 0, as v0.2 does for the viewpoint that the agent moved to.
void become_here(ViewPointObject& viewpoint);
/// All 0, no location, an empty list; black images of that size.
nb::object make_state(std::uint32_t width, std::uint32_t height);
/// A NumPy array with the content of a Mat; a null object for null. Imports NumPy.
nb::object copy_pixels(PyObject* mat);
/// A copy for v0.1; `rgb` may be null.
nb::object copy_state(const SimStateObject& state, nb::object rgb);
nb::object make_mat(const Pixels& pixels);

// \pre the object is of that type
inline SimStateObject& as_state(PyObject* o) { return *reinterpret_cast<SimStateObject*>(o); }
inline ViewPointObject& as_viewpoint(PyObject* o) { return *reinterpret_cast<ViewPointObject*>(o); }

}  // namespace enfilade::python::mattersim
