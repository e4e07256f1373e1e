// BatchEnvironment: Room-to-Room's episodes for reinforcement learning.
#include "enfilade/agents/batch_environment.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "enfilade/core/enum_names.h"
#include "python/src/bindings.h"
#include "python/src/errors.h"

namespace enfilade::python {
namespace {

using namespace nb::literals;

constexpr std::size_t kCandidateValues = 3;  // rel_heading, rel_elevation, distance
constexpr std::size_t kNodeValues = std::tuple_size_v<agents::MapFeature>;

/// An environment with its candidates as one array.
class Environment {
 public:
  Environment(std::shared_ptr<const tasks::EpisodeSet> episodes,
              const agents::EnvironmentConfig& config)
      : native_(std::move(episodes), config),
        candidates_(config.batch_size * config.max_navigable * kCandidateValues),
        mask_(config.batch_size * config.max_navigable),
        filled_(config.batch_size) {
    const std::size_t rows = config.batch_size * config.max_navigable;
    if (has_panoramas()) {
      viewpoints_.resize(rows);
      candidate_views_.resize(rows);
    }
    if (!has_maps()) return;
    node_viewpoints_.resize(config.batch_size * nodes());
    node_mask_.resize(config.batch_size * nodes());
    node_visited_.resize(config.batch_size * nodes());
    node_features_.resize(config.batch_size * nodes() * kNodeValues);
  }

  void reset(const std::optional<Row<std::uint8_t>>& mask,
             const std::optional<Row<std::int64_t>>& chosen) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    native_.reset(mask ? span_of(*mask) : std::span<const std::uint8_t>{},
                  chosen ? span_of(*chosen) : std::span<const std::int64_t>{});
    gather();
  }
  void step(const Row<std::int64_t>& actions) {
    const Busy busy(busy_);
    const nb::gil_scoped_release unlocked;
    native_.step(span_of(actions));
    gather();
  }
  void seed(std::size_t agent, std::uint64_t seed) {
    if (agent >= native_.config().batch_size) throw nb::index_error("agent");
    native_.seed(agent, seed);
  }

  // All arrays by name; they share the environment's memory.
  nb::dict arrays(nb::handle self) const {
    const std::size_t n = native_.config().batch_size, m = native_.config().max_navigable;
    const sim::StateSpans& state = native_.state();
    const agents::Outcome& out = native_.outcome();
    nb::dict d;
    d["scan"] = view_of(state.scan, self, n);
    d["viewpoint"] = view_of(state.viewpoint, self, n);
    d["heading"] = view_of(state.heading, self, n);
    d["elevation"] = view_of(state.elevation, self, n);
    d["step"] = view_of(out.actions, self, n);
    d["view_index"] = view_of(state.view_index, self, n);
    d["candidates"] = view_of(candidates_, self, n, m, kCandidateValues);
    d["candidate_mask"] = view_of(mask_, self, n, m);
    if (has_panoramas()) {
      d["candidate_viewpoint"] = view_of(viewpoints_, self, n, m);
      d["candidate_view"] = view_of(candidate_views_, self, n, m);
    } else {
      d["candidate_viewpoint"] = view_of(state.navigable_viewpoint, self, n, m);
    }
    if (has_maps()) {
      d["nodes"] = view_of(node_features_, self, n, nodes(), kNodeValues);
      d["node_mask"] = view_of(node_mask_, self, n, nodes());
      d["node_visited"] = view_of(node_visited_, self, n, nodes());
      d["node_viewpoint"] = view_of(node_viewpoints_, self, n, nodes());
    }
    d["reward"] = view_of(out.reward, self, n);
    d["terminated"] = view_of(out.terminated, self, n);
    d["truncated"] = view_of(out.truncated, self, n);
    d["began"] = view_of(out.began, self, n);
    d["distance"] = view_of(out.distance, self, n);
    d["episode"] = view_of(out.episode, self, n);
    d["success"] = view_of(out.success, self, n);
    d["spl"] = view_of(out.spl, self, n);
    return d;
  }
  const agents::BatchEnvironment& native() const { return native_; }

