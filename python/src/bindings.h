/// \file  The parts of the extension module, and how arrays pass between Python and C++.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/metrics.h"
#include "python/src/arrays.h"

namespace enfilade::python {

namespace nb = nanobind;

/// One value per agent or view. Arrays of another type are converted; arrays of this type are read
/// without a copy.
template <class T>
using Row = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

template <class T>
std::span<const T> span_of(const Row<T>& row) {
  return {row.data(), row.size()};
}

inline constexpr nb::dlpack::dtype kHalf{static_cast<std::uint8_t>(nb::dlpack::dtype_code::Float),
                                         16, 1};

/// A read-only view of a span or vector that `owner` keeps, of numbers, or of indices as uint32.
template <class Values, class... Sizes>
nb::object view_of(const Values& values, nb::handle owner, Sizes... sizes) {
  const auto* data = values.data();
  using Value = std::remove_cvref_t<decltype(*data)>;
  if constexpr (std::is_arithmetic_v<Value>) {
    return array_of(data, owner, sizes...);
  } else {
    static_assert(std::is_same_v<Value, ScanIndex> || std::is_same_v<Value, ViewpointIndex>,
                  "elements must be numbers, ScanIndex or ViewpointIndex");
    static_assert(std::is_trivially_copyable_v<Value> && sizeof(Value) == sizeof(std::uint32_t));
    return array_of(reinterpret_cast<const std::uint32_t*>(data), owner, sizes...);
  }
}

/// \throws ArgumentError unless an array has an element for each agent
void check_batch(const char* name, std::size_t found, std::size_t batch);
/// A viewpoint by its id. \throws LookupError
ViewpointIndex find_viewpoint(const graph::NavGraph& graph, const std::string& id);
/// \name Goals of episodes, passed between C++ and enfilade.goals as tuples
/// @{
/// The name of a class of enfilade.goals, then its fields: ("Object", 66, ("<viewpoint>", ...)).
/// \param end  the path's last viewpoint, for NearEnd
nb::tuple goal_tuple(const tasks::Goal& goal, const graph::NavGraph& graph, ViewpointIndex end);
/// The goal of such a tuple. \throws LookupError for an unknown viewpoint; nb::python_error for
/// values of wrong types
tasks::Goal read_goal(const nb::tuple& goal, const graph::NavGraph& graph);
/// Whether a goal is of this kind.
bool fits(const tasks::Goal& goal, tasks::GoalKind kind) noexcept;
/// @}
/// The viewpoints of a path: ids, or indices as integers. Negative indices are padding and are
/// skipped. \param what  its name in messages
/// \throws LookupError; ArgumentError for an empty path and indices out of range
std::vector<ViewpointIndex> read_viewpoints(nb::handle path, const graph::NavGraph& graph,
                                            const char* what);
/// The C++ object of a Python EpisodeSet. \throws nb::cast_error for another object
std::shared_ptr<const tasks::EpisodeSet> episode_set(nb::handle episodes);
/// \throws ArgumentError unless the distance is positive
tasks::MetricOptions metric_options(double success_distance);
/// {"nav_error": ..., "success": ..., ...}
nb::dict metrics_dict(const tasks::EpisodeMetrics& metrics);

void bind_arena(nb::module_& module);  ///< after bind_dataset and bind_episodes
void bind_features(nb::module_& module);
void bind_graphs(nb::module_& module);
void bind_dataset(nb::module_& module);
void bind_simulator(nb::module_& module);
void bind_renderer(nb::module_& module);
void bind_episodes(nb::module_& module);
void bind_scores(nb::module_& module);
void bind_environment(nb::module_& module);
void bind_continuous(nb::module_& module);
void bind_continuous_episodes(nb::module_& module);
namespace mattersim {
void bind(nb::module_& module);  ///< the old simulator's names, in a module of their own
void bind_cbf(nb::module_& module);
}  // namespace mattersim

/// The arguments with which shared objects were opened, for other processes to open them again: a
/// value for each object, for its lifetime. Under the GIL.
template <class T, class Value>
class Origins {
 public:
  /// Stores a value, and removes those of destroyed objects.
  void put(const std::shared_ptr<const T>& object, Value value) {
    std::erase_if(known_, [](const auto& entry) { return entry.second.first.expired(); });
    known_.insert_or_assign(object.get(), std::pair(std::weak_ptr<const T>(object), value));
  }
  /// Null for an unknown object.
  const Value* find(const T& object) const {
    const auto found = known_.find(&object);
    const bool alive = found != known_.end() && !found->second.first.expired();
    return alive ? &found->second.second : nullptr;
  }

 private:
  std::map<const T*, std::pair<std::weak_ptr<const T>, Value>> known_;
};

}  // namespace enfilade::python
