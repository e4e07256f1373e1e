// Navigation meshes, and the simulator of continuous agents.
#include "python/src/continuous.h"

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/follower.h"
#include "python/src/errors.h"

namespace enfilade::python {
namespace {

using namespace nb::literals;
using continuous::Buildings;
using continuous::Floor;
using continuous::FloorPoint;

std::shared_ptr<const Buildings> open_buildings(const std::filesystem::path& folder) {
  const nb::gil_scoped_release unlocked;
  return std::make_shared<const Buildings>(folder);
}

std::size_t checked(const Buildings& buildings, std::size_t building) {
  if (building < buildings.size()) return building;
  throw ArgumentError(
      fmt::format("building {}: 0 to {} are allowed", building, buildings.size() - 1));
}

// The floor points of those rows of an array that have floor within reach.
std::vector<FloorPoint> on_floor(const Floor& floor, const PointRows& points,
                                 continuous::Reach reach) {
  std::vector<FloorPoint> found;
  for (std::size_t i = 0; i < points.shape(0); ++i) {
    if (const auto at = floor.nearest(point_of(points, i), reach)) found.push_back(*at);
  }
  return found;
}

nb::tuple tuple_of(Vec3f p) { return nb::make_tuple(p.x, p.y, p.z); }

nb::object floor_nearest(const Buildings& self, std::size_t building, const PointRows& point,
                         float aside, float above_below) {
  const Floor& floor = self.floor(checked(self, building));
  const auto found = on_floor(floor, point, {aside, above_below});
  if (found.empty()) return nb::none();
  return nb::make_tuple(tuple_of(found[0].point), floor.area_of(found[0]));
}

double floor_distance(const Buildings& self, std::size_t building, const PointRows& from,
                      const PointRows& goals, float reach) {
  const Floor& floor = self.floor(checked(self, building));
  const auto starts = on_floor(floor, from, {reach, reach});
  const auto ends = on_floor(floor, goals, {reach, reach});
  if (starts.empty() || ends.empty()) return std::numeric_limits<double>::infinity();
  if (ends.size() == 1) return floor.distance(starts[0], ends[0]);
  return floor.field(ends).distance(starts[0]);
}

nb::object floor_path(const Buildings& self, std::size_t building, const PointRows& from,
                      const PointRows& to, float reach) {
  const Floor& floor = self.floor(checked(self, building));
  const auto starts = on_floor(floor, from, {reach, reach});
  const auto ends = on_floor(floor, to, {reach, reach});
  if (starts.empty() || ends.empty()) return nb::none();
  const auto found = floor.path(starts[0], ends[0]);
  if (!found) return nb::none();
  std::vector<float> numbers;
  for (const Vec3f p : *found) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  return owned_array(std::move(numbers), found->size(), 3);
}

nb::tuple floor_point(const Buildings& self, std::size_t building, std::uint64_t seed) {
  Rng rng(seed);
  return tuple_of(self.floor(checked(self, building)).random_point(rng, std::nullopt).point);
}

std::vector<double> floor_areas(const Buildings& self, std::size_t building) {
  const Floor& floor = self.floor(checked(self, building));
  std::vector<double> found;
  for (std::size_t area = 0; area < floor.areas(); ++area) found.push_back(floor.area_m2(area));
  return found;
}

/// A simulator and its agents' teachers.
class BatchContinuous {
 public:
  BatchContinuous(std::shared_ptr<const Buildings> buildings,
                  const continuous::SimulatorConfig& config)
      : buildings_(std::move(buildings)),
        native_(buildings_, config),
        actions_(config.batch_size),
        begun_(config.batch_size),
        teachers_(config.batch_size) {}