 private:
  bool has_maps() const { return native_.config().actions == agents::ActionSpace::kMap; }
  bool has_panoramas() const {
    return has_maps() || native_.config().actions == agents::ActionSpace::kPanoramic;
  }
  std::size_t nodes() const { return static_cast<std::size_t>(native_.action_count()); }

  void gather() {
    if (!has_panoramas()) {
      gather_lists();
      return;
    }
    for (std::size_t i = 0; i < native_.config().batch_size; ++i) {
      gather_panorama(i);
      if (has_maps()) gather_map(i);
    }
  }

  // Row 0 is the agent's viewpoint, row k the target of action k of the panoramic space.
  void gather_panorama(std::size_t agent) {
    const sim::StateSpans& state = native_.state();
    const std::size_t m = native_.config().max_navigable, first = agent * m;
    const std::vector<sim::Candidate>& candidates = native_.panorama(agent).candidates;
    std::fill_n(&mask_[first], m, std::int8_t{0});
    std::fill_n(&candidates_[first * kCandidateValues], m * kCandidateValues, 0.0F);
    mask_[first] = 1;
    viewpoints_[first] = state.viewpoint[agent];
    candidate_views_[first] = state.view_index[agent];
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      const std::size_t at = first + k + 1;
      const sim::Candidate& candidate = candidates[k];
      const Radians right = wrap_difference(candidate.heading - Radians(state.heading[agent]));
      mask_[at] = 1;
      viewpoints_[at] = candidate.viewpoint;
      candidate_views_[at] = candidate.view;
      float* out = &candidates_[at * kCandidateValues];
      out[0] = static_cast<float>(right.value);
      out[1] = static_cast<float>(candidate.elevation.value - state.elevation[agent]);
      out[2] = static_cast<float>(candidate.distance);
    }
  }

  // Row 0 is [stop], row k the target of action k of the map space.
  void gather_map(std::size_t agent) {
    const sim::StateSpans& state = native_.state();
    const agents::TopologicalMap& map = native_.map(agent);
    const std::size_t first = agent * nodes();
    std::fill_n(&node_mask_[first], nodes(), std::int8_t{0});
    std::fill_n(&node_visited_[first], nodes(), std::int8_t{0});
    std::fill_n(&node_features_[first * kNodeValues], nodes() * kNodeValues, 0.0F);
    node_mask_[first] = 1;
    node_viewpoints_[first] = state.viewpoint[agent];
    std::ranges::copy(agents::kStopFeature, &node_features_[first * kNodeValues]);
    const auto here = map.find(state.viewpoint[agent]).value();
    for (agents::TopologicalMap::Node node = 0; node < map.size(); ++node) {
      const std::size_t at = first + node + 1;
      node_mask_[at] = map.visited(node) ? 0 : 1;
      node_visited_[at] = map.visited(node) ? 1 : 0;
      node_viewpoints_[at] = map.viewpoint(node);
      std::ranges::copy(agents::map_feature(map, here, node, Radians(state.heading[agent]),
                                            Radians(state.elevation[agent])),
                        &node_features_[at * kNodeValues]);
    }
  }

  void gather_lists() {
    const sim::StateSpans& state = native_.state();
    const std::size_t m = native_.config().max_navigable;
    for (std::size_t i = 0; i < native_.config().batch_size; ++i) {
      const std::uint32_t count = state.navigable_count[i];
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t at = i * m + k;
        mask_[at] = 1;
        float* out = &candidates_[at * kCandidateValues];
        out[0] = static_cast<float>(state.navigable_rel_heading[at]);
        out[1] = static_cast<float>(state.navigable_rel_elevation[at]);
        out[2] = static_cast<float>(state.navigable_distance[at]);
      }
      for (std::size_t k = count; k < filled_[i]; ++k) {
        const std::size_t at = i * m + k;
        mask_[at] = 0;
        std::fill_n(&candidates_[at * kCandidateValues], kCandidateValues, 0.0F);
      }
      filled_[i] = count;
    }
  }

  agents::BatchEnvironment native_;
  std::vector<float> candidates_;      // (n, m, 3), 0 beyond the list
  std::vector<std::int8_t> mask_;      // (n, m), 1 within it
  std::vector<std::uint32_t> filled_;  // (n), rows in use
  // Panoramic and map space only, (n, m).
  std::vector<ViewpointIndex> viewpoints_;
  std::vector<std::uint32_t> candidate_views_;
  // Map space only, (n, actions), and (n, actions, 7).
  std::vector<ViewpointIndex> node_viewpoints_;
  std::vector<std::int8_t> node_mask_, node_visited_;
  std::vector<float> node_features_;
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

