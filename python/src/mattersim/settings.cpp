#include <fmt/format.h>

#include <cstdlib>
#include <string_view>
#include <utility>

#include "enfilade/core/errors.h"
#include "python/src/mattersim/arguments.h"
#include "python/src/mattersim/simulator.h"

namespace enfilade::python::mattersim {
namespace {

constexpr const char* kVariable = "ENFILADE_MATTERSIM";

void set_option(Options& options, std::string_view word) {
  for (const auto& [name, option] : {std::pair("8bit-depth", &Options::eight_bit_depth),
                                     std::pair("smooth-edges", &Options::smooth_edges),
                                     std::pair("perspective-fov", &Options::perspective_view),
                                     std::pair("uniform-starts", &Options::uniform_starts),
                                     std::pair("one-stream", &Options::one_stream),
                                     std::pair("shared-cache", &Options::shared_cache)}) {
    if (word == name) {
      options.*option = true;
      return;
    }
  }
  throw ArgumentError(
      fmt::format("{}: '{}': 8bit-depth, smooth-edges, perspective-fov, "
                  "uniform-starts, one-stream and shared-cache are allowed, with commas between",
                  kVariable, word));
}

}  // namespace

Options Options::from_environment() {
  Options options;
  const char* value = std::getenv(kVariable);
  std::string_view rest = value == nullptr ? "" : value;
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    if (comma > 0) set_option(options, rest.substr(0, comma));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return options;
}

void Simulator::warn_if_begun(const char* setter) const {
  if (!begun_) return;
  const char* begin = api_ == Api::kV1 ? "init()" : "initialize()";
  const int failed = PyErr_WarnFormat(PyExc_RuntimeWarning, 1,
                                      "%s() after %s takes effect at the next %s only; "
                                      "Matterport3DSimulator did not warn",
                                      setter, begin, begin);
  if (failed != 0) throw nb::python_error();  // Python was told to raise warnings as errors
}

void Simulator::set_dataset_path(PyObject* path) {
  const Busy busy(busy_);
  settings_.dataset_path = to_text(path, "setDatasetPath()");
  if (begun_ && api_ == Api::kV1) {
    active_.dataset_path = settings_.dataset_path;
    pictures_.reset();
  } else {
    warn_if_begun("setDatasetPath");
  }
}

void Simulator::set_nav_graph_path(PyObject* path) {
  const Busy busy(busy_);
  settings_.nav_graph_path = to_text(path, "setNavGraphPath()");
  if (begun_ && api_ == Api::kV1) {
    active_.nav_graph_path = settings_.nav_graph_path;
    path_changed_ = true;
  } else {
    warn_if_begun("setNavGraphPath");
  }
}

void Simulator::set_camera_resolution(int width, int height) {
  const Busy busy(busy_);
  if (begun_ && (width < 1 || height < 1)) {
    throw ArgumentError(fmt::format("setCameraResolution: {} x {} pixels; at least 1 x 1 is needed",
                                    width, height));
  }
  settings_.width = active_.width = width;
  settings_.height = active_.height = height;
  camera_changed_ = true;
}

void Simulator::set_camera_vfov(double vfov) {
  const Busy busy(busy_);
  if (begun_ && !(vfov > 0 && vfov < kPi)) {
    throw ArgumentError(
        fmt::format("setCameraVFOV: {} radians; more than 0 and less than pi is needed", vfov));
  }
  settings_.vertical_field_of_view = active_.vertical_field_of_view = vfov;
  camera_changed_ = true;
}

bool Simulator::set_elevation_limits(double min, double max) {
  const Busy busy(busy_);
  if (!(-kPi / 2 < min && min < 0 && 0 < max && max < kPi / 2)) return false;
  settings_.limits = active_.limits = {Radians(min), Radians(max)};
  camera_changed_ = true;
  return true;
}

void Simulator::set_seed(int seed) {
  const Busy busy(busy_);
  seed_ = seed;
  seed_stream();
}

// The old simulator converted a negative seed to an unsigned integer of 64 bits.
void Simulator::seed_stream() {
  random_ = sim::MatterSimRandom(static_cast<std::uint64_t>(std::int64_t{*seed_}));
}

void Simulator::reset_timers() {
  const Busy busy(busy_);
  frames_ = 0;
  step_seconds_ = draw_seconds_ = preload_seconds_ = 0;
}

std::string Simulator::timing_info() const {
  const Busy busy(busy_);
  const auto frames = static_cast<double>(frames_);
  const double ms = frames > 0 ? 1e3 * draw_seconds_ / frames : 0;
  return fmt::format(
      "preloading: {:.2f} minutes\nframes: {}\nmoving and drawing: {:.3f} ms a frame ({:.1f} "
      "frames/s)\nmoving without drawing: {:.3f} s\n",
      preload_seconds_ / 60, frames_, ms, ms > 0 ? 1e3 / ms : 0, step_seconds_);
}

nb::object Simulator::get_state() {
  const Busy busy(busy_);
  if (api_ != Api::kV1) {  // before initialize(): []
    if (!states_) return own(PyList_New(0));
    return own(PyList_GetSlice(states_.ptr(), 0, PyList_Size(states_.ptr())));
  }
  const nb::object state = nb::borrow(PyList_GetItem(states_.ptr(), 0));
  const SimStateObject& fields = as_state(state.ptr());
  if (fields.location == Py_None) {
    throw WrongOrder("MatterSim: newEpisode must be called before getState");
  }
  return copy_state(fields, copy_pixels(fields.rgb));
}

}  // namespace enfilade::python::mattersim
