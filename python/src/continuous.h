/// \file  Shared by the bindings of continuous episodes.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/continuous/simulator.h"
#include "python/src/bindings.h"

namespace enfilade::python {

/// Points from Python, (n, 3), metres, world frame; the last dimension is checked.
using PointRows = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using FloatRows = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

/// Point i of an array. \pre i < rows.shape(0)
inline Vec3f point_of(const PointRows& rows, std::size_t i) {
  return {static_cast<float>(rows(i, 0)), static_cast<float>(rows(i, 1)),
          static_cast<float>(rows(i, 2))};
}

/// The state's arrays by name, over the memory that `owner` keeps.
nb::dict continuous_state(const continuous::StateSpans& state, nb::handle owner);

/// A simulator's options by name.
using Options = nb::typed<nb::dict, nb::str, nb::object>;

/// A benchmark's configuration with another batch size and options by their names.
/// \throws ArgumentError for an unknown option
continuous::SimulatorConfig continuous_config(const std::string& task, std::size_t batch_size,
                                              const Options& options);

}  // namespace enfilade::python
