// Continuous episodes, and their environment.
#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "enfilade/agents/continuous_environment.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/benchmark.h"
#include "python/src/continuous.h"
#include "python/src/errors.h"

namespace enfilade::python {
namespace {

using namespace nb::literals;
using continuous::Buildings;
using tasks::text_of;

/// A split, and the places of its episodes by id.
class ContinuousSet {
 public:
  explicit ContinuousSet(tasks::Split split) : split_(std::move(split)) {
    for (std::size_t i = 0; i < split_.size(); ++i) by_id_.emplace(split_.id(i), i);
  }

  const tasks::Split& split() const { return split_; }
  const std::vector<tasks::ContinuousEpisode>& all() const { return split_.continuous()->episodes; }
  const tasks::ContinuousEpisode& at(std::size_t i) const {
    if (i >= all().size()) throw nb::index_error("episode");
    return all()[i];
  }
  std::optional<std::size_t> find(const std::string& id) const {
    const auto found = by_id_.find(id);
    return found == by_id_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  tasks::Split split_;
  std::unordered_map<std::string, std::size_t> by_id_;
};

std::unique_ptr<ContinuousSet> load_set(const std::filesystem::path& data, const std::string& task,
                                        const std::string& split,
                                        const std::optional<std::filesystem::path>& file) {
  const nb::gil_scoped_release unlocked;
  const tasks::Benchmark& benchmark = tasks::benchmark(task, tasks::WorldKind::kContinuous);
  if (!file) {
    return std::make_unique<ContinuousSet>(dataset::Dataset(data).split(benchmark, split));
  }
  return std::make_unique<ContinuousSet>(
      tasks::Split(benchmark, std::make_shared<const tasks::ContinuousEpisodes>(
                                  tasks::load_continuous_episodes(*file, split))));
}

nb::tuple tuple_of(Vec3d p) { return nb::make_tuple(p.x, p.y, p.z); }

nb::object points_array(const std::vector<Vec3d>& points) {
  std::vector<double> numbers;
  for (const Vec3d p : points) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  return owned_array(std::move(numbers), points.size(), 3);
}

nb::object goals_of(const tasks::ContinuousEpisode& episode) {
  if (!episode.goals) return nb::none();
  nb::list goals;
  for (const tasks::ContinuousGoal& goal : *episode.goals) {
    goals.append(nb::make_tuple(tuple_of(goal.position), goal.radius));
  }
  return nb::tuple(goals);
}

// (id, trajectory_id, scene, scan, text, start, heading, rotation, goals, reference_path,
// geodesic_distance, language, instruction_id, tokens)
nb::tuple set_episode(const ContinuousSet& self, std::size_t i) {
  const tasks::ContinuousEpisode& e = self.at(i);
  const tasks::StartRotation& r = e.rotation;
  nb::object path = nb::none();
  if (e.reference_path) path = points_array(*e.reference_path);
  std::optional<double> metres;
  if (e.info) metres = e.info->geodesic_distance;
  std::optional<std::string> instruction_id;
  if (e.instruction.id) instruction_id = text_of(*e.instruction.id);
  return nb::make_tuple(text_of(e.id), text_of(e.trajectory_id), e.scene, std::string(e.scan()),
                        e.instruction.text, tuple_of(e.start), e.start_heading().value,
                        nb::make_tuple(r.x, r.y, r.z, r.w), goals_of(e), path, metres,
                        e.instruction.language, instruction_id, e.instruction.tokens);
}

// (locations, actions), or None
nb::object set_expert(const ContinuousSet& self, std::size_t i) {
  const tasks::ExpertWalks& experts = *self.split().experts();
  const auto found = experts.find(text_of(self.at(i).id));
  if (found == experts.end()) return nb::none();
  const tasks::ExpertWalk& walk = found->second;
  return nb::make_tuple(points_array(walk.locations),
                        owned_array(walk.actions, walk.actions.size()));
}

nb::dict score_dict(const tasks::ContinuousScore& score) {
  nb::dict d;
  const auto values = tasks::vlnce_values(score);
  const auto metrics = tasks::benchmark("r2r-ce").scorer("vlnce").metrics;
  for (std::size_t k = 0; k < values.size(); ++k) d[metrics[k].name] = values[k];
  d["oracle_navigation_error"] = score.oracle_navigation_error;
  d["oracle_spl"] = score.oracle_spl;
  return d;
}

// The measures of a trajectory, and the distance to the goal at each of its poses.
nb::tuple score_walk(const ContinuousSet& self, const std::shared_ptr<const Buildings>& buildings,
                     std::size_t i, const FloatRows& positions, const Row<std::uint8_t>& actions,
                     const Row<std::uint8_t>& collided) {
  const tasks::ContinuousEpisode& e = self.at(i);
  if (e.goal_hidden()) {
    throw ArgumentError(
        fmt::format("episode {} hides its goal, so there is no score", text_of(e.id)));
  }
  tasks::ContinuousResult walk;
  walk.episode = i;
  for (std::size_t k = 0; k < positions.shape(0); ++k) {
    walk.positions.push_back({positions(k, 0), positions(k, 1), positions(k, 2)});
  }
  walk.actions.assign(actions.data(), actions.data() + actions.size());
  walk.collided.assign(collided.data(), collided.data() + collided.size());
  std::vector<double> distances = agents::goal_distances(walk, e, *buildings);
  const nb::dict score =
      score_dict(agents::score_continuous_walk(walk, e, *buildings, *self.split().experts()));
  return nb::make_tuple(score, owned_array(distances, distances.size()));
}

/// Episodes that step together.
class FreeEnvironment {
 public:
  FreeEnvironment(const ContinuousSet& set, std::shared_ptr<const Buildings> buildings,
                  const continuous::SimulatorConfig& config)
      : native_({set.split().continuous(), set.split().experts(), std::move(buildings)}, config),
        actions_(config.batch_size) {}