  void new_episodes(const Row<std::uint32_t>& buildings, const PointRows& positions,
                    const Row<double>& headings, const Row<double>& elevations) {
    const Busy busy(busy_);
    check("buildings", buildings.size());
    check("positions", positions.shape(0));
    check("headings", headings.size());
    check("elevations", elevations.size());
    const nb::gil_scoped_release unlocked;
    std::vector<continuous::EpisodeStart> starts;
    for (std::size_t i = 0; i < actions_.size(); ++i) {
      starts.push_back(
          {buildings.data()[i],
           {point_of(positions, i), Radians(headings.data()[i]), Radians(elevations.data()[i])}});
    }
    native_.new_episodes(starts);
    begun_.assign(begun_.size(), true);
    for (auto& teacher : teachers_) teacher.reset();
  }
  void new_episode(std::size_t agent, std::uint32_t building, const PointRows& position,
                   double heading, double elevation) {
    const Busy busy(busy_);
    check_agent(agent);
    native_.new_episode(agent,
                        {building, {point_of(position, 0), Radians(heading), Radians(elevation)}});
    begun_[agent] = true;
    teachers_[agent].reset();
  }
  void step(const Row<std::uint8_t>& actions) {
    const Busy busy(busy_);
    check("actions", actions.size());
    const nb::gil_scoped_release unlocked;
    for (std::size_t i = 0; i < actions_.size(); ++i) {
      actions_[i] = static_cast<continuous::Action>(actions.data()[i]);
    }
    native_.step(actions_);
  }
  void follow(std::size_t agent, const PointRows& points, double reached, double last_reached) {
    const Busy busy(busy_);
    check_walking(agent);
    const Floor& floor = buildings_->floor(native_.state().building[agent]);
    auto found = on_floor(floor, points, {1, 1});
    if (found.size() != points.shape(0)) {
      throw ArgumentError(fmt::format("points: {} of {} have no floor within 1 m",
                                      points.shape(0) - found.size(), points.shape(0)));
    }
    teachers_[agent].emplace(
        std::shared_ptr<const Floor>(buildings_, &floor), std::move(found), native_.config(),
        continuous::FollowerConfig{.reached = reached, .last_reached = last_reached});
  }
  int expert_action(std::size_t agent) {
    const Busy busy(busy_);
    check_walking(agent);
    if (!teachers_[agent]) {
      throw ArgumentError(fmt::format("agent {}: follow() has to come first", agent));
    }
    return static_cast<int>(teachers_[agent]->next(native_.floor_point(agent),
                                                   Radians(native_.state().heading[agent])));
  }
  const continuous::Simulator& native() const { return native_; }

 private:
  void check(const char* name, std::size_t found) const {
    check_batch(name, found, actions_.size());
  }
  void check_agent(std::size_t agent) const {
    if (agent < actions_.size()) return;
    throw ArgumentError(fmt::format("agent {}: 0 to {} are allowed", agent, actions_.size() - 1));
  }
  // An agent without an episode has no position.
  void check_walking(std::size_t agent) const {
    check_agent(agent);
    if (begun_[agent]) return;
    throw ArgumentError(fmt::format("agent {} has no episode yet", agent));
  }

