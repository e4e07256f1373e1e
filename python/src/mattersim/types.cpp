#include "python/src/mattersim/types.h"

#include <structmember.h>

#include <array>
#include <cstdlib>
#include <initializer_list>
#include <vector>

namespace enfilade::python::mattersim {
namespace {

struct MatObject {
  PyObject_HEAD Pixels* pixels;
  std::array<Py_ssize_t, 3> shape, strides;
};

PyTypeObject* viewpoint_type = nullptr;
PyTypeObject* state_type = nullptr;
PyTypeObject* mat_type = nullptr;

PyObject* zero() {
  static PyObject* value = PyFloat_FromDouble(0);
  return value;
}
PyObject* zero_integer() {
  static PyObject* value = PyLong_FromLong(0);
  return value;
}

// A new reference to the same object.
PyObject* shared(PyObject* o) {
  Py_XINCREF(o);
  return o;
}

template <class T>
T* allocate(PyTypeObject* type) {
  auto* object = PyObject_New(T, type);
  if (object == nullptr) throw nb::python_error();
  return object;
}

void free_object(PyObject* self) {
  PyTypeObject* type = Py_TYPE(self);
  PyObject_Free(self);
  Py_DECREF(reinterpret_cast<PyObject*>(type));
}

PyObject* refuse_new(PyTypeObject* type, PyObject*, PyObject*) {
  PyErr_Format(PyExc_TypeError, "%s: No constructor defined! A Simulator makes them.",
               type_name(type).c_str());
  return nullptr;
}

template <class Function>
void* slot(Function function) {
  return reinterpret_cast<void*>(function);
}

// A type whose objects Python code cannot make. `more` are the slots of its attributes.
PyTypeObject* make_type(const char* name, std::size_t size, const char* doc, destructor free,
                        std::initializer_list<PyType_Slot> more) {
  std::vector<PyType_Slot> slots{{Py_tp_dealloc, slot(free)},
                                 {Py_tp_new, slot(refuse_new)},
                                 {Py_tp_doc, const_cast<char*>(doc)}};
  slots.insert(slots.end(), more);
  slots.push_back({});
  PyType_Spec spec{name, static_cast<int>(size), 0, Py_TPFLAGS_DEFAULT, slots.data()};
  return reinterpret_cast<PyTypeObject*>(PyType_FromSpec(&spec));
}

PyMemberDef member(const char* name, std::size_t offset, const char* doc) {
  return {name, T_OBJECT_EX, static_cast<Py_ssize_t>(offset), READONLY, doc};
}

// --- ViewPoint

void free_viewpoint(PyObject* self) {
  ViewPointObject& v = as_viewpoint(self);
  for (PyObject* field : {v.viewpoint_id, v.ix, v.x, v.y, v.z, v.rel_heading, v.rel_elevation,
                          v.rel_distance, v.point}) {
    Py_XDECREF(field);
  }
  free_object(self);
}

PyObject* get_point(PyObject* self, void*) {
  ViewPointObject& v = as_viewpoint(self);
  if (v.point == nullptr) v.point = Py_BuildValue("[OOO]", v.x, v.y, v.z);
  return shared(v.point);
}

PyTypeObject* make_viewpoint_type() {
  static std::array members{
      member("viewpointId", offsetof(ViewPointObject, viewpoint_id), "str: the viewpoint's id."),
      member("ix", offsetof(ViewPointObject, ix),
             "int: index in the scan's connectivity file, excluded viewpoints counted."),
      member("x", offsetof(ViewPointObject, x), "float: metres, world frame."),
      member("y", offsetof(ViewPointObject, y), "float: metres, world frame."),
      member("z", offsetof(ViewPointObject, z), "float: metres, world frame, up."),
      member("rel_heading", offsetof(ViewPointObject, rel_heading),
             "float: radians from the image's centre, right positive."),
      member("rel_elevation", offsetof(ViewPointObject, rel_elevation),
             "float: radians from the image's centre, up positive."),
      member("rel_distance", offsetof(ViewPointObject, rel_distance), "float: metres."),
      PyMemberDef{}};
  static std::array getters{
      PyGetSetDef{"point", get_point, nullptr, "list: [x, y, z], as in v0.1.", nullptr},
      PyGetSetDef{}};
  return make_type("MatterSim.ViewPoint", sizeof(ViewPointObject),
                   "A viewpoint, relative to an agent's view.", free_viewpoint,
                   {{Py_tp_members, members.data()}, {Py_tp_getset, getters.data()}});
}

// --- SimState

void free_state(PyObject* self) {
  SimStateObject& s = as_state(self);
  for (PyObject* field : {s.scan_id, s.step, s.rgb, s.depth, s.location, s.heading, s.elevation,
                          s.view_index, s.navigable}) {
    Py_XDECREF(field);
  }
  free_object(self);
}

PyObject* black_picture(const SimStateObject& s, std::uint32_t channels, std::uint32_t bytes) {
  Pixels pixels{nullptr, 0, s.width, s.height, channels, bytes};
  // calloc: the system allocates pages of zeros at first use; these are rarely used.
  pixels.memory = {static_cast<std::byte*>(std::calloc(pixels.bytes() + 1, 1)), std::free};
  if (!pixels.memory) return PyErr_NoMemory();
  return make_mat(pixels).release().ptr();
}

PyObject* get_picture(PyObject*& picture, const SimStateObject& s, std::uint32_t channels,
                      std::uint32_t bytes) {
  if (picture == nullptr && s.is_copy) {
    PyErr_SetString(PyExc_TypeError,
                    "rgb: nothing is drawn: setRenderingEnabled(False) was called");
    return nullptr;
  }
  if (picture == nullptr) picture = black_picture(s, channels, bytes);
  return shared(picture);
}

PyObject* get_rgb(PyObject* self, void*) {
  SimStateObject& s = as_state(self);
  return get_picture(s.rgb, s, 3, 1);
}

PyObject* get_depth(PyObject* self, void*) {
  SimStateObject& s = as_state(self);
  if (s.is_copy) {
    PyErr_SetString(PyExc_AttributeError,
                    "depth: v0.1's states have none; initialize() gives v0.2");
    return nullptr;
  }
  return get_picture(s.depth, s, 1, 2);
}

// v0.2 returns a new list at each access, which callers may change.
PyObject* get_navigable(PyObject* self, void*) {
  const SimStateObject& s = as_state(self);
  if (!s.is_copy) return PyList_GetSlice(s.navigable, 0, PyList_Size(s.navigable));
  return shared(s.navigable);
}

PyTypeObject* make_state_type() {
  static std::array members{
      member("scanId", offsetof(SimStateObject, scan_id), "str: the building."),
      member("step", offsetof(SimStateObject, step), "int: actions since the episode began."),
      member("location", offsetof(SimStateObject, location),
             "ViewPoint: the agent's viewpoint; None before the first episode."),
      member("heading", offsetof(SimStateObject, heading),
             "float: radians clockwise from world +y, [0, 2 pi]."),
      member("elevation", offsetof(SimStateObject, elevation), "float: radians above the horizon."),
      member("viewIndex", offsetof(SimStateObject, view_index),
             "int: 0..35 when discretized (12 headings; down, level, up), else 0."),
      PyMemberDef{}};
  static std::array getters{
      PyGetSetDef{"navigableLocations", get_navigable, nullptr,
                  "list[ViewPoint]: the navigable viewpoints; [0] is the current one.", nullptr},
      PyGetSetDef{"rgb", get_rgb, nullptr,
                  "(height, width, 3) uint8, B G R, row 0 on top: a Mat that later actions draw "
                  "over (v0.2), or an array that is a copy (v0.1).",
                  nullptr},
      PyGetSetDef{"depth", get_depth, nullptr,
                  "Mat: (height, width, 1) uint16, quarter millimetres along the optical axis; 0: "
                  "no reading.",
                  nullptr},
      PyGetSetDef{}};
  return make_type(
      "MatterSim.SimState", sizeof(SimStateObject),
      "The state of an agent: pose, images and navigable viewpoints. World frame: metres, z up; "
      "headings in radians clockwise from +y, elevations above the horizon. In v0.2 the simulator "
      "changes the object, and the pixels of its images, at each action and episode, until close() "
      "or another initialize(). In v0.1 it is a copy. It stays valid without the simulator.",
      free_state, {{Py_tp_members, members.data()}, {Py_tp_getset, getters.data()}});
}

// --- Mat

void free_mat(PyObject* self) {
  delete reinterpret_cast<MatObject*>(self)->pixels;
  free_object(self);
}

int get_buffer(PyObject* self, Py_buffer* view, int) {
  auto& mat = *reinterpret_cast<MatObject*>(self);
  static char byte_format[] = "B";
  static char short_format[] = "H";
  *view = {};
  view->buf = mat.pixels->data();
  view->obj = self;
  Py_INCREF(self);
  view->len = static_cast<Py_ssize_t>(mat.pixels->bytes());
  view->itemsize = mat.pixels->value_bytes;
  view->format = view->itemsize == 2 ? short_format : byte_format;
  view->ndim = 3;
  view->shape = mat.shape.data();
  view->strides = mat.strides.data();
  return 0;
}

PyTypeObject* make_mat_type() {
#if PY_VERSION_HEX >= 0x03090000
  const PyType_Slot buffer{Py_bf_getbuffer, slot(get_buffer)};
#else
  const PyType_Slot buffer{};  // Python 3.8 has no slot for it
#endif
  PyTypeObject* type = make_type(
      "MatterSim.Mat", sizeof(MatObject),
      "An image: np.array(mat, copy=False) shares the simulator's memory, shape (height, width, "
      "channels), row 0 on top.",
      free_mat, {buffer});
#if PY_VERSION_HEX < 0x03090000
  if (type != nullptr) type->tp_as_buffer->bf_getbuffer = get_buffer;
#endif
  return type;
}

int add_type(PyObject* module, const char* name, PyTypeObject* type) {
  if (type == nullptr) return -1;
  auto* object = reinterpret_cast<PyObject*>(type);
  Py_INCREF(object);  // the module takes one reference, ours stays
  return PyModule_AddObject(module, name, object);
}

}  // namespace

int add_types(PyObject* module) {
  if (viewpoint_type == nullptr) viewpoint_type = make_viewpoint_type();
  if (state_type == nullptr) state_type = make_state_type();
  if (mat_type == nullptr) mat_type = make_mat_type();
  if (add_type(module, "ViewPoint", viewpoint_type) != 0) return -1;
  if (add_type(module, "SimState", state_type) != 0) return -1;
  return add_type(module, "Mat", mat_type);
}

nb::object make_viewpoint(const ViewpointNames& names, const Relative& relative) {
  auto* v = allocate<ViewPointObject>(viewpoint_type);
  v->viewpoint_id = shared(names.viewpoint_id.ptr());
  v->ix = shared(names.ix.ptr());
  v->x = shared(names.x.ptr());
  v->y = shared(names.y.ptr());
  v->z = shared(names.z.ptr());
  v->rel_heading = PyFloat_FromDouble(relative.heading);
  v->rel_elevation = PyFloat_FromDouble(relative.elevation);
  v->rel_distance = PyFloat_FromDouble(relative.distance);
  v->point = nullptr;
  return own(reinterpret_cast<PyObject*>(v));
}

void become_here(ViewPointObject& viewpoint) {
  put(viewpoint.rel_heading, nb::borrow(zero()));
  put(viewpoint.rel_elevation, nb::borrow(zero()));
  put(viewpoint.rel_distance, nb::borrow(zero()));
}

nb::object make_state(std::uint32_t width, std::uint32_t height) {
  auto* s = allocate<SimStateObject>(state_type);
  s->scan_id = PyUnicode_FromString("");
  s->step = shared(zero_integer());
  s->rgb = s->depth = nullptr;
  s->location = shared(Py_None);
  s->heading = shared(zero());
  s->elevation = shared(zero());
  s->view_index = shared(zero_integer());
  s->navigable = PyList_New(0);
  s->width = width;
  s->height = height;
  s->is_copy = false;
  return own(reinterpret_cast<PyObject*>(s));
}

nb::object copy_state(const SimStateObject& state, nb::object rgb) {
  auto* s = allocate<SimStateObject>(state_type);
  s->scan_id = shared(state.scan_id);
  s->step = shared(state.step);
  s->rgb = rgb.release().ptr();
  s->depth = nullptr;
  s->location = shared(state.location);
  s->heading = shared(state.heading);
  s->elevation = shared(state.elevation);
  s->view_index = shared(state.view_index);
  s->navigable = PyList_GetSlice(state.navigable, 0, PyList_Size(state.navigable));
  s->width = state.width;
  s->height = state.height;
  s->is_copy = true;
  return own(reinterpret_cast<PyObject*>(s));
}

nb::object copy_pixels(PyObject* mat) {
  if (mat == nullptr) return {};
  const nb::object numpy = own(PyImport_ImportModule("numpy"));
  return own(PyObject_CallMethod(numpy.ptr(), "array", "O", mat));
}

nb::object make_mat(const Pixels& pixels) {
  auto* mat = allocate<MatObject>(mat_type);
  mat->pixels = new Pixels(pixels);
  const auto bytes = static_cast<Py_ssize_t>(pixels.value_bytes);
  const auto width = static_cast<Py_ssize_t>(pixels.width);
  const auto channels = static_cast<Py_ssize_t>(pixels.channels);
  mat->shape = {static_cast<Py_ssize_t>(pixels.height), width, channels};
  mat->strides = {width * channels * bytes, channels * bytes, bytes};
  return own(reinterpret_cast<PyObject*>(mat));
}

}  // namespace enfilade::python::mattersim