  void begin(const Row<std::int64_t>& chosen) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    native_.begin(span_of(chosen));
  }
  void step(const Row<std::uint8_t>& actions) {
    const Busy busy(busy_);
    check_batch("actions", actions.size(), actions_.size());
    const nb::gil_scoped_release unlocked;
    for (std::size_t i = 0; i < actions_.size(); ++i) {
      actions_[i] = static_cast<continuous::Action>(actions.data()[i]);
    }
    native_.step(actions_);
  }
  std::optional<int> expert(std::size_t agent, bool shortest) {
    const Busy busy(busy_);
    const auto rule =
        shortest ? agents::ContinuousExpert::kShortest : agents::ContinuousExpert::kReference;
    const auto action = native_.expert(agent, rule);
    return action ? std::optional(static_cast<int>(*action)) : std::nullopt;
  }
  nb::dict score(std::size_t agent) const { return score_dict(native_.score(agent)); }
  // (positions, headings, actions, collided)
  nb::tuple walk(std::size_t agent) const {
    const tasks::ContinuousResult& walk = native_.walk(agent);
    std::vector<float> positions;
    std::vector<double> headings;
    for (const Vec3f p : walk.positions) positions.insert(positions.end(), {p.x, p.y, p.z});
    for (const Radians heading : walk.headings) headings.push_back(heading.value);
    return nb::make_tuple(owned_array(std::move(positions), walk.positions.size(), 3),
                          owned_array(std::move(headings), walk.headings.size()),
                          owned_array(walk.actions, walk.actions.size()),
                          owned_array(walk.collided, walk.collided.size()));
  }
  nb::dict arrays(nb::handle self) const {
    nb::dict d = continuous_state(native_.simulator().state(), self);
    d["state"] = d["episode"];  // its status; `episode` is the index, as in other environments
    d["episode"] = view_of(native_.episode(), self, actions_.size());
    d["distance"] = view_of(native_.distance(), self, actions_.size());
    return d;
  }

 private:
  agents::ContinuousEnvironment native_;
  std::vector<continuous::Action> actions_;
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

std::unique_ptr<FreeEnvironment> make_free_environment(
    const ContinuousSet& set, const std::shared_ptr<const Buildings>& buildings,
    std::size_t batch_size, const Options& options) {
  const continuous::SimulatorConfig config =
      continuous_config(std::string(set.split().benchmark().name), batch_size, options);
  const nb::gil_scoped_release unlocked;
  return std::make_unique<FreeEnvironment>(set, buildings, config);
}

void bind_set(nb::module_& m) {
  nb::class_<ContinuousSet>(m, "ContinuousSet", "The core of enfilade.ContinuousEpisodes.")
      .def(nb::new_(&load_set), "data"_a, "task"_a, "split"_a, "file"_a.none())
      .def("__len__", [](const ContinuousSet& s) { return s.all().size(); })
      .def_prop_ro("file", [](const ContinuousSet& s) { return s.split().continuous()->file; })
      .def_prop_ro(
          "texts",
          [](const ContinuousSet& s) {
            nb::list texts;
            for (const auto& e : s.all()) texts.append(e.instruction.text);
            return texts;
          },
          nb::sig("def texts(self) -> list[str]"))
      .def("find", &ContinuousSet::find, "episode_id"_a)
      .def("episode", set_episode, "index"_a,
           nb::sig("def episode(self, index: int) -> tuple[typing.Any, ...]"))
      .def("expert", set_expert, "index"_a,
           nb::sig("def expert(self, index: int) -> tuple[numpy.typing.NDArray[numpy.float64], "
                   "numpy.typing.NDArray[numpy.uint8]] | None"))
      .def("score_walk", score_walk, "buildings"_a, "index"_a, "positions"_a, "actions"_a,
           "collided"_a,
           nb::sig("def score_walk(self, buildings: FloorSet, index: int, positions: "
                   "numpy.typing.NDArray[numpy.float32], actions: "
                   "numpy.typing.NDArray[numpy.uint8], collided: "
                   "numpy.typing.NDArray[numpy.uint8]) -> tuple[dict[str, float], "
                   "numpy.typing.NDArray[numpy.float64]]"));
}

}  // namespace

void bind_continuous_episodes(nb::module_& m) {
  bind_set(m);
  nb::class_<FreeEnvironment>(m, "FreeEnvironment",
                              "The core of enfilade.gym's continuous environments.")
      .def(nb::new_(&make_free_environment), "episodes"_a, "buildings"_a, "batch_size"_a,
           "options"_a)
      .def("begin", &FreeEnvironment::begin, "chosen"_a)
      .def("step", &FreeEnvironment::step, "actions"_a)
      .def("expert", &FreeEnvironment::expert, "agent"_a, "shortest"_a)
      .def("score", &FreeEnvironment::score, "agent"_a,
           nb::sig("def score(self, agent: int) -> dict[str, float]"))
      .def("walk", &FreeEnvironment::walk, "agent"_a,
           nb::sig("def walk(self, agent: int) -> tuple[numpy.typing.NDArray[numpy.float32], "
                   "numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint8], "
                   "numpy.typing.NDArray[numpy.uint8]]"))
      .def(
          "arrays",
          [](nb::handle self) { return nb::cast<const FreeEnvironment&>(self).arrays(self); },
          nb::sig("def arrays(self) -> dict[str, numpy.typing.NDArray[typing.Any]]"));
}

}  // namespace enfilade::python