  std::shared_ptr<const Buildings> buildings_;
  continuous::Simulator native_;
  std::vector<continuous::Action> actions_;
  std::vector<bool> begun_;
  std::vector<std::optional<continuous::ReferenceFollower>> teachers_;
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

std::unique_ptr<BatchContinuous> make_continuous(const std::shared_ptr<const Buildings>& buildings,
                                                 const std::string& task, std::size_t batch_size,
                                                 const Options& options) {
  return std::make_unique<BatchContinuous>(buildings, continuous_config(task, batch_size, options));
}

nb::dict continuous_options(const BatchContinuous& self) {
  const continuous::SimulatorConfig& c = self.native().config();
  nb::dict d;
  d["forward"] = c.forward;
  d["turn"] = c.turn.value;
  d["look"] = c.look.value;
  d["most_elevation"] = c.most_elevation.value;
  d["slide"] = c.walls == continuous::Walls::kSlide;
  d["eye_height"] = c.eye_height;
  d["most_steps"] = c.most_steps;
  d["start_reach"] = nb::make_tuple(c.start_reach.aside, c.start_reach.above_below);
  d["threads"] = c.threads;
  return d;
}

// [(name, title, radius, height, step, slope in degrees), ...]
nb::list benchmark_list() {
  nb::list rows;
  for (const tasks::Benchmark& one : tasks::benchmarks()) {
    if (!one.continuous()) continue;
    const mesh::Body& body = agents::continuous_setup(one).body;
    rows.append(nb::make_tuple(std::string(one.name), std::string(one.title), body.radius,
                               body.height, body.step, body.slope));
  }
  return rows;
}

template <class T>
T option(const std::string& name, nb::handle value) {
  try {
    return nb::cast<T>(value);
  } catch (const nb::cast_error&) {
    throw nb::type_error(
        fmt::format("{}: {} has a wrong type or sign", name, nb::cast<std::string>(nb::repr(value)))
            .c_str());
  }
}

void bind_buildings(nb::module_& m) {
  nb::class_<Buildings>(m, "FloorSet", "The navigation meshes of a folder, by name.")
      .def(nb::new_(&open_buildings), "folder"_a)
      .def("__len__", &Buildings::size)
      .def_prop_ro("scans",
                   [](const Buildings& b) {
                     std::vector<std::string> names;
                     for (std::size_t i = 0; i < b.size(); ++i) names.push_back(b.scan(i));
                     return names;
                   })
      .def_prop_ro("floor", [](const Buildings& b) { return std::string(b.floor_name()); })
      .def(
          "index", [](const Buildings& b, const std::string& scan) { return b.at(scan); }, "scan"_a)
      .def("nearest", floor_nearest, "building"_a, "point"_a, "aside"_a, "above_below"_a,
           nb::sig("def nearest(self, building: int, point: numpy.typing.NDArray[numpy.float64], "
                   "aside: float, above_below: float) -> tuple[tuple[float, float, float], int] | "
                   "None"))
      .def("distance", floor_distance, "building"_a, "start"_a, "goals"_a, "reach"_a,
           nb::sig("def distance(self, building: int, start: numpy.typing.NDArray[numpy.float64], "
                   "goals: numpy.typing.NDArray[numpy.float64], reach: float) -> float"))
      .def("path", floor_path, "building"_a, "start"_a, "goal"_a, "reach"_a,
           nb::sig("def path(self, building: int, start: numpy.typing.NDArray[numpy.float64], "
                   "goal: numpy.typing.NDArray[numpy.float64], reach: float) -> "
                   "numpy.typing.NDArray[numpy.float32] | None"))
      .def("random_point", floor_point, "building"_a, "seed"_a,
           nb::sig("def random_point(self, building: int, seed: int) -> tuple[float, float, "
                   "float]"))
      .def("areas", floor_areas, "building"_a);
}

}  // namespace

continuous::SimulatorConfig continuous_config(const std::string& task, std::size_t batch_size,
                                              const Options& options) {
  continuous::SimulatorConfig c = agents::continuous_setup(task).simulator;
  c.batch_size = batch_size;
  for (const auto& [key, value] : options) {
    const auto name = nb::cast<std::string>(key);
    if (name == "forward") {
      c.forward = option<double>(name, value);
    } else if (name == "turn") {
      c.turn = Radians(option<double>(name, value));
    } else if (name == "look") {
      c.look = Radians(option<double>(name, value));
    } else if (name == "most_elevation") {
      c.most_elevation = Radians(option<double>(name, value));
    } else if (name == "slide") {
      c.walls = option<bool>(name, value) ? continuous::Walls::kSlide : continuous::Walls::kStop;
    } else if (name == "eye_height") {
      c.eye_height = option<double>(name, value);
    } else if (name == "most_steps") {
      c.most_steps = option<std::uint32_t>(name, value);
    } else if (name == "start_reach") {
      const auto reach = option<std::pair<float, float>>(name, value);
      c.start_reach = {reach.first, reach.second};
    } else if (name == "threads") {
      c.threads = option<int>(name, value);
    } else {
      throw ArgumentError(fmt::format("{}: not an option of a simulator", name));
    }
  }
  return c;
}

nb::dict continuous_state(const continuous::StateSpans& s, nb::handle owner) {
  const std::size_t n = s.building.size();
  nb::dict d;
  d["building"] = view_of(s.building, owner, n);
  d["position"] = array_of(reinterpret_cast<const float*>(s.position.data()), owner, n, 3);
  d["heading"] = view_of(s.heading, owner, n);
  d["elevation"] = view_of(s.elevation, owner, n);
  d["steps"] = view_of(s.steps, owner, n);
  d["collisions"] = view_of(s.collisions, owner, n);
  d["collided"] = array_of(reinterpret_cast<const bool*>(s.collided.data()), owner, n);
  d["episode"] = array_of(reinterpret_cast<const std::uint8_t*>(s.episode.data()), owner, n);
  d["off_floor"] = view_of(s.off_floor, owner, n);
  return d;
}

void bind_continuous(nb::module_& m) {
  bind_buildings(m);
  m.def("continuous_benchmarks", benchmark_list,
        nb::sig("def continuous_benchmarks() -> list[tuple[str, str, float, float, float, "
                "float]]"));
  nb::class_<BatchContinuous>(m, "BatchContinuous",
                              "The core of enfilade.ContinuousSimulator: indices and arrays.")
      .def(nb::new_(&make_continuous), "buildings"_a, "task"_a, "batch_size"_a, "options"_a)
      .def("new_episodes", &BatchContinuous::new_episodes, "buildings"_a, "positions"_a,
           "headings"_a, "elevations"_a)
      .def("new_episode", &BatchContinuous::new_episode, "agent"_a, "building"_a, "position"_a,
           "heading"_a, "elevation"_a)
      .def("step", &BatchContinuous::step, "actions"_a)
      .def("follow", &BatchContinuous::follow, "agent"_a, "points"_a, "reached"_a, "last_reached"_a)
      .def("expert_action", &BatchContinuous::expert_action, "agent"_a)
      .def("config", continuous_options, nb::sig("def config(self) -> dict[str, typing.Any]"))
      .def(
          "state_arrays",
          [](nb::handle self) {
            return continuous_state(nb::cast<const BatchContinuous&>(self).native().state(), self);
          },
          nb::sig("def state_arrays(self) -> dict[str, numpy.typing.NDArray[typing.Any]]"));
}

}  // namespace enfilade::python
