#include <nanobind/stl/string.h>

#include <limits>
#include <type_traits>

#include "python/src/bindings.h"
#include "python/src/mattersim/arguments.h"
#include "python/src/mattersim/simulator.h"

namespace enfilade::python::mattersim {
namespace {

// Makes a call and converts exceptions to the types of the old binding.
template <class F>
auto as_before(const F& f) {
  try {
    return f();
  } catch (const UnknownScan& error) {
    throw nb::index_error(error.what());
  } catch (const WrongOrder& error) {
    PyErr_SetString(PyExc_RuntimeError, error.what());
    throw nb::python_error();
  } catch (const Error& error) {
    throw nb::value_error(error.what());
  }
}

template <class T>
T converted(PyObject* o, const char* name) {
  if constexpr (std::is_same_v<T, bool>) {
    return to_flag(o, name);
  } else if constexpr (std::is_floating_point_v<T>) {
    return to_angle(o, name);
  } else {
    return static_cast<T>(
        to_integer(o, name, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
  }
}

// An argument of any type, None included: None is an unset flag.
template <class>
auto anything() {
  return nb::arg().none();
}

/// Binds a method of numbers and flags, converted as the old binding did.
template <class R, class... Args>
void def(nb::class_<Simulator>& c, const char* name, R (Simulator::*function)(Args...),
         const char* doc) {
  c.def(
      name,
      [=](Simulator& self, std::conditional_t<true, nb::handle, Args>... args) {
        return as_before([&] { return (self.*function)(converted<Args>(args.ptr(), name)...); });
      },
      doc, anything<Args>()...);
}

/// Binds a method that takes the objects unconverted. Without anything(), so that calls at each
/// step take nanobind's fastest path.
template <class... Objects>
void def_of_objects(nb::class_<Simulator>& c, const char* name,
                    void (Simulator::*function)(Objects...), const char* doc) {
  c.def(
      name,
      [=](Simulator& self, std::conditional_t<true, nb::handle, Objects>... args) {
        as_before([&] { (self.*function)(args.ptr()...); });
      },
      doc);
}

/// Binds a setter of one setting, used at the next initialize(). \tparam Value the type in Python
template <class Value, class T>
void def_setting(nb::class_<Simulator>& c, const char* name, T Settings::*field, const char* doc) {
  c.def(
      name,
      [=](Simulator& self, nb::handle value) {
        as_before([&] { self.set(field, converted<Value>(value.ptr(), name), name); });
      },
      doc, anything<Value>());
}

nb::object get_state(Simulator& self) {
  return as_before([&] { return self.get_state(); });
}

void bind_setters(nb::class_<Simulator>& c) {
  def_of_objects(c, "setDatasetPath", &Simulator::set_dataset_path,
                 "Folder of the scans' images. Default ./data/v1/scans/ (v0.1: ./data).");
  def_of_objects(c, "setNavGraphPath", &Simulator::set_nav_graph_path,
                 "Folder of scans.txt and <scan>_connectivity.json. Default ./connectivity.");
  def_setting<bool>(c, "setRenderingEnabled", &Settings::rendering,
                    "False: no image is opened. Default True.");
  def(c, "setCameraResolution", &Simulator::set_camera_resolution,
      "Width and height, pixels. Default 320, 240. Takes effect at the next action.");
  def(c, "setCameraVFOV", &Simulator::set_camera_vfov,
      "Vertical field of view, radians. Default 0.8. Takes effect at the next action.");
  def(c, "setElevationLimits", &Simulator::set_elevation_limits,
      "Radians, -pi/2 < min < 0 < max < pi/2, else nothing changes and False is returned.");
  def_setting<bool>(c, "setDiscretizedViewingAngles", &Settings::discretized,
                    "36 views: 12 headings x 3 elevations of 30 degrees. Default False.");
  def_setting<bool>(c, "setRestrictedNavigation", &Settings::restricted,
                    "Only viewpoints within the image's width are navigable. Default True.");
  def_setting<bool>(
      c, "setPreloadingEnabled", &Settings::preloading,
      "Decode all images of all scans at initialize(), and keep them. Default False.");
  def_setting<bool>(c, "setDepthEnabled", &Settings::depth, "Draw depth too. Default False.");
  def_setting<unsigned>(c, "setBatchSize", &Settings::batch_size, "Agents. Default 1.");
  def_setting<unsigned>(c, "setCacheSize", &Settings::cache_panoramas,
                        "Decoded panoramas to keep. Default 200.");
  def(c, "setSeed", &Simulator::set_seed, "Seed of random starts. Default 1 (v0.1: the clock).");
}

}  // namespace

void bind(nb::module_& m) {
  if (add_types(m.ptr()) != 0) throw nb::python_error();
  nb::class_<Simulator> c(m, "Simulator", nb::is_weak_referenceable(),
                          "The old simulator's interface, v0.2 (lists) and v0.1 (scalars).");
  c.attr("__module__") = "MatterSim";
  c.def("__init__", [](Simulator* self) { as_before([&] { new (self) Simulator(); }); });
  bind_setters(c);
  def(c, "initialize", &Simulator::initialize, "Applies the settings; v0.2.");
  def(c, "init", &Simulator::init, "Applies the settings; v0.1.");
  def(c, "close", &Simulator::close, "Releases the images; initialize() starts again.");
  def_of_objects(
      c, "newEpisode", &Simulator::new_episode,
      "newEpisode(scanIds, viewpointIds, headings, elevations): lists with one element per agent "
      "(v0.2), or scalars (v0.1, where viewpoint \"\" is a random one).");
  def_of_objects(c, "newRandomEpisode", &Simulator::new_random_episode,
                 "newRandomEpisode(scanIds): random viewpoints, the old simulator's headings.");
  def_of_objects(
      c, "makeAction", &Simulator::make_action,
      "makeAction(indices, headings, elevations): move to navigableLocations[index], then turn by "
      "heading and elevation, radians.");
  c.def("getState", get_state,
        "A list of SimStates that later actions change (v0.2), or a copy of one (v0.1).");
  def(c, "resetTimers", &Simulator::reset_timers, "Resets timingInfo().");
  c.def(
      "timingInfo", [](const Simulator& self) { return self.timing_info(); },
      "Times of the simulator's parts, as text.");
  bind_cbf(m);
}

}  // namespace enfilade::python::mattersim
