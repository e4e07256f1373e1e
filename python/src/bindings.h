/// \file  The parts of the extension module, and how arrays pass between Python and C++.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/metrics.h"

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

/// A view of memory that `owner` keeps, for NumPy; `T` const: read-only.
template <class T, class... Sizes>
nb::object array_of(T* data, nb::handle owner, Sizes... sizes) {
  return nb::cast(nb::ndarray<nb::numpy, T>(data, {static_cast<std::size_t>(sizes)...}, owner));
}

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

/// A viewpoint by its id. \throws LookupError
ViewpointIndex find_viewpoint(const graph::NavGraph& graph, const std::string& id);
/// The C++ object of a Python EpisodeSet. \throws nb::cast_error for another object
std::shared_ptr<const tasks::EpisodeSet> episode_set(nb::handle episodes);
/// {"nav_error": ..., "success": ..., ...}
nb::dict metrics_dict(const tasks::EpisodeMetrics& metrics);

void bind_arena(nb::module_& module);  ///< after bind_dataset and bind_episodes
void bind_features(nb::module_& module);
void bind_gl_trial(nb::module_& module);
void bind_graphs(nb::module_& module);
void bind_dataset(nb::module_& module);
void bind_simulator(nb::module_& module);
void bind_renderer(nb::module_& module);
void bind_episodes(nb::module_& module);
void bind_scores(nb::module_& module);
void bind_tokens(nb::module_& module);
void bind_environment(nb::module_& module);
void bind_continuous(nb::module_& module);
void bind_continuous_episodes(nb::module_& module);
namespace mattersim {
void bind(nb::module_& module);  ///< the old simulator's names, in a module of their own
void bind_cbf(nb::module_& module);
}  // namespace mattersim

}  // namespace enfilade::python