agents::ActionSpace parse_actions(const std::string& name) {
  if (const auto found = find_enum<agents::ActionSpace>(name)) return *found;
  throw ArgumentError("actions '" + name + "': viewpoint, six, panoramic and map are allowed");
}

std::unique_ptr<Environment> make_environment(nb::handle episodes, std::size_t batch_size,
                                              const std::string& actions, const std::string& reward,
                                              std::uint32_t max_steps, double success_distance,
                                              bool reset_at_next_step, std::uint64_t seed,
                                              std::uint32_t width, std::uint32_t height,
                                              double vfov, std::size_t max_navigable) {
  agents::EnvironmentConfig config;
  config.batch_size = batch_size;
  config.actions = parse_actions(actions);
  if (reward == "none") {
    config.reward = agents::Reward::kNone;
  } else if (reward == "success") {
    config.reward = agents::Reward::kSuccess;
  } else if (reward != "progress") {
    throw ArgumentError("reward '" + reward + "': none, success and progress are allowed");
  }
  config.max_steps = max_steps;
  config.success_distance = success_distance;
  config.reset_at_next_step = reset_at_next_step;
  config.seed = seed;
  config.camera = {width, height, Radians(vfov)};
  config.max_navigable = max_navigable;
  return std::make_unique<Environment>(episode_set(episodes), config);
}

}  // namespace

void bind_environment(nb::module_& m) {
  nb::class_<Environment>(m, "BatchEnvironment", "The core of enfilade.gym's environments.")
      .def(nb::new_(&make_environment), "episodes"_a, nb::kw_only(), "batch_size"_a, "actions"_a,
           "reward"_a, "max_steps"_a, "success_distance"_a, "reset_at_next_step"_a, "seed"_a,
           "width"_a, "height"_a, "vfov"_a, "max_navigable"_a)
      .def("reset", &Environment::reset, "mask"_a.none(), "chosen"_a.none())
      .def("step", &Environment::step, "actions"_a)
      .def("seed", &Environment::seed, "agent"_a, "seed"_a)
      .def_prop_ro("action_count", [](const Environment& e) { return e.native().action_count(); })
      .def(
          "arrays", [](nb::handle self) { return nb::cast<const Environment&>(self).arrays(self); },
          nb::sig("def arrays(self) -> dict[str, numpy.typing.NDArray[typing.Any]]"))
      .def(
          "expert",
          [](const Environment& e, std::size_t agent, const std::string& rule) {
            return e.native().expert(agent, agents::parse_expert_rule(rule));
          },
          "agent"_a, "rule"_a, nb::sig("def expert(self, agent: int, rule: str) -> int | None"))
      .def(
          "walked",
          [](const Environment& e, std::size_t agent) {
            if (agent >= e.native().config().batch_size) throw nb::index_error("agent");
            nb::list viewpoints;
            for (const tasks::TrajectoryPoint& p : e.native().trajectory(agent).points) {
              viewpoints.append(p.viewpoint.value);
            }
            return viewpoints;
          },
          "agent"_a, nb::sig("def walked(self, agent: int) -> list[int]"))
      .def(
          "metrics",
          [](const Environment& e, std::size_t agent) {
            return metrics_dict(e.native().compute_metrics(agent));
          },
          "agent"_a, nb::sig("def metrics(self, agent: int) -> dict[str, float]"));
}

}  // namespace enfilade::python
