// The module enfilade._eyes.habitat: Habitat's floor, bodies and follower, which the package
// habitat_sim stands on. Points are given as any sequence of three numbers and come back as tuples.
#include <fmt/ranges.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "enfilade/continuous/habitat/greedy_follower.h"
#include "enfilade/continuous/habitat/sensors.h"
#include "enfilade/continuous/habitat/settings_table.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/mesh/read_mesh.h"
#include "python/src/arrays.h"
#include "python/src/errors.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace enfilade::python {
namespace {

using namespace continuous::habitat;

template <std::size_t n>
std::array<float, n> numbers_of(nb::handle given, const char* name) {
  std::array<float, n> out;
  if (!PySequence_Check(given.ptr()) ||
      PySequence_Size(given.ptr()) != static_cast<Py_ssize_t>(n)) {
    PyErr_Clear();
    throw nb::type_error(fmt::format("{}: a sequence of {} numbers is wanted", name, n).c_str());
  }
  for (std::size_t k = 0; k < n; ++k) {
    const nb::object item = nb::steal(PySequence_GetItem(given.ptr(), static_cast<Py_ssize_t>(k)));
    if (!item.is_valid()) throw nb::python_error();
    const double value = PyFloat_AsDouble(item.ptr());
    if (value == -1.0 && PyErr_Occurred() != nullptr) throw nb::python_error();
    out[k] = static_cast<float>(value);
  }
  return out;
}
Vec3f point_from(nb::handle given, const char* name) {
  const auto [x, y, z] = numbers_of<3>(given, name);
  return {x, y, z};
}
Pose pose_from(nb::handle position, nb::handle rotation) {
  const auto [x, y, z, w] = numbers_of<4>(rotation, "rotation");
  return {point_from(position, "position"), {x, y, z, w}};
}
nb::tuple tuple_of(Vec3f p) { return nb::make_tuple(p.x, p.y, p.z); }
nb::tuple tuple_of(const Rotation& q) { return nb::make_tuple(q.x, q.y, q.z, q.w); }

template <class Enum>
Enum named(const std::string& name, const char* what) {
  if (const auto found = find_enum<Enum>(name)) return *found;
  throw ArgumentError(
      fmt::format("{} '{}': one of {} is wanted", what, name, fmt::join(enum_names<Enum>(), ", ")));
}

nb::object points_array(const std::vector<Vec3f>& points) {
  std::vector<float> out;
  out.reserve(3 * points.size());
  for (const Vec3f p : points) out.insert(out.end(), {p.x, p.y, p.z});
  return owned_array(std::move(out), points.size(), 3);
}
using GoalRows = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

Moves moves_of(bool slide) { return slide ? Moves::kSlide : Moves::kStop; }

std::unique_ptr<PathFinder> make_floor(const std::string& file, const std::string& up,
                                       const NavMeshSettings& settings,
                                       const std::string& navigation) {
  const auto which = named<Navigation>(navigation, "navigation");
  const Upright upright = named<Upright>(up, "up");
  const nb::gil_scoped_release unlocked;
  const mesh::ReadOptions options{.up =
                                      upright == Upright::kZ ? mesh::UpAxis::kZ : mesh::UpAxis::kY};
  const Triangles triangles = triangles_of(mesh::read_mesh(file, options).mesh, upright);
  return std::make_unique<PathFinder>(make_nav_mesh(triangles, settings, which), which);
}

std::unique_ptr<PathFinder> read_floor(nb::bytes data, const std::string& name,
                                       const std::string& navigation, nb::handle bounds) {
  const auto which = named<Navigation>(navigation, "navigation");
  const std::span bytes(static_cast<const std::uint8_t*>(data.data()), data.size());
  NavMesh mesh = parse_nav_mesh(bytes, name);
  if (!bounds.is_none()) {
    mesh.low = point_from(bounds[0], "bounds");
    mesh.high = point_from(bounds[1], "bounds");
  }
  return std::make_unique<PathFinder>(std::move(mesh), which);
}

std::size_t island_of(const PathFinder& floor, int island) {
  if (island < 0 || static_cast<std::size_t>(island) >= floor.islands()) {
    throw nb::index_error(
        fmt::format("island_index {}, not 0 to {}", island, floor.islands()).c_str());
  }
  return static_cast<std::size_t>(island);
}

void bind_floor(nb::module_& m) {
  nb::class_<NavMeshSettings> settings(m, "NavMeshSettings");
  settings.def(nb::init<>())
      .def("set_defaults", [](NavMeshSettings& self) { self = {}; })
      .def(
          "__eq__", [](const NavMeshSettings& a, const NavMeshSettings& b) { return a == b; },
          nb::is_operator());
  for (const NumberSetting& number : kNumberSettings) settings.def_rw(number.name, number.value);
  for (const SwitchSetting& one : kSwitchSettings) settings.def_rw(one.name, one.value);

  nb::class_<GoalBounds>(m, "GoalBounds").def(nb::init<>()).def("reset", [](GoalBounds& self) {
    self = {};
  });

  nb::class_<PathFinder>(m, "Floor")
      .def_static("make", make_floor, "mesh_file"_a, "up"_a, "settings"_a,
                  "navigation"_a = "latest")
      .def_static("read", read_floor, "data"_a, "name"_a, "navigation"_a = "latest",
                  "bounds"_a = nb::none())
      .def("file",
           [](const PathFinder& self) {
             const std::string file = to_nav_mesh_file(self.mesh());
             return nb::bytes(file.data(), file.size());
           })
      .def_prop_ro("settings", [](const PathFinder& self) { return self.mesh().settings; })
      .def_prop_ro("navigation",
                   [](const PathFinder& self) { return std::string(enum_name(self.navigation())); })
      .def_prop_ro("bounds",
                   [](const PathFinder& self) {
                     return nb::make_tuple(tuple_of(self.mesh().low), tuple_of(self.mesh().high));
                   })
      .def_prop_ro("islands", &PathFinder::islands)
      .def_prop_ro("area", &PathFinder::area)
      .def("island",
           [](const PathFinder& self, nb::handle p) { return self.island(point_from(p, "point")); })
      .def("island_radius_at",
           [](const PathFinder& self, nb::handle p) {
             return self.island_radius(point_from(p, "point"));
           })
      .def("island_radius",
           [](const PathFinder& self, int k) { return self.island_radius(island_of(self, k)); })
      .def("island_area",
           [](const PathFinder& self, int k) { return self.island_area(island_of(self, k)); })
      .def(
          "snap",
          [](const PathFinder& self, nb::handle p, int island) {
            return tuple_of(self.snap(point_from(p, "point"), island));
          },
          "point"_a, "island"_a = kAnyIsland)
      .def(
          "is_navigable",
          [](const PathFinder& self, nb::handle p, float most_dy) {
            return self.is_navigable(point_from(p, "point"), most_dy);
          },
          "point"_a, "most_dy"_a = 0.5F)
      .def(
          "closest_obstacle",
          [](const PathFinder& self, nb::handle p, float radius) {
            const Obstacle found = self.closest_obstacle(point_from(p, "point"), radius);
            return nb::make_tuple(tuple_of(found.position), tuple_of(found.normal), found.distance);
          },
          "point"_a, "radius"_a = 2.0F)
      .def("path",
           [](const PathFinder& self, nb::handle start, nb::handle end) {
             const Path found = self.path(point_from(start, "start"), point_from(end, "end"));
             return nb::make_tuple(points_array(found.points), found.length);
           })
      .def("path_to_any",
           [](const PathFinder& self, nb::handle start, const GoalRows& goals, GoalBounds& bounds) {
             std::vector<Vec3f> ends;
             for (std::size_t k = 0; k < goals.shape(0); ++k) {
               ends.push_back({goals(k, 0), goals(k, 1), goals(k, 2)});
             }
             const GoalPath found = self.path(point_from(start, "start"), ends, bounds);
             return nb::make_tuple(points_array(found.path.points), found.path.length, found.goal);
           })
      .def(
          "random_point",
          [](const PathFinder& self, int most_tries, int island) {
            return tuple_of(self.random_point(most_tries, island));
          },
          "most_tries"_a = 10, "island"_a = kAnyIsland)
      .def(
          "random_point_near",
          [](const PathFinder& self, nb::handle centre, float radius, int most_tries, int island) {
            return tuple_of(self.random_point_near(point_from(centre, "circle_center"), radius,
                                                   most_tries, island));
          },
          "centre"_a, "radius"_a, "most_tries"_a = 100, "island"_a = kAnyIsland)
      .def("step",
           [](const PathFinder& self, nb::handle start, nb::handle end, bool slide) {
             return tuple_of(
                 self.step(point_from(start, "start"), point_from(end, "end"), moves_of(slide)));
           })
      .def(
          "vertices",
          [](const PathFinder& self, int island) { return points_array(self.vertices(island)); },
          "island"_a = kAnyIsland)
      .def(
          "topdown",
          [](const PathFinder& self, float metres, float height, float eps) {
            FloorMap<std::uint8_t> map = self.topdown(metres, height, eps);
            return owned_array(std::move(map.values), map.rows, map.columns).attr("view")("bool");
          },
          "metres_per_pixel"_a, "height"_a, "eps"_a = 0.5F)
      .def(
          "topdown_islands",
          [](const PathFinder& self, float metres, float height, float eps) {
            FloorMap<std::int32_t> map = self.topdown_islands(metres, height, eps);
            return owned_array(std::move(map.values), map.rows, map.columns);
          },
          "metres_per_pixel"_a, "height"_a, "eps"_a = 0.5F);
  m.def("seed", &PathFinder::seed);
}

void bind_bodies(nb::module_& m) {
  m.def(
      "act",
      [](nb::handle position, nb::handle rotation, const std::string& motion, double amount,
         const PathFinder* floor, bool slide) {
        Pose pose = pose_from(position, rotation);
        const bool collided =
            act(pose, named<Motion>(motion, "action"), amount, {floor, moves_of(slide)});
        return nb::make_tuple(tuple_of(pose.position), tuple_of(pose.rotation), collided);
      },
      "position"_a, "rotation"_a, "motion"_a, "amount"_a, "floor"_a.none(), "slide"_a);
  m.def("moves_body",
        [](const std::string& motion) { return moves_body(named<Motion>(motion, "action")); });
  m.def("in_world", [](nb::handle position, nb::handle rotation, nb::handle sensor_position,
                       nb::handle sensor_rotation) {
    const Pose pose =
        in_world(pose_from(position, rotation), pose_from(sensor_position, sensor_rotation));
    return nb::make_tuple(tuple_of(pose.position), tuple_of(pose.rotation));
  });
  nb::class_<GreedyFollower>(m, "GreedyFollower")
      .def(
          "__init__",
          [](GreedyFollower* self, const PathFinder& floor, bool slide, float step,
             double turn_degrees, float goal_radius, bool fix_thrashing, std::size_t thrashing) {
            new (self) GreedyFollower(floor, moves_of(slide),
                                      {.step = step,
                                       .turn_degrees = turn_degrees,
                                       .goal_radius = goal_radius,
                                       .fix_thrashing = fix_thrashing,
                                       .thrashing = thrashing});
          },
          "floor"_a, "slide"_a, "step"_a, "turn_degrees"_a, "goal_radius"_a,
          "fix_thrashing"_a = true, "thrashing"_a = 16, nb::keep_alive<1, 2>())
      .def("next",
           [](GreedyFollower& self, nb::handle position, nb::handle rotation, nb::handle goal) {
             return static_cast<int>(
                 self.next(pose_from(position, rotation), point_from(goal, "goal")));
           })
      .def("path",
           [](GreedyFollower& self, nb::handle position, nb::handle rotation, nb::handle goal) {
             std::vector<int> out;
             for (const Follow action :
                  self.path(pose_from(position, rotation), point_from(goal, "goal"))) {
               out.push_back(static_cast<int>(action));
             }
             return out;
           })
      .def("reset", &GreedyFollower::reset);
}

template <class T, class Dims>
using Pixels = std::optional<nb::ndarray<T, Dims, nb::c_contig, nb::device::cpu>>;

template <class T, class Dims>
std::span<T> memory_of(
    const std::optional<nb::ndarray<T, Dims, nb::c_contig, nb::device::cpu>>& pixels) {
  return pixels ? std::span<T>(pixels->data(), pixels->size()) : std::span<T>();
}

// Scenes that are open, so that several simulators of one building share it.
std::shared_ptr<const continuous::Scene> shared_scene(const std::string& file, Upright up,
                                                      bool labels) {
  using Key =
      std::tuple<std::string, Upright, bool, std::filesystem::file_time_type, std::uintmax_t>;
  static std::mutex mutex;
  static std::map<Key, std::weak_ptr<const continuous::Scene>> open;
  std::error_code none;  // the reader says what is wrong with a file
  const Key key{file, up, labels, std::filesystem::last_write_time(file, none),
                std::filesystem::file_size(file, none)};
  const std::scoped_lock lock(mutex);
  std::erase_if(open, [](const auto& one) { return one.second.expired(); });
  if (const auto found = open.find(key); found != open.end()) {
    if (auto scene = found->second.lock()) return scene;
  }
  auto scene = labels ? open_labels(file, up) : open_scene(file, up);
  open.insert_or_assign(key, scene);
  return scene;
}

using Range = std::pair<float, float>;
constexpr Range kUsualRange{Sensor().near, Sensor().far};

Sensor checked(Sensor sensor, Range range) {
  std::tie(sensor.near, sensor.far) = range;
  check(sensor);
  return sensor;
}

Sensor pinhole(std::uint32_t width, std::uint32_t height, double hfov, Range range) {
  return checked({.width = width, .height = height, .horizontal_field_of_view = Radians(hfov)},
                 range);
}
Sensor equirectangular(std::uint32_t width, std::uint32_t height, std::uint32_t cube_size,
                       Range range) {
  return checked(
      {.lens = Lens::kEquirectangular, .width = width, .height = height, .cube_size = cube_size},
      range);
}
Sensor fisheye(std::uint32_t width, std::uint32_t height, std::pair<double, double> focal,
               std::pair<double, double> middle, double xi, double alpha, std::uint32_t cube_size,
               Range range) {
  return checked(
      {.lens = Lens::kFisheye,
       .width = width,
       .height = height,
       .double_sphere = {focal.first, focal.second, middle.first, middle.second, xi, alpha},
       .cube_size = cube_size},
      range);
}

void bind_sensors(nb::module_& m) {
  nb::class_<Sensor>(m, "Lens")
      .def_static("pinhole", pinhole, "width"_a, "height"_a, "hfov"_a, "range"_a = kUsualRange)
      .def_static("equirectangular", equirectangular, "width"_a, "height"_a, "cube_size"_a = 0,
                  "range"_a = kUsualRange)
      .def_static("fisheye", fisheye, "width"_a, "height"_a, "focal"_a, "middle"_a, "xi"_a,
                  "alpha"_a, "cube_size"_a = 0, "range"_a = kUsualRange)
      .def_ro("width", &Sensor::width)
      .def_ro("height", &Sensor::height)
      .def(
          "__eq__", [](const Sensor& a, const Sensor& b) { return a == b; }, nb::is_operator())
      .def("__hash__", [](const Sensor& self) { return self.width * 8192 + self.height; });
  nb::class_<Sensors>(m, "Sensors")
      .def(
          "__init__",
          [](Sensors* self, const std::string& file, const std::string& up, int threads,
             bool labels) {
            const Upright upright = named<Upright>(up, "up");
            const nb::gil_scoped_release unlocked;
            new (self) Sensors(shared_scene(file, upright, labels), threads);
          },
          "mesh_file"_a, "up"_a, "threads"_a = 0, "labels"_a = false)
      .def(
          "draw",
          [](Sensors& self, const Sensor& sensor, nb::handle position, nb::handle rotation,
             const Pixels<std::uint8_t, nb::shape<-1, -1, 4>>& colour,
             const Pixels<float, nb::ndim<2>>& depth,
             const Pixels<std::uint32_t, nb::ndim<2>>& instance) {
            const Pose pose = pose_from(position, rotation);
            const SensorPicture picture{memory_of(colour), memory_of(depth), memory_of(instance)};
            const nb::gil_scoped_release unlocked;
            self.render(sensor, pose, picture);
          },
          "lens"_a, "position"_a, "rotation"_a, "colour"_a.none(), "depth"_a.none(),
          "instance"_a.none() = nb::none());
}

}  // namespace

void bind_habitat(nb::module_& m) {
  bind_floor(m);
  bind_bodies(m);
  bind_sensors(m);
}

}  // namespace enfilade::python
